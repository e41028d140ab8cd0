#include "uneven_stretches.h"

#include <cmath>
#include <limits>

namespace tetraction {
namespace {

double product(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void rotate_columns(double t, double* a, double* b) {
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  for (int k = 0; k < 3; ++k) {
    const double old = a[k];
    a[k] = c * (old - t * b[k]);
    b[k] = c * (b[k] + t * old);
  }
}

// Rotates two columns until they are normal to each other. Returns whether they were not.
bool make_normal(double* a, double* b, double* axis_a, double* axis_b) {
  const double aa = product(a, a);
  const double bb = product(b, b);
  const double ab = product(a, b);
  if (!(std::abs(ab) > std::numeric_limits<double>::epsilon() * std::sqrt(aa) * std::sqrt(bb))) {
    return false;
  }
  const double cot = (bb - aa) / (2.0 * ab);  // of twice the angle
  const double t = std::copysign(1.0 / (std::abs(cot) + std::hypot(1.0, cot)), cot);
  rotate_columns(t, a, b);
  rotate_columns(t, axis_a, axis_b);
  return true;
}

}  // namespace

UnevenStretches uneven_stretches(const double (&columns)[3][3]) {
  constexpr int kSweeps = 30;
  double b[3][3];
  UnevenStretches result{};
  for (int i = 0; i < 3; ++i) {
    result.axes[i][i] = 1.0;
    for (int k = 0; k < 3; ++k) b[i][k] = columns[i][k];
  }
  bool turned = true;
  for (int sweep = 0; sweep < kSweeps && turned; ++sweep) {
    turned = false;
    for (int r = 0; r < 3; ++r) {
      const int p = (r + 1) % 3;
      const int q = (r + 2) % 3;
      turned |= make_normal(b[p], b[q], result.axes[p], result.axes[q]);
    }
  }
  double mean = 0.0;
  for (int i = 0; i < 3; ++i) {
    result.c[i] = product(b[i], b[i]);
    result.log[i] = 0.5 * std::log(result.c[i]);
    mean += result.log[i] / 3.0;
  }
  for (double& log : result.log) log -= mean;
  return result;
}

}  // namespace tetraction
