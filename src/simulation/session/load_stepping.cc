#include "load_stepping.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "contact_point.h"
#include "simulation/facts/free_motions.h"
#include "solver/modes/load_stability.h"
#include "solver/newton/mixed_newton.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/solver/newton_root_finder.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

// The smallest increment of the load factor, which is the accuracy of a limit point.
constexpr double kLeast = 1.0 / 1024;
// A body that moves so many times as fast with the load factor as in the step before has jumped, unless half
// of the increment has moved it by half as far, or by little more.
constexpr double kJump = 3.0;
constexpr double kSmooth = 0.6;
// A vibration counts as flutter if it grows by more than this, relative to itself, in a radian. Modes that have nearly the same
// frequency are coupled by an asymmetric mesh alone, and the slightest damping stops what grows more slowly.
constexpr double kSlowGrowth = 1e-3;
// Number of attempts in a row that may fail before solvers search for long.
constexpr int kQuickEnds = 3;
// So many times a stable equilibrium is looked for where the path of Newton's method has become unstable or
// ends. Each search may be as long as the whole path.
constexpr int kSearches = 4;
// So many attempts at a load step fail before it is asked whether the body lies loose.
constexpr int kCutsOfLoose = 3;

// The largest change of a coordinate, m.
double largest_move(const State& from, const State& to) {
  return (to.position - from.position).lpNorm<Eigen::Infinity>();
}

// How modes about an equilibrium whose time is the load factor are found.
NormalModeOptions mode_options(const StaticProblem& problem, const State& at, Index count) {
  const MechanicalSystem& system = problem.system();
  NormalModeOptions options;
  options.count = count;
  options.time = problem.time();
  options.with_loads = true;
  options.load_factor = at.time;
  options.multipliers = balancing_multipliers(
      system, at.position, problem.applied_force(at.time, at.position), problem.time(), at.time);
  return options;
}

// The fastest motion that goes away from an equilibrium, if one is found.
std::optional<LossOfStability> examined(const StaticProblem& problem, const State& at) {
  constexpr Index kModes = 6;  // loads of this kind couple the lowest modes
  const MechanicalSystem& system = problem.system();
  const NormalModeOptions options = mode_options(problem, at, kModes);
  std::optional<LossOfStability> loss;
  const LoadStability found = examine_loads(system, at.position, options, kSlowGrowth);
  if (found.is_known) {
    if (found.growth_rate == 0.0) return {};
    return LossOfStability{
        0.0,  at.time, found.is_flutter, found.growth_rate, found.is_flutter ? found.ratio : 0.0,
        false};
  }
  for (const NormalMode& mode : normal_modes(system, at.position, options).modes) {
    const bool is_flutter = mode.kind == ModeKind::kFlutter;
    if (!is_flutter && mode.kind != ModeKind::kUnstable) continue;
    const double rate = is_flutter ? mode.growth_rate : std::sqrt(-mode.omega_squared);
    const double ratio = is_flutter ? rate / std::hypot(rate, std::sqrt(mode.omega_squared)) : 1.0;
    if (ratio <= kSlowGrowth || (loss && loss->growth_rate >= rate)) continue;
    loss = LossOfStability{0.0, at.time, is_flutter, rate, is_flutter ? ratio : 0.0, false};
  }
  return loss;
}

// Says how the body lies loose between the obstacles that it touches. Empty if it does not.
std::string loose_text(const StaticProblem& problem, const State& at) {
  std::string motions;
  for (const std::string& each : motions_beside_obstacles(problem.system(), at, problem.time())) {
    motions += (motions.empty() ? "" : ", ") + each;
  }
  if (motions.empty()) return {};
  return fmt::format(
      "the obstacles that the body touches there leave it free to {}, so that it has no definite "
      "place. Hold it in these directions with [[fix]] or springs, bring it near all obstacles "
      "that are "
      "to hold it, or let it come to rest with run and backward-euler",
      motions);
}

