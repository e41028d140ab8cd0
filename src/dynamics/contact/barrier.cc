#include "tetraction/dynamics/contact/barrier.h"

#include <algorithm>
#include <array>

namespace tetraction {
namespace {

// Points and weights of Gauss and Legendre's rule with eight points on (0, 1).
struct GaussPoint {
  double place;
  double weight;
};
constexpr std::array<GaussPoint, 8> kGauss{{{0.019855071751231884, 0.050614268145188130},
                                            {0.101666761293186630, 0.111190517226687240},
                                            {0.237233795041835510, 0.156853322938943640},
                                            {0.408282678752175100, 0.181341891689180990},
                                            {0.591717321247824900, 0.181341891689180990},
                                            {0.762766204958164490, 0.156853322938943640},
                                            {0.898333238706813370, 0.111190517226687240},
                                            {0.980144928248768120, 0.050614268145188130}}};

// Where the two distances are so close, the rule is exact to round-off: U′ is analytic up to r = 0.
bool are_close(double a, double b) {
  return std::max(a, b) <= 1.5 * std::min(a, b);
}

// The smallest r in (0, 1) for which `is_below(r)` holds, where it holds from some r on. Bisection in ln(r/(1 − r)).
template <class Function>
double first_part(const Function& is_below) {
  double low = -40.0;
  double high = 18.0;
  constexpr int kHalvings = 30;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (is_below(1.0 / (1.0 + std::exp(-middle))) ? high : low) = middle;
  }
  return 1.0 / (1.0 + std::exp(-low));
}

}  // namespace

double Barrier::mean_slope(double a, double b) const {
  if (a >= thickness && b >= thickness) return 0.0;
  if (a == b) return slope(a);
  const double inner_a = std::min(a, thickness);
  const double inner_b = std::min(b, thickness);
  if (!are_close(inner_a, inner_b)) return (value(b) - value(a)) / (b - a);
  double mean = 0.0;
  for (const GaussPoint& point : kGauss) {
    mean += point.weight * slope(inner_a + point.place * (inner_b - inner_a));
  }
  return mean * ((inner_b - inner_a) / (b - a));
}

double Barrier::mean_slope_rate(double a, double b) const {
  if (a >= thickness && b >= thickness) return 0.0;
  if (a == b) return 0.5 * curvature(a);
  if (b >= thickness || a >= thickness || !are_close(a, b)) {
    const double outer = b >= thickness ? 0.0 : slope(b);
    return std::max(0.0, (outer - mean_slope(a, b)) / (b - a));
  }
  double rate = 0.0;
  for (const GaussPoint& point : kGauss) {
    rate += point.weight * point.place * curvature(a + point.place * (b - a));
  }
  return rate;
}

double Barrier::distance_at_energy(double energy) const {
  if (!(energy > 0.0)) return thickness;
  return thickness * first_part([&](double r) { return value(r * thickness) <= energy; });
}

double Barrier::distance_at_pressure(double pressure) const {
  if (!(pressure > 0.0)) return thickness;
  return thickness * first_part([&](double r) { return -slope(r * thickness) <= pressure; });
}

}  // namespace tetraction
