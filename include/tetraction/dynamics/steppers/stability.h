// The step-size limit of the explicit rules.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction {

/// Largest eigenfrequency of the linearised system and the step it allows.
struct StabilityLimit {
  double omega_max = 0.0;      ///< rad/s, √λ_max of M⁻¹K(q) over the free coordinates
  double damping_rate = 0.0;   ///< c, 1/s: λ_max of M⁻¹C with the damping matrix C
  double critical_step = 0.0;  ///< h_crit of the rule, s: 2/ω_max without damping
  Index element = -1;  ///< moves most in the mode that sets the limit; −1 without such a mode
};

/// The modes that set a limit. The next search can begin with them. They are vectors over the free
/// coordinates, scaled by the square roots of their masses, and empty if they are not known.
struct CriticalModes {
  Vector stiffness;  ///< mode of M⁻¹K; of M⁻¹(K + wC) for the rule `explicit` with damping
  Vector damping;    ///< mode of M⁻¹C
};

/// The largest h for which `explicit` is stable for one mode of frequency ω and damping rate c,
/// both ≥ 0. It is the solution of h²ω² + 2hc = 4, and infinite for ω = c = 0.
double explicit_critical_step(double omega, double rate);

/// The largest h for which `verlet` is stable for modes of frequencies up to ω and damping rates up
/// to c. It is h = 2/ω as long as a = ½hc ≤ 1. Beyond that it is the solution of ¼h²ω² (1 + (1−a)²)
/// = 1 + (1−a)(1−a+a²), which is hc = 3.087 for ω = 0.
double verlet_critical_step(double omega, double rate);

/// The largest rate c, 1/s, at which the damping of single vertices (drag, mass damping, terms of a
/// program) slows down a vertex at positions q and `time`. 0 without such damping.
double vertex_damping_rate(const MechanicalSystem& system, const Vector& q, double time);

/// Computes h_crit at positions q by Lanczos iterations (Spectra) on the matrix-free K, to a
/// relative accuracy of 1e-4 in ω². W must be defined at q. K is the Hessian of the elastic energy
/// and of the potentials of all force terms at `time`. C is the damping matrix of viscosity and of
/// the dissipation potentials of all terms at v = 0. Distances and free handles restrict the motions as they do
/// at q; that their forces turn with the body (λ ∂²g/∂q²) is left out.
///
/// The limits of the explicit rules differ if there is damping. For an implicit rule the limit is
/// that of `explicit`. Damping lowers the limit, because its force is taken at velocities that are
/// already known. The limit of `explicit` is the smallest h for which h²K + 2hC − 4M is singular,
/// which is exact. The limit of `verlet` is verlet_critical_step() of ω_max and c. These may belong
/// to different modes, so that the limit may be smaller than necessary. If K(q) has no positive
/// eigenvalue, or if every vertex is prescribed, omega_max is 0; without damping critical_step is
/// then infinite. Throws InputError if M⁻¹K(q) is not finite. The modes are returned in `modes`
/// unless it is null.
StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q,
                               Integrator rule = Integrator::kExplicit,
                               CriticalModes* modes = nullptr, double time = 0.0);

/// Follows h_crit while a body moves. It takes a few products with K, where stability_limit() takes
/// hundreds. The search begins with the last critical modes, with the vertex that has the largest
/// stiffness for its mass, and with a little noise, so that it also finds other parts of the body
/// that have become stiff. The result is correct within a few per cent and is rather too large than
/// too small.
///
/// Keeps a reference to the system. Make a new tracker after the constraints of the system were
/// changed.
class StabilityTracker {
 public:
  explicit StabilityTracker(const MechanicalSystem& system);
  ~StabilityTracker();
  StabilityTracker(const StabilityTracker&) = delete;
  StabilityTracker& operator=(const StabilityTracker&) = delete;

  /// h_crit at q, where W must be defined. Replaces `modes` with the critical modes at q.
  double critical_step(const Vector& q, Integrator rule, CriticalModes& modes, double time = 0.0);
  /// The cost of the last call, as a number of evaluations of the elastic forces.
  double cost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The element that moves most in the mode that set a limit (internal number), or −1 without one.
Index critical_element(const MechanicalSystem& system, const CriticalModes& modes);

/// The largest ρc of the body's tetrahedra, with the speed c = √((λ + 2μ)/ρ) of pressure waves at rest, Pa s/m. The
/// impact of a half-space with the speed v has the pressure ρ c v.
double largest_impedance(const MechanicalSystem& system);

}  // namespace tetraction
