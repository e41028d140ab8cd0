#include "replay_bar.h"

#include <QCheckBox>
#include <QComboBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QSlider>
#include <QTimer>
#include <QToolButton>
#include <algorithm>
#include <cmath>

#include "viewer/gui/widgets/icons.h"

namespace tetraction::viewer {
namespace {

constexpr int kFrameTime_ms = 50;

}  // namespace

ReplayBar::ReplayBar(QWidget* parent)
    : QWidget(parent),
      slider_(new QSlider(Qt::Horizontal, this)),
      play_(new QToolButton(this)),
      loop_(new QCheckBox(tr("Loop"), this)),
      speed_(new QComboBox(this)),
      label_(new QLabel(this)),
      timer_(new QTimer(this)) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(6, 2, 6, 2);
  row->addWidget(play_);
  row->addWidget(slider_, 1);
  row->addWidget(label_);
  row->addWidget(speed_);
  row->addWidget(loop_);
  loop_->setObjectName(QStringLiteral("replay_loop"));
  loop_->setToolTip(tr("Plays the frames again and again"));
  loop_->setFocusPolicy(Qt::TabFocus);
  speed_->setObjectName(QStringLiteral("replay_speed"));
  speed_->setToolTip(tr("Frames in a second"));
  speed_->setFocusPolicy(Qt::TabFocus);
  for (const int rate : {1, 2, 5, 10, 20, 50}) speed_->addItem(tr("%1 frames/s").arg(rate), rate);
  speed_->setCurrentIndex(speed_->findData(1000 / kFrameTime_ms));
  connect(speed_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
          [this] { timer_->setInterval(1000 / speed_->currentData().toInt()); });
  slider_->setObjectName(QStringLiteral("replay_slider"));
  play_->setToolTip(tr("Plays the frames (Space)"));
  play_->setCheckable(true);
  play_->setIcon(icon(Icon::kRun));
  timer_->setInterval(kFrameTime_ms);
  connect(play_, &QToolButton::toggled, this, &ReplayBar::play);
  connect(timer_, &QTimer::timeout, this, [this] {
    if (slider_->value() == slider_->maximum() && loop_->isChecked()) {
      slider_->setValue(0);
    } else if (slider_->value() == slider_->maximum()) {
      play(false);
    } else {
      forward();
    }
  });
  connect(slider_, &QSlider::valueChanged, this, [this](int frame) {
    show_time();
    emit frame_wanted(frame);
  });
}

void ReplayBar::set_times(const std::vector<double>& times, RunKind kind) {
  times_ = times;
  kind_ = kind;
  slider_->setToolTip(kind == RunKind::kMotion ? tr("Frames of the run, by time in s")
                                               : tr("Frames of the load steps, by load factor"));
  play(false);
  const QSignalBlocker quiet(slider_);
  slider_->setRange(0, static_cast<int>(times.size()) - 1);
  slider_->setValue(0);
  show_time();
}

int ReplayBar::frame() const {
  return slider_->value();
}

void ReplayBar::set_frame(int frame) {
  slider_->setValue(frame);
}

void ReplayBar::set_time(double time) {
  if (times_.empty()) return;
  const auto nearest = std::min_element(times_.begin(), times_.end(), [time](double a, double b) {
    return std::abs(a - time) < std::abs(b - time);
  });
  set_frame(static_cast<int>(nearest - times_.begin()));
}

bool ReplayBar::playing() const {
  return timer_->isActive();
}

void ReplayBar::play(bool on) {
  if (on && slider_->value() == slider_->maximum()) slider_->setValue(0);
  if (on) {
    timer_->start();
  } else {
    timer_->stop();
  }
  const QSignalBlocker quiet(play_);
  play_->setChecked(on);
  play_->setIcon(icon(on ? Icon::kPause : Icon::kRun));
}

void ReplayBar::forward() {
  slider_->setValue(slider_->value() + 1);
}

void ReplayBar::show_time() {
  const auto frame = static_cast<std::size_t>(slider_->value());
  if (frame >= times_.size()) return;
  label_->setText((kind_ == RunKind::kMotion ? tr("t = %1 s, frame %2 of %3")
                                             : tr("load factor %1, frame %2 of %3"))
                      .arg(QString::number(times_[frame], 'f', 4))
                      .arg(frame + 1)
                      .arg(times_.size()));
}

}  // namespace tetraction::viewer
