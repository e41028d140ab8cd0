// The body and everything that acts on it. Integrators advance such a system in time.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "tetraction/dynamics/body.h"
#include "tetraction/dynamics/constraints/constraints.h"
#include "tetraction/dynamics/terms/damping.h"
#include "tetraction/dynamics/terms/environment.h"
#include "tetraction/dynamics/terms/external_forces.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/dynamics/terms/surface_pressure.h"
#include "tetraction/dynamics/terms/vertex_damping.h"
#include "tetraction/dynamics/terms/vertex_pull.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

class Contact;

/// A body with its constraints, damping and loads.
///
/// Time stepping is in Stepper, the balance of energy and momentum in Balance.
class MechanicalSystem : public Body {
 public:
  /// The constructors of Body.
  MechanicalSystem(TetMesh mesh, const MaterialField& material, double density);
  MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                   const std::vector<int>& region_of_element,
                   VolumeRule volume = VolumeRule::kElement);

  /// Replaces all constraints of the body. Returns the former ones.
  Constraints set_constraints(Constraints constraints);
  const Constraints& constraints() const { return constraints_; }
  const FreeCoordinates& coordinates() const { return constraints_.coordinates(); }
  void set_environment(const Environment& environment) { environment_ = environment; }
  const Environment& environment() const { return environment_; }
  /// Throws InputError for numbers that are negative or not finite.
  void set_damping(const Damping& damping);
  const Damping& damping() const { return damping_; }
  /// Throws InputError for a force that is not finite or a vertex that does not exist.
  void add_force(ExternalForce force);
  /// Replaces force number `index`, counted from 0 in the order of their addition.
  void set_force(std::size_t index, ExternalForce force);
  const std::vector<ExternalForce>& forces() const { return external_forces_.list(); }
  /// Replaces all forces.
  void set_forces(std::vector<ExternalForce> forces);
  /// Replaces all pressures. Throws InputError for a pressure that is not finite, a vertex that does
  /// not exist, or a pressure without triangles.
  void set_pressures(std::vector<PressureLoad> pressures);
  const std::vector<PressureLoad>& pressures() const { return pressure_.list(); }
  /// Replaces the spring that pulls vertices.
  void set_pull(VertexPull pull) { pull_ = std::move(pull); }
  /// Replaces the contact with obstacles (null: there are none). Steppers and solvers that were made before do not
  /// know it. Returns the former contact.
  std::shared_ptr<const Contact> set_contact(std::shared_ptr<const Contact> contact);
  /// The contact with obstacles; null without one.
  const Contact* contact() const { return contact_.get(); }

  /// Adds a force term of the caller's own. Steppers and solvers that were made before do not know
  /// it. Throws InputError for a null pointer, for a name that is not made of lower-case letters,
  /// digits and underscores, or that another term or energy has, and for a potential without an
  /// account.
  void add_force_term(std::shared_ptr<const ForceTerm> term);
  /// The same, but takes the place of an added term with the same name, if there is one.
  void set_force_term(std::shared_ptr<const ForceTerm> term);
  /// Everything that acts on the body besides elasticity and viscosity: environment, damping of
  /// single vertices, penalty springs, external forces, pressure, pull, contact if there is one, and the terms
  /// that were added, in this order.
  const std::vector<const ForceTerm*>& force_terms() const { return terms_; }
  /// Where force terms are evaluated, at an instant. It refers to `position`.
  ForcePoint force_point(const Vector& position, double time) const {
    return {force_masses(), position, time};
  }
  /// The same for forces that act in a step.
  ForcePoint force_point(const Vector& position, double time,
                         const std::optional<TimeSpan>& step) const {
    return {force_masses(), position, time, step};
  }
  /// Where energies of terms are evaluated, at an instant. Its masses are those of the own vertices only.
  /// Energies, changes of energy and driven work at such points are those of the own part.
  ForcePoint energy_point(const Vector& position, double time) const {
    return {part() != nullptr ? own_masses() : force_masses(), position, time};
  }
  /// |Tᵀ f|₂ over the free coordinates of the whole body (FreeCoordinates::restricted_norm()).
  double restricted_norm(const Vector& full) const;
  /// Lets forces per mass, such as gravity, act with consistent weights
  /// (dynamics/consistent_mass.h) instead of the lumped masses, for statics. External forces that
  /// were added before stay as they are.
  void use_consistent_weights();
  bool has_consistent_weights() const { return weights_.size() > 0; }
  /// ∫ N_a dV over element e for each of its nodes a, m³: the weights with which a force per volume
  /// acts on them. They are the element's volume times RestState::mass_fraction(), or the consistent
  /// weights after use_consistent_weights().
  Vector element_weights(Index e) const;
  /// f ← the sum of the loads of all terms at a point (3 per vertex, N): their mean over a step, so
  /// that h f is the impulse ∫ f dt, or their values at an instant. It is empty if no term has a load.
  void external_force(const ForcePoint& at, Vector& f) const;
  /// f ← all forces of the user's on the vertices: the loads, and the forces of potentials that count
  /// as external work (pressure).
  void applied_force(const ForcePoint& at, Vector& f) const;
  /// The same, as the means over the step of size h that starts at `time`, with the positions `q`
  /// where forces depend on positions.
  void external_force(const Vector& q, double time, double h, Vector& f) const {
    external_force(force_point(q, time, TimeSpan{time, time + h}), f);
  }
  void applied_force(const Vector& q, double time, double h, Vector& f) const {
    applied_force(force_point(q, time, TimeSpan{time, time + h}), f);
  }
  /// Whether a load depends on positions.
  bool has_load_of_position() const;
  /// force −= ∂D/∂v of all terms at velocities v (3 per vertex, N). Viscosity is not included.
  void add_damping_force(const Vector& q, double time, const Vector& v, Vector& force) const;
  /// Whether a term or viscosity dissipates energy of a moving body.
  bool is_dissipative() const;
  /// Returns the first term whose potential is not defined at q, or null if all are defined. `vertex` is
  /// the first vertex at which it is not defined, or −1 if the energy of the term is not finite. Of a
  /// part, only its own vertices count.
  const ForceTerm* undefined_term(const Vector& q, double time, Index& vertex) const;

  /// force += the forces of viscosity at positions q and velocities v (3 per vertex, N).
  void add_viscous_force(const Vector& q, const Vector& v, Vector& force) const;

  /// Sets p = Mv, projected to what the constraints allow. Prescribed components move as
  /// prescribed.
  void set_velocity(State& state, const Vector& velocity) const;

 private:
  const Vector& force_masses() const { return weights_.size() > 0 ? weights_ : mass(); }
  void check(const ExternalForce& force) const;
  void list_terms();

  Vector weights_;  // in place of the lumped masses for forces; empty if they are the same
  ViscousPotential viscous_;
  Constraints constraints_;
  Environment environment_;
  Damping damping_;
  VertexDamping vertex_damping_;
  ExternalForces external_forces_;
  SurfacePressure pressure_;
  VertexPull pull_;
  std::shared_ptr<const Contact> contact_;
  std::vector<std::shared_ptr<const ForceTerm>> added_terms_;
  std::vector<const ForceTerm*> terms_;
};

}  // namespace tetraction
