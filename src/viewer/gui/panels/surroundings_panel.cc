#include "surroundings_panel.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QLabel>
#include <tuple>
#include <type_traits>

#include "load_editor.h"
#include "panel_layout.h"
#include "section_form.h"
#include "simulation/scene/setting_keys.h"
#include "viewer/gui/widgets/number_field.h"
#include "viewer/gui/widgets/vector_fields.h"

namespace tetraction::viewer {
namespace {

// The scene key of the strength, with title, unit and help for one kind of environment.
KeyInfo strength(const char* title, const char* unit, const char* help) {
  KeyInfo key = key_info(&EnvironmentSettings::strength);
  key.title = title;
  key.unit = unit;
  key.help = help;
  return key;
}

void set_row_visible(QFormLayout* form, QWidget* field, bool visible) {
  field->setVisible(visible);
  if (QWidget* label = form->labelForField(field)) label->setVisible(visible);
}

}  // namespace

SurroundingsPanel::SurroundingsPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);
  auto* environment = add_group(column, tr("Environment"));
  kind_ = new QComboBox(this);
  kind_->setObjectName(QStringLiteral("environment"));
  kind_->addItems({tr("None"), tr("Gravity"), tr("Attraction to the origin")});
  kind_->setToolTip(tr("Force field around the body"));
  environment->addRow(tr("Kind"), kind_);
  gravity_ = new NumberSlider(strength("Gravity", "m/s²", "acceleration of gravity"), 0.0, 30.0,
                              NumberSlider::Scale::kLinear, this);
  gravity_->setObjectName(QStringLiteral("gravity"));
  environment->addRow(tr("g [m/s²]"), gravity_);
  const KeyInfo& direction_key = key_info(&EnvironmentSettings::direction);
  direction_ = new VectorFields(tr(direction_key.title), QString(), direction_key.range, this);
  direction_->setObjectName(QStringLiteral("direction"));
  connect(direction_, &VectorFields::entered, this, [this] { environment_edited(false); });
  connect(direction_, &VectorFields::refused, this, &SurroundingsPanel::refused);
  environment->addRow(tr("Direction"), direction_);
  attraction_ =
      new NumberSlider(strength("Attraction", "N m²", "k of the force −k q/|q|³ on every vertex"),
                       0.0, 5.0, NumberSlider::Scale::kLinear, this);
  attraction_->setObjectName(QStringLiteral("attraction"));
  environment->addRow(tr("k [N m²]"), attraction_);
  softening_ = new NumberField(key_info(&EnvironmentSettings::softening), this);
  environment->addRow(tr("Softening [m]"), softening_);
  amplitude_ = new QLabel(this);
  amplitude_->setObjectName(QStringLiteral("environment_amplitude"));
  amplitude_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  environment->addRow(amplitude_);

  auto* loads = add_group(column, tr("Loads"));
  loads_ = new LoadEditor(this);
  loads->addRow(loads_);
  connect(loads_, &LoadEditor::edited, this, &SurroundingsPanel::edited);
  connect(loads_, &LoadEditor::refused, this, &SurroundingsPanel::refused);

  std::apply([&](auto... member) { (add_form(column, member), ...); },
             ChangeableSections::members());
  column->addStretch(1);

  connect(kind_, QOverload<int>::of(&QComboBox::activated), this,
          [this] { environment_edited(false); });
  for (NumberSlider* slider : {gravity_, attraction_}) {
    connect(slider, &NumberSlider::entered, this,
            [this](double, bool continues_previous) { environment_edited(continues_previous); });
  }
  connect(softening_, &NumberField::entered, this, [this] { environment_edited(false); });
  connect(softening_, &NumberField::refused, this, &SurroundingsPanel::refused);
  for (NumberSlider* slider : {gravity_, attraction_}) {
    connect(slider, &NumberSlider::refused, this, &SurroundingsPanel::refused);
  }
}

