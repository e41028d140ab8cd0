// The energy-momentum step (Simo & Tarnow 1992; Gonzalez 2000).
#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/problems/energy_momentum_problem.h"
#include "dynamics/problems/solve_to_round_off.h"
#include "dynamics/terms/term_forces.h"
#include "implicit_stepper.h"
#include "notes_on_failures.h"
#include "residual_work.h"
#include "rotated_guess.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {
namespace {

// The share of the energies that the residual may add to them in a step before the equations are
// solved further.
constexpr double kEnergyShare = 1e-13;
// The largest share with which a step is accepted.
constexpr double kLargestEnergyShare = 1e-9;
// Guesses besides those of FirstGuess.
constexpr int kRotated = FirstGuess::kCount;
constexpr int kMirrored = kRotated + 1;
constexpr int kGuesses = kMirrored + 1;

class EnergyMomentumStepper : public ImplicitStepper {
 public:
  EnergyMomentumStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer,
                        std::shared_ptr<RootFinder> finder, StepForces forces)
      : EnergyMomentumStepper(std::make_unique<DiscreteGradientStep>(system, forces),
                              std::move(minimizer), std::move(finder)) {}

  void reset() override {
    ImplicitStepper::reset();
    best_guess_ = -1;
    floor_ = 0.0;
  }

 private:
  EnergyMomentumStepper(std::unique_ptr<DiscreteGradientStep> step,
                        std::shared_ptr<Minimizer> minimizer, std::shared_ptr<RootFinder> finder)
      : ImplicitStepper(std::move(step), minimizer, finder, 0.5, ConstraintDirection::kMiddle),
        step_(static_cast<DiscreteGradientStep&>(own_problem())),
        equations_(step_),
        finder_(std::move(finder)),
        added_(step_) {}

  bool solve_step(const State& from, double end_time, StepOutcome& outcome) override {
    from_ = &from;
    added_.begin(from);
    if (system_.coordinates().count() == 0) {  // x is where everything is prescribed to be
      step_.set_origin(step_.base());
      solve_.u().setZero(system_.dof_count());
      outcome.minimizer.termination = Termination::kConverged;
      outcome.minimizer.message = "nothing to solve for: every vertex is held";
      return hold_equations(from, outcome);
    }
    const Vector& force = solve_.constraint_force();
    step_.set_constraint_force(force.size() > 0 ? system_.constraints().vertex_forces(force)
                                                : Vector());
    // The guess of the last step is good enough if its residual is as small as it was then. The others
    // are looked at from time to time.
    constexpr int kRest = 8;
    constexpr double kGrowth = 1.5;
    double residual = 0.0;
    const bool usual = ++steps_with_guess_ < kRest && set_guess(from, best_guess_, residual) &&
                       residual <= kGrowth * residual_of_guess_;
    if (usual && solve_again(from, outcome)) {
      residual_of_guess_ = residual;
      return true;
    }
    steps_with_guess_ = 0;
    struct Guess {
      double residual;
      int number;
    };
    std::vector<Guess> guesses;
    for (int i = 0; i < kGuesses; ++i) {
      if (!(usual && i == best_guess_) && set_guess(from, i, residual)) {
        guesses.push_back({residual, i});
      }
    }
    std::sort(guesses.begin(), guesses.end(),
              [](const Guess& a, const Guess& b) { return a.residual < b.residual; });
    constexpr std::size_t kMost = 3;
    for (std::size_t k = 0; k < std::min(guesses.size(), kMost); ++k) {
      best_guess_ = guesses[k].number;
      if (set_guess(from, best_guess_, residual_of_guess_) && solve_again(from, outcome)) {
        return true;
      }
    }
    best_guess_ = -1;
    // The last resort is the result of the midpoint rule.
    const std::string message = outcome.message;
    outcome.status = StepStatus::kOk;
    outcome.message.clear();
    step_.set_constraint_force({});
    step_.take_hessian_at_middle();
    guess_residual_.resize(0);
    if (find(from, end_time, outcome) && solve_again(from, outcome)) return true;
    outcome.status = StepStatus::kNotConverged;
    outcome.message = std::string("the equations of the ") +
                      (step_.forces() == StepForces::kDiscrete ? "energy-momentum" : "midpoint") +
                      " step have no solution near any guess" +
                      (message.empty() ? std::string() : ": " + message) + note_on_limit(from);
    const std::string note = note_on_layer(system_, *from_);
    if (!message.ends_with(note)) outcome.message += note;
    return false;
  }

  // A remark for messages where the motion reaches the limit of the stretch of a material.
  std::string note_on_limit(const State& from) {
    if (!has_stretch_limit(system_.elastic())) return {};
    step_.inertial_guess(work_);
    return tetraction::note_on_limit(system_, from.position, 2.0 * work_ - from.position);
  }

