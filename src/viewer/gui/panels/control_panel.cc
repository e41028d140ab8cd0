#include "control_panel.h"

#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QSpinBox>
#include <QStyle>
#include <QVBoxLayout>

#include "panel_layout.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
ControlPanel::ControlPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);

  auto* buttons = new QHBoxLayout;
  const auto button = [&](const QString& text, QStyle::StandardPixmap icon, const QString& tip) {
    auto* b = new QPushButton(style()->standardIcon(icon), text, this);
    b->setToolTip(tip);
    buttons->addWidget(b);
    return b;
  };
  run_ = button(tr("Run"), QStyle::SP_MediaPlay, tr("Run or pause (Space)"));
  run_->setObjectName(QStringLiteral("run"));
  step_ = button(tr("Step"), QStyle::SP_MediaSkipForward, tr("One time step, then pause (S)"));
  step_->setObjectName(QStringLiteral("step"));
  restart_ =
      button(tr("Restart"), QStyle::SP_MediaSkipBackward,
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

  column->addStretch(1);
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
  run_->setIcon(style()->standardIcon(running_ ? QStyle::SP_MediaPause : QStyle::SP_MediaPlay));
  QString time = tr("%1 s, step %2")
                     .arg(QString::number(snapshot.time, 'f', 4))
                     .arg(static_cast<qlonglong>(snapshot.step));
  if (snapshot.adapted_step > 0.0) time += tr(" of %1 s").arg(short_number(snapshot.adapted_step));
  time_->setText(time);
  factor_->setText(running_ ? QString::number(snapshot.real_time_factor, 'g', 3) : tr("paused"));
}

}  // namespace tetraction::viewer
