// Messages inside the window, where they do not interrupt.
#pragma once

#include <QFrame>
#include <functional>

class QLabel;
class QPushButton;

namespace tetraction::viewer {

/// One line or more above the picture, until it is closed or another takes its place.
class MessageStrip : public QFrame {
  Q_OBJECT

 public:
  enum class Kind { kNote, kWarning, kError };
  explicit MessageStrip(QWidget* parent = nullptr);

  void show_message(Kind kind, const QString& text);
  /// With a button for what can be done about it.
  void show_message(Kind kind, const QString& text, const QString& button,
                    std::function<void()> action);
  /// From now on, until it is withdrawn with an empty one: the button of messages that have none.
  void set_way_out(const QString& button, std::function<void()> action);
  QString text() const;
  QPushButton* action_button() const { return action_; }

 private:
  QLabel* label_;
  QPushButton* action_;
  std::function<void()> do_;
  QString way_out_button_;
  std::function<void()> way_out_;
};

}  // namespace tetraction::viewer
