#include "message_strip.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QStyle>
#include <QToolButton>
#include <utility>

namespace tetraction::viewer {

MessageStrip::MessageStrip(QWidget* parent)
    : QFrame(parent), label_(new QLabel(this)), action_(new QPushButton(this)) {
  setObjectName(QStringLiteral("message_strip"));
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(10, 5, 5, 5);
  label_->setWordWrap(true);
  label_->setTextFormat(Qt::PlainText);
  label_->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  row->addWidget(label_, 1);
  action_->setObjectName(QStringLiteral("message_action"));
  row->addWidget(action_);
  auto* close = new QToolButton(this);
  close->setAutoRaise(true);
  close->setIcon(style()->standardIcon(QStyle::SP_TitleBarCloseButton));
  close->setToolTip(tr("Close this message"));
  row->addWidget(close);
  connect(close, &QToolButton::clicked, this, &QWidget::hide);
  connect(action_, &QPushButton::clicked, this, [this] {
    hide();
    if (do_) do_();
  });
  hide();
}

void MessageStrip::show_message(Kind kind, const QString& text) {
  show_message(kind, text, default_button_, default_action_);
}

void MessageStrip::set_default_action(const QString& button, std::function<void()> action) {
  default_button_ = button;
  default_action_ = std::move(action);
}

void MessageStrip::show_message(Kind kind, const QString& text, const QString& button,
                                std::function<void()> action) {
  static const QString colors[] = {QStringLiteral("#e3f0fb; color: #10344f"),
                                   QStringLiteral("#fff3cd; color: #5c4300"),
                                   QStringLiteral("#fbdcdc; color: #6b0d0d")};
  setStyleSheet(QStringLiteral("#message_strip { background: %1; } #message_strip QLabel { "
                               "background: %1; }")
                    .arg(colors[static_cast<int>(kind)]));
  label_->setText(text);
  do_ = std::move(action);
  action_->setText(button);
  action_->setVisible(!button.isEmpty());
  show();
}

QString MessageStrip::text() const {
  return isHidden() ? QString() : label_->text();
}

}  // namespace tetraction::viewer
