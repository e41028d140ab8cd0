// The explicit rules. The only unknowns to be solved for are the multipliers of constraints, if
// any.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <optional>
#include <vector>

#include "common_outcome.h"
#include "core/scope_exit.h"
#include "dynamics/contact/friction/explicit_friction.h"
#include "dynamics/terms/term_forces.h"
#include "dynamics/terms/vertex_kernels.h"
#include "force_cache.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {
namespace {

class ExplicitStepper : public Stepper {
 public:
  // `halves` 1: p moves by a whole step before q (α = 0); 2: by half before and half after
  // (verlet).
  ExplicitStepper(const MechanicalSystem& system, int halves)
      : Stepper(system),
        halves_(halves),
        constrained_(system.constraints().constrained_vertices()),
        contact_(system) {
    if (system.part() != nullptr) shared_ = system.part()->shared_vertices;
  }

  void reset() override {
    force_.invalidate();
    agreed_.reset();
    multipliers_.resize(0);
  }

  StepOutcome advance(const State& from, State& to, double h, double end_time) override {
    StepOutcome outcome = advance_part(from, to, h, end_time);
    if (system_.part() != nullptr) {
      outcome.balance_sums = outcome.ok() ? balance_shares(system_, to)
                                          : std::vector<double>(balance_share_count(system_));
      make_common(system_.part(), outcome);
    }
    if (!outcome.ok()) force_.invalidate();  // of all parts or of none
    return outcome;
  }

 private:
  // The step of the own part of the body, with the part's shares in the balance.
  StepOutcome advance_part(const State& from, State& to, double h, double end_time) {
    StepOutcome outcome;
    // The forces belong to a state that is not reached if the step fails, however it ends.
    ScopeExit forget_forces([this] { force_.invalidate(); });
    const bool was_known = force_.is_known();
    const EvaluationStatus start = force_.update(system_, from.position);
    if (!was_known && !everywhere(system_.part(), start.ok())) {
      return inverted(outcome, start.failed_element);
    }
    classify_terms();
    const double kick_step = halves_ == 2 ? 0.5 * h : h;
    gather_loads(from, h, halves_ == 2 ? 0.5 : 0.0, load_);
    span_ = {from.time, from.time + h};
    to.step = from.step + 1;
    to.time = end_time;
    to.momentum.resize(system_.dof_count());
    to.velocity.resize(system_.dof_count());
    to.position.resize(system_.dof_count());
    if (terms_.constraining) {
      spring_impulse_.setZero(system_.dof_count());
      spring_delay_.setZero(system_.dof_count());
    }
    for (const Index v : constrained_) {
      vertex_block(reactions_.force, v).setZero();
      vertex_block(reactions_.delay, v).setZero();
    }
    if (terms_.damping) system_.velocity_of(from.momentum, velocity_);

    const VertexKick first = kick(from.position, from.time, kick_step, outcome);
    Dissipated dissipated;
    if (terms_.damping) {
      dissipated = dissipated_by(kick_step, from.position, from.momentum, Place::kBegin);
      if (!(dissipated.energy >= -dissipated.round_off)) {
        outcome.status = StepStatus::kOverdamped;
        return outcome;
      }
    }
    // A part whose step fails goes on to where the others expect something from it.
    const bool is_finite = move(first, h, from, to);
    if (!is_finite && system_.part() == nullptr) return overflowed(outcome);
    contact_.rub_and_drift(from, to, kick_step, span_, outcome);
    if (!constrain_drift(from, to, h, outcome)) return outcome;
    force_.invalidate();
    const EvaluationStatus forces = force_.update(system_, to.position);
    const bool is_well = is_finite && forces.ok();
    if (terms_.damping && !everywhere(system_.part(), is_well) && is_well) {
      return inverted(outcome, -1);
    }
    if (!is_finite) return overflowed(outcome);
    if (!forces.ok()) return inverted(outcome, forces.failed_element);
    if (Index vertex = -1; terms_.potential) {
      const ForceTerm* term = system_.undefined_term(to.position, end_time, vertex);
      if (term != nullptr) return undefined(outcome, *term, vertex);
      if (contact_.is_crossing(from, to, vertex)) {
        return undefined(outcome, *system_.contact(), vertex);
      }
    }
    contact_.enter(from, to, kick_step, halves_ == 2, outcome);
    if (halves_ == 2) {
      if (terms_.damping) predict_velocity(to, kick_step);
      const VertexKick second = kick(to.position, to.time, kick_step, outcome);
      if (!kick_all(second, to.momentum)) return overflowed(outcome);
      contact_.rub(to.position, to.time, kick_step, span_, to.momentum, outcome);
    }
    end_drift(to, h, outcome);
    contact_.finish(to, halves_ == 2, outcome);
    if (terms_.damping) {
      if (halves_ == 2) {
        dissipated.energy += dissipated_by(kick_step, to.position, to.momentum, Place::kEnd).energy;
      }
      // The share of one part is that of all.
      const bool is_first = system_.part() == nullptr || system_.part()->rank() == 0;
      outcome.dissipated_energy = is_first ? std::max(0.0, dissipated.energy) : 0.0;
    }
    finish(from, to, h, outcome);
    if (!has_finite_balance(outcome)) return overflowed(outcome);
    forget_forces.release();
    return outcome;
  }

