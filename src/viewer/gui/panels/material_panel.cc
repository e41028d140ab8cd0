#include "material_panel.h"

#include <QComboBox>
#include <QLabel>
#include <QVBoxLayout>
#include <algorithm>
#include <limits>
#include <string_view>

#include "panel_layout.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
namespace {

// Whether the panel shows the material by Young's modulus and Poisson's ratio.
bool takes_young(const MaterialChoice& choice) {
  return std::string_view(choice.instead.front().name) == kYoungsModulus.name;
}

// The parameters that have fields: those beside Young's modulus and Poisson's ratio, or else the model's own.
std::vector<MaterialParameter> fields_of(const MaterialChoice& choice) {
  if (takes_young(choice)) return choice.beside_young;
  std::vector<MaterialParameter> fields;
  for (const MaterialParameter& p : choice.parameters) {
    if (p.most_entries == 0) fields.push_back(p);
    for (int i = 0; i < p.most_entries; ++i) fields.push_back(entry_of(p, i));
  }
  return fields;
}

bool takes(const MaterialChoice* choice, const MaterialParameter& parameter) {
  if (choice == nullptr) return false;
  const std::vector<MaterialParameter> fields = fields_of(*choice);
  return std::any_of(fields.begin(), fields.end(), [&](const MaterialParameter& p) {
    return std::string_view(p.name) == parameter.name;
  });
}

bool is_array(const MaterialSettings& settings, const MaterialParameter& parameter) {
  return settings.arrays.count(parameter.name) > 0;
}
// Whether cell arrays of the mesh give parameters besides the density.
bool array_gives_parameters(const MaterialSettings& settings) {
  return settings.arrays.size() > (is_array(settings, kDensity) ? 1U : 0U);
}
bool is_given_by_young(const MaterialSettings& settings) {
  return settings.youngs_modulus || settings.poissons_ratio || is_array(settings, kYoungsModulus) ||
         is_array(settings, kPoissonsRatio);
}

}  // namespace

MaterialPanel::MaterialPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);
  auto* where = add_group(column, tr("Part of the body"));
  region_ = new QComboBox(this);
  region_->setObjectName(QStringLiteral("region"));
  region_->setToolTip(tr("Region of the scene whose material is shown"));
  where->addRow(tr("Region"), region_);

  auto* material = add_group(column, tr("Material"));
  form_ = material;
  model_ = new QComboBox(this);
  model_->setObjectName(QStringLiteral("model"));
  for (const MaterialChoice& choice : material_choices()) {
    model_->addItem(QString::fromUtf8(choice.title), QString::fromUtf8(choice.name));
  }
  model_->setToolTip(tr("Hyperelastic model; all have the same response to small strains"));
  material->addRow(tr("Model"), model_);
  young_ = new NumberSlider(tr("Young's modulus"), tr("Pa"), {0.0, kInfinity, false}, 1e3, 1e10,
                            NumberSlider::Scale::kLogarithmic, this);
  young_->setObjectName(QStringLiteral("youngs_modulus"));
  material->addRow(tr("Young [Pa]"), young_);
  poisson_ = new NumberSlider(tr("Poisson's ratio"), QString(), {-1.0, 0.5, false, false}, 0.0,
                              0.495, NumberSlider::Scale::kLinear, this);
  poisson_->setObjectName(QStringLiteral("poissons_ratio"));
  material->addRow(tr("Poisson"), poisson_);
  std::vector<MaterialParameter> parameters;
  for (const MaterialChoice& choice : material_choices()) {
    for (const MaterialParameter& own : fields_of(choice)) {
      const auto is_same = [&](const MaterialParameter& p) {
        return std::string_view(p.name) == own.name;
      };
      if (std::none_of(parameters.begin(), parameters.end(), is_same)) parameters.push_back(own);
    }
  }
  for (const MaterialParameter& parameter : parameters) {
    const QString help = QString::fromUtf8(parameter.help);
    const QString unit = QString::fromUtf8(parameter.unit);
    auto* field = new NumberField(help, unit, parameter.range, this);
    field->setObjectName(QString::fromUtf8(parameter.name));
    const QString in_scene = QString::fromUtf8(parameter.name);
    const QString name =
        in_scene.contains(QLatin1Char('.')) ? in_scene : help.section(QStringLiteral(","), 0, 0);
    material->addRow(unit.isEmpty() ? name : tr("%1 [%2]").arg(name, unit), field);
    other_fields_.emplace_back(parameter, field);
  }
  volumetric_ = new QComboBox(this);
  volumetric_->setObjectName(QStringLiteral("volumetric"));
  volumetric_->addItem(tr("λ/2 (ln J)²"), static_cast<int>(VolumetricPart::kLogarithmic));
  volumetric_->addItem(tr("λ/2 (J − 1)²"), static_cast<int>(VolumetricPart::kQuadratic));
  volumetric_->setToolTip(tr("Energy of changes of volume, of the models that have the choice"));
  material->addRow(tr("Volumetric"), volumetric_);

  auto* derived = add_group(column, tr("That is"));
  lame_ = new QLabel(this);
  lame_->setWordWrap(true);
  lame_->setToolTip(tr("Lamé parameters of small strains, Pa"));
  wave_ = new QLabel(this);
  wave_->setToolTip(tr("Speed of compression waves, √((λ + 2μ)/ρ), m/s"));
  density_ = new QLabel(this);
  density_->setWordWrap(true);
  density_->setToolTip(tr("kg/m³; cannot change during a run: mass would appear from nowhere"));
  derived->addRow(tr("μ, λ"), lame_);
  derived->addRow(tr("Wave speed"), wave_);
  derived->addRow(tr("Density"), density_);
  column->addStretch(1);

  connect(region_, QOverload<int>::of(&QComboBox::activated), this, &MaterialPanel::show_region);
  connect(model_, QOverload<int>::of(&QComboBox::activated), this,
          [this] { commit(tr("Model %1").arg(model_->currentText()), false); });
  connect(young_, &NumberSlider::entered, this, [this](double value, bool continues_previous) {
    commit(tr("Young's modulus %1 Pa").arg(short_number(value)), continues_previous);
  });
  connect(poisson_, &NumberSlider::entered, this, [this](double value, bool continues_previous) {
    commit(tr("Poisson's ratio %1").arg(short_number(value)), continues_previous);
  });
  for (const auto& [parameter, field] : other_fields_) {
    connect(field, &NumberField::entered, this, [this, field = field](double value) {
      commit(tr("%1 %2 %3").arg(field->what(), short_number(value), field->unit()).trimmed(),
             false);
    });
    connect(field, &NumberField::refused, this, &MaterialPanel::refused);
  }
  connect(volumetric_, QOverload<int>::of(&QComboBox::activated), this,
          [this] { commit(tr("Volumetric part %1").arg(volumetric_->currentText()), false); });
  for (NumberSlider* slider : {young_, poisson_}) {
    connect(slider, &NumberSlider::refused, this, &MaterialPanel::refused);
  }
}

