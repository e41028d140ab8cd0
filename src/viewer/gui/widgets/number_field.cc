#include "number_field.h"

#include <QHBoxLayout>
#include <QKeyEvent>
#include <QSlider>
#include <QTimer>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "tetraction/simulation/setting_keys.h"

namespace tetraction::viewer {
namespace {

constexpr int kPlaces = 1000;  // of a slider
constexpr int kPause_ms = 40;  // between two values of a slider that is dragged

QString text_of(const NumberRange& range) {
  return QString::fromStdString(range.text());
}

QString number(double value) {
  return QString::number(value, 'g', 6);
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
  setStyleSheet(wrong ? QStringLiteral("QLineEdit { background: #ffd6d6; color: #7a0000; }")
                      : QString());
}

void NumberField::commit() {
  if (!isModified()) return;
  bool is_number = false;
  const double value =
      text().trimmed().replace(QLatin1Char(','), QLatin1Char('.')).toDouble(&is_number);
  if (!is_number || !range_.contains(value)) {
    mark(true);
    const QString message = tr("%1: “%2” is not possible; allowed: %3%4.")
                                .arg(what_, text(), text_of(range_),
                                     unit_.isEmpty() ? QString() : QLatin1Char(' ') + unit_);
    QToolTip::showText(mapToGlobal(QPoint(0, height())), message, this);
    emit refused(message);
    return;
  }
  setModified(false);
  if (value != value_) {
    value_ = value;
    emit entered(value);
  }
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
    if (isModified())
      restore();  // what was refused does not stay behind
    else if (!empty_)
      restore();
  }
  QLineEdit::focusOutEvent(event);
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
      pause_(new QTimer(this)),
      low_(low),
      high_(high),
      scale_(scale) {
  // Tab comes to children in the order in which they are added.
  field_->setParent(this);
  slider_ = new QSlider(Qt::Horizontal, this);
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(slider_, 3);
  layout->addWidget(field_, 2);
  slider_->setRange(0, kPlaces);
  slider_->setPageStep(kPlaces / 20);
  slider_->setMinimumWidth(70);
  slider_->setAccessibleName(field_->what());
  slider_->setToolTip(field_->toolTip());
  setFocusProxy(field_);
  pause_->setSingleShot(true);
  pause_->setInterval(kPause_ms);
  connect(slider_, &QSlider::valueChanged, this, [this] {
    if (!pause_->isActive()) pause_->start();
  });
  connect(slider_, &QSlider::sliderReleased, this, [this] {
    slid();
    under_way_ = false;
  });
  connect(pause_, &QTimer::timeout, this, &NumberSlider::slid);
  connect(field_, &NumberField::entered, this, [this](double value) {
    const QSignalBlocker quiet(slider_);
    slider_->setValue(place_of(value));
    emit entered(value, false);
  });
  connect(field_, &NumberField::refused, this, &NumberSlider::refused);
}

void NumberSlider::set_value(double value) {
  if (pause_->isActive() || slider_->isSliderDown()) return;  // the user's own value is on its way
  field_->set_value(value);
  const QSignalBlocker quiet(slider_);
  slider_->setValue(place_of(value));
}

double NumberSlider::at(int place) const {
  const double t = static_cast<double>(place) / kPlaces;
  const double value =
      scale_ == Scale::kLogarithmic ? low_ * std::pow(high_ / low_, t) : low_ + t * (high_ - low_);
  return QString::number(value, 'g', 3).toDouble();  // no more digits than a slider has
}

int NumberSlider::place_of(double value) const {
  const double t = scale_ == Scale::kLogarithmic
                       ? (value > 0.0 ? std::log(value / low_) / std::log(high_ / low_) : 0.0)
                       : (value - low_) / (high_ - low_);
  return static_cast<int>(std::lround(std::clamp(t, 0.0, 1.0) * kPlaces));
}

void NumberSlider::slid() {
  pause_->stop();
  if (place_of(field_->value()) == slider_->value()) return;
  const double value = at(slider_->value());
  field_->setModified(false);
  field_->set_value(value);
  emit entered(value, under_way_);
  under_way_ = slider_->isSliderDown();
}

}  // namespace tetraction::viewer
