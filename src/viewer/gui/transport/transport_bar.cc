#include "transport_bar.h"

#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QSpinBox>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

constexpr int kGap = 8;
constexpr int kTimeSize = 20;             // of the figures, pixels
constexpr int kTick_ms = 20;              // of a replay
constexpr double kUsualDuration_s = 5.0;  // of a replay at the speed that is chosen for it
constexpr double kSpeedOfModes = 0.5;     // periods in a second

QString seconds(double time, int digits) {
  return QString::fromStdString(with_unit(time, "s", digits));
}

}  // namespace

TransportBar::TransportBar(QWidget* parent)
    : QWidget(parent),
      buttons_(new QHBoxLayout),
      slider_row_(new QHBoxLayout),
      timeline_(new Timeline(this)),
      time_(new QLabel(this)),
      details_(new QLabel(this)),
      speed_(new QComboBox(this)),
      steps_(new QSpinBox(this)),
      loop_(new QCheckBox(tr("Loop"), this)),
      timer_(new QTimer(this)) {
  setObjectName(QStringLiteral("transport"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, kGap / 2, 0, kGap / 2);
  column->setSpacing(kGap / 2);
  slider_row_->addWidget(timeline_);
  column->addLayout(slider_row_);
  auto* row = new QHBoxLayout;
  row->setContentsMargins(kGap, 0, kGap, 0);
  row->setSpacing(kGap);
  buttons_->setSpacing(2);
  row->addWidget(time_);
  row->addWidget(details_);
  row->addLayout(buttons_);
  row->addStretch(1);
  row->addWidget(loop_);
  row->addWidget(steps_);
  row->addWidget(speed_);
  column->addLayout(row);

  QFont large = font();
  large.setPixelSize(kTimeSize);
  time_->setFont(large);
  time_->setObjectName(QStringLiteral("time"));
  time_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  time_->setMinimumWidth(time_->fontMetrics().horizontalAdvance(QStringLiteral("0.0000 s")));
  details_->setObjectName(QStringLiteral("transport_details"));
  details_->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("step 0000000")));
  details_->setToolTip(tr("Steps, and simulated seconds in a second of wall clock"));
  speed_->setObjectName(QStringLiteral("speed"));
  speed_->setFocusPolicy(Qt::TabFocus);
  speed_->setToolTip(tr("Speed: the most simulated seconds in a second"));
  for (const int slowness : {1000, 500, 200, 100, 50, 20, 10, 5, 2}) {
    speed_->addItem(QStringLiteral("1/%1").arg(slowness), 1.0 / slowness);
  }
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    speed_->addItem(QStringLiteral("%1 ×").arg(factor), factor);
  }
  speed_->addItem(tr("max"), 0.0);
  speed_->setCurrentIndex(speed_->findData(1.0));
  steps_->setObjectName(QStringLiteral("steps_per_picture"));
  steps_->setRange(1, 100000);
  steps_->setPrefix(QStringLiteral("1 : "));
  steps_->setToolTip(tr("Time steps from one picture to the next, 1 to 100000"));
  loop_->setObjectName(QStringLiteral("replay_loop"));
  loop_->setToolTip(tr("Plays the frames again and again"));
  loop_->setFocusPolicy(Qt::TabFocus);
  timer_->setInterval(kTick_ms);

  connect(speed_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
          [this] { emit speed_changed(speed()); });
  connect(steps_, QOverload<int>::of(&QSpinBox::valueChanged), this, &TransportBar::steps_changed);
  connect(timer_, &QTimer::timeout, this, &TransportBar::play_on);
  connect(timeline_, &Timeline::time_wanted, this, &TransportBar::go_to);
  connect(timeline_, &QSlider::sliderReleased, this, [this] { timeline_->show_time(shown_); });
  connect(timeline_, &Timeline::stop_wanted, this, &TransportBar::go);
  begin_simulation();
}

void TransportBar::add_buttons(const std::vector<std::pair<const char*, QAction*>>& actions) {
  for (const auto& [name, action] : actions) {
    auto* button = new QToolButton(this);
    button->setObjectName(QLatin1String(name));
    button->setDefaultAction(action);
    button->setAutoRaise(true);
    button->setFocusPolicy(Qt::TabFocus);
    if (action->icon().isNull()) button->setToolButtonStyle(Qt::ToolButtonTextOnly);
    connect(action, &QAction::changed, button,
            [button, action = action] { button->setVisible(action->isVisible()); });
    button->setVisible(action->isVisible());
    buttons_->addWidget(button);
  }
}

void TransportBar::begin(bool replay, RunKind kind) {
  play(false);
  replay_ = replay;
  kind_ = kind;
  stop_ = 0;
  stops_.clear();
  // What goes away makes room first: otherwise the window would grow.
  QWidget* other[] = {loop_, steps_};
  if (replay) std::swap(other[0], other[1]);
  other[0]->setVisible(false);
  other[1]->setVisible(kind != RunKind::kMode);
  timeline_->set_marks({});
  timeline_->setToolTip(replay ? tr("The frames of the run")
                               : tr("The states that the run has kept: drag to look back"));
}

void TransportBar::begin_simulation() {
  begin(false, RunKind::kMotion);
}

void TransportBar::begin_replay(const std::vector<double>& times, RunKind kind) {
  begin(true, kind);
  stops_ = times;
  timeline_->set_span(times.front(), std::max(times.back(), times.front() + 1e-12));
  timeline_->set_stops(times);
  if (kind == RunKind::kMode) {
    speed_->setCurrentIndex(speed_->findData(kSpeedOfModes));
  } else {
    choose_speed(times.back() - times.front());
  }
  show_frame(0);
}

