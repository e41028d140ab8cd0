// The scrolled area of a panel.
#pragma once

#include <QEvent>
#include <QScrollArea>
#include <QScrollBar>
#include <algorithm>

namespace tetraction::viewer {

/// As wide as its panel needs at the moment, also after rows were added, up to a limit. Beyond that it has
/// a horizontal scroll bar.
class PanelArea : public QScrollArea {
 public:
  explicit PanelArea(QWidget* parent) : QScrollArea(parent) {
    setWidgetResizable(true);
    setFrameShape(QFrame::NoFrame);
  }
  QSize minimumSizeHint() const override {
    constexpr int kWidest = 296;
    const int content = widget() != nullptr ? widget()->minimumSizeHint().width() : 0;
    const int width = content + verticalScrollBar()->sizeHint().width() + 4;
    return {std::min(width, kWidest), QScrollArea::minimumSizeHint().height()};
  }

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() == QEvent::LayoutRequest) updateGeometry();
    return QScrollArea::eventFilter(watched, event);
  }
};

}  // namespace tetraction::viewer
