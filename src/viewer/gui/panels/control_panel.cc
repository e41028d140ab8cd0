#include "control_panel.h"

#include <QComboBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>
#include <cmath>
#include <limits>

#include "panel_layout.h"
#include "simulation/scene/setting_keys.h"
#include "viewer/gui/widgets/icons.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
namespace {

struct SolverChoice {
  const char* text;
  const char* kind;
  LinearSolver linear;
};
constexpr SolverChoice kSolvers[] = {
    {"Newton, chosen linear solver", "newton", LinearSolver::kAuto},
    {"Newton, matrix-free gradients", "newton", LinearSolver::kMatrixFree},
    {"Newton, conjugate gradients", "newton", LinearSolver::kCg},
    {"Newton, kept factor", "newton", LinearSolver::kFactor},
    {"Ceres", "ceres", LinearSolver::kAuto}};

}  // namespace

ControlPanel::ControlPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);

  auto* buttons = new QHBoxLayout;
  const auto button = [&](const QString& text, Icon picture, const QString& tip) {
    auto* b = new QPushButton(icon(picture), text, this);
    b->setToolTip(tip);
    buttons->addWidget(b);
    return b;
  };
  run_ = button(tr("Run"), Icon::kRun, tr("Run or pause (Space)"));
  run_->setObjectName(QStringLiteral("run"));
  step_ = button(tr("Step"), Icon::kStep, tr("One time step, then pause (S)"));
  step_->setObjectName(QStringLiteral("step"));
  restart_ =
      button(tr("Restart"), Icon::kRestart,
             tr("Back to the scene's start; settings, fixes and forces stay as they are (R)"));
  restart_->setObjectName(QStringLiteral("restart"));
  column->addLayout(buttons);
  connect(run_, &QPushButton::clicked, this, [this] { emit run_wanted(!running_); });
  connect(step_, &QPushButton::clicked, this, &ControlPanel::step_wanted);
  connect(restart_, &QPushButton::clicked, this, &ControlPanel::restart_wanted);

  auto* now = add_group(column, tr("Now"));
  time_ = new QLabel(this);
  factor_ = new QLabel(this);
  factor_->setToolTip(tr("Simulated seconds a second of wall clock"));
  now->addRow(tr("Time"), time_);
  now->addRow(tr("Real-time factor"), factor_);

  auto* speed = add_group(column, tr("Speed"));
  per_picture_ = new QSpinBox(this);
  per_picture_->setObjectName(QStringLiteral("steps_per_picture"));
  per_picture_->setRange(1, 100000);
  per_picture_->setToolTip(tr("Time steps from one picture to the next, 1 to 100000"));
  speed->addRow(tr("Steps a picture"), per_picture_);
  connect(per_picture_, QOverload<int>::of(&QSpinBox::valueChanged), this,
          &ControlPanel::steps_per_picture);
  speed_ = new NumberField(tr("Largest real-time factor (0: as fast as it goes)"), QString(),
                           {0.0, kInfinity}, this);
  speed_->setObjectName(QStringLiteral("speed_limit"));
  speed_->set_value(1.0);
  speed->addRow(tr("At most × real time"), speed_);
  connect(speed_, &NumberField::entered, this, &ControlPanel::speed_limited);
  connect(speed_, &NumberField::refused, this, &ControlPanel::refused);

  auto* time = add_group(column, tr("Time steps"));
  integrator_ = new QComboBox(this);
  integrator_->setObjectName(QStringLiteral("integrator"));
  integrator_->setToolTip(
      tr("Explicit rules need steps below the stability limit; implicit ones solve each step"));
  for (const char* name : integrator_names()) integrator_->addItem(QString::fromUtf8(name));
  time->addRow(tr("Integrator"), integrator_);
  step_size_ = new NumberSlider(key_info(&TimeSettings::step), 1e-6, 1e-1,
                                NumberSlider::Scale::kLogarithmic, this);
  step_size_->setObjectName(QStringLiteral("step_size"));
  time->addRow(tr("Step [s]"), step_size_);
  limit_ = new QLabel(this);
  limit_->setObjectName(QStringLiteral("limit"));
  limit_->setToolTip(tr("Largest stable step of the explicit rules, 2/ω_max, estimated now"));
  half_limit_ = new QPushButton(tr("Use half"), this);
  half_limit_->setObjectName(QStringLiteral("use_half"));
  half_limit_->setToolTip(tr("Sets the step to half the stability limit"));
  auto* limit_row = new QHBoxLayout;
  limit_row->addWidget(limit_, 1);
  limit_row->addWidget(half_limit_);
  time->addRow(tr("Stability limit"), limit_row);
  adapt_ = new QComboBox(this);
  adapt_->setObjectName(QStringLiteral("adapt"));
  adapt_->setToolTip(
      tr("How the step size follows the motion: not at all, by an estimate of the error of each "
         "step, or such that the discrete energy stays the same (midpoint)"));
  for (const char* name : names_of<StepAdaptation>()) adapt_->addItem(QString::fromUtf8(name));
  time->addRow(tr("Adaptive steps"), adapt_);
  step_tolerance_ = new NumberField(key_info(&TimeSettings::tolerance), this);
  step_tolerance_->setObjectName(QStringLiteral("step_tolerance"));
  time->addRow(tr("Error of a step"), step_tolerance_);
  retry_ = new QSpinBox(this);
  retry_->setObjectName(QStringLiteral("retry"));
  const KeyInfo& retry_key = key_info(&TimeSettings::retry);
  retry_->setRange(0, static_cast<int>(retry_key.range.most));
  retry_->setToolTip(key_tip(retry_key));
  retry_->setKeyboardTracking(false);
  time->addRow(tr("Halve failed steps"), retry_);

  auto* solver = add_group(column, tr("Solver of implicit steps"));
  solver_ = new QComboBox(this);
  solver_->setObjectName(QStringLiteral("solver"));
  solver_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  for (const SolverChoice& choice : kSolvers) solver_->addItem(tr(choice.text));
  solver_->setToolTip(tr("Minimiser of each implicit step, and its linear systems"));
  solver->addRow(tr("Solver"), solver_);
  tolerance_ = new NumberField(key_info(&SolverSettings::tolerance), this);
  tolerance_->setObjectName(QStringLiteral("tolerance"));
  solver->addRow(tr("Tolerance"), tolerance_);
  iterations_ = new QSpinBox(this);
  iterations_->setObjectName(QStringLiteral("max_iterations"));
  const KeyInfo& iterations_key = key_info(&SolverSettings::max_iterations);
  iterations_->setRange(static_cast<int>(iterations_key.range.least), 100000);
  iterations_->setToolTip(key_tip(iterations_key));
  iterations_->setKeyboardTracking(false);
  solver->addRow(tr("Most iterations"), iterations_);
  column->addStretch(1);

  connect(integrator_, QOverload<int>::of(&QComboBox::activated), this, [this] {
    settings_.time.integrator = integrator_from_string(integrator_->currentText().toStdString());
    time_edited(tr("Integrator %1").arg(integrator_->currentText()), false);
  });
  connect(step_size_, &NumberSlider::entered, this, [this](double h, bool continues_previous) {
    settings_.time.step = h;
    time_edited(tr("Step %1 s").arg(short_number(h)), continues_previous);
  });
  connect(half_limit_, &QPushButton::clicked, this, [this] {
    if (!(stable_step_ > 0.0) || !std::isfinite(stable_step_)) return;
    settings_.time.step = short_number(0.5 * stable_step_).toDouble();
    time_edited(tr("Step %1 s").arg(short_number(settings_.time.step)), false);
  });
  connect(adapt_, QOverload<int>::of(&QComboBox::activated), this, [this] {
    settings_.time.adapt = from_string<StepAdaptation>(adapt_->currentText().toStdString());
    if (settings_.time.adapt != StepAdaptation::kNone) settings_.time.retry = 0;
    time_edited(tr("Adaptive steps: %1").arg(adapt_->currentText()), false);
  });
  connect(step_tolerance_, &NumberField::entered, this, [this](double tolerance) {
    settings_.time.tolerance = tolerance;
    time_edited(tr("Error of a step %1").arg(short_number(tolerance)), false);
  });
  connect(retry_, QOverload<int>::of(&QSpinBox::valueChanged), this, [this](int halvings) {
    settings_.time.retry = halvings;
    time_edited(tr("Halve failed steps %1 times").arg(halvings), false);
  });
  connect(step_tolerance_, &NumberField::refused, this, &ControlPanel::refused);
  connect(solver_, QOverload<int>::of(&QComboBox::activated), this, &ControlPanel::solver_edited);
  connect(tolerance_, &NumberField::entered, this, &ControlPanel::solver_edited);
  connect(iterations_, QOverload<int>::of(&QSpinBox::valueChanged), this,
          &ControlPanel::solver_edited);
  connect(step_size_, &NumberSlider::refused, this, &ControlPanel::refused);
  connect(tolerance_, &NumberField::refused, this, &ControlPanel::refused);
}