  // Where an impulse stands among the impulses of a step.
  enum class Place { kBegin, kEnd };

  // The kinds of force terms that a step has to deal with.
  struct Terms {
    Vector3 acceleration = Vector3::Zero();  // of all that are uniform
    bool potential = false;     // some others have a potential of the body or of a constraint, …
    bool constraining = false;  // … of a constraint
    bool only_contact = false;  // those others are the contact with obstacles alone
    bool damping = false;       // anything, viscosity included, is dissipative
  };

  void classify_terms() {
    terms_ = {};
    terms_.damping = system_.is_dissipative();
    terms_.only_contact = system_.part() == nullptr && system_.contact() != nullptr;
    for (const ForceTerm* term : system_.force_terms()) {
      if (!term->has_potential()) continue;
      if (const std::optional<Vector3> acceleration = term->uniform_acceleration()) {
        terms_.acceleration += *acceleration;
        continue;
      }
      terms_.potential = true;
      terms_.only_contact = terms_.only_contact && term == system_.contact();
      if (term->account() == EnergyAccount::kConstraintWork) terms_.constraining = true;
    }
    if (system_.part() == nullptr) return;
    // A spring may be in one part only. All parts use the same method, so that copies of a vertex add up the same
    // forces in the same order. The terms change only with a reset().
    if (!agreed_) {
      agreed_.emplace(std::array{terms_.potential ? 1.0 : 0.0, terms_.damping ? 1.0 : 0.0});
      system_.part()->largest(agreed_->data(), 2);
    }
    terms_.potential = agreed_->at(0) > 0.0;
    terms_.damping = agreed_->at(1) > 0.0;
  }

  // f + m a − ∇W, with f holding whatever is not a uniform acceleration; enters the impulses of all
  // terms at positions q. Damping is that of velocity_; its forces are in damping_ afterwards.
  VertexKick kick(const Vector& q, double time, double dt, StepOutcome& outcome) {
    VertexKick kick;
    kick.mass = system_.mass().data();
    kick.inverse_mass = system_.inverse_mass().data();
    kick.gradient = force_.gradient().data();
    kick.dt = dt;
    if ((!terms_.potential || terms_.only_contact) && !terms_.damping) {
      kick.acceleration = terms_.acceleration;
      if (load_.size() > 0) {
        kick.force = load_.data();
        add_impulse(q, load_, dt, outcome);
      }
      if (!kick.acceleration.isZero(0.0)) {
        const Vector3 moment = system_.part() != nullptr
                                   ? own_first_moment(system_, q)
                                   : Vector3(system_.total_mass() * center_of_mass(system_, q));
        ImpulseSums sums(outcome);
        sums.add(dt * system_.own_mass() * kick.acceleration, moment.cross(dt * kick.acceleration));
        sums.enter(outcome);
      }
      if (terms_.only_contact) {
        contact_.set_force(system_.force_point(q, time, span_), dt, outer_, outcome);
        if (load_.size() > 0) outer_ += load_;
        kick.force = outer_.data();
      }
      return kick;
    }
    gather_term_forces(system_, system_.force_point(q, time, span_), load_, outer_, spring_force_);
    if (terms_.constraining) {
      spring_impulse_ += dt * spring_force_;
      spring_delay_ += (span_.end - time) * dt * spring_force_;
    }
    if (terms_.damping) {
      damping_.setZero(system_.dof_count());
      system_.add_damping_force(q, time, velocity_, damping_);
      outer_ += damping_;
      add_impulse(q, outer_, dt, outcome);
      outer_ -= damping_;
      system_.add_viscous_force(q, velocity_, damping_);
      outer_ += damping_;
    } else {
      add_impulse(q, outer_, dt, outcome);
    }
    kick.force = outer_.data();
    return kick;
  }

  struct Dissipated {
    double energy = 0.0;     // J
    double round_off = 0.0;  // that the energy may have
  };

