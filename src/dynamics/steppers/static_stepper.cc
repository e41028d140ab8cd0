#include "tetraction/dynamics/steppers/static_stepper.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "converge_loads.h"
#include "dynamics/constraints/constrained_minimization.h"
#include "first_guess.h"
#include "mesh/bounding_box.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

class Implementation : public StaticStepper {
 public:
  Implementation(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer, double time,
                 std::shared_ptr<RootFinder> root_finder, FollowerLoads follower_loads)
      : StaticStepper(system),
        problem_(system, time),
        minimizer_(std::move(minimizer)),
        solve_(problem_, minimizer_, std::move(root_finder), 1.0, ConstraintDirection::kEnd),
        guess_(system, true),
        minimizes_first_(follower_loads == FollowerLoads::kMinimizeFirst &&
                         system.has_load_of_position()) {}

  const StaticProblem& problem() const override { return problem_; }
  void set_minimizes(bool minimizes) override { minimizes_ = minimizes; }
  void set_divisible(bool divisible) override { problem_.set_divisible(divisible); }
  void reset() override {
    solve_.forget();
    last_.resize(0);
    earlier_.resize(0);
  }

  StepOutcome advance(const State& from, State& to, double h, double end_factor) override {
    const bool minimizes = minimizes_ || minimizes_first_;
    StepOutcome outcome = attempt(from, to, h, end_factor, minimizes);
    if (outcome.ok() || minimizes == minimizes_) return outcome;
    const MinimizerReport before = outcome.minimizer;
    outcome = attempt(from, to, h, end_factor, minimizes_);
    outcome.minimizer.iterations += before.iterations;
    outcome.minimizer.factorizations += before.factorizations;
    outcome.minimizer.cg_iterations += before.cg_iterations;
    return outcome;
  }

 private:
  StepOutcome attempt(const State& from, State& to, double h, double end_factor, bool minimizes) {
    StepOutcome outcome;
    solve_.set_minimizes(minimizes);
    problem_.begin(from.position, end_factor);
    solve_.add_constraint_potential();
    if (!choose_start(from, h, end_factor, outcome) || !minimize(from, outcome) ||
        !converge_loads(end_factor, outcome)) {
      return outcome;
    }
    const Vector& u = solve_.u();
    problem_.positions(u, to.position);
    problem_.prescribe(end_factor, to.position);
    to.step = from.step + 1;
    to.time = end_factor;
    to.momentum.setZero(system_.dof_count());
    to.velocity.setZero(system_.dof_count());
    const EvaluationStatus end = system_.elastic_energy(to.position, outcome.elastic_energy);
    if (!end.ok()) {
      outcome.status = StepStatus::kInverted;
      outcome.element = end.failed_element;
      return outcome;
    }
    Vector& configuration_force = reactions_.configuration_force;
    configuration_force = solve_.constraint_force();
    Vector equation_force;
    if (configuration_force.size() > 0) {
      equation_force = system_.constraints().vertex_forces(configuration_force);
    }
    problem_.reactions(u, equation_force, reactions_.force);
    if (!is_balanced(to.position, end_factor, outcome)) return outcome;
    last_ = from.position;
    last_step_ = h;
    last_end_ = end_factor;
    return outcome;
  }

  // Sets the origin to the positions at which the minimisation begins: those of the last
  // equilibrium, with the prescribed vertices moved and the body carried along, or the continuation
  // of the last load step, if its Π is lower.
  bool choose_start(const State& from, double h, double factor, StepOutcome& outcome) {
    solve_.u().setZero(system_.dof_count());
    start_ = from.position;
    double phi = 0.0;
    if (problem_.base() != start_) guess_.carry_along(problem_, start_);
    clear_way(from, factor);
    problem_.set_origin(start_);
    const EvaluationStatus status = problem_.value(solve_.u(), phi);
    const bool is_good = status.ok() && guess_.keeps_volumes(from.position, start_);
    phi = is_good ? phi + problem_.origin_value() : std::numeric_limits<double>::infinity();
    try_moving_along(from, factor, phi);
    if (!std::isfinite(phi)) {
      outcome.status = StepStatus::kInverted;
      outcome.element = status.failed_element;
      outcome.message = "what moves as prescribed would crush the elements beside it";
      return false;
    }
    // The last step counts if its end was accepted.
    if (last_.size() > 0 && from.time == last_end_) {
      earlier_.swap(last_);
      earlier_step_ = last_step_;
      last_.resize(0);
    }
    if (earlier_.size() > 0) {
      trial_ = from.position + (h / earlier_step_) * (from.position - earlier_);
      problem_.prescribe(factor, trial_);
      take_if_lower(phi);
    }
    problem_.set_origin(start_);
    return true;
  }