  // Where every vertex is held, constraints' equations need no forces, but they must be met.
  bool hold_equations(const State& from, StepOutcome& outcome) {
    constexpr double kAccepted = 1e-10;
    const Constraints& constraints = system_.constraints();
    if (!constraints.has_equations()) return true;
    solve_.set_constraint_force(Vector::Zero(constraints.configuration_size()));
    const Vector end = constraints.configuration(2.0 * step_.base() - from.position);
    Index worst = 0;
    if (constraints.values(end).cwiseAbs().maxCoeff(&worst) <= kAccepted) return true;
    outcome.status = StepStatus::kNotConverged;
    outcome.message = cannot_be_met(constraints, worst);
    return false;
  }

  // Sets work_ to guess number i. Returns false if it is not possible.
  bool propose(int i, const State& from) {
    if (!propose_freely(i, from)) return false;
    step_.clear_way(work_);
    return true;
  }

  bool propose_freely(int i, const State& from) {
    if (i < FirstGuess::kCount) return guess_.propose(i, step_, from, work_);
    if (system_.constraints().empty()) {
      step_.inertial_guess(work_);
      const Vector3 move =
          2.0 * (center_of_mass(system_, work_) - center_of_mass(system_, from.position));
      guess_rotated(system_, from, 2.0 * step_.step(), move,
                    i == kMirrored ? GuessedStrain::kMirrored : GuessedStrain::kKept, work_);
      return true;
    }
    if (i != kMirrored) return false;
    // The middle between two shapes with mirrored strains is the shape at rest.
    work_ = system_.mesh().rest_positions() - step_.base();
    system_.coordinates().project_velocity(system_.mass(), work_);
    work_ += step_.base();
    return true;
  }

  // Moves the origin to guess number i. Returns false if it is not possible or r is not defined there.
  bool set_guess(const State& from, int i, double& residual) {
    if (i < 0 || !propose(i, from)) return false;
    step_.set_origin(work_);
    solve_.u().setZero(system_.dof_count());
    if (!equations_.residual(solve_.u(), guess_residual_).ok()) return false;
    residual = system_.coordinates().restricted_norm(guess_residual_);
    return std::isfinite(residual);
  }

  bool solve_again(const State& from, StepOutcome& outcome) override {
    outcome.status = StepStatus::kOk;
    outcome.message.clear();
    if (!system_.constraints().has_equations()) return solve(outcome);
    return solve_.solve_with_multipliers(
        from.position, outcome, [&] { return solve(outcome); },
        [&] { step_.linearize(solve_.u()); });
  }