  // The kinetic energy that the impulse k = dt f of the damping forces f in damping_ takes from the
  // body, J. `momentum` is that at the beginning of the step, where k is the first impulse, or that
  // at its end, where k is the last one. The velocities M⁻¹p are v, and P k is what the constraints
  // leave of k:
  //
  //     first impulse: −kᵀv − ½ kᵀM⁻¹P k        last impulse: −kᵀv + ½ kᵀM⁻¹P k
  //
  // P is orthogonal in M⁻¹, so that these are the changes of ½pᵀM⁻¹p. Vertices that are moved as
  // prescribed have no part in P k, but in kᵀv: there the support does the work that k takes.
  // If k is the first impulse, its energy is negative only if k reverses velocities, for a damping
  // rate beyond h c = 2 (explicit) or 4 (verlet). That is above the stability limit.
  // The round-off is a bound for a sum of this many terms: a damper of a mean velocity has forces on all
  // vertices whose powers cancel where the mean is at rest.
  Dissipated dissipated_by(double dt, const Vector& q, const Vector& momentum, Place place) {
    free_damping_ = damping_;
    project_impulse(system_.constraints(), system_.mass(), q, free_damping_);
    const double half = place == Place::kBegin ? -0.5 * dt : 0.5 * dt;
    std::array<double, 2> sums{};
    for (Index v = 0; v < system_.owned_vertex_count(); ++v) {
      const auto k = vertex_block(std::as_const(damping_), v);
      const auto left = vertex_block(free_damping_, v);
      const auto p = vertex_block(momentum, v);
      const double inverse_mass = system_.inverse_mass()[v];
      sums[0] += inverse_mass * (half * k.dot(left) - k.dot(p));
      sums[1] += inverse_mass * k.cwiseAbs().dot(std::abs(half) * left.cwiseAbs() + p.cwiseAbs());
    }
    sums[1] *= 4.0 * std::numeric_limits<double>::epsilon() * double(system_.dof_count());
    sum_over_parts(system_.part(), sums.data(), sums.size());
    return {dt * sums[0], dt * sums[1]};
  }

  // All vertices as if they were free. Returns false if a position overflows.
  bool move(const VertexKick& kick, double h, const State& from, State& to) {
    std::atomic<bool> finite{true};
    parallel_for(system_.vertex_count(), kVertexGrain, [&](Index begin, Index end) {
      if (!kick_and_drift(begin, end, kick, h, from.position.data(), from.momentum.data(),
                          to.momentum.data(), to.velocity.data(), to.position.data())) {
        finite = false;
      }
    });
    // A vertex is computed with other instructions if it is one of the last. Those that other parts have, too, must
    // have the same bits there.
    for (const Index v : shared_) {
      kick_and_drift(v, v + 1, kick, h, from.position.data(), from.momentum.data(),
                     to.momentum.data(), to.velocity.data(), to.position.data());
    }
    return finite;
  }

  // The momenta alone. Returns false if one of them overflows.
  bool kick_all(const VertexKick& kick, Vector& momentum) {
    std::vector<Vector3> before;
    before.reserve(shared_.size());
    for (const Index v : shared_) before.emplace_back(vertex_block(momentum, v));
    std::atomic<bool> finite{true};
    parallel_for(system_.vertex_count(), kVertexGrain, [&](Index begin, Index end) {
      if (!kick_only(begin, end, kick, momentum.data())) finite = false;
    });
    for (std::size_t i = 0; i < shared_.size(); ++i) {
      vertex_block(momentum, shared_[i]) = before[i];
      kick_only(shared_[i], shared_[i] + 1, kick, momentum.data());
    }
    return finite;
  }

  // Sets the momenta of constrained vertices so that the step ends on the constraints.
  bool constrain_drift(const State& from, State& to, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return true;
    remember_momenta(to.momentum);
    constraints.coordinates().project_momentum(system_.mass(), to.momentum);
    constraints.for_each_prescribed_displacement(
        from.position, to.time, [&](Index v, const Vector3& displacement) {
          vertex_block(to.momentum, v) += system_.mass()[v] / h * displacement;
        });
    if (constraints.has_equations()) {
      const Vector start = constraints.configuration(from.position);
      system_.velocity_of(to.momentum, work_);
      const Vector free_end = start + h * constraints.configuration(work_);
      const MultiplierSolution solution = solve_multipliers(
          constraints, free_end, Constraints::SparseMatrix(h * constraints.sparse_inverse_mass()),
          start, ConstraintDirection::kStart, multipliers_);
      if (!solution.ok) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = cannot_be_met(constraints, solution.worst);
        outcome.obstacle = StepObstacle::kConstraints;
        return false;
      }
      multipliers_ = solution.multipliers;
      reactions_.configuration_force = solution.forces / h;
      Vector impulse = constraints.vertex_forces(solution.forces);
      constraints.coordinates().project_momentum(system_.mass(), impulse);
      to.momentum += impulse;
    }
    enter_reactions(from.position, h, to.momentum, outcome);
    for (const Index v : constrained_) {
      vertex_block(to.velocity, v) = vertex_block(to.momentum, v) / system_.mass()[v];
      vertex_block(to.position, v) =
          vertex_block(from.position, v) + h * vertex_block(to.velocity, v);
    }
    constraints.prescribe(to.time, to.position);
    return true;
  }