void MaterialPanel::show_settings(const Settings& settings) {
  materials_ = settings.materials;
  moduli_ = settings.moduli;
  const int count = static_cast<int>(materials_.size());
  if (region_->count() != count) {
    region_->clear();
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const QString name = k < settings.region_names.size()
                               ? QString::fromStdString(settings.region_names[k])
                               : QString();
      region_->addItem(name.isEmpty() ? QString::number(i) : tr("%1: %2").arg(i).arg(name));
    }
  }
  region_->setEnabled(count > 1);
  show_region();
}

void MaterialPanel::show_region() {
  const auto region = static_cast<std::size_t>(std::max(0, region_->currentIndex()));
  if (region >= materials_.size()) return;
  const MaterialSettings& settings = materials_[region];
  const bool custom = settings.custom.has_value();
  const bool has_arrays = array_gives_parameters(settings);
  const bool can_change = !custom && (!has_arrays || is_given_by_young(settings));
  model_->setEnabled(can_change);
  const MaterialChoice* choice = custom ? nullptr : find_material(settings.model);
  const bool by_young = choice == nullptr || takes_young(*choice);
  young_->setEnabled(can_change && by_young && !is_array(settings, kYoungsModulus));
  poisson_->setEnabled(can_change && (by_young || settings.poissons_ratio) &&
                       !is_array(settings, kPoissonsRatio));
  const LameRange& moduli = moduli_[region];
  const LameParameters& small = moduli.least;
  const double young = small.mu * (3.0 * small.lambda + 2.0 * small.mu) / (small.lambda + small.mu);
  if (!custom) model_->setCurrentIndex(model_->findData(QString::fromStdString(settings.model)));
  young_->set_value(settings.youngs_modulus.value_or(young));
  poisson_->set_value(
      settings.poissons_ratio.value_or(small.lambda / (2.0 * (small.lambda + small.mu))));
  for (const auto& [parameter, field] : other_fields_) {
    const std::optional<double> given = number_of(settings, parameter.name);
    const bool is_own = takes(choice, parameter) && (by_young || given);
    field->setEnabled((can_change || !by_young) && is_own && !is_array(settings, parameter));
    double value = given.value_or(0.0);
    // The scene may give μ₁ and μ₂ instead of their ratio.
    const std::optional<double> mu1 = number_of(settings, "mu1");
    const std::optional<double> mu2 = number_of(settings, "mu2");
    if (mu1 && mu2 && std::string_view(parameter.name) == "ratio") {
      value = *mu1 > 0.0 ? *mu2 / *mu1 : 0.0;
    }
    field->set_value(field->isEnabled() ? value : 0.0);
    // Only those of the many entries of lists are shown that the material has.
    if (std::string_view(parameter.name).find('.') == std::string_view::npos) continue;
    field->setVisible(is_own);
    if (QWidget* label = form_->labelForField(field)) label->setVisible(is_own);
  }
  volumetric_->setEnabled(choice != nullptr && choice->has_volumetric_part);
  volumetric_->setCurrentIndex(volumetric_->findData(
      static_cast<int>(settings.volumetric.value_or(VolumetricPart::kLogarithmic))));
  if (has_arrays) {
    const LameParameters& most = moduli.most;
    lame_->setText(tr("%1 to %2 Pa, %3 to %4 Pa")
                       .arg(short_number(small.mu), short_number(most.mu),
                            short_number(small.lambda), short_number(most.lambda)));
  } else {
    lame_->setText(tr("%1 Pa, %2 Pa").arg(short_number(small.mu), short_number(small.lambda)));
  }
  const auto density_array = settings.arrays.find(kDensity.name);
  const bool density_varies = density_array != settings.arrays.end();
  wave_->setText(has_arrays || density_varies
                     ? tr("varies")
                     : tr("%1 m/s").arg(short_number(wave_speed(small, settings.density))));
  density_->setText(
      density_varies
          ? tr("array \"%1\" of the mesh").arg(QString::fromStdString(density_array->second))
          : tr("%1 kg/m³").arg(short_number(settings.density)));
}