// Sections with choices that depend on each other have panels or groups of their own.
template <class Section>
void SurroundingsPanel::add_form(QVBoxLayout* column, Section ChangeableSections::*member) {
  if constexpr (!std::is_same_v<Section, TimeSettings> &&
                !std::is_same_v<Section, SolverSettings> &&
                !std::is_same_v<Section, EnvironmentSettings> &&
                !std::is_same_v<Section, PullSettings>) {  // the mouse sets it
    const SceneSection& section = section_of<Section>();
    QString title = QString::fromUtf8(section.name).replace(QLatin1Char('_'), QLatin1Char(' '));
    title.replace(0, 1, title.at(0).toUpper());
    auto* form = new SectionForm(section, add_group(column, title), this);
    forms_.emplace_back([this, form, member] { form->show_settings(&(present_.*member)); });
    connect(form, &SectionForm::edited, this,
            [this, form, member](const QString& what, bool continues_previous) {
              form->read(&(present_.*member));
              emit edited(SetSection<Section>{present_.*member}, what, continues_previous);
            });
    connect(form, &SectionForm::refused, this, &SurroundingsPanel::refused);
  }
}

void SurroundingsPanel::show_settings(const Settings& settings) {
  present_ = settings;
  for (const auto& show : forms_) show();
  environment_ = settings.environment;
  show_environment();
  loads_->show_loads(settings.loads);
}

void SurroundingsPanel::show_environment() {
  const EnvironmentKind kind = environment_.kind;
  if (kind == EnvironmentKind::kCustom) {
    kind_->setEnabled(false);  // a custom force field is not in the list
    return;
  }
  kind_->setCurrentIndex(static_cast<int>(kind));
  const bool gravity = kind == EnvironmentKind::kGravity;
  const bool attraction = kind == EnvironmentKind::kAttraction;
  auto* form = static_cast<QFormLayout*>(kind_->parentWidget()->layout());
  set_row_visible(form, gravity_, gravity);
  set_row_visible(form, direction_, gravity);
  set_row_visible(form, attraction_, attraction);
  set_row_visible(form, softening_, attraction);
  if (gravity) gravity_->set_value(environment_.strength);
  if (attraction) attraction_->set_value(environment_.strength);
  softening_->set_value(environment_.softening);
  amplitude_->setText(
      tr("times the amplitude \"%1\"").arg(QString::fromStdString(environment_.amplitude)));
  amplitude_->setToolTip(amplitude_->text());
  amplitude_->setVisible(!environment_.amplitude.empty());
  // The direction is normalised where it is used. The fields keep the numbers that were typed, so that
  // the user can go on to change single components of the same vector.
  const bool as_typed = !typed_direction_.isZero(0.0) &&
                        unit_direction(typed_direction_).isApprox(environment_.direction);
  direction_->set_value(as_typed ? typed_direction_ : environment_.direction);
}

void SurroundingsPanel::environment_edited(bool continues_previous) {
  const auto kind = static_cast<EnvironmentKind>(kind_->currentIndex());
  EnvironmentSettings next;
  next.kind = kind;
  const bool same = kind == environment_.kind;
  if (same) next.amplitude = environment_.amplitude;
  QString what = tr("No environment");
  if (kind == EnvironmentKind::kGravity) {
    if (same) next.strength = gravity_->value();
    const Vector3 direction = direction_->value();
    if (direction.isZero(0.0)) {
      emit refused(tr(
          "Direction of gravity: at least one component must not be zero. The Tab key goes to the "
          "next component; the direction changes when the last field is left."));
      show_environment();
      return;
    }
    typed_direction_ = direction;
    next.direction = unit_direction(direction);
    what = tr("Gravity %1 m/s²").arg(short_number(next.strength));
  } else if (kind == EnvironmentKind::kAttraction) {
    // The initial strength causes a visible but moderate motion. The softening bounds the force at the
    // origin.
    next.strength = same ? attraction_->value() : 0.5;
    next.softening = same ? softening_->value() : 0.3;
    what = tr("Attraction %1 N m²").arg(short_number(next.strength));
  }
  emit edited(SetEnvironment{next}, what, continues_previous);
}

}  // namespace tetraction::viewer
