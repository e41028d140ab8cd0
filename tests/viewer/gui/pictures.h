// What there is to say of pictures of the window.
#pragma once

#include <QImage>
#include <QPoint>
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <vector>

namespace tetraction::viewer {

/// Whether two colours are told apart by eye.
inline bool differ(QRgb a, QRgb b) {
  constexpr int kVisible = 8;
  return std::abs(qRed(a) - qRed(b)) > kVisible || std::abs(qGreen(a) - qGreen(b)) > kVisible ||
         std::abs(qBlue(a) - qBlue(b)) > kVisible;
}

/// The pixels that are such.
inline std::vector<QPoint> pixels(const QImage& image, const std::function<bool(QRgb)>& is_such) {
  std::vector<QPoint> found;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (is_such(image.pixel(x, y))) found.emplace_back(x, y);
    }
  }
  return found;
}

/// How many pixels differ; all if the sizes do.
inline int differing_pixels(const QImage& a, const QImage& b) {
  if (a.size() != b.size()) return a.width() * a.height();
  int count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) count += differ(a.pixel(x, y), b.pixel(x, y)) ? 1 : 0;
  }
  return count;
}

/// Whether pictures differ at a place or at most `radius` pixels away.
inline bool differ_at(const QImage& a, const QImage& b, const QPoint& place, int radius = 0) {
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const QPoint p = place + QPoint(x, y);
      if (a.valid(p) && b.valid(p) && differ(a.pixel(p), b.pixel(p))) return true;
    }
  }
  return false;
}

/// 0 to 255, the mean of some pixels around a place.
inline double brightness(const QImage& image, const QPoint& place) {
  constexpr int kRadius = 2;
  double sum = 0.0;
  int count = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      const QPoint p = place + QPoint(x, y);
      if (!image.valid(p)) continue;
      sum += qGray(image.pixel(p));
      ++count;
    }
  }
  return count > 0 ? sum / count : -1.0;
}

}  // namespace tetraction::viewer