// The fastest of the speeds with which the frames last a few seconds.
void TransportBar::choose_speed(double duration) {
  for (int i = speed_->findData(1.0); i >= 0; --i) {
    speed_->setCurrentIndex(i);
    if (duration >= kUsualDuration_s * speed()) return;
  }
}

void TransportBar::follow_axis(int left, int right, double first, double last) {
  const int margin = timeline_->margin();
  const bool follows = last > first && right > left;
  slider_row_->setContentsMargins(follows ? std::max(left - margin, 0) : kGap, 0,
                                  follows ? std::max(width() - right - margin, 0) : kGap, 0);
  if (follows) {
    timeline_->set_span(first, last);
  } else if (!stops_.empty()) {
    timeline_->set_span(stops_.front(), std::max(stops_.back(), stops_.front() + 1e-12));
  }
  timeline_->show_time(shown_);
}

void TransportBar::show(double time, const QString& details) {
  shown_ = time;
  // As many digits as tell two steps apart, at least those of 0.1 ms.
  const DisplayUnit unit = display_unit(kind_ == RunKind::kMotion ? "s" : "");
  const double spacing =
      stops_.size() > 1 ? (stops_.back() - stops_.front()) / static_cast<double>(stops_.size()) : 1;
  const int digits = spacing > 0.0 ? static_cast<int>(std::ceil(1.0 - std::log10(spacing))) : 4;
  const QString number =
      QString::number(unit.from_si(time), 'f', std::max(0, std::clamp(digits, 4, 6) + unit.power));
  time_->setText((number + QLatin1Char(' ') + QString::fromStdString(unit.text)).trimmed());
  // It grows with the number, so that the buttons beside it rarely move.
  time_->setMinimumWidth(std::max(time_->minimumWidth(), time_->sizeHint().width()));
  details_->setText(details);
  timeline_->show_time(time);
}

void TransportBar::show_simulation(const Snapshot& snapshot, const std::vector<double>& kept) {
  stops_ = kept;
  if (stops_.empty() || stops_.back() < snapshot.newest) stops_.push_back(snapshot.newest);
  timeline_->set_stops(kept);
  steps_->setVisible(
      !snapshot.earlier);  // a small window has no room for it beside the button to continue
  QString details = tr("step %1").arg(static_cast<qlonglong>(snapshot.step));
  if (snapshot.adapted_step > 0.0) details += tr(" of %1").arg(seconds(snapshot.adapted_step, 3));
  details += QLatin1Char('\n');
  if (snapshot.running) {
    details += QStringLiteral("× %1").arg(snapshot.real_time_factor, 0, 'g', 3);
  } else {
    details += snapshot.earlier ? tr("of %1").arg(seconds(snapshot.newest, 4)) : tr("paused");
  }
  show(snapshot.time, details);
}

void TransportBar::show_frame(std::size_t frame) {
  stop_ = frame;
  const QString what = kind_ == RunKind::kMotion        ? QString()
                       : kind_ == RunKind::kEquilibrium ? tr("load factor,\n")
                                                        : tr("of the period,\n");
  show(stops_[frame], what + tr("frame %1 of %2").arg(frame + 1).arg(stops_.size()));
}

std::size_t TransportBar::nearest(double time) const {
  const auto next = std::lower_bound(stops_.begin(), stops_.end(), time);
  if (next == stops_.begin()) return 0;
  const auto i = static_cast<std::size_t>(next - stops_.begin());
  return next == stops_.end() || time - stops_[i - 1] < *next - time ? i - 1 : i;
}

void TransportBar::go_to(double time) {
  if (stops_.empty()) return;
  played_ = time;
  if (replay_) {
    emit frame_wanted(nearest(time));
  } else {
    emit time_wanted(time);
  }
}

void TransportBar::go(int direction) {
  if (stops_.empty()) return;
  const std::size_t now = replay_ ? stop_ : nearest(shown_);
  const bool is_end = direction < 0 ? now == 0 : now + 1 == stops_.size();
  if (!is_end) go_to(stops_[direction < 0 ? now - 1 : now + 1]);
}

bool TransportBar::playing() const {
  return timer_->isActive();
}

void TransportBar::play(bool on) {
  if (on == playing() || (on && !replay_)) return;
  if (on) {
    if (stop_ + 1 == stops_.size()) go_to(stops_.front());
    played_ = stops_[stop_];
    since_played_.start();
    timer_->start();
  } else {
    timer_->stop();
  }
  emit playing_changed(on);
}

void TransportBar::play_on() {
  const double passed = 1e-3 * static_cast<double>(since_played_.restart());
  if (stop_ + 1 == stops_.size()) {
    if (loop_->isChecked() || kind_ == RunKind::kMode) {
      go_to(stops_.front());
    } else {
      play(false);
    }
    return;
  }
  double time = stops_[stop_ + 1];
  if (speed() > 0.0) {
    played_ += passed * speed();
    if (played_ < time) return;
    time = *(std::upper_bound(stops_.begin(), stops_.end(), played_) - 1);
  }
  const double played = played_;
  go_to(time);
  played_ = speed() > 0.0 ? played : time;
}

double TransportBar::speed() const {
  return speed_->currentData().toDouble();
}

void TransportBar::set_speed(double speed) {
  speed_->setCurrentIndex(speed_->findData(speed));
}

int TransportBar::steps_per_picture() const {
  return steps_->value();
}

}  // namespace tetraction::viewer