  // start_ ← trial_, if Π is lower there than `phi`, which becomes its value.
  void take_if_lower(double& phi) {
    problem_.set_origin(trial_);
    double value = 0.0;
    if (!problem_.value(solve_.u(), value).ok()) return;
    value += problem_.origin_value();
    if (!(value < phi)) return;
    phi = value;
    start_ = trial_;
  }

  // A body that lies on an obstacle, and that nothing holds in the direction of its offset, goes with it as a whole.
  void try_moving_along(const State& from, double factor, double& phi) {
    const Contact* contact = system_.contact();
    if (contact == nullptr) return;
    ForcePoint before = system_.force_point(from.position, problem_.time());
    before.load_factor = from.time;
    for (std::size_t i = 0; i < contact->size(); ++i) {
      const Vector3& offset = contact->obstacle(i).motion.offset;
      if (offset.isZero(0.0) || !std::isfinite(contact->smallest_gap(before, i))) continue;
      trial_ = ((factor - from.time) * offset).replicate(system_.vertex_count(), 1);
      system_.coordinates().project_velocity(system_.mass(), trial_);
      trial_ += from.position;
      problem_.prescribe(factor, trial_);
      take_if_lower(phi);
    }
  }

  // Obstacles that move with the loads push vertices aside.
  void clear_way(const State& from, double factor) {
    const Contact* contact = system_.contact();
    if (contact == nullptr) return;
    ForcePoint before = system_.force_point(from.position, problem_.time());
    before.load_factor = from.time;
    ForcePoint after = system_.force_point(start_, problem_.time());
    after.load_factor = factor;
    if (!contact->clear_way(before, after, start_)) return;
    start_ -= problem_.base();
    system_.coordinates().project_velocity(system_.mass(), start_);
    start_ += problem_.base();
  }

  // The first minimisation begins far away. The displacements that it finds have round-off, which
  // the second one removes. The first one examines the Hessian.
  bool minimize(const State& from, StepOutcome& outcome) {
    if (!solve_.minimize(from.position, outcome)) return false;
    problem_.move_origin(solve_.u());
    problem_.set_examined(true);
    if (!solve_.minimize(from.position, outcome) || !approach_equilibrium(outcome)) return false;
    if (solve_.follows_loads()) problem_.take_loads(solve_.u());
    return true;
  }

  // Forces that are in balance up to round-off say little of the positions of a slender body, because small
  // forces bend it far. If round-off is a part of the forces, Newton's corrections tell how far the
  // equilibrium is. They are made until they are small beside the displacements.
  bool approach_equilibrium(StepOutcome& outcome) {
    constexpr double kPart = 1e-6;     // of the forces, up to which nothing is to be examined
    constexpr double kShare = 1e-3;    // of the displacements, that is near enough
    constexpr double kNothing = 1e-9;  // of the body's size: moved by round-off alone
    constexpr int kRounds = 20;
    if (problem_.constraints().has_equations() || system_.coordinates().count() == 0) return true;
    Vector& u = solve_.u();
    const FreeCoordinates& coordinates = system_.coordinates();
    double last = std::numeric_limits<double>::infinity();
    const double unbalanced = outcome.minimizer.residual;
    for (int round = 0; round < kRounds; ++round) {
      if (!solve_.residual(gradient_).ok()) break;
      const double residual = coordinates.restricted_norm(gradient_);
      outcome.minimizer.residual = residual;
      if (residual <= kPart * std::max(problem_.force_scale(), gradient_.norm())) return true;
      ++outcome.minimizer.factorizations;
      if (!solve_.newton_correction(correction_)) break;
      const double length = correction_.lpNorm<Eigen::Infinity>();
      problem_.positions(u, trial_);
      trial_ -= system_.mesh().rest_positions();
      const double moved = trial_.lpNorm<Eigen::Infinity>();
      if (problem_.force_scale() == 0.0 && length <= kNothing * problem_.length_scale())
        return true;
      if (length <= kShare * moved && length > 0.5 * last) return true;
      if (!(length < 0.9 * last)) break;
      if (problem_.longest_step(u, correction_, false) < 1.0) break;
      last = length;
      u += correction_;
      problem_.move_origin(u);
      ++outcome.minimizer.iterations;
    }
    outcome.status = StepStatus::kNotConverged;
    outcome.obstacle = StepObstacle::kRoundOff;
    outcome.message = fmt::format(
        "round-off of the stresses is as large as the loads: forces of {:.2g} N stay unbalanced "
        "beside loads of {:.2g} N, so that the displacements are not known. The body is too "
        "slender or too stiff for these loads in double precision: take larger loads, longer "
        "elements along the body and fewer across it, or a thicker or softer body",
        unbalanced, problem_.force_scale());
    return false;
  }