void ControlPanel::time_edited(const QString& what, bool continues_previous) {
  settings_.time.automatic = false;
  emit edited(SetTime{settings_.time}, what, continues_previous);
}

void ControlPanel::solver_edited() {
  const SolverChoice& choice = kSolvers[solver_->currentIndex()];
  settings_.solver.kind = choice.kind;
  settings_.solver.linear = choice.linear;
  settings_.solver.tolerance = tolerance_->value();
  settings_.solver.max_iterations = iterations_->value();
  emit edited(SetSolver{settings_.solver},
              tr("Solver %1, tolerance %2")
                  .arg(solver_->currentText(), short_number(settings_.solver.tolerance)),
              false);
}

void ControlPanel::show_settings(const Settings& settings) {
  settings_ = settings;
  integrator_->setCurrentText(QString::fromStdString(to_string(settings.time.integrator)));
  step_size_->set_value(settings.time.step);
  const StepAdaptation adapt = settings.time.adapt;
  adapt_->setCurrentText(QString::fromStdString(to_string(adapt)));
  step_tolerance_->set_value(settings.time.tolerance);
  step_tolerance_->setEnabled(adapt == StepAdaptation::kError);
  retry_->setEnabled(adapt == StepAdaptation::kNone);
  if (!retry_->hasFocus()) {
    const QSignalBlocker quiet(retry_);
    retry_->setValue(settings.time.retry);
  }
  for (int i = 0; i < solver_->count(); ++i) {
    if (settings.solver.kind == kSolvers[i].kind && settings.solver.linear == kSolvers[i].linear) {
      solver_->setCurrentIndex(i);
    }
  }
  tolerance_->set_value(settings.solver.tolerance);
  if (!iterations_->hasFocus()) {
    const QSignalBlocker quiet(iterations_);
    iterations_->setValue(settings.solver.max_iterations);
  }
  const bool implicit = is_implicit(settings.time.integrator);
  solver_->setEnabled(implicit);
  tolerance_->setEnabled(implicit);
  iterations_->setEnabled(implicit);
  show_limit(stable_step_);
}

