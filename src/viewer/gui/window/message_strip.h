// Messages that float over the picture and do not interrupt the user.
#pragma once

#include <QFrame>
#include <functional>
#include <map>
#include <vector>

class QLabel;
class QVBoxLayout;

namespace tetraction::viewer {

/// A button of a message.
struct MessageAction {
  QString text;
  std::function<void()> act;
};

/// Shows messages as cards at the top of another widget, which keeps its size. A message belongs to a
/// cause: another one of the same cause replaces it, and it goes with its cause, with one of its
/// actions, or when the user closes it.
class MessageStrip : public QFrame {
  Q_OBJECT

 public:
  enum class Kind { kNote, kWarning, kError };
  /// Shows the cards over `over`.
  explicit MessageStrip(QWidget* over);

  /// `cause` may be empty: the next message without a cause replaces this one.
  void show_message(Kind kind, const QString& text, const QString& cause = {},
                    std::vector<MessageAction> actions = {});
  /// Removes the message of a cause.
  void end(const QString& cause);
  /// Removes all messages.
  void clear();
  /// The texts of all messages, a line each.
  QString text() const;
  /// The text of the message of a cause. Empty if there is none.
  QString text(const QString& cause) const;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  struct Card {
    QFrame* frame;
    QLabel* label;
    Kind kind;
  };
  static void set_colors(const Card& card);
  void place();

  std::map<QString, Card> cards_;
  QVBoxLayout* column_;
};

}  // namespace tetraction::viewer
