// The explicit rules. The only unknowns to be solved for are the multipliers of constraints, if
// any.
#include <Eigen/Geometry>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "term_forces.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/multipliers.h"
#include "tetraction/dynamics/stepper.h"
#include "vertex_kernels.h"

namespace tetraction {
namespace {

// The number of vertices for which a task of its own is worthwhile.
constexpr Index kGrain = 2048;

// ∇W of the elastic energy at the current position, kept from the end of the last step.
class ForceCache {
 public:
  EvaluationStatus update(const MechanicalSystem& system, const Vector& q) {
    if (valid_) return {};
    const EvaluationStatus status =
        system.elastic().value_and_gradient(q, elastic_energy_, gradient_);
    valid_ = status.ok();
    return status;
  }
  void invalidate() { valid_ = false; }
  const Vector& gradient() const { return gradient_; }
  double elastic_energy() const { return elastic_energy_; }

 private:
  bool valid_ = false;
  double elastic_energy_ = 0.0;
  Vector gradient_;
};

// Forgets the forces unless the step ends well: they belong to a state that is not reached then, however
// the step ends.
class CacheGuard {
 public:
  explicit CacheGuard(ForceCache& cache) : cache_(cache) {}
  ~CacheGuard() {
    if (!kept_) cache_.invalidate();
  }
  CacheGuard(const CacheGuard&) = delete;
  CacheGuard& operator=(const CacheGuard&) = delete;
  void keep() { kept_ = true; }

 private:
  ForceCache& cache_;
  bool kept_ = false;
};

class ExplicitStepper : public Stepper {
 public:
  // `halves` 1: p moves by a whole step before q (α = 0); 2: by half before and half after
  // (verlet).
  ExplicitStepper(const MechanicalSystem& system, int halves)
      : Stepper(system),
        halves_(halves),
        constrained_(system.constraints().constrained_vertices()) {}

  void reset() override {
    force_.invalidate();
    multipliers_.resize(0);
  }

  bool take_back(State& state) override {
    std::swap(state, next_);
    reset();
    return true;
  }

  StepOutcome step_to(State& state, double h, double end_time) override {
    StepOutcome outcome;
    CacheGuard guard(force_);
    if (const EvaluationStatus start = force_.update(system_, state.position); !start.ok()) {
      return inverted(outcome, start.failed_element);
    }
    classify_terms();
    const double kick_step = halves_ == 2 ? 0.5 * h : h;
    system_.external_force(state.time, h, load_);
    next_.time = end_time;
    next_.momentum.resize(system_.dof_count());
    next_.velocity.resize(system_.dof_count());
    next_.position.resize(system_.dof_count());
    if (terms_.constraining) spring_impulse_.setZero(system_.dof_count());
    for (const Index v : constrained_) vertex_block(reaction_, v).setZero();
    overdamped_ = false;
    if (terms_.damping) system_.velocity_of(state.momentum, velocity_);

    const VertexKick first = kick(state.position, state.time, kick_step, When::kFirst, outcome);
    if (!move(first, h, state)) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    if (!constrain_drift(state, h, outcome)) return outcome;
    force_.invalidate();
    if (const EvaluationStatus end = force_.update(system_, next_.position); !end.ok()) {
      return inverted(outcome, end.failed_element);
    }
    if (Index vertex = -1; terms_.potential) {
      const ForceTerm* term = system_.undefined_term(next_.position, end_time, vertex);
      if (term != nullptr) return undefined(outcome, *term, vertex);
    }
    if (halves_ == 2) {
      if (terms_.damping) predict_velocity(kick_step);
      const VertexKick second = kick(next_.position, next_.time, kick_step, When::kLast, outcome);
      parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
        kick_only(begin, end, second, next_.momentum.data());
      });
    }
    if (overdamped_) {
      outcome.status = StepStatus::kOverdamped;
      return outcome;
    }
    end_drift(h, outcome);
    finish(state, h, outcome);
    guard.keep();
    std::swap(state, next_);
    return outcome;
  }

 private:
  // Whether a kick comes before or after the drift.
  enum class When { kFirst, kLast };

  // The kinds of force terms that a step has to deal with.
  struct Terms {
    Vector3 acceleration = Vector3::Zero();  // of all that are uniform
    bool potential = false;     // some others have a potential of the body or of a constraint, …
    bool constraining = false;  // … of a constraint
    bool damping = false;       // anything, viscosity included, is dissipative
  };

