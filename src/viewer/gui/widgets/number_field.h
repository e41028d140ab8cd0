// Fields for numbers with unit and range, with or without a slider.
#pragma once

#include <QLineEdit>
#include <QString>
#include <QWidget>
#include <functional>
#include <optional>
#include <utility>

#include "tetraction/core/number_range.h"
#include "viewer/display_units.h"

class QSlider;
class QTimer;

namespace tetraction {
struct KeyInfo;
}

namespace tetraction::viewer {

/// Where a value stands in a drag of the mouse, whose values belong together.
struct InputStage {
  bool continues_previous = false;  ///< it replaces the value before it
  bool goes_on = false;             ///< others follow
};

/// A field for a number. Its values are in SI units, and its text is in the unit of display_unit(). The value changes when the user presses Return or leaves the field. If the
/// text is not a number or is out of range, the field refuses it and shows the allowed range.
class NumberField : public QLineEdit {
  Q_OBJECT

 public:
  /// `what` and `unit` are used in the tooltip and the message, for instance "Young's modulus", "Pa".
  NumberField(const QString& what, const QString& unit, NumberRange range,
              QWidget* parent = nullptr);

  double value() const { return value_; }
  /// Shows the present value, unless the user is typing another one.
  void set_value(double value);
  const QString& what() const { return what_; }
  const QString& unit() const { return unit_; }
  /// Another unit, or the same after a change of the system of units.
  void set_unit(const QString& unit);
  const NumberRange& range() const { return range_; }

  /// Shows a text in place of a number, such as "auto" or nothing, unless the user is typing.
  void set_text_value(const QString& text);
  /// A function that may take a text that is no number. It returns whether it has taken it.
  void set_other_texts(std::function<bool(const QString&)> take) { take_other_ = std::move(take); }
  /// Shows the unit inside the field. A drag of the mouse then changes the number: by a decade in 60
  /// pixels, with Shift in 600.
  void set_draggable();
  /// Drags change it by whole numbers.
  void set_whole() { whole_ = true; }
  /// Marks the text as refused. It stays until the user changes it.
  void show_refused();
  bool is_refused() const { return refused_; }

 signals:
  /// A drag has changed the value.
  void dragged(double value, tetraction::viewer::InputStage stage);
  /// The user entered another value.
  void entered(double value);
  /// The user entered a value that is not allowed. The argument is the message.
  void refused(const QString& message);
  /// The user has pressed Return or Escape.
  void finished();
  /// Before it, the user has pressed Escape.
  void given_up();
  /// The field has lost the focus.
  void left();

 protected:
  void keyPressEvent(QKeyEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void paintEvent(QPaintEvent* event) override;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 private:
  void commit();
  void refuse(const QString& reason);
  void restore();
  void mark(bool wrong);
  QString range_text() const;
  QString number() const;
  QString unit_text() const;
  void set_margin();

  QString what_, unit_;
  DisplayUnit shown_;
  NumberRange range_;
  double value_ = 0.0;
  bool empty_ = true;               // whether no value has been set yet
  std::optional<QString> instead_;  // the text in place of a number
  std::function<bool(const QString&)> take_other_;
  bool refused_ = false;  // whether the text stays although it was refused
  bool draggable_ = false;
  bool whole_ = false;
  struct Drag {
    int from = 0;
    int last = 0;  // place of the mouse
    double value = 0.0;
    double decades = 0.0;
    bool moved = false;
    bool sent = false;
    qint64 sent_at = 0;  // ms
  };
  double dragged_value() const;
  std::optional<Drag> drag_;
};

/// The tooltip of a scene key: its help text and its range.
QString key_tip(const KeyInfo& key);

/// A field with a slider for the usual range of the number.
class NumberSlider : public QWidget {
  Q_OBJECT

 public:
  NumberSlider(const QString& what, const QString& unit, NumberRange allowed, double low,
               double high, QWidget* parent = nullptr);

  double value() const { return field_->value(); }
  void set_value(double value);
  NumberField* field() const { return field_; }
  QSlider* slider() const { return slider_; }

 signals:
  /// The user entered another value.
  void entered(double value, tetraction::viewer::InputStage stage);
  void refused(const QString& message);

 private:
  NumberSlider(NumberField* field, double low, double high, QWidget* parent);
  double value_at(int step) const;
  int step_of(double value) const;
  void move_slider();
  void slider_moved();

  NumberField* field_;
  QSlider* slider_;
  QTimer* edit_timer_;  // limits the rate of values of a moving slider
  bool moving_ = false;
  double low_, high_;
};

}  // namespace tetraction::viewer
