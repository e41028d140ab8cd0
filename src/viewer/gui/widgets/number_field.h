// Fields for numbers with unit and range, with or without a slider.
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

/// A field for a number. The value changes when the user presses Return or leaves the field. If the
/// text is not a number or is out of range, the field refuses it and shows the allowed range.
class NumberField : public QLineEdit {
  Q_OBJECT

 public:
  /// `what` and `unit` are used in the tooltip and the message, for instance "Young's modulus", "Pa".
  NumberField(const QString& what, const QString& unit, NumberRange range,
              QWidget* parent = nullptr);
  /// Takes title, unit, range and help text from a scene key.
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
  /// The user entered a value that is not allowed. The argument is the message.
  void refused(const QString& message);
  /// The user has pressed Return or Escape.
  void finished();
  /// The field has lost the focus.
  void left();

 protected:
  void keyPressEvent(QKeyEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 private:
  void commit();
  void refuse(const QString& reason);
  void restore();
  void mark(bool wrong);

  QString what_, unit_;
  NumberRange range_;
  double value_ = 0.0;
  bool empty_ = true;  // whether no value has been set yet
};

/// The tooltip of a scene key: its help text and its range.
QString key_tip(const KeyInfo& key);

/// A field with a slider for the usual range of the number. A logarithmic slider changes the number
/// relative to what it is: a decade for 60 pixels. Afterwards it is in the middle again.
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
  /// The user entered another value. `continues_previous`: the slider is still moving, and this value
  /// replaces the previous one.
  void entered(double value, bool continues_previous);
  void refused(const QString& message);

 private:
  NumberSlider(NumberField* field, double low, double high, Scale scale, QWidget* parent);
  double value_at(int step) const;
  int step_of(double value) const;
  double decades() const;
  void recenter();
  void slider_moved();

  NumberField* field_;
  QSlider* slider_;
  QTimer* edit_timer_;  // limits the rate of values of a moving slider
  bool moving_ = false;
  double low_, high_;   // of a linear slider
  double start_ = 1.0;  // of a logarithmic slider: the number in its middle
  Scale scale_;
};

}  // namespace tetraction::viewer
