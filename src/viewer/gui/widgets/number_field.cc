#include "number_field.h"

#include <QApplication>
#include <QDateTime>
#include <QHBoxLayout>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QSlider>
#include <QTimer>
#include <QToolTip>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "simulation/scene/setting_keys.h"

#include "theme.h"

namespace tetraction::viewer {
namespace {

constexpr int kSliderSteps = 1000;
constexpr double kPixelsPerDecade = 60.0;
constexpr int kEditInterval_ms = 40;  // between two values of a moving slider

QString text_of(NumberRange range, const DisplayUnit& unit) {
  range.least = unit.from_si(range.least);
  range.most = unit.from_si(range.most);
  return QString::fromStdString(range.text());
}

// Whether the text is a decimal number that is too large or too near to zero for the computer.
bool exceeds_numbers(const QString& text) {
  const QByteArray digits = text.toLatin1();
  const char* first = digits.begin() + (digits.startsWith('+') ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, digits.end(), value);
  return error == std::errc::result_out_of_range && end == digits.end();
}

}  // namespace

QString key_tip(const KeyInfo& key) {
  QString help = QString::fromUtf8(key.help);
  help.remove(QLatin1Char('`')).remove(QLatin1String("**"));
  const DisplayUnit shown = display_unit(key.unit);
  const QString unit = QString::fromStdString(shown.text);
  return NumberField::tr("%1%2; allowed: %3")
      .arg(help, unit.isEmpty() ? QString() : NumberField::tr("; in %1").arg(unit),
           text_of(key.range, shown));
}

NumberField::NumberField(const QString& what, const QString& unit, NumberRange range,
                         QWidget* parent)
    : QLineEdit(parent), what_(what), range_(range) {
  setAlignment(Qt::AlignRight);
  setAccessibleName(what);
  set_unit(unit);
  connect(this, &QLineEdit::textEdited, this, [this] {
    refused_ = false;
    mark(false);
  });
}

void NumberField::set_unit(const QString& unit) {
  unit_ = unit;
  shown_ = display_unit(unit.toStdString());
  setToolTip(unit.isEmpty() ? tr("%1; allowed: %2").arg(what_, range_text())
                            : tr("%1 in %2; allowed: %3").arg(what_, unit_text(), range_text()));
  set_margin();
  if (!empty_) restore();
}

QString NumberField::unit_text() const {
  return QString::fromStdString(shown_.text);
}

QString NumberField::range_text() const {
  return text_of(range_, shown_);
}

QString NumberField::number() const {
  return QString::number(shown_.from_si(value_), 'g', 6);
}

QSize NumberField::sizeHint() const {
  QSize size = QLineEdit::sizeHint();
  size.setWidth(fontMetrics().horizontalAdvance(QStringLiteral("-0.000000e-00")) + 14 +
                textMargins().right());
  return size;
}

QSize NumberField::minimumSizeHint() const {
  QSize size = QLineEdit::minimumSizeHint();
  size.setWidth(fontMetrics().horizontalAdvance(QStringLiteral("-0.0e-00")) + 12 +
                textMargins().right());
  return size;
}

void NumberField::set_value(double value) {
  if (drag_) return;
  if (value == value_ && !empty_ && !instead_) return;
  value_ = value;
  empty_ = false;
  instead_.reset();
  if (!refused_ && !(hasFocus() && isModified())) restore();
}

void NumberField::set_text_value(const QString& text) {
  if (instead_ == text) return;
  instead_ = text;
  empty_ = false;
  if (!refused_ && !(hasFocus() && isModified())) restore();
}

void NumberField::show_refused() {
  refused_ = true;
  setModified(true);
  mark(true);
}

void NumberField::restore() {
  refused_ = false;
  setText(instead_ ? *instead_ : number());
  setModified(false);
  mark(false);
}

void NumberField::mark(bool wrong) {
  const ColorPair& error = theme_colors().cards[2];
  setStyleSheet(wrong ? QStringLiteral("QLineEdit { background: %1; color: %2; }")
                            .arg(error.ground.name(), error.text.name())
                      : QString());
}

void NumberField::commit() {
  if (!isModified()) return;
  bool is_number = false;
  if (instead_ && text().trimmed() == *instead_) return restore();
  const QString typed = text().trimmed().replace(QLatin1Char(','), QLatin1Char('.'));
  const double value = shown_.to_si(typed.toDouble(&is_number));
  if (exceeds_numbers(typed)) {
    using Limits = std::numeric_limits<double>;
    refuse(typed.contains(QLatin1String("e-"), Qt::CaseInsensitive)
               ? tr("is too near to zero; the smallest number above it is %1").arg(Limits::min())
               : tr("is too large; the largest number is %1").arg(Limits::max()));
    return;
  }
  if (!is_number && take_other_ && take_other_(text().trimmed())) {
    if (!refused_) setModified(false);
    return;
  }
  if (!is_number || !range_.contains(value)) {
    refuse(tr("is not possible; allowed: %1%2")
               .arg(range_text(), unit_.isEmpty() ? QString() : tr(", in %1").arg(unit_text())));
    return;
  }
  setModified(false);
  if (value != value_ || instead_) {
    value_ = value;
    instead_.reset();
    emit entered(value);
  }
}

void NumberField::set_draggable() {
  draggable_ = true;
  setCursor(Qt::SizeHorCursor);
  set_margin();
}

void NumberField::set_margin() {
  const bool shows_unit = draggable_ && !unit_.isEmpty();
  setTextMargins(0, 0, shows_unit ? fontMetrics().horizontalAdvance(unit_text()) + 4 : 0, 0);
}

void NumberField::paintEvent(QPaintEvent* event) {
  QLineEdit::paintEvent(event);
  if (!draggable_ || unit_.isEmpty()) return;
  QPainter painter(this);
  painter.setPen(palette().color(QPalette::Disabled, QPalette::Text));
  painter.drawText(rect().adjusted(0, 0, -6, 0), Qt::AlignRight | Qt::AlignVCenter, unit_text());
}

// The value after the mouse has moved. A number that is 0 begins at a thousandth.
double NumberField::dragged_value() const {
  const double start = drag_->value;
  const double decades = drag_->decades;
  const double value =
      start != 0.0
          ? start * std::pow(10.0, decades)
          : std::copysign(shown_.to_si(1e-3) * (std::pow(10.0, std::abs(decades)) - 1.0), decades);
  return whole_ ? std::round(value) : QString::number(value, 'g', 3).toDouble();
}

void NumberField::mousePressEvent(QMouseEvent* event) {
  const bool is_first = draggable_ && event->button() == Qt::LeftButton && !hasFocus();
  if (is_first && instead_) {
    setFocus(Qt::MouseFocusReason);
    selectAll();
  } else if (is_first) {
    const int x = event->pos().x();
    drag_ = Drag{.from = x, .last = x, .value = value_};
    event->accept();
  } else {
    QLineEdit::mousePressEvent(event);
  }
}

void NumberField::mouseMoveEvent(QMouseEvent* event) {
  if (!drag_) return QLineEdit::mouseMoveEvent(event);
  const int x = event->pos().x();
  drag_->moved = drag_->moved || std::abs(x - drag_->from) >= QApplication::startDragDistance() / 2;
  if (!drag_->moved) return;
  const bool fine = (event->modifiers() & Qt::ShiftModifier) != 0;
  drag_->decades += (x - std::exchange(drag_->last, x)) / (fine ? 10.0 : 1.0) / kPixelsPerDecade;
  const double value = dragged_value();
  if (value == value_ || !range_.contains(value)) return;
  value_ = value;
  restore();
  const qint64 now = QDateTime::currentMSecsSinceEpoch();
  if (now - drag_->sent_at < kEditInterval_ms) return;
  drag_->sent_at = now;
  emit dragged(value, {.continues_previous = std::exchange(drag_->sent, true), .goes_on = true});
}

void NumberField::mouseReleaseEvent(QMouseEvent* event) {
  if (!drag_) return QLineEdit::mouseReleaseEvent(event);
  const Drag drag = *std::exchange(drag_, std::nullopt);
  if (!drag.moved) {
    setFocus(Qt::MouseFocusReason);
    selectAll();
  } else if (value_ != drag.value || drag.sent) {
    emit dragged(value_, {.continues_previous = drag.sent});
  }
}

// Shows that the text is not accepted. `reason` is the rest of a sentence about it.
void NumberField::refuse(const QString& reason) {
  mark(true);
  const QString message = tr("%1: “%2” %3.").arg(what_, text(), reason);
  QToolTip::showText(mapToGlobal(QPoint(0, height())), message, this);
  emit refused(message);
}

void NumberField::keyPressEvent(QKeyEvent* event) {
  if (event->key() == Qt::Key_Return || event->key() == Qt::Key_Enter) {
    commit();
    if (!isModified()) emit finished();
    return;
  }
  if (event->key() == Qt::Key_Escape) {
    restore();
    emit given_up();
    emit finished();
    return;
  }
  QLineEdit::keyPressEvent(event);
}

void NumberField::focusOutEvent(QFocusEvent* event) {
  if (event->reason() != Qt::PopupFocusReason) {
    commit();
    // A text that was refused is removed, unless its reason is shown beside it.
    if (!refused_ && (isModified() || !empty_)) restore();
  }
  QLineEdit::focusOutEvent(event);
  if (event->reason() != Qt::PopupFocusReason) emit left();
}

NumberSlider::NumberSlider(const QString& what, const QString& unit, NumberRange allowed,
                           double low, double high, QWidget* parent)
    : NumberSlider(new NumberField(what, unit, allowed), low, high, parent) {}

NumberSlider::NumberSlider(NumberField* field, double low, double high, QWidget* parent)
    : QWidget(parent), field_(field), edit_timer_(new QTimer(this)), low_(low), high_(high) {
  // The Tab key follows the order in which children are added.
  field_->setParent(this);
  slider_ = new QSlider(Qt::Horizontal, this);
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(slider_, 3);
  layout->addWidget(field_, 2);
  slider_->setRange(0, kSliderSteps);
  slider_->setPageStep(kSliderSteps / 20);
  slider_->setMinimumWidth(40);
  slider_->setAccessibleName(field_->what());
  slider_->setToolTip(field_->toolTip());
  setFocusProxy(field_);
  edit_timer_->setSingleShot(true);
  edit_timer_->setInterval(kEditInterval_ms);
  connect(slider_, &QSlider::valueChanged, this, [this] {
    if (!edit_timer_->isActive()) edit_timer_->start();
  });
  connect(slider_, &QSlider::sliderReleased, this, [this] {
    slider_moved();
    moving_ = false;
  });
  connect(edit_timer_, &QTimer::timeout, this, &NumberSlider::slider_moved);
  connect(field_, &NumberField::entered, this, [this](double value) {
    move_slider();
    emit entered(value, {});
  });
  connect(field_, &NumberField::refused, this, &NumberSlider::refused);
}

void NumberSlider::set_value(double value) {
  if (edit_timer_->isActive() || slider_->isSliderDown()) return;  // the user is changing the value
  field_->set_value(value);
  move_slider();
}

void NumberSlider::move_slider() {
  const QSignalBlocker quiet(slider_);
  slider_->setValue(step_of(field_->value()));
}

double NumberSlider::value_at(int step) const {
  const double t = static_cast<double>(step) / kSliderSteps;
  return QString::number(low_ + t * (high_ - low_), 'g', 3).toDouble();  // its resolution
}

int NumberSlider::step_of(double value) const {
  const double t = (value - low_) / (high_ - low_);
  return static_cast<int>(std::lround(std::clamp(t, 0.0, 1.0) * kSliderSteps));
}

void NumberSlider::slider_moved() {
  edit_timer_->stop();
  if (step_of(field_->value()) == slider_->value()) return;
  const double value = value_at(slider_->value());
  field_->setModified(false);
  field_->set_value(value);
  emit entered(value, {.continues_previous = moving_, .goes_on = slider_->isSliderDown()});
  moving_ = slider_->isSliderDown();
}

}  // namespace tetraction::viewer
