// Coulomb friction of explicit steps.
#pragma once

#include <vector>

#include "friction_step.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The impulses of friction that belong to one kick of an explicit step. A place of contact whose normal
/// impulse is J_n gets the tangential impulse J that stops its slip, but not more than |J| = μ J_n. So friction sets no
/// limit to the step, and what sticks is at rest.
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
        add(each.obstacle, each.place.vertices.at(n),
            Vector3(each.place.weights.at(n) * each.impulse));
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

}  // namespace tetraction
