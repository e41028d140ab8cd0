#include "message_strip.h"

#include <QEvent>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "viewer/gui/widgets/icons.h"
#include "viewer/gui/widgets/theme.h"

namespace tetraction::viewer {
namespace {

constexpr int kMargin = 8;     // around the cards, pixels
constexpr int kWidest = 720;   // of a card, pixels
constexpr int kMostCards = 4;  // the oldest ones go first

}  // namespace

MessageStrip::MessageStrip(QWidget* over) : QFrame(over), column_(new QVBoxLayout(this)) {
  setObjectName(QStringLiteral("message_strip"));
  column_->setContentsMargins(0, 0, 0, 0);
  column_->setSpacing(kMargin);
  over->installEventFilter(this);
  hide();
}

void MessageStrip::show_message(Kind kind, const QString& text, const QString& cause,
                                std::vector<MessageAction> actions) {
  end(cause);
  // What is said already, perhaps of another cause, is not said twice.
  const auto same = std::find_if(cards_.begin(), cards_.end(), [&](const auto& card) {
    return card.second.label->text() == text;
  });
  if (same != cards_.end()) end(QString(same->first));
  while (static_cast<int>(cards_.size()) >= kMostCards) {
    QWidget* oldest = column_->itemAt(0)->widget();
    const auto card = std::find_if(cards_.begin(), cards_.end(),
                                   [&](const auto& c) { return c.second.frame == oldest; });
    end(QString(card->first));
  }
  auto* frame = new QFrame(this);
  frame->setObjectName(QStringLiteral("message_card"));
  auto* rows = new QVBoxLayout(frame);
  rows->setContentsMargins(10, 5, 5, 5);
  auto* row = new QHBoxLayout;
  auto* label = new QLabel(text, frame);
  label->setWordWrap(true);
  label->setTextFormat(Qt::PlainText);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  row->addWidget(label, 1);
  auto* close = new QToolButton(frame);
  close->setAutoRaise(true);
  close->setFocusPolicy(Qt::TabFocus);
  close->setIcon(icon(Icon::kClose));
  close->setToolTip(tr("Close this message"));
  row->addWidget(close, 0, Qt::AlignTop);
  rows->addLayout(row);
  connect(close, &QToolButton::clicked, this, [this, cause] { end(cause); });
  if (!actions.empty()) {
    auto* buttons = new QHBoxLayout;
    for (MessageAction& action : actions) {
      auto* button = new QPushButton(action.text, frame);
      button->setObjectName(QStringLiteral("message_action"));
      button->setFocusPolicy(Qt::TabFocus);
      buttons->addWidget(button);
      connect(button, &QPushButton::clicked, this, [this, cause, act = std::move(action.act)] {
        const auto kept = act;  // the message and its buttons are deleted
        end(cause);
        if (kept) kept();
      });
    }
    buttons->addStretch(1);
    rows->addLayout(buttons);
  }
  column_->addWidget(frame);
  cards_[cause] = {frame, label, kind};
  set_colors(cards_[cause]);
  place();
}

void MessageStrip::set_colors(const Card& card) {
  const ColorPair& colors = theme_colors().cards[static_cast<std::size_t>(card.kind)];
  const QString style =
      QStringLiteral("background: %1; color: %2;").arg(colors.ground.name(), colors.text.name());
  card.frame->setStyleSheet(
      QStringLiteral("#message_card { %1 border: 1px solid %2; border-radius: "
                     "4px; } #message_card QLabel { %1 }")
          .arg(style, theme_colors().border.name()));
}

void MessageStrip::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    for (const auto& [cause, card] : cards_) set_colors(card);
  }
  QFrame::changeEvent(event);
}

void MessageStrip::end(const QString& cause) {
  const auto card = cards_.find(cause);
  if (card == cards_.end()) return;
  QFrame* frame = card->second.frame;
  cards_.erase(card);
  column_->removeWidget(frame);
  frame->hide();
  frame->deleteLater();
  place();
}

void MessageStrip::clear() {
  while (!cards_.empty()) end(QString(cards_.begin()->first));
}

// Lays the cards over the top of the widget, beside the colour bar, as high as their texts need.
void MessageStrip::place() {
  setVisible(!cards_.empty());
  if (cards_.empty()) return;
  constexpr int kColorBar = 120;  // the part of the picture that it has
  const int room = parentWidget()->width() - kColorBar;
  const int width = std::min(kWidest, room - 2 * kMargin);
  int height = (static_cast<int>(cards_.size()) - 1) * kMargin;
  for (const auto& [cause, card] : cards_) {
    QLayout* layout = card.frame->layout();
    layout->activate();
    const int own = layout->hasHeightForWidth() ? layout->heightForWidth(width)
                                                : card.frame->sizeHint().height();
    card.frame->setFixedHeight(own + 2);  // and its border
    height += own + 2;
  }
  setGeometry((room - width) / 2, kMargin, width, height);
  raise();
}

bool MessageStrip::eventFilter(QObject* watched, QEvent* event) {
  if (watched == parentWidget() && event->type() == QEvent::Resize) place();
  return QFrame::eventFilter(watched, event);
}

QString MessageStrip::text() const {
  QStringList texts;
  for (int i = 0; i < column_->count(); ++i) {
    for (const auto& [cause, card] : cards_) {
      if (card.frame == column_->itemAt(i)->widget()) texts += card.label->text();
    }
  }
  return texts.join(QLatin1Char('\n'));
}

QString MessageStrip::text(const QString& cause) const {
  const auto card = cards_.find(cause);
  return card != cards_.end() ? card->second.label->text() : QString();
}

}  // namespace tetraction::viewer