  // The sum of forces on vertices, and of their moments about a point.
  struct Resultant {
    Vector3 force = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    double force_size = 0.0;  // sums of magnitudes
    double moment_size = 0.0;

    void add(const Vector& forces, const Vector& x, const Vector3& about) {
      for (Index v = 0; 3 * v < forces.size(); ++v) {
        const Vector3 each = vertex_block(forces, v);
        const Vector3 turning = (vertex_block(x, v) - about).cross(each);
        force += each;
        moment += turning;
        force_size += each.norm();
        moment_size += turning.norm();
      }
    }
  };

  // All that acts on the body from outside: loads, potentials and constraints. This examines the result without
  // the equations that were solved.
  bool is_balanced(const Vector& x, double factor, StepOutcome& outcome) {
    constexpr double kPart = 1e-6;
    const Vector3 about = vertex_block(x, 0);
    Resultant all;
    all.add(problem_.applied_force(factor, x), x, about);
    all.add(reactions_.force, x, about);
    for (const ForceTerm* term : system_.force_terms()) {
      if (!term->has_potential() || term->account() != EnergyAccount::kStored) continue;
      gradient_.setZero(system_.dof_count());
      ForcePoint at = system_.force_point(x, problem_.time());
      at.load_factor = factor;
      term->add_gradient(at, gradient_);
      all.add(term == system_.contact() ? Vector(-gradient_) : Vector(-factor * gradient_), x,
              about);
    }
    // Residuals that the solver may leave at the vertices add up.
    const double left = std::sqrt(static_cast<double>(system_.vertex_count())) *
                        std::max(outcome.minimizer.residual, outcome.minimizer.residual_limit);
    const double size = bounding_box(system_.mesh()).diagonal();
    if (all.force.norm() <= kPart * all.force_size + left &&
        all.moment.norm() <= kPart * all.moment_size + left * size) {
      return true;
    }
    outcome.status = StepStatus::kNotConverged;
    outcome.message = fmt::format(
        "the forces found are not in balance: a force of {:.2g} N and a moment of {:.2g} N m "
        "remain beside forces of {:.2g} N",
        all.force.norm(), all.moment.norm(), all.force_size);
    return false;
  }

  // Loads that depend on positions are those of the last minimiser. They are taken anew until they do
  // not change any more.
  bool converge_loads(double end_factor, StepOutcome& outcome) {
    constexpr double kEnough = 1e-13;  // of the loads
    if (!system_.has_load_of_position()) return true;
    load_ = problem_.constant_loads();
    const auto load_of_solution = [&](Vector& load) {
      problem_.positions(solve_.u(), start_);
      load = problem_.load(start_);
    };
    const auto is_small = [&](const Vector& change, const Vector& load) {
      return change.norm() <= kEnough * load.norm();
    };
    const auto solve_with = [&](const Vector& load) {
      problem_.begin(start_, end_factor, load);
      problem_.set_examined(true);
      solve_.u().setZero();
      return solve_.minimize(start_, outcome);
    };
    const LoadConvergence settling =
        tetraction::converge_loads(load_, load_of_solution, is_small, solve_with);
    if (settling == LoadConvergence::kConverged) return true;
    if (settling == LoadConvergence::kNotSolved) return false;
    outcome.status = StepStatus::kNotConverged;
    outcome.message =
        "the forces at the rim of a pressure, which depend on the positions, do not settle: hold "
        "the rim, or close the surface";
    return false;
  }

  StaticProblem problem_;
  std::shared_ptr<Minimizer> minimizer_;
  ConstrainedMinimization solve_;
  FirstGuess guess_;
  bool minimizes_first_;
  bool minimizes_ = false;
  Vector start_;
  Vector trial_;
  Vector gradient_;
  Vector correction_;
  Vector load_;  // if it depends on positions: in the problem
  // The positions at the start of the last step that was accepted, and at that of the last step.
  Vector earlier_;
  Vector last_;
  double earlier_step_ = 0.0;
  double last_step_ = 0.0;
  double last_end_ = 0.0;
};

}  // namespace

std::unique_ptr<StaticStepper> StaticStepper::make(const MechanicalSystem& system,
                                                   std::shared_ptr<Minimizer> minimizer,
                                                   double time,
                                                   std::shared_ptr<RootFinder> root_finder,
                                                   FollowerLoads follower_loads) {
  return std::make_unique<Implementation>(system, std::move(minimizer), time,
                                          std::move(root_finder), follower_loads);
}

}  // namespace tetraction