int ControlPanel::steps_between_pictures() const {
  return per_picture_->value();
}

double ControlPanel::speed_limit() const {
  return speed_->value();
}

void ControlPanel::show_state(const Snapshot& snapshot) {
  running_ = snapshot.running;
  run_->setText(running_ ? tr("Pause") : tr("Run"));
  run_->setIcon(icon(running_ ? Icon::kPause : Icon::kRun));
  QString time = tr("%1 s, step %2")
                     .arg(QString::number(snapshot.time, 'f', 4))
                     .arg(static_cast<qlonglong>(snapshot.step));
  if (snapshot.adapted_step > 0.0) time += tr(" of %1 s").arg(short_number(snapshot.adapted_step));
  time_->setText(time);
  factor_->setText(running_ ? QString::number(snapshot.real_time_factor, 'g', 3) : tr("paused"));
  show_limit(snapshot.stable_step);
}

void ControlPanel::show_limit(double stable_step) {
  stable_step_ = stable_step;
  const bool known = stable_step > 0.0 && std::isfinite(stable_step);
  const bool exceeded = known && settings_.time.step > stable_step;
  const bool matters = !is_implicit(settings_.time.integrator);
  QString text = known ? tr("%1 s").arg(short_number(stable_step)) : tr("none");
  if (exceeded) text += matters ? tr(", exceeded") : tr(", not needed");
  limit_->setText(text);
  limit_->setForegroundRole(exceeded && matters ? QPalette::BrightText : QPalette::WindowText);
  half_limit_->setEnabled(known);
}

}  // namespace tetraction::viewer
