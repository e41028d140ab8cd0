#include "additive_ccd.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetraction {
namespace {

// A pair that needs more advances is stopped where it is, which is safe.
constexpr int kMostAdvances = 2000;
// The part of the distance that an advance may use up.
constexpr double kAdvance = 0.9;
// The pair stops where its distance falls below this part of the one at the start.
constexpr double kStop = 0.1;

// The gap between two sides along `direction`, from the second side to the first one: negative if they overlap
// in this direction.
double gap_along(PairKind kind, const PairPoints& p, const Vector3& direction) {
  const int first = first_side_size(kind);
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (int i = 0; i < pair_size(kind); ++i) {
    const double along = direction.dot(p.col(i));
    if (i < first) {
      nearest = std::min(nearest, along);
    } else {
      farthest = std::max(farthest, along);
    }
  }
  return nearest - farthest;
}

}  // namespace

double first_touch(PairKind kind, const PairPoints& points, const PairPoints& moves, double cap) {
  const int size = pair_size(kind);
  const int first = first_side_size(kind);
  // Positions from a point of the pair, so that those of small pairs far from the origin have digits.
  PairPoints p = PairPoints::Zero();
  PairPoints m = PairPoints::Zero();
  const Vector3 origin = points.col(0);
  const Vector3 mean = moves.leftCols(size).rowwise().sum() / static_cast<double>(size);
  p.leftCols(size) = points.leftCols(size).colwise() - origin;
  m.leftCols(size) = moves.leftCols(size).colwise() - mean;
  double speeds[2] = {0.0, 0.0};
  for (int i = 0; i < size; ++i) {
    double& speed = speeds[i < first ? 0 : 1];
    speed = std::max(speed, m.col(i).norm());
  }
  const double closing = speeds[0] + speeds[1];
  PairDistance distance = pair_distance(kind, p);
  double d = std::sqrt(distance.squared);
  if (!std::isfinite(closing) || !std::isfinite(d)) return 0.0;
  if (!(d > 0.0)) return 0.0;
  const double stop = kStop * std::min(d, cap);
  double t = 0.0;
  for (int advance = 0; advance < kMostAdvances; ++advance) {
    const double rest = 1.0 - t;
    if (closing * rest <= kAdvance * d && d - closing * rest >= stop) return 1.0;
    // The gap is at least what lies on the line between its values now and at the end.
    const double end = gap_along(kind, p + rest * m, distance.difference / d);
    if (end >= stop) return 1.0;
    double by = kAdvance * d / closing;
    if (end < d) by = std::max(by, rest * std::min(1.0, kAdvance * d / (d - end)));
    by = std::min(by, rest);
    const PairPoints q = p + by * m;
    distance = pair_distance(kind, q);
    d = std::sqrt(distance.squared);
    // An advance leaves a tenth of the distance at least, so that its end is safe.
    if (t + by >= 1.0) return d >= 0.1 * stop ? 1.0 : t;
    if (d < stop) return d >= 0.1 * stop ? t + by : t;
    p = q;
    t += by;
  }
  return t;
}

}  // namespace tetraction
