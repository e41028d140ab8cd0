#include "tetraction/dynamics/contact/barrier.h"

#include <algorithm>
#include <array>

namespace tetraction {
namespace {

// Gauss–Legendre rule of eight points on [0, 1]: half of the points, by symmetry.
constexpr std::array<double, 4> kBarrierNodes = {0.1834346424956498, 0.5255324099163290,
                                                 0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> kBarrierWeights = {0.3626837833783620, 0.3137066458778873,
                                                   0.2223810344533745, 0.1012285362903763};
// Up to this ratio of interval and distance the rule is exact to round-off.
constexpr double kCloseDistances = 0.2;

template <class Function>
double mean_on_unit_interval(const Function& f) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kBarrierNodes.size(); ++k) {
    sum += 0.5 * kBarrierWeights[k] *
           (f(0.5 * (1.0 - kBarrierNodes[k])) + f(0.5 * (1.0 + kBarrierNodes[k])));
  }
  return sum;
}

}  // namespace

double Barrier::mean_slope(double a, double b) const {
  if (a >= thickness && b >= thickness) return 0.0;
  if (a >= thickness || b >= thickness) return (value(b) - value(a)) / (b - a);
  if (std::abs(b - a) > kCloseDistances * std::min(a, b)) return (value(b) - value(a)) / (b - a);
  return mean_on_unit_interval([&](double t) { return slope(a + t * (b - a)); });
}

double Barrier::mean_slope_rate(double a, double b) const {
  if (a >= thickness && b >= thickness) return 0.0;
  if (a >= thickness || b >= thickness || std::abs(b - a) > kCloseDistances * std::min(a, b)) {
    return b == a ? 0.5 * curvature(b) : (slope(b) - mean_slope(a, b)) / (b - a);
  }
  return mean_on_unit_interval([&](double t) { return t * curvature(a + t * (b - a)); });
}

}  // namespace tetraction
