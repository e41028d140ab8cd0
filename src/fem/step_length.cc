#include "tetraction/fem/step_length.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

Matrix3 edges(const RestState& rest, const Vector& field, Index e) {
  const RestState::Shape::NodeMatrix nodes = rest.gather(field, e);
  return nodes.rightCols<3>().colwise() - nodes.col(0);
}

// J(t)/J(0) = 1 + a t + b t² + c t³ stays above `least` up to the result (≤ limit).
double first_loss(double a, double b, double c, double least, double limit) {
  if (1.0 + std::min(a, 0.0) + std::min(b, 0.0) + std::min(c, 0.0) > least) return limit;
  // Advance by what the steepest slope allows, until a tenth of the loss is left.
  const double slope = std::abs(a) + 2.0 * std::abs(b) + 3.0 * std::abs(c);
  double t = 0.0;
  while (t < limit) {
    const double room = 1.0 + t * (a + t * (b + t * c)) - least;
    if (room < 0.1 * (1.0 - least)) return t;
    t += room / slope;
  }
  return limit;
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
      own = first_loss(a, b, m.determinant(), kLeast, own);
    }
    const std::lock_guard<std::mutex> lock(mutex);
    step = std::min(step, own);
  });
  return step;
}

}  // namespace tetraction
