#include "icons.h"

#include <QApplication>
#include <QIconEngine>
#include <QPainter>
#include <QPainterPath>
#include <QPalette>
#include <sstream>
#include <string>

namespace tetraction::viewer {
namespace {

struct Drawing {
  bool filled;
  const char* path;  // M, L, C and Z as in SVG, with spaces between all parts, in a square of 16
};

// In the order of Icon.
constexpr Drawing kDrawings[] = {
    {true, "M 4 2.5 L 13.5 8 L 4 13.5 Z"},
    {true,
     "M 3.5 2.5 L 6.5 2.5 L 6.5 13.5 L 3.5 13.5 Z M 9.5 2.5 L 12.5 2.5 L 12.5 13.5 L 9.5 13.5 Z"},
    {true, "M 3 2.5 L 10 8 L 3 13.5 Z M 11 2.5 L 13 2.5 L 13 13.5 L 11 13.5 Z"},
    {true, "M 13 2.5 L 6 8 L 13 13.5 Z M 3 2.5 L 5 2.5 L 5 13.5 L 3 13.5 Z"},
    {true, "M 8 3 L 2.5 8 L 8 13 Z M 13.5 3 L 8 8 L 13.5 13 Z"},
    {true,
     "M 3 8 C 3 5.2 5.2 3 8 3 C 10.8 3 13 5.2 13 8 C 13 10.8 10.8 13 8 13 C 5.2 13 3 10.8 3 8 Z"},
    {false,
     "M 2 8 C 2 4.7 4.7 2 8 2 C 11.3 2 14 4.7 14 8 C 14 11.3 11.3 14 8 14 C 6.3 14 4.8 13.3 3.7 "
     "12.2 "
     "M 3.7 15 L 3.7 12.2 L 6.5 12.2"},
    {false,
     "M 2 5 L 2 2 L 5 2 M 11 2 L 14 2 L 14 5 M 14 11 L 14 14 L 11 14 M 5 14 L 2 14 L 2 11 "
     "M 7.5 8 L 8.5 8"},
    {false, "M 2 13 L 5 9 L 6 12 L 8 6.5 L 9 9.5 L 13.5 2.5 M 10 2.5 L 13.5 2.5 L 13.5 6"},
    {false, "M 2.5 13.5 L 13 3 M 8 3 L 13 3 L 13 8"},
    {false, "M 2 8 L 13.5 8 M 9.5 4 L 13.5 8 L 9.5 12 M 2 4 L 6 4 M 2 12 L 6 12"},
    {false, "M 3.5 3.5 L 12.5 12.5 M 12.5 3.5 L 3.5 12.5"},
    {false, "M 2 8 L 14 8 M 5 5 L 2 8 L 5 11 M 11 5 L 14 8 L 11 11"},
    {false, "M 8 2 L 8 10 M 4.5 7 L 8 10.5 L 11.5 7 M 2.5 11 L 2.5 14 L 13.5 14 L 13.5 11"}};

QPainterPath path_of(const char* text) {
  QPainterPath path;
  std::istringstream in(text);
  std::string command;
  double x[6];
  const auto read = [&](int count) {
    for (int i = 0; i < count; ++i) in >> x[i];
  };
  while (in >> command) {
    if (command == "M") {
      read(2);
      path.moveTo(x[0], x[1]);
    } else if (command == "L") {
      read(2);
      path.lineTo(x[0], x[1]);
    } else if (command == "C") {
      read(6);
      path.cubicTo(x[0], x[1], x[2], x[3], x[4], x[5]);
    } else {
      path.closeSubpath();
    }
  }
  return path;
}

class PathIcon : public QIconEngine {
 public:
  explicit PathIcon(Icon which) : which_(which) {}

  void paint(QPainter* painter, const QRect& rect, QIcon::Mode mode, QIcon::State) override {
    const Drawing& drawing = kDrawings[static_cast<int>(which_)];
    const bool disabled = mode == QIcon::Disabled;
    const QColor color = QApplication::palette().color(
        disabled ? QPalette::Disabled : QPalette::Active, QPalette::ButtonText);
    painter->save();
    painter->setRenderHint(QPainter::Antialiasing);
    painter->translate(rect.topLeft());
    painter->scale(rect.width() / 16.0, rect.height() / 16.0);
    if (drawing.filled) {
      painter->fillPath(path_of(drawing.path), color);
    } else {
      painter->strokePath(path_of(drawing.path),
                          QPen(color, 1.5, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
    }
    painter->restore();
  }
  QPixmap pixmap(const QSize& size, QIcon::Mode mode, QIcon::State state) override {
    QPixmap picture(size);
    picture.fill(Qt::transparent);
    QPainter painter(&picture);
    paint(&painter, QRect(QPoint(), size), mode, state);
    return picture;
  }
  QIconEngine* clone() const override { return new PathIcon(which_); }

 private:
  Icon which_;
};

}  // namespace

QIcon icon(Icon which) {
  return QIcon(new PathIcon(which));
}

}  // namespace tetraction::viewer
