#include "line_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tetraction {
namespace {

constexpr double kArmijo = 1e-4;
// A change of Φ relative to Φ that may be mere round-off.
constexpr double kPotentialRoundOff = 1e-11;

// Begins a path at u. Returns the largest t on it, at most `most`, which is 0 for a translation.
double begin_path(const MinimizationProblem& problem, const Vector& u, const Vector& direction,
                  double most, TurningPath& path) {
  constexpr double kLargest = 2.0;  // |∇d F⁻¹| t of a rotation by 81°
  const Positions x = problem.hessian_parts(u).positions;
  path.begin(x.displacement() == nullptr ? x.origin() : Vector(x.origin() + *x.displacement()),
             direction);
  return path.rate() > 0.0 ? std::min(most, kLargest / path.rate()) : 0.0;
}

}  // namespace

bool evaluate(const MinimizationProblem& problem, Iterate& iterate) {
  if (!problem.value_and_full_gradient(iterate.u, iterate.phi, iterate.force).ok()) return false;
  iterate.residual = problem.free_norm(iterate.force);
  return std::isfinite(iterate.phi);
}

bool evaluate(const RootProblem& problem, Iterate& iterate) {
  if (!problem.residual(iterate.u, iterate.force).ok()) return false;
  iterate.residual = problem.free_norm(iterate.force);
  return std::isfinite(iterate.residual);
}

// Tries u + t d for t = longest step, half of it, and so on. A trial point is evaluated if
// is_worth_trying(t), and then judged by judge(t, trial). If the longest step is not good enough, turns() may find a
// point elsewhere.
template <class Problem, class TryAt, class Judge, class Turn>
bool LineSearch::halve(const Problem& problem, const Line& line, const TryAt& is_worth_trying,
                       const Judge& judge, const Turn& turns, Iterate& iterate) {
  constexpr double kShortest = 1e-6;
  const double longest = problem.longest_step(iterate.u, line.direction, line.elements_are_safe);
  before_.u = iterate.u;
  before_.force.swap(iterate.force);
  before_.phi = iterate.phi;
  before_.residual = iterate.residual;
  for (double t = longest; t > kShortest * longest && is_worth_trying(t, longest); t *= 0.5) {
    iterate.u = before_.u + t * line.direction;
    if (evaluate(problem, iterate) && judge(t)) return true;
    if (t == longest && turns()) return true;
  }
  std::swap(iterate, before_);
  return false;
}

// Tries points of the curved path that begins at before_.
template <class Judge>
bool LineSearch::turn(const MinimizationProblem& problem, const Line& line, const Judge& judge,
                      Iterate& iterate) {
  constexpr double kShortest = 0.05;
  double t = begin_path(problem, before_.u, line.direction, 1.0, *line.path);
  for (; t > kShortest; t *= 0.5) {
    iterate.u = before_.u + line.path->at(t);
    if (evaluate(problem, iterate) && judge(t)) return true;
  }
  return false;
}

bool LineSearch::search(const MinimizationProblem& problem, const Line& line, Iterate& iterate) {
  const double slope = problem.dot(iterate.force, line.direction);
  if (!(slope < 0.0)) return false;
  const double phi = iterate.phi;
  const double residual = iterate.residual;
  const auto drowns = [&](double t) { return -t * slope <= kPotentialRoundOff * std::abs(phi); };
  const auto is_good = [&](double t) {
    const bool lower =
        drowns(t) ? iterate.residual <= 0.9 * residual : iterate.phi <= phi + kArmijo * t * slope;
    return lower || iterate.residual <= 0.5 * residual || iterate.residual <= line.residual_limit;
  };
  return halve(
      problem, line,
      // A step so short that Φ cannot tell is not better than a long one.
      [&](double t, double longest) { return !drowns(t) || t >= 0.1 * longest; }, is_good,
      [&] { return line.path != nullptr && !drowns(1.0) && turn(problem, line, is_good, iterate); },
      iterate);
}

bool LineSearch::search(const RootProblem& problem, const Line& line, Iterate& iterate) {
  const double residual = iterate.residual;
  return halve(
      problem, line, [](double, double) { return true; },
      [&](double t) {
        return iterate.residual <= (1.0 - kArmijo * t) * residual ||
               iterate.residual <= line.residual_limit;
      },
      [] { return false; }, iterate);
}

bool follow(const MinimizationProblem& problem, const NegativeCurvature& descent, Iterate& iterate,
            TurningPath* path) {
  constexpr double kShare = 0.1;
  constexpr double kShortest = 1e-9;
  const double size = problem.length_scale();
  if (!(descent.curvature < 0.0)) return false;
  const double largest = problem.largest(descent.direction);
  if (!(largest > 0.0) || !std::isfinite(largest)) return false;
  // t = 1 moves some vertex by the size of the body.
  Vector direction = (size / largest) * descent.direction;
  const double curvature = descent.curvature * (size / largest) * (size / largest);
  // Directions without stiffness, such as rigid motions with a large step, have a curvature that is
  // mere round-off.
  const double length = std::sqrt(problem.dot(direction, direction));
  if (-curvature <= problem.round_off(direction) * length) return false;
  double slope = problem.dot(iterate.force, direction);
  if (slope > 0.0) {
    direction = -direction;
    slope = -slope;
  }
  double longest_turn = 0.0;
  if (path != nullptr) {
    longest_turn =
        begin_path(problem, iterate.u, direction, std::numeric_limits<double>::infinity(), *path);
  }
  Iterate trial;
  double sign = 1.0;
  const auto move = [&](double t) {
    if (longest_turn > 0.0) {
      trial.u = iterate.u + path->at(sign * t);
    } else {
      trial.u = iterate.u + t * direction;
    }
  };
  const auto value = [&](double t, double& result) {
    move(t);
    return problem.value(trial.u, result).ok() && std::isfinite(result);
  };
  for (int side = 0; side < 2; ++side) {
    double t =
        longest_turn > 0.0 ? longest_turn : problem.longest_step(iterate.u, direction, false);
    for (; t > kShortest; t *= 0.5) {
      const double fall = -t * slope - 0.5 * t * t * curvature;
      if (fall <= kPotentialRoundOff * std::abs(iterate.phi)) break;
      double lowest = 0.0;
      if (!value(t, lowest) || lowest > iterate.phi - kShare * fall) continue;
      double next = 0.0;
      while (value(0.5 * t, next) && next < lowest) {
        lowest = next;
        t *= 0.5;
      }
      move(t);
      if (!evaluate(problem, trial)) return false;
      std::swap(iterate, trial);
      return true;
    }
    direction = -direction;
    sign = -sign;
    slope = -slope;
  }
  return false;
}

}  // namespace tetraction