// The settings that the fields show. Parameters that an array gives stay as they are. If they are
// not those of this panel, all parameters stay.
MaterialSettings MaterialPanel::entered(const MaterialSettings& before) const {
  MaterialSettings settings;
  settings.model = model_->currentData().toString().toStdString();
  settings.density = before.density;
  settings.arrays = before.arrays;
  if (array_gives_parameters(before) && !is_given_by_young(before)) settings = before;
  settings.volumetric.reset();
  const MaterialChoice* choice = find_material(settings.model);
  MaterialSettings usual = settings;
  choice->set_like(usual,
                   moduli_[static_cast<std::size_t>(std::max(0, region_->currentIndex()))].least);
  if (!takes_young(*choice)) {
    if (before.custom || before.model != settings.model) return usual;
    settings.numbers = before.numbers;
    settings.poissons_ratio = before.poissons_ratio;
    if (poisson_->isEnabled()) settings.poissons_ratio = poisson_->value();
    for (const auto& [parameter, field] : other_fields_) {
      if (field->isEnabled()) set_number(settings, parameter.name, field->value());
    }
    return settings;
  }
  const MaterialChoice* previous = find_material(before.model);
  const bool was_by_young = before.custom || previous == nullptr || takes_young(*previous);
  if (young_->isEnabled() || !was_by_young) settings.youngs_modulus = young_->value();
  if (poisson_->isEnabled() || !was_by_young) settings.poissons_ratio = poisson_->value();
  for (const auto& [parameter, field] : other_fields_) {
    if (!model_->isEnabled() || !takes(choice, parameter) || is_array(before, parameter)) continue;
    double value = field->value();
    // A parameter that must not be 0 has no value yet after a change of the model.
    if (!parameter.range.contains(value)) {
      value = number_of(usual, parameter.name).value_or(value);
    }
    set_number(settings, parameter.name, value);
  }
  const auto part = static_cast<VolumetricPart>(volumetric_->currentData().toInt());
  if (choice->has_volumetric_part && part != VolumetricPart::kLogarithmic) {
    settings.volumetric = part;
  }
  return settings;
}

void MaterialPanel::commit(const QString& what, bool continues_previous) {
  const int region = std::max(0, region_->currentIndex());
  const MaterialSettings settings = entered(materials_[static_cast<std::size_t>(region)]);
  const QString text = materials_.size() > 1 ? tr("%1 (region %2)").arg(what).arg(region) : what;
  emit edited(SetMaterial{region, settings}, text, continues_previous);
}

}  // namespace tetraction::viewer