  void classify_terms() {
    terms_ = {};
    terms_.damping = system_.is_dissipative();
    for (const ForceTerm* term : system_.force_terms()) {
      if (!term->has_potential()) continue;
      if (const std::optional<Vector3> acceleration = term->uniform_acceleration()) {
        terms_.acceleration += *acceleration;
        continue;
      }
      terms_.potential = true;
      if (term->account() == EnergyAccount::kConstraintWork) terms_.constraining = true;
    }
  }

  // f + m a − ∇W, with f holding whatever is not a uniform acceleration; enters the impulses of all
  // terms at positions q. Damping is that of velocity_.
  VertexKick kick(const Vector& q, double time, double dt, When when, StepOutcome& outcome) {
    VertexKick kick;
    kick.mass = system_.mass().data();
    kick.inverse_mass = system_.inverse_mass().data();
    kick.gradient = force_.gradient().data();
    kick.dt = dt;
    if (!terms_.potential && !terms_.damping) {
      kick.acceleration = terms_.acceleration;
      if (load_.size() > 0) {
        kick.force = load_.data();
        add_impulse(q, load_, dt, outcome);
      }
      if (!kick.acceleration.isZero(0.0)) {
        const Vector3 moment = system_.total_mass() * system_.center_of_mass(q);
        outcome.linear_impulse += dt * system_.total_mass() * kick.acceleration;
        outcome.angular_impulse += moment.cross(dt * kick.acceleration);
      }
      return kick;
    }
    gather_term_forces(system_, q, time, load_, outer_, spring_force_);
    if (terms_.constraining) spring_impulse_ += dt * spring_force_;
    if (terms_.damping) {
      work_.setZero(system_.dof_count());
      system_.add_damping_force(q, time, velocity_, work_);
      outer_ += work_;
      add_impulse(q, outer_, dt, outcome);
      outer_ -= work_;
      system_.add_viscous_force(q, velocity_, work_);
      outer_ += work_;
      const double dissipated = dissipated_by(dt, when);
      overdamped_ = overdamped_ || !(dissipated >= 0.0);
      outcome.dissipated_energy += dissipated;
    } else {
      add_impulse(q, outer_, dt, outcome);
    }
    kick.force = outer_.data();
    return kick;
  }