  // Momenta that keep the constraints at the end of the step.
  void end_drift(State& to, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return;
    remember_momenta(to.momentum);
    const Vector impulses =
        project_to_constraints(constraints, system_.mass(), to.position, to.time, to.momentum);
    if (impulses.size() > 0) reactions_.configuration_force += impulses / h;
    enter_reactions(to.position, 0.0, to.momentum, outcome);
  }

  void remember_momenta(const Vector& momentum) {
    before_.resize(3, static_cast<Index>(constrained_.size()));
    for (std::size_t i = 0; i < constrained_.size(); ++i) {
      before_.col(static_cast<Index>(i)) = vertex_block(momentum, constrained_[i]);
    }
  }

  // Those of constraints at positions q, `delay` seconds before the end of the step.
  void enter_reactions(const Vector& q, double delay, const Vector& momentum,
                       StepOutcome& outcome) {
    ImpulseSums sums(outcome);
    for (std::size_t i = 0; i < constrained_.size(); ++i) {
      const Index v = constrained_[i];
      const Vector3 impulse = vertex_block(momentum, v) - before_.col(static_cast<Index>(i));
      vertex_block(reactions_.force, v) += impulse;
      if (delay != 0.0) vertex_block(reactions_.delay, v) += delay * impulse;
      if (v >= system_.owned_vertex_count()) continue;
      sums.add_at(vertex_block(q, v), impulse);
    }
    sums.enter(outcome);
  }

  // velocity_ ← a prediction of the velocity at the end of the step: a first kick with the velocity
  // of the drift gives it. It is of second order, as the damping force of verlet needs.
  void predict_velocity(const State& to, double dt) {
    gather_term_forces(system_, system_.force_point(to.position, to.time, span_), load_, outer_,
                       spring_force_);
    outer_ -= force_.gradient();
    system_.add_damping_force(to.position, to.time, to.velocity, outer_);
    system_.add_viscous_force(to.position, to.velocity, outer_);
    Vector& momentum = work_;
    momentum = to.momentum + dt * outer_;
    if (!system_.constraints().empty()) {
      project_to_constraints(system_.constraints(), system_.mass(), to.position, to.time, momentum);
    }
    system_.velocity_of(momentum, velocity_);
  }

  void finish(const State& from, State& to, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    for (const Index v : constrained_) {
      vertex_block(reactions_.force, v) /= h;
      vertex_block(reactions_.delay, v) /= h;
      vertex_block(to.velocity, v) =
          (vertex_block(to.position, v) - vertex_block(from.position, v)) / h;
    }
    if (load_.size() > 0) outcome.external_work = h * own_dot(system_, load_, to.velocity);
    if (terms_.potential) outcome.external_work += driven_work(from, to);
    if (!constraints.empty() || terms_.constraining) {
      outcome.constraint_work += constraint_work(from, to);
    }
    if (terms_.constraining) {
      for (const Index v : constrained_) {
        vertex_block(reactions_.force, v) += vertex_block(spring_impulse_, v) / h;
        vertex_block(reactions_.delay, v) += vertex_block(spring_delay_, v) / h;
      }
    }
    outcome.elastic_energy = force_.elastic_energy();
  }

  static StepOutcome overflowed(StepOutcome& outcome) {
    outcome.status = StepStatus::kNotFinite;
    return outcome;
  }

  static StepOutcome inverted(StepOutcome& outcome, Index element) {
    outcome.status = StepStatus::kInverted;
    outcome.element = element;
    return outcome;
  }

  int halves_;
  std::vector<Index> constrained_;  // constrained vertices
  std::vector<Index> shared_;       // vertices that other parts have, too
  ForceCache force_;
  // These are members in order to avoid allocations.
  Terms terms_;
  // Whether any part has terms with a potential, and whether any has damping. Unknown after a reset().
  std::optional<std::array<double, 2>> agreed_;
  TimeSpan span_;  // that of the step
  Vector load_;    // empty: none
  Vector outer_;
  Vector work_;
  Vector velocity_;        // that damping is of
  Vector damping_;         // forces, viscosity included
  Vector free_damping_;    // what the constraints leave of them
  Vector spring_force_;    // of terms that stand for constraints
  Vector spring_impulse_;  // of them in this step
  Vector spring_delay_;    // each times the time to the end of the step
  Matrix before_;          // momenta of the constrained vertices
  Vector multipliers_;
  ExplicitContact contact_;
};

}  // namespace

std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 1);
}

std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 2);
}

}  // namespace tetraction
