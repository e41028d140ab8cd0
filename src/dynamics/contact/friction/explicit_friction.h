// Contact in explicit steps: Coulomb friction and impulses. The source has Contact::impact_forecast(), too.
#pragma once

#include <vector>

#include "friction_step.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// The impulses of friction that belong to one kick of an explicit step. A place of contact whose normal impulse is
/// J_n gets a tangential impulse J against its slip u, which stops it (between bodies: in the direction of u), but not
/// more than |J| = μ J_n. So friction sets no limit to the step, and what sticks on an obstacle is at rest.
class ExplicitFriction {
 public:
  /// Changes the momenta after a kick of the length dt at positions q, in a step from `span.begin` to `span.end`.
  void apply(const MechanicalSystem& system, const Vector& q, double time, const TimeSpan& span,
             double dt, Vector& momentum);
  /// The vertices whose momenta the last apply() changed.
  const std::vector<Index>& vertices() const { return vertices_; }
  /// The energies of the last apply(), J, if the velocities were those before the kick and after it: an impulse J
  /// does its work with ½(v⁻ + v⁺). A place that sticks therefore makes no heat.
  FrictionPower energy(const MechanicalSystem& system, const Vector& before,
                       const Vector& after) const;
  /// add(obstacle, vertex, impulse) for the last apply().
  template <class Add>
  void for_each_impulse(const Add& add) const {
    for (const Impulse& each : impulses_) {
      for (int i = 0; i < each.place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        add(each.obstacle, each.place.vertices.at(n), each.place.part(n, each.impulse));
      }
    }
  }

 private:
  struct Impulse {
    std::size_t obstacle;
    ContactPoint place;  // vertices are those of the mesh
    Vector3 impulse;     // N s
    Vector3 drift;       // the velocity of the obstacle there, m/s
  };

  std::vector<Impulse> impulses_;
  std::vector<Index> vertices_;
};

/// What obstacles do in an explicit step: the forces of their potential where no other term has one, friction, its
/// heat, the impulses of each obstacle, and whether the step jumped over one. All functions but set_force() do nothing
/// where there are no obstacles.
class ExplicitContact {
 public:
  /// Keeps a reference to `system`, which must live longer.
  explicit ExplicitContact(const MechanicalSystem& system) : system_(system) {}

  /// force ← that of the contact at a point, 3 per vertex, N. Enters its impulse of a kick of the length dt. Most vertices
  /// touch nothing, which makes this cheaper than the same for the forces of all terms.
  void set_force(const ForcePoint& at, double dt, Vector& force, StepOutcome& outcome) const;
  /// Friction after a kick of the length dt at positions q, in the step `span`.
  void rub(const Vector& q, double time, double dt, const TimeSpan& span, Vector& momentum,
           StepOutcome& outcome);
  /// The same after the first kick, with the drift to the end of the step.
  void rub_and_drift(const State& from, State& to, double dt, const TimeSpan& span,
                     StepOutcome& outcome);
  /// Enters the impulses of obstacles, the work of their motion, and the heat of the first friction. The momenta of `to` are those of the
  /// drift. With `twice` there is a second kick at the end.
  void enter(const State& from, const State& to, double dt, bool twice, StepOutcome& outcome);
  /// Enters the heat of the second friction, if there is one. The momenta of `to` are final.
  void finish(const State& to, bool twice, StepOutcome& outcome) const;
  /// Whether a vertex jumped over an obstacle.
  bool is_crossing(const State& from, const State& to, Index& vertex) const;

 private:
  bool has_friction() const;
  void enter_heat(const Vector& before, const Vector& after, StepOutcome& outcome) const;

  const MechanicalSystem& system_;
  ExplicitFriction friction_;
  Vector middle_momentum_;  // in the middle of a step with two kicks
};

}  // namespace tetraction
