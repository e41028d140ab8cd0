// The step-size limit of the explicit rules.
#pragma once

#include <memory>

#include "tetraction/dynamics/integrator.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Largest eigenfrequency of the linearised system and the step it allows.
struct StabilityLimit {
  double omega_max = 0.0;      ///< rad/s, √λ_max of M⁻¹K(q) over the free coordinates
  double damping_rate = 0.0;   ///< c, 1/s: λ_max of M⁻¹C with the damping matrix C
  double critical_step = 0.0;  ///< h_crit of the rule, s: 2/ω_max without damping
  Index element = -1;  ///< that moves most in the mode that sets the limit; −1 without any
};

/// The modes that set a limit, where the next search for it can begin: over the free coordinates,
/// scaled by the roots of their masses; empty where they are not known.
struct CriticalModes {
  Vector stiffness;  ///< of M⁻¹K; with damping and the rule `explicit` that of both together
  Vector damping;    ///< of M⁻¹C
};

/// The largest h for which `explicit` is stable for one mode of frequency ω and damping rate c, both
/// ≥ 0: that of h²ω² + 2hc = 4. Infinite for ω = c = 0.
double explicit_critical_step(double omega, double rate);

/// The largest h for which `verlet` is stable for modes of frequencies up to ω and damping rates up to
/// c: h = 2/ω as long as a = ½hc ≤ 1, and beyond that the h of
/// ¼h²ω² (1 + (1−a)²) = 1 + (1−a)(1−a+a²), which is hc = 3.087 for ω = 0.
double verlet_critical_step(double omega, double rate);

/// h_crit at positions q by Lanczos iterations (Spectra) on the matrix-free K, to a relative accuracy
/// of 1e-4 in ω². W must be defined at q. K holds elastic energy and the potentials of all
/// force terms at `time`, C viscosity and the dissipation potentials of all terms at rest; multipliers
/// are left out, which can only make the limit too small.
///
/// The limits of the explicit rules differ where there is damping; for an implicit rule the limit is that
/// of `explicit`. Damping lowers the limit, as its force is taken at velocities that are known. The limit of `explicit`
/// is the least h for which h²K + 2hC − 4M is singular, which is exact. That of `verlet` is
/// verlet_critical_step() of ω_max and c, which may belong to different modes: on the safe side.
/// If K(q) has no positive eigenvalue, or every vertex is held, omega_max is 0; without damping
/// critical_step is then infinite. Throws InputError where K(q) over the masses is not finite. The modes
/// are left in `modes` unless it is null.
StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q,
                               Integrator rule = Integrator::kExplicit,
                               CriticalModes* modes = nullptr, double time = 0.0);

/// Follows h_crit while a body moves: a few products with K from the modes that were critical last,
/// where stability_limit() takes hundreds. The search begins with these modes, the vertex that is held
/// most stiffly for its mass, and a little noise, so that it also finds what has become stiff elsewhere.
/// Its result is within a few per cent, rather too large than too small.
///
/// Keeps a reference to the system; make a new one after its constraints were changed.
class StabilityTracker {
 public:
  explicit StabilityTracker(const MechanicalSystem& system);
  ~StabilityTracker();
  StabilityTracker(const StabilityTracker&) = delete;
  StabilityTracker& operator=(const StabilityTracker&) = delete;

  /// h_crit at q, where W must be defined; exchanges `modes` for those at q.
  double critical_step(const Vector& q, Integrator rule, CriticalModes& modes, double time = 0.0);
  /// What the last call cost, in evaluations of the elastic forces.
  double cost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The element that moves most in the mode that set a limit (internal number), or −1 without one.
Index critical_element(const MechanicalSystem& system, const CriticalModes& modes);

}  // namespace tetraction
