// Exact numbers with unit and range, by keyboard and by slider.
#pragma once

#include <QLineEdit>
#include <QString>
#include <QWidget>

#include "tetraction/core/number_range.h"

class QSlider;
class QTimer;

namespace tetraction {
struct KeyInfo;
}

namespace tetraction::viewer {

/// A field for one number. A text that is not a number or is out of range is refused in the field,
/// with the allowed range. The present value stays until the user presses Return or leaves the
/// field.
class NumberField : public QLineEdit {
  Q_OBJECT

 public:
  /// `what` and `unit` make the tooltip and the message: "Young's modulus", "Pa".
  NumberField(const QString& what, const QString& unit, NumberRange range,
              QWidget* parent = nullptr);
  /// Title, unit, range and meaning of a key of the scene.
  explicit NumberField(const KeyInfo& key, QWidget* parent = nullptr);

  double value() const { return value_; }
  /// Shows the present value, unless the user is typing another one.
  void set_value(double value);
  const QString& what() const { return what_; }
  const QString& unit() const { return unit_; }
  const NumberRange& range() const { return range_; }

 signals:
  /// The user entered another value.
  void entered(double value);
  /// The user entered an impossible value. The argument is a sentence about it.
  void refused(const QString& message);
  /// The user is done with the field, by Return or Escape.
  void finished();

 protected:
  void keyPressEvent(QKeyEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 private:
  void commit();
  void restore();
  void mark(bool wrong);

  QString what_, unit_;
  NumberRange range_;
  double value_ = 0.0;
  bool empty_ = true;  // nothing was shown yet
};

/// The meaning of a key of the scene and what it may be, as a tooltip.
QString key_tip(const KeyInfo& key);

/// A field with a slider for the range in which people usually look.
class NumberSlider : public QWidget {
  Q_OBJECT

 public:
  enum class Scale { kLinear, kLogarithmic };
  NumberSlider(const QString& what, const QString& unit, NumberRange allowed, double low,
               double high, Scale scale, QWidget* parent = nullptr);
  NumberSlider(const KeyInfo& key, double low, double high, Scale scale, QWidget* parent = nullptr);

  double value() const { return field_->value(); }
  void set_value(double value);
  NumberField* field() const { return field_; }
  QSlider* slider() const { return slider_; }

 signals:
  /// `goes_on`: the slider is still moving, and this value replaces the one before.
  void entered(double value, bool goes_on);
  void refused(const QString& message);

 private:
  NumberSlider(NumberField* field, double low, double high, Scale scale, QWidget* parent);
  double at(int place) const;
  int place_of(double value) const;
  void slid();

  NumberField* field_;
  QSlider* slider_;
  QTimer* pause_;  // between two values of a slider under way
  bool under_way_ = false;
  double low_, high_;
  Scale scale_;
};

}  // namespace tetraction::viewer
