#include "number_field.h"

#include <QHBoxLayout>
#include <QKeyEvent>
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

QString text_of(const NumberRange& range) {
  return QString::fromStdString(range.text());
}

QString number(double value) {
  return QString::number(value, 'g', 6);
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
  const QString unit = QString::fromUtf8(key.unit);
  return NumberField::tr("%1%2; allowed: %3")
      .arg(help, unit.isEmpty() ? QString() : NumberField::tr("; in %1").arg(unit),
           QString::fromStdString(key.range.text()));
}

NumberField::NumberField(const QString& what, const QString& unit, NumberRange range,
                         QWidget* parent)
    : QLineEdit(parent), what_(what), unit_(unit), range_(range) {
  setAlignment(Qt::AlignRight);
  setAccessibleName(what);
  setToolTip(unit.isEmpty() ? tr("%1; allowed: %2").arg(what, text_of(range))
                            : tr("%1 in %2; allowed: %3").arg(what, unit, text_of(range)));
  connect(this, &QLineEdit::textEdited, this, [this] { mark(false); });
}

NumberField::NumberField(const KeyInfo& key, QWidget* parent)
    : NumberField(QString::fromUtf8(key.title), QString::fromUtf8(key.unit), key.range, parent) {
  setToolTip(key_tip(key));
}

QSize NumberField::sizeHint() const {
  QSize size = QLineEdit::sizeHint();
  size.setWidth(fontMetrics().horizontalAdvance(QStringLiteral("-0.000000e-00")) + 14);
  return size;
}

QSize NumberField::minimumSizeHint() const {
  QSize size = QLineEdit::minimumSizeHint();
  size.setWidth(fontMetrics().horizontalAdvance(QStringLiteral("-0.000e-00")) + 12);
  return size;
}

void NumberField::set_value(double value) {
  if (value == value_ && !empty_) return;
  value_ = value;
  empty_ = false;
  if (!(hasFocus() && isModified())) restore();
}

void NumberField::restore() {
  setText(number(value_));
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
  const QString typed = text().trimmed().replace(QLatin1Char(','), QLatin1Char('.'));
  const double value = typed.toDouble(&is_number);
  if (exceeds_numbers(typed)) {
    using Limits = std::numeric_limits<double>;
    refuse(typed.contains(QLatin1String("e-"), Qt::CaseInsensitive)
               ? tr("is too near to zero; the smallest number above it is %1").arg(Limits::min())
               : tr("is too large; the largest number is %1").arg(Limits::max()));
    return;
  }
  if (!is_number || !range_.contains(value)) {
    refuse(tr("is not possible; allowed: %1%2")
               .arg(text_of(range_), unit_.isEmpty() ? QString() : QLatin1Char(' ') + unit_));
    return;
  }
  setModified(false);
  if (value != value_) {
    value_ = value;
    emit entered(value);
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
    emit finished();
    return;
  }
  QLineEdit::keyPressEvent(event);
}

void NumberField::focusOutEvent(QFocusEvent* event) {
  if (event->reason() != Qt::PopupFocusReason) {
    commit();
    // A text that was refused is removed.
    if (isModified() || !empty_) restore();
  }
  QLineEdit::focusOutEvent(event);
  if (event->reason() != Qt::PopupFocusReason) emit left();
}

NumberSlider::NumberSlider(const QString& what, const QString& unit, NumberRange allowed,
                           double low, double high, Scale scale, QWidget* parent)
    : NumberSlider(new NumberField(what, unit, allowed), low, high, scale, parent) {}

NumberSlider::NumberSlider(const KeyInfo& key, double low, double high, Scale scale,
                           QWidget* parent)
    : NumberSlider(new NumberField(key), low, high, scale, parent) {}

NumberSlider::NumberSlider(NumberField* field, double low, double high, Scale scale,
                           QWidget* parent)
    : QWidget(parent),
      field_(field),
      edit_timer_(new QTimer(this)),
      low_(low),
      high_(high),
      scale_(scale) {
  // The Tab key follows the order in which children are added.
  field_->setParent(this);
  slider_ = new QSlider(Qt::Horizontal, this);
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(slider_, 3);
  layout->addWidget(field_, 2);
  slider_->setRange(0, kSliderSteps);
  slider_->setPageStep(kSliderSteps / 20);
  slider_->setMinimumWidth(70);
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
    recenter();
  });
  connect(edit_timer_, &QTimer::timeout, this, &NumberSlider::slider_moved);
  connect(field_, &NumberField::entered, this, [this](double value) {
    recenter();
    emit entered(value, false);
  });
  connect(field_, &NumberField::refused, this, &NumberSlider::refused);
}

void NumberSlider::set_value(double value) {
  if (edit_timer_->isActive() || slider_->isSliderDown()) return;  // the user is changing the value
  field_->set_value(value);
  recenter();
}

// Moves the slider to the place of the present number.
void NumberSlider::recenter() {
  if (slider_->isSliderDown()) return;
  const QSignalBlocker quiet(slider_);
  start_ = field_->value();
  slider_->setValue(step_of(start_));
}

double NumberSlider::value_at(int step) const {
  const double t = static_cast<double>(step) / kSliderSteps;
  const double value = scale_ == Scale::kLogarithmic
                           ? start_ * std::pow(10.0, (t - 0.5) * decades())
                           : low_ + t * (high_ - low_);
  return QString::number(value, 'g', 3).toDouble();  // the resolution of the slider
}

double NumberSlider::decades() const {
  return std::max(1.0, slider_->width() / kPixelsPerDecade);
}

int NumberSlider::step_of(double value) const {
  const double t = scale_ == Scale::kLogarithmic
                       ? (value > 0.0 ? 0.5 + std::log10(value / start_) / decades() : 0.0)
                       : (value - low_) / (high_ - low_);
  return static_cast<int>(std::lround(std::clamp(t, 0.0, 1.0) * kSliderSteps));
}

void NumberSlider::slider_moved() {
  edit_timer_->stop();
  if (step_of(field_->value()) == slider_->value()) return;
  const double value = value_at(slider_->value());
  if (!field_->range().contains(value)) return recenter();
  field_->setModified(false);
  field_->set_value(value);
  emit entered(value, moving_);
  moving_ = slider_->isSliderDown();
  recenter();
}

}  // namespace tetraction::viewer
