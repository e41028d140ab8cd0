#include "negative_curvature.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "tetraction/fem/step_length.h"

namespace tetraction {

double longest_step(const StepProblem& problem, const Vector& x, const Vector& displacement,
                    bool elements_are_safe) {
  constexpr double kShare = 0.9;
  const double longest = std::min(1.0, kShare * problem.longest_term_step(x, displacement));
  if (elements_are_safe) return longest;
  const ElasticPotential& elastic = problem.system().elastic();
  Vector positions;
  problem.positions(x, positions);
  return std::min(longest,
                  admissible_step(problem.system().rest(), positions, displacement, [&](Index e) {
                    return !std::holds_alternative<StVenantKirchhoff>(
                        elastic.materials()[static_cast<std::size_t>(elastic.material_index(e))]);
                  }));
}

bool follow(const StepProblem& problem, const NegativeCurvature& way, double phi,
            const Vector& gradient, Vector& x) {
  constexpr double kShare = 0.1;
  constexpr double kRoundOff = 1e-11;
  constexpr double kShortest = 1e-9;
  const double size = std::cbrt(problem.system().mesh().total_volume());
  const double largest = way.direction.lpNorm<Eigen::Infinity>();
  if (!(way.curvature < 0.0) || !(largest > 0.0) || !std::isfinite(largest)) return false;
  // t = 1 moves some vertex by the size of the body.
  Vector direction = (size / largest) * way.direction;
  const double curvature = way.curvature * (size / largest) * (size / largest);
  // Directions without stiffness, such as rigid motions with a large step, have a curvature that is
  // mere round-off.
  if (-curvature <= problem.round_off(direction) * direction.norm()) return false;
  double slope = gradient.dot(direction);
  if (slope > 0.0) {
    direction = -direction;
    slope = -slope;
  }
  Vector trial;
  const auto value = [&](double t, double& result) {
    trial = x + t * direction;
    return problem.value(trial, result).ok() && std::isfinite(result);
  };
  for (int sign = 0; sign < 2; ++sign) {
    for (double t = longest_step(problem, x, direction); t > kShortest; t *= 0.5) {
      const double fall = -t * slope - 0.5 * t * t * curvature;
      if (fall <= kRoundOff * std::abs(phi)) break;
      double lowest = 0.0;
      if (!value(t, lowest) || lowest > phi - kShare * fall) continue;
      double next = 0.0;
      while (value(0.5 * t, next) && next < lowest) {
        lowest = next;
        t *= 0.5;
      }
      x += t * direction;
      return true;
    }
    direction = -direction;
    slope = -slope;
  }
  return false;
}

}  // namespace tetraction