  // Solves the equations with the forces of constraints that the problem has.
  bool solve(StepOutcome& outcome) {
    step_.set_with_load_stiffness(step_.has_following_forces());
    const MinimizerReport report = solve_to_round_off(step_, solve_.u(), outcome.minimizer, [&] {
      return finder_->find_root(equations_, solve_.u());
    });
    if (!report.converged()) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = report.message;
      return false;
    }
    const bool is_exact =
        step_.roughness() > 1.0 || (step_.forces() == StepForces::kDiscrete
                                        ? polish(outcome)
                                        : is_exact_enough(energy_share_of_residual(), outcome));
    if (step_.has_following_forces()) step_.take_loads(solve_.u());
    return is_exact;
  }

  // Solves further until the energy that the residual adds to the body is round-off, or until the
  // residual is. Fails if the energy is above what a step may add.
  bool polish(StepOutcome& outcome) {
    constexpr int kRounds = 3;
    constexpr double kFloorMargin = 2.0;
    double share = energy_share_of_residual();
    balance_energy(outcome.minimizer, share);
    for (int i = 0; i < kRounds && std::max(share, added_.angular_share()) > kEnergyShare; ++i) {
      const MinimizerReport reached = outcome.minimizer;
      const double round_off = step_.round_off(solve_.u());
      if (!(reached.asked_limit > 0.0) || reached.limited_by_round_off()) break;
      if (reached.residual <= std::max(1.0, floor_) * round_off) break;
      const Vector u = solve_.u();
      equations_.set_accuracy(
          0.3 * reached.residual / reached.asked_limit *
          std::min(1.0, kEnergyShare / std::max(share, added_.angular_share())));
      const MinimizerReport report = finder_->find_root(equations_, solve_.u());
      equations_.set_accuracy(1.0);
      MinimizerReport& all = outcome.minimizer;
      add_call(report, all);
      all.termination = Termination::kConverged;
      all.residual_limit = reached.residual_limit;
      all.asked_limit = reached.asked_limit;
      all.message = reached.message;
      // The rest is round-off.
      const bool is_at_floor = report.termination == Termination::kNoProgress &&
                               report.residual <= kRoundOffMargin * round_off;
      if (is_at_floor)
        floor_ = std::min(kFloorMargin * report.residual / round_off, kRoundOffMargin);
      if (!(report.residual < reached.residual)) {
        solve_.u() = u;
        all.residual = reached.residual;
        break;
      }
      share = energy_share_of_residual();
      if (report.termination == Termination::kNoProgress) break;
    }
    // Near rest the energies themselves are so small that round-off is a share of them. Such a step is
    // as exact as it can be, and its residual is counted as limited by round-off.
    if (share <= kLargestEnergyShare) return true;
    return is_exact_enough(share, outcome);
  }

  // Removes the energy that the residual adds, and keeps its size: a small part t u of the displacement u from the
  // guess is added to u. With the residual r₀ of the guess that changes the residual by nearly −t r₀, and the energy
  // in proportion. Such a t takes an evaluation of r only. With contact the iterations go on: energy drifts less.
  void balance_energy(MinimizerReport& report, double& share) {
    constexpr double kLargest = 1e-3;  // t
    Vector& u = solve_.u();
    if (system_.contact() != nullptr || report.limited_by_round_off() || share <= kEnergyShare ||
        added_.angular_share() > kEnergyShare || guess_residual_.size() != u.size()) {
      return;
    }
    const double energy = added_.energy();
    added_.measure(u, guess_residual_);
    const double t = energy / added_.energy();
    if (!(std::abs(t) <= kLargest)) return;
    const Vector before = u;
    u *= 1.0 + t;
    const double share_there = energy_share_of_residual();
    const double residual = system_.coordinates().restricted_norm(trial_residual_);
    if (share_there < share && residual <= std::max(report.residual, report.asked_limit)) {
      share = share_there;
      report.residual = residual;
    } else {
      u = before;
    }
  }

  // Where a body squeezes the layer of an obstacle to almost nothing, the layer is so stiff that round-off of
  // positions means large forces. A step must not add energy because of that.
  // `share` is that of the energies of the step which the residual adds to them.
  bool is_exact_enough(double share, StepOutcome& outcome) {
    constexpr double kLargestWithContact = 1e-6;
    if (system_.contact() != nullptr && share <= kLargestWithContact) return true;
    if (!touches_obstacles() && is_round_off(step_, solve_.u(), outcome.minimizer.residual)) {
      return true;
    }
    outcome.status = StepStatus::kNotConverged;
    outcome.message = fmt::format(
        "the equations cannot be solved exactly enough: the step would add {:.1g} of its energy{}",
        share, note_on_layer(system_, *from_));
    return false;
  }

  // Whether the body is in the layer of an obstacle at the beginning or the end of the step.
  bool touches_obstacles() {
    const Contact* contact = system_.contact();
    if (contact == nullptr) return false;
    const ForcePoint start = system_.force_point(from_->position, from_->time);
    if (std::isfinite(contact->smallest_gap(start))) return true;
    step_.positions(solve_.u(), work_);
    const Vector end = 2.0 * work_ - from_->position;
    return std::isfinite(contact->smallest_gap(step_.end_point(end)));
  }

  // Measures the residual at solve_.u(). Returns the share of the energies of the step that it adds to them.
  double energy_share_of_residual() {
    if (!equations_.residual(solve_.u(), trial_residual_).ok()) {
      return std::numeric_limits<double>::infinity();
    }
    added_.measure(solve_.u(), trial_residual_);
    return added_.energy_share();
  }

  void set_end_position(const State& from, State& to, double h) override {
    to.position = from.position + h * to.velocity;
  }

  // The potential of contact has the same values on both sides of a surface of triangles, and of other bodies. The
  // other obstacles have an inside, where no step can end.
  bool passes_obstacle(const State& from, const State& to, StepOutcome& outcome) {
    const Contact* contact = system_.contact();
    if (contact == nullptr) return false;
    const auto crossing = contact->crossing_without_inside(
        system_.force_point(from.position, from.time), system_.force_point(to.position, to.time));
    if (!crossing) return false;
    outcome.status = StepStatus::kNotConverged;
    outcome.message = fmt::format(
        "the solution that was found passes through {} with vertex {}: take smaller steps",
        contact->partner(crossing->obstacle), system_.mesh().vertex_id(crossing->vertex));
    return true;
  }

  bool gather_forces(const State& from, const State& to, double /*h*/,
                     StepOutcome& outcome) override {
    if (passes_obstacle(from, to, outcome)) return false;
    const ForcePoint start = system_.force_point(from.position, from.time);
    const ForcePoint end = system_.force_point(to.position, to.time);
    if (step_.forces() == StepForces::kDiscrete) {
      constraining_ = gather_discrete_forces(system_, start, end, load_, outer_, spring_force_);
    } else {
      const TimeSpan span{from.time, to.time};
      const ForcePoint middle = system_.force_point(x_, from.time + step_.step(), span);
      constraining_ =
          gather_middle_forces(system_, middle, start, end, load_, outer_, spring_force_);
    }
    if (const Contact* contact = system_.contact(); contact != nullptr) {
      obstacle_forces_ = contact->mean_forces(start, end);
      add_friction(to);
    }
    if (system_.is_dissipative()) add_damping(from, to.velocity, outer_);
    step_.set_rate_estimate(solve_.u());
    const Vector* gradient = nullptr;
    if (const EvaluationStatus status = step_.internal_gradient(solve_.u(), gradient);
        !status.ok()) {
      outcome.status = StepStatus::kInverted;
      outcome.element = status.failed_element;
      return false;
    }
    force_ = outer_ - *gradient;
    return true;
  }

  // The forces of constraints' equations act in the whole step, at x. So the momenta are
  // p_{k+1} = p_k + h (forces), and their mean is M v. Prescribed vertices get the velocity of their
  // motion in the step by an impulse at its beginning, and their own velocity at its end by another one.
  void set_end_momentum(const State& from, State& to, const Vector& start, double h,
                        StepOutcome& outcome) override {
    to.momentum = from.momentum + h * force_;
    work_of_impulses_ = 0.0;
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return;
    const FreeCoordinates& free = constraints.coordinates();
    const Vector& mass = system_.mass();
    Vector& eliminated = carried_;  // M v in eliminated directions
    work_ = carried_;
    free.project_momentum(mass, work_);
    eliminated -= work_;
    Vector first = from.momentum;
    free.project_momentum(mass, first);
    const Vector eliminated_before = from.momentum - first;
    first += eliminated;
    work_ = first - from.momentum;
    add_reaction(from.position, h, work_, outcome);

    // At vertices without constraints the difference below is zero without round-off.
    const Vector unconstrained = to.momentum;
    to.momentum += 2.0 * (start - from.momentum);
    free.project_momentum(mass, to.momentum);
    const Vector moving = to.momentum;
    to.momentum += eliminated;
    work_ = to.momentum - first - (unconstrained - from.momentum);
    add_reaction(x_, 0.5 * h, work_, outcome);
    if (constraints.has_equations()) reactions_.configuration_force = constraint_force_;

    work_ = to.momentum;
    constraints.prescribe_momentum(to.time, to.momentum);
    work_ = to.momentum - work_;
    add_reaction(to.position, 0.0, work_, outcome);
    if (!constraints.moving()) return;
    const Vector eliminated_after = to.momentum - moving;
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 change = vertex_block(eliminated_after, v) - vertex_block(eliminated_before, v);
      const Vector3 mean =
          0.5 * (vertex_block(eliminated_after, v) + vertex_block(eliminated_before, v));
      work_of_impulses_ += change.dot(mean - vertex_block(eliminated, v)) / mass[v];
    }
  }

  // An impulse does its work with the mean of the velocities before and after it.
  double work_of_constraints(const State& from, const State& to) override {
    return constraint_work(from, to) + work_of_impulses_;
  }

  double work_of_obstacles(const State& from, const State& to) const override {
    return system_.contact()->driven_work(system_.force_point(from.position, from.time),
                                          system_.force_point(to.position, to.time));
  }

  Vector3 residual_arm(const State& from, Index v) const override {
    return vertex_block(x_, v) - vertex_block(from.position, v);
  }

  DiscreteGradientStep& step_;
  EnergyMomentumProblem equations_;
  std::shared_ptr<RootFinder> finder_;
  const State* from_ = nullptr;  // of the step in progress
  double work_of_impulses_ = 0.0;
  int best_guess_ = -1;  // of the last step
  double residual_of_guess_ = 0.0;
  double floor_ = 0.0;  // residuals from which polish() could get no further, relative to round-off
  int steps_with_guess_ = 0;  // since all were compared
  Vector guess_residual_;     // at the first guess, if the step began there
  Vector trial_residual_;
  ResidualWork added_;  // by it
};

}  // namespace

std::unique_ptr<Stepper> make_energy_momentum_stepper(const MechanicalSystem& system,
                                                      std::shared_ptr<Minimizer> minimizer,
                                                      std::shared_ptr<RootFinder> root_finder) {
  return std::make_unique<EnergyMomentumStepper>(system, std::move(minimizer),
                                                 std::move(root_finder), StepForces::kDiscrete);
}

std::unique_ptr<Stepper> make_midpoint_contact_stepper(const MechanicalSystem& system,
                                                       std::shared_ptr<Minimizer> minimizer,
                                                       std::shared_ptr<RootFinder> root_finder) {
  return std::make_unique<EnergyMomentumStepper>(
      system, std::move(minimizer), std::move(root_finder), StepForces::kMiddleButContact);
}

}  // namespace tetraction