  // The kinetic energy that the impulse of the damping forces f in work_ dissipates in a time dt,
  // J. With the velocities v in velocity_ it is −dt fᵀ(v ± ½ dt M⁻¹f). The sign depends on whether
  // the impulse comes before or after all others of the step. It is not negative unless it reverses
  // a velocity.
  double dissipated_by(double dt, When when) {
    const double rate = -work_.dot(velocity_);
    free_damping_ = work_;
    system_.coordinates().project_momentum(system_.mass(), free_damping_);
    double square = 0.0;
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      square += system_.inverse_mass()[v] * vertex_block(free_damping_, v).squaredNorm();
    }
    return dt * (rate + (when == When::kFirst ? -0.5 : 0.5) * dt * square);
  }

  // All vertices as if they were free. Returns false if a position overflows.
  bool move(const VertexKick& kick, double h, const State& state) {
    std::atomic<bool> finite{true};
    parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
      if (!kick_and_drift(begin, end, kick, h, state.position.data(), state.momentum.data(),
                          next_.momentum.data(), next_.velocity.data(), next_.position.data())) {
        finite = false;
      }
    });
    return finite;
  }

  // Sets the momenta of constrained vertices so that the step ends on the constraints.
  bool constrain_drift(const State& state, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return true;
    remember_momenta();
    constraints.coordinates().project_momentum(system_.mass(), next_.momentum);
    constraints.for_each_prescribed_way(
        state.position, next_.time, [&](Index v, const Vector3& way) {
          vertex_block(next_.momentum, v) += system_.mass()[v] / h * way;
        });
    if (constraints.has_equations()) {
      const Vector start = constraints.configuration(state.position);
      system_.velocity_of(next_.momentum, work_);
      const Vector free_end = start + h * constraints.configuration(work_);
      const MultiplierSolution solution =
          solve_multipliers(constraints, free_end, h * constraints.inverse_mass(), start,
                            ConstraintDirection::kStart, multipliers_);
      if (!solution.ok) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = cannot_be_met(constraints, solution.worst);
        return false;
      }
      multipliers_ = solution.multipliers;
      configuration_force_ = solution.forces / h;
      Vector impulse = constraints.vertex_forces(solution.forces);
      constraints.coordinates().project_momentum(system_.mass(), impulse);
      next_.momentum += impulse;
    }
    enter_reactions(state.position, outcome);
    for (const Index v : constrained_) {
      vertex_block(next_.velocity, v) = vertex_block(next_.momentum, v) / system_.mass()[v];
      vertex_block(next_.position, v) =
          vertex_block(state.position, v) + h * vertex_block(next_.velocity, v);
    }
    constraints.prescribe(next_.time, next_.position);
    return true;
  }

  // Momenta that keep the constraints at the end of the step.
  void end_drift(double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return;
    remember_momenta();
    const Vector impulses = project_to_constraints(constraints, system_.mass(), next_.position,
                                                   next_.time, next_.momentum);
    if (impulses.size() > 0) configuration_force_ += impulses / h;
    enter_reactions(next_.position, outcome);
  }

  void remember_momenta() {
    before_.resize(3, static_cast<Index>(constrained_.size()));
    for (std::size_t i = 0; i < constrained_.size(); ++i) {
      before_.col(static_cast<Index>(i)) = vertex_block(next_.momentum, constrained_[i]);
    }
  }

  void enter_reactions(const Vector& q, StepOutcome& outcome) {
    for (std::size_t i = 0; i < constrained_.size(); ++i) {
      const Index v = constrained_[i];
      const Vector3 impulse = vertex_block(next_.momentum, v) - before_.col(static_cast<Index>(i));
      vertex_block(reaction_, v) += impulse;
      outcome.linear_impulse += impulse;
      outcome.angular_impulse += vertex_block(q, v).cross(impulse);
    }
  }

  // velocity_ ← a prediction of the velocity at the end of the step: a first kick with the velocity
  // of the drift gives it. It is of second order, as the damping force of verlet needs.
  void predict_velocity(double dt) {
    gather_term_forces(system_, next_.position, next_.time, load_, outer_, spring_force_);
    outer_ -= force_.gradient();
    system_.add_damping_force(next_.position, next_.time, next_.velocity, outer_);
    system_.add_viscous_force(next_.position, next_.velocity, outer_);
    Vector& momentum = work_;
    momentum = next_.momentum + dt * outer_;
    if (!system_.constraints().empty()) {
      project_to_constraints(system_.constraints(), system_.mass(), next_.position, next_.time,
                             momentum);
    }
    system_.velocity_of(momentum, velocity_);
  }

  void finish(const State& state, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    for (const Index v : constrained_) {
      vertex_block(reaction_, v) /= h;
      vertex_block(next_.velocity, v) =
          (vertex_block(next_.position, v) - vertex_block(state.position, v)) / h;
    }
    if (load_.size() > 0) outcome.external_work = h * load_.dot(next_.velocity);
    if (terms_.potential) outcome.external_work += driven_work(state, next_);
    if (!constraints.empty() || terms_.constraining) {
      outcome.constraint_work = constraint_work(state, next_);
    }
    if (terms_.constraining) {
      for (const Index v : constrained_)
        vertex_block(reaction_, v) += vertex_block(spring_impulse_, v) / h;
    }
    outcome.elastic_energy = force_.elastic_energy();
    next_.step = state.step + 1;
  }

  static StepOutcome inverted(StepOutcome& outcome, Index element) {
    outcome.status = StepStatus::kInverted;
    outcome.element = element;
    return outcome;
  }

  int halves_;
  std::vector<Index> constrained_;  // constrained vertices
  ForceCache force_;
  // These are members in order to avoid allocations.
  State next_;
  Terms terms_;
  Vector load_;  // empty: none
  Vector outer_;
  Vector work_;
  Vector velocity_;        // that damping is of
  Vector free_damping_;    // the part of damping forces that changes the free momenta
  Vector spring_force_;    // of terms that stand for constraints
  Vector spring_impulse_;  // of them in this step
  Matrix before_;          // momenta of the constrained vertices
  bool overdamped_ = false;
  Vector multipliers_;
};

}  // namespace

std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 1);
}

std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 2);
}

}  // namespace tetraction
