// Messages in a strip of the window, which do not interrupt the user.
#pragma once

#include <QFrame>
#include <functional>

class QLabel;
class QPushButton;

namespace tetraction::viewer {

/// Shows a message above the picture until the user closes it or another message replaces it.
class MessageStrip : public QFrame {
  Q_OBJECT

 public:
  enum class Kind { kNote, kWarning, kError };
  explicit MessageStrip(QWidget* parent = nullptr);

  void show_message(Kind kind, const QString& text);
  /// Shows a message with a button that calls `action`.
  void show_message(Kind kind, const QString& text, const QString& button,
                    std::function<void()> action);
  /// Sets the button and action of all later messages that have none. An empty button ends this.
  void set_default_action(const QString& button, std::function<void()> action);
  QString text() const;
  QPushButton* action_button() const { return action_; }

 private:
  QLabel* label_;
  QPushButton* action_;
  std::function<void()> do_;
  QString default_button_;
  std::function<void()> default_action_;
};

}  // namespace tetraction::viewer
