#include "tetraction/fem/step_length.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

Matrix3 edges(const RestState& rest, const Vector& field, Index e) {
  const RestState::Shape::NodeMatrix nodes = rest.gather(field, e);
  return nodes.rightCols<3>().colwise() - nodes.col(0);
}

// The result t ≤ 1 is such that J(t)/J(0) = 1 + a t + b t² + c t³ stays above `least` up to it.
double first_loss(double a, double b, double c, double least) {
  constexpr double kLimit = 1.0;
  if (1.0 + std::min(a, 0.0) + std::min(b, 0.0) + std::min(c, 0.0) > least) return kLimit;
  const auto ratio = [=](double t) { return 1.0 + t * (a + t * (b + t * c)); };
  // The points where the slope changes its sign, ascending. Between them the ratio is monotonic.
  std::array<double, 3> ends{kLimit, kLimit, kLimit};
  if (const double square = b * b - 3.0 * a * c; square > 0.0) {
    const double s = -(b + std::copysign(std::sqrt(square), b));
    const auto within = [=](double turn) { return turn > 0.0 && turn < kLimit ? turn : kLimit; };
    ends = {within(s / (3.0 * c)), within(a / s), kLimit};
    std::sort(ends.begin(), ends.end());
  }
  double low = 0.0;
  for (double high : ends) {
    if (ratio(high) > least) {
      low = high;
      continue;
    }
    // Bisection until the ratio is above `least` by less than a tenth of the allowed loss.
    while (ratio(low) - least >= 0.1 * (1.0 - least)) {
      const double middle = low + 0.5 * (high - low);
      if (!(middle > low && middle < high)) break;
      (ratio(middle) > least ? low : high) = middle;
    }
    return low;
  }
  return kLimit;
}

}  // namespace

double admissible_step(const RestState& rest, const Vector& q, const Vector& d,
                       const std::function<bool(Index)>& counts) {
  constexpr double kLeast = 0.1;
  double step = 1.0;
  std::mutex mutex;
  parallel_for(rest.element_count(), 512, [&](Index begin, Index end) {
    double own = 1.0;
    for (Index e = begin; e < end; ++e) {
      if (counts && !counts(e)) continue;
      const Matrix3 now = edges(rest, q, e);
      const double det = now.determinant();
      if (!(det > 0.0)) continue;
      const Matrix3 m = now.inverse() * edges(rest, d, e);
      const double a = m.trace();
      const double b = 0.5 * (a * a - (m * m).trace());
      own = std::min(own, first_loss(a, b, m.determinant(), kLeast));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    step = std::min(step, own);
  });
  return step;
}

}  // namespace tetraction