// The lowest ω² about an equilibrium; infinite if there is no mode.
double lowest_omega_squared(const StaticProblem& problem, const State& at) {
  const NormalModes found =
      normal_modes(problem.system(), at.position, mode_options(problem, at, 1));
  return found.modes.empty() ? std::numeric_limits<double>::infinity()
                             : found.modes.front().omega_squared;
}

}  // namespace

std::unique_ptr<StaticStepper> make_static_stepper(const MechanicalSystem& system,
                                                   const SolverSettings& solver, double time) {
  // Round-off stops the minimiser before it reaches this tolerance.
  constexpr double kToRoundOff = 1e-13;
  SolverSettings exact = solver;
  exact.tolerance = std::min(exact.tolerance, kToRoundOff);
  // Without inertia the Hessian is ill-conditioned: a factor serves better than an iteration. A minimiser alone
  // does not find equilibria of which the loads do not settle.
  std::shared_ptr<RootFinder> root_finder;
  const bool minimizes_first = exact.kind == "ceres";
  if (minimizes_first || (exact.kind == "newton" && exact.linear == LinearSolver::kAuto)) {
    root_finder = make_newton_root_finder(system, {exact.tolerance, exact.max_iterations});
  } else {
    root_finder = make_root_finder(exact, system);
  }
  const bool is_mixed =
      exact.kind == "newton" && nearly_keeps_volume(system) &&
      (exact.linear == LinearSolver::kAuto || exact.linear == LinearSolver::kFactor);
  if (is_mixed) exact.linear = LinearSolver::kFactor;
  std::unique_ptr<Minimizer> minimizer = make_minimizer(exact, system);
  if (is_mixed) {
    minimizer = make_mixed_newton_minimizer(system, {exact.tolerance, exact.max_iterations},
                                            std::move(minimizer));
  }
  return StaticStepper::make(system, std::move(minimizer), time, std::move(root_finder),
                             minimizes_first ? StaticStepper::FollowerLoads::kMinimizeFirst
                                             : StaticStepper::FollowerLoads::kSolve);
}

LoadStepping::LoadStepping(StaticStepper& stepper, double largest_increment,
                           bool examines_stability)
    : stepper_(stepper), largest_increment_(largest_increment), increment_(largest_increment) {
  if (!(largest_increment > 0.0 && largest_increment <= 1.0)) {
    throw InputError(fmt::format(
        "The largest increment of the load factor must be above 0 and at most 1, not {}.",
        largest_increment));
  }
  path_.is_examined = examines_stability || !stepper.problem().system().has_load_of_position();
}

