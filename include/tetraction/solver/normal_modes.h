// Natural frequencies and mode shapes of a body at rest or at an equilibrium.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

enum class ModeKind {
  kRigid,    ///< motion without any stiffness: ω = 0
  kElastic,  ///< oscillation, ω² > 0
  kUnstable,  ///< exponential growth at the rate √(−ω²): the positions are no stable equilibrium
  kFlutter,  ///< oscillation that grows, fed by loads that follow the deformation, in spite of damping
  kMechanism  ///< motion without any stiffness in which pieces of the body turn against each other: ω = 0
};

template <>
struct EnumNames<ModeKind> {
  static constexpr std::array names{"rigid", "elastic", "unstable", "flutter", "mechanism"};
};
/// Whether a mode swings: elastic modes and those that flutter.
inline bool is_vibration(ModeKind kind) {
  return kind == ModeKind::kElastic || kind == ModeKind::kFlutter;
}

/// Whether a mode strains nothing: rigid ones and those of mechanisms.
inline bool is_free_of_strain(ModeKind kind) {
  return kind == ModeKind::kRigid || kind == ModeKind::kMechanism;
}

/// One solution of K y = ω² M y over the motions that the constraints allow.
struct NormalMode {
  ModeKind kind = ModeKind::kElastic;
  double omega_squared = 0.0;  ///< ω², 1/s²; negative for unstable modes, 0 for rigid ones
  /// Displacements of all vertices (3 per vertex), mass-normalised: φᵀMφ = 1; in kg^(−½).
  Vector shape;
  /// (φᵀM r_d)² for the unit translations r_d along x, y, z: the effective modal masses, kg. Under loads
  /// that depend on positions it is the real part of ψᵀM r_d φᵀM r_d with the left eigenvector ψ, ψᵀMφ = 1,
  /// which may be negative.
  Vector3 effective_mass = Vector3::Zero();
  /// φᵀCφ/(2ω), the part of the critical damping, with the damping matrix C of small motions about the
  /// positions: drag, mass damping, viscosity and other dissipation. 0 without damping; infinite for a
  /// damped rigid mode. It says nothing of an unstable mode. Under loads that depend on positions it is
  /// −Re λ/|λ| for the motion e^(λt) of the damped body in the space of the modes, and it is negative if that
  /// motion grows.
  double damping_ratio = 0.0;
  /// Of a mode that flutters: the amplitude grows as exp(growth_rate t), 1/s, with the damping of the body.
  /// Without damping such modes come in pairs with the same frequency and rate; their two shapes alternate
  /// within a period.
  double growth_rate = 0.0;
  /// The estimated relative error of the frequency that round-off causes, at most 1. It grows with the
  /// distance to the highest frequency of the mesh. At 1 nothing is known of the frequency, nor whether
  /// the mode is unstable. 0 for a rigid mode.
  double round_off = 0.0;

  /// √|ω²|/2π, Hz: the frequency of an elastic mode. For an unstable mode it is the rate of growth
  /// over 2π, as an imaginary frequency.
  double frequency() const;
};

struct NormalModes {
  /// In the order of ω²: unstable, rigid, elastic.
  std::vector<NormalMode> modes;
  /// What the effective masses of all modes add up to along x, y, z, kg: the mass that takes part in
  /// motions that the constraints allow.
  Vector3 moved_mass = Vector3::Zero();
  /// The number of modes that the body has: free coordinates less independent equations of
  /// constraints.
  Index total = 0;
};

struct NormalModeOptions {
  Index count = 10;   ///< number of modes, 1 or more
  double time = 0.0;  ///< s, at which the potentials of force terms are taken
  /// Whether potentials of loads (EnergyAccount::kExternalWork, such as pressures) are parts of K, as
  /// they must be at an equilibrium under these loads.
  bool with_loads = false;
  /// What the loads and stored potentials of force terms are multiplied by, as in a load step (StaticProblem).
  /// Potentials that stand for constraints are not.
  double load_factor = 1.0;
  /// The multipliers λ of the equations of constraints that balance the forces at an equilibrium
  /// (balancing_multipliers()), J. Empty for a body without stress: all are zero.
  Vector multipliers = Vector();
};

/// The multipliers λ with Tᵀ(∇W + ∇U − f + Σ λᵢ ∂gᵢ/∂q) = 0 at an equilibrium q, in the sense of least
/// squares. `load` is f, 3 per vertex, N: the loads, and the forces of potentials that count as
/// external work (Equilibrium::load). U are the other potentials; stored ones are multiplied by `load_factor`.
/// Empty if no constraint has equations. Throws InputError if W is not defined at q.
Vector balancing_multipliers(const MechanicalSystem& system, const Vector& q, const Vector& load,
                             double time = 0.0, double load_factor = 1.0);

/// The modes of the lowest ω² of small motions about the positions q.
///
/// The generalised eigenproblem TᵀK(q)T y = ω² TᵀMT y over the free coordinates y is solved by
/// Lanczos iterations (Spectra) with the inverse of K − σM, which CHOLMOD factorises (B. N. Parlett,
/// The Symmetric Eigenvalue Problem, 13). K is the Hessian of the elastic energy and of the
/// potentials of force terms at `time`. M is the lumped mass, as in time steps, and for quadratic
/// elements the consistent one (dynamics/consistent_mass.h). Distances and free rigid handles are linearised: modes
/// satisfy (∂g/∂q) δq = 0, and K has the curvature Σ λᵢ ∂²gᵢ/∂q² of the equations. With
/// `with_loads`, K also has the stiffness −∂f/∂x of loads that depend on positions, such as the forces on
/// the rim of a pressure. It is not symmetric. The modes are then found by Davidson's method, beginning
/// with those of the symmetric part. Their shapes are not orthogonal to each other but to the eigenvectors of
/// the transposed matrix, the left ones, and ω² may be complex. Damping does not change
/// frequencies or shapes, but it decides which modes flutter (ModeKind::kFlutter).
///
/// Rigid motions that meet no stiffness are found exactly, apart from the iterations: their number follows
/// from the constraints and the force terms. About the body at rest the same holds for pieces that touch
/// only in edges and vertices (ModeKind::kMechanism). Eigenvalues of
/// any multiplicity are found in full, since the search is repeated in what the modes found so far
/// leave over until nothing lower comes. The modes found are then made more accurate in the space that they span,
/// with strain energies that are summed over the elements. The frequencies of the discrete problem are accurate to
/// about 1e-15 ω_max/ω relative, at best 1e-12 (NormalMode::round_off, round_off_warning()).
///
/// Returns fewer modes if the body has no more. q must be an equilibrium for the result to mean
/// oscillations about it; this is not checked. Throws InputError if the count is not positive, if
/// the elastic energy or a potential is not defined at q, if every vertex is held, or if the matrix
/// is not finite or cannot be factorised. Throws Error if the iterations do not converge.
NormalModes normal_modes(const MechanicalSystem& system, const Vector& q,
                         const NormalModeOptions& options = {});

/// A warning that round-off spoils the frequencies of some of the modes, with the number of digits that are
/// left. Empty if all have a relative error of less than 1e-4.
std::string round_off_warning(const NormalModes& modes);

}  // namespace tetraction
