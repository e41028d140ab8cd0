#include "material_panel.h"

#include <QComboBox>
#include <QLabel>
#include <QVBoxLayout>
#include <algorithm>
#include <limits>

#include "panel_layout.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

QString short_number(double value) {
  return QString::number(value, 'g', 4);
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
  model_ = new QComboBox(this);
  model_->setObjectName(QStringLiteral("model"));
  model_->addItem(tr("Saint Venant–Kirchhoff"), QStringLiteral("stvk"));
  model_->addItem(tr("neo-Hookean"), QStringLiteral("neo-hookean"));
  model_->addItem(tr("Mooney–Rivlin"), QStringLiteral("mooney-rivlin"));
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
  ratio_ = new NumberSlider(tr("Ratio μ₂/μ₁ of Mooney–Rivlin"), QString(), {0.0, kInfinity}, 0.0,
                            2.0, NumberSlider::Scale::kLinear, this);
  material->addRow(tr("μ₂/μ₁"), ratio_);

  auto* derived = add_group(column, tr("That is"));
  lame_ = new QLabel(this);
  lame_->setToolTip(tr("Lamé parameters of small strains, Pa"));
  wave_ = new QLabel(this);
  wave_->setToolTip(tr("Speed of compression waves, √((λ + 2μ)/ρ), m/s"));
  density_ = new QLabel(this);
  density_->setToolTip(tr("kg/m³; cannot change during a run: mass would appear from nowhere"));
  derived->addRow(tr("μ, λ"), lame_);
  derived->addRow(tr("Wave speed"), wave_);
  derived->addRow(tr("Density"), density_);
  column->addStretch(1);

  connect(region_, QOverload<int>::of(&QComboBox::activated), this, &MaterialPanel::show_region);
  connect(model_, QOverload<int>::of(&QComboBox::activated), this,
          [this] { commit(tr("Model %1").arg(model_->currentText()), false); });
  connect(young_, &NumberSlider::entered, this, [this](double value, bool goes_on) {
    commit(tr("Young's modulus %1 Pa").arg(short_number(value)), goes_on);
  });
  connect(poisson_, &NumberSlider::entered, this, [this](double value, bool goes_on) {
    commit(tr("Poisson's ratio %1").arg(short_number(value)), goes_on);
  });
  connect(ratio_, &NumberSlider::entered, this, [this](double value, bool goes_on) {
    commit(tr("μ₂/μ₁ %1").arg(short_number(value)), goes_on);
  });
  for (NumberSlider* slider : {young_, poisson_, ratio_}) {
    connect(slider, &NumberSlider::refused, this, &MaterialPanel::refused);
  }
}

void MaterialPanel::show_settings(const Settings& settings) {
  materials_ = settings.materials;
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
  for (QWidget* widget : {static_cast<QWidget*>(model_), static_cast<QWidget*>(young_),
                          static_cast<QWidget*>(poisson_)}) {
    widget->setEnabled(!custom);
  }
  const MaterialModel material = make_material(settings);
  const LameParameters small = initial_lame(material);
  const double young = small.mu * (3.0 * small.lambda + 2.0 * small.mu) / (small.lambda + small.mu);
  if (!custom) model_->setCurrentIndex(model_->findData(QString::fromStdString(settings.model)));
  young_->set_value(settings.youngs_modulus.value_or(young));
  poisson_->set_value(
      settings.poissons_ratio.value_or(small.lambda / (2.0 * (small.lambda + small.mu))));
  const auto* mooney = std::get_if<MooneyRivlin>(&material);
  ratio_->setEnabled(mooney != nullptr);
  if (mooney != nullptr) {
    ratio_->set_value(
        settings.ratio.value_or(mooney->mu1() > 0.0 ? mooney->mu2() / mooney->mu1() : 0.0));
  } else {
    ratio_->set_value(0.0);
  }
  lame_->setText(tr("%1 Pa, %2 Pa").arg(short_number(small.mu), short_number(small.lambda)));
  wave_->setText(tr("%1 m/s").arg(short_number(wave_speed(small, settings.density))));
  density_->setText(tr("%1 kg/m³").arg(short_number(settings.density)));
}

void MaterialPanel::commit(const QString& what, bool goes_on) {
  const int region = std::max(0, region_->currentIndex());
  MaterialSettings settings;
  settings.model = model_->currentData().toString().toStdString();
  settings.density = materials_[static_cast<std::size_t>(region)].density;
  settings.youngs_modulus = young_->value();
  settings.poissons_ratio = poisson_->value();
  if (settings.model == "mooney-rivlin") settings.ratio = ratio_->value();
  const QString text = materials_.size() > 1 ? tr("%1 (region %2)").arg(what).arg(region) : what;
  emit edited(SetMaterial{region, settings}, text, goes_on);
}

}  // namespace tetraction::viewer