StepOutcome LoadStepping::advance(const State& from, State& to) {
  sum_ = {};
  Beyond beyond;
  std::optional<LossOfStability> loss;  // in the last attempt
  bool cut = false;
  bool unstable = false;
  double last_move = 0.0;  // of the attempt before, with twice the increment; 0: none
  int cuts_here = 0;
  for (;;) {
    // A last increment that would be mere round-off is added to the one before.
    constexpr double kMerged = 1e-9;
    const double next = from.time + increment_ > 1.0 - kMerged ? 1.0 : from.time + increment_;
    const bool is_quick = increment_ > kLeast && quick_ends_ < kQuickEnds;
    stepper_.set_divisible(is_quick);
    StepOutcome outcome = stepper_.advance(from, to, next - from.time, next);
    const MinimizerReport& report = outcome.minimizer;
    sum_.iterations += report.iterations;
    sum_.factorizations += report.factorizations;
    sum_.cg_iterations += report.cg_iterations;
    if (is_quick) quick_ends_ = outcome.ok() ? 0 : quick_ends_ + 1;
    const double move = outcome.ok() ? largest_move(from, to) : 0.0;
    const double rate = move / (next - from.time);
    const bool is_smooth = last_move > 0.0 && move < kSmooth * last_move;
    const bool jumped = outcome.ok() && rate_ > 0.0 && rate > kJump * rate_ && !is_smooth;
    last_move = move;
    // If multipliers or loads did not settle, the minimisations before tell nothing.
    const bool telling = outcome.ok() || !report.converged();
    unstable = unstable || (report.met_negative_curvature && telling) || jumped;
    if (outcome.ok() && !jumped && !path_.loss) loss = instability(to);
    if (outcome.ok() && !report.met_negative_curvature && !jumped && !loss) {
      if (!cut) increment_ = std::min(2.0 * increment_, largest_increment_);
      rate_ = rate;
      return accept(outcome, to);
    }
    if (outcome.ok()) {
      beyond = {to, outcome, stepper_.reactions()};
    }
    // Smaller increments do not help a body that lies loose between obstacles.
    if (++cuts_here >= kCutsOfLoose && from.time > 0.0) {
      if (const std::string loose = loose_text(stepper_.problem(), from); !loose.empty()) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = loose;
        outcome.minimizer.iterations = sum_.iterations;
        return outcome;
      }
    }
    if (increment_ > kLeast) {
      increment_ = 0.5 * std::min(increment_, 1.0 - from.time);
      cut = true;
      ++path_.cuts;
      continue;
    }
    if (find_beyond(from, to, next, beyond)) {
      unstable = true;
      loss.reset();
    }
    // Where multipliers do not settle beyond a limit point, the minimisations themselves tell nothing.
    if (!beyond.found() && !unstable && outcome.obstacle == StepObstacle::kConstraints) {
      unstable = is_nearly_singular(from);
    }
    // Before a body reaches an obstacle, nothing need hold it: that is no limit point.
    const bool is_falling =
        from.time == 0.0 && stepper_.problem().system().contact() != nullptr && beyond.found();
    if (unstable && !is_falling) enter_limit_point({from.time, next, beyond.found()});
    if (loss && beyond.found()) {
      path_.loss = loss;
      path_.loss->below = from.time;
      path_.loss->above = beyond.state.time;
    }
    if (!beyond.found()) {
      if (outcome.message.empty()) outcome.message = "an element would be inverted";
      outcome.minimizer.iterations = sum_.iterations;
      return outcome;
    }
    to = beyond.state;
    stepper_.set_reactions(beyond.reactions);
    stepper_.reset();
    rate_ = 0.0;
    return accept(beyond.outcome, to);
  }
}

bool LoadStepping::find_beyond(const State& from, State& to, double next, Beyond& beyond) {
  if (!stepper_.problem().system().has_load_of_position() || searches_ >= kSearches) return false;
  ++searches_;
  stepper_.set_minimizes(true);
  const StepOutcome outcome = stepper_.advance(from, to, next - from.time, next);
  stepper_.set_minimizes(false);
  sum_.iterations += outcome.minimizer.iterations;
  sum_.factorizations += outcome.minimizer.factorizations;
  if (!outcome.ok() || instability(to)) return false;
  beyond = {to, outcome, stepper_.reactions()};
  return true;
}

std::optional<LossOfStability> LoadStepping::instability(const State& at) {
  const MechanicalSystem& system = stepper_.problem().system();
  if (!path_.is_examined || !system.has_load_of_position()) return {};
  if (system.coordinates().count() == 0) return {};
  const auto start = std::chrono::steady_clock::now();
  std::optional<LossOfStability> loss = examined(stepper_.problem(), at);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  examination_seconds_ += taken.count();
  return loss;
}

bool LoadStepping::is_nearly_singular(const State& at) const {
  // At a bifurcation the least stiffness falls in proportion to the distance to it, at a limit point as
  // its root, which is 0.03 at the least increment.
  constexpr double kNearly = 0.1;
  const StaticProblem& problem = stepper_.problem();
  const MechanicalSystem& system = problem.system();
  if (at.time == 0.0 || system.coordinates().count() == 0) return false;
  // Just beyond a limit point the body is still soft.
  constexpr double kBeside = 16.0 * kLeast;
  if (!path_.limit_points.empty() && at.time - path_.limit_points.back().above < kBeside) {
    return false;
  }
  return lowest_omega_squared(problem, at) <
         kNearly * lowest_omega_squared(problem, system.rest_state());
}

// Two limit points without a stable part of the path between them are one.
void LoadStepping::enter_limit_point(const LimitPoint& limit) {
  std::vector<LimitPoint>& limits = path_.limit_points;
  if (!limits.empty() && limits.back().above == limit.below) {
    limits.back().above = limit.above;
    limits.back().passed = limit.passed;
  } else {
    limits.push_back(limit);
  }
}

StepOutcome LoadStepping::accept(const StepOutcome& outcome, const State& to) {
  path_.factor = to.time;
  if (path_.loss && to.time == 1.0) path_.loss->is_over = !instability(to).has_value();
  ++path_.steps;
  path_.residual = outcome.minimizer.residual;
  path_.residual_limit = outcome.minimizer.residual_limit;
  const StaticProblem& problem = stepper_.problem();
  path_.force = std::max(problem.applied_force(to.time, to.position).norm(),
                         stepper_.reactions().force.norm());
  if (const Contact* contact = problem.system().contact(); contact != nullptr) {
    Vector layers = Vector::Zero(problem.system().dof_count());
    contact->add_gradient(contact_point(problem.system(), to, true), layers);
    path_.force = std::max(path_.force, layers.norm());
  }
  // Without loads and prescribed displacements the reactions are mere round-off.
  if (problem.force_scale() == 0.0 && path_.force <= path_.residual_limit) path_.force = 0.0;
  StepOutcome result = outcome;
  result.minimizer.iterations = sum_.iterations;
  result.minimizer.factorizations = sum_.factorizations;
  result.minimizer.cg_iterations = sum_.cg_iterations;
  return result;
}

std::string limit_text(const LimitPoint& limit) {
  return fmt::format(
      "limit point near load factor {:.3f} (between {:.4f} and {:.4f}): the body buckles or snaps "
      "through{}",
      0.5 * (limit.below + limit.above), limit.below, limit.above,
      limit.passed ? ". From there on the result is another equilibrium, to which the minimiser "
                     "went; there may be more of them"
                   : "");
}

std::string loss_text(const LossOfStability& loss) {
  const std::string damping =
      loss.is_flutter
          ? fmt::format(", unless they have a damping ratio of {:.2g} more", loss.damping_ratio)
          : "";
  return fmt::format(
      "the equilibrium becomes unstable between the load factors {:.4f} and {:.4f}: loads that "
      "follow the deformation let small motions {}, by {:.3g} 1/s at first{}. {}",
      loss.below, loss.above, loss.is_flutter ? "swing further and further" : "grow",
      loss.growth_rate, damping,
      loss.is_over
          ? "The last equilibrium is stable again, but the body would not stay on the way to it"
          : "tetraction modes --static tells more of the last equilibrium");
}

std::string round_off_text(const LoadPath& path) {
  constexpr double kMuch = 1e-6;
  if (path.force == 0.0 || path.residual <= kMuch * path.force) return {};
  return fmt::format(
      "round-off: the forces of the equilibrium balance each other to {:.1g} of their size only, "
      "and reactions are no more accurate. The loads are very small for the stiffness of the body: "
      "make them larger, or the body softer or larger",
      path.residual / path.force);
}

std::string LoadStepping::message(const StepOutcome& outcome) const {
  std::string text;
  for (const LimitPoint& limit : path_.limit_points) {
    if (!outcome.ok() && limit.passed) continue;
    text += (text.empty() ? "" : "; ") + limit_text(limit);
  }
  if (path_.loss) text += (text.empty() ? "" : "; ") + loss_text(*path_.loss);
  if (outcome.ok()) {
    if (const std::string round_off = round_off_text(path_); !round_off.empty()) {
      text += (text.empty() ? "" : "; ") + round_off;
    }
    return text;
  }
  if (outcome.obstacle == StepObstacle::kRoundOff) {
    return text + fmt::format("{}no equilibrium was found beyond load factor {:.4f}: {}",
                              text.empty() ? "" : "; ", path_.factor, outcome.message);
  }
  return text + fmt::format(
                    "{}no equilibrium was found beyond load factor {:.4f}: {}. The body may not be "
                    "able to carry the loads: make them smaller, hold it elsewhere, or raise "
                    "solver.max_iterations",
                    text.empty() ? "" : "; ", path_.factor, outcome.message);
}

}  // namespace tetraction
