#include "mode_construction.h"

#include <algorithm>
#include <cmath>

namespace tetraction {
namespace {}  // namespace

double RoundOff::of_vector(double omega_squared) const {
  const double error = kEpsilon * largest;
  if (error == 0.0 || std::isinf(beyond)) return 0.0;
  return (error / std::abs(omega_squared)) * (error / beyond);
}

double RoundOff::of_frequency(double omega_squared) const {
  constexpr double kProduct = 4.0;
  if (omega_squared == 0.0) return 1.0;
  const double size = std::abs(omega_squared);
  // Strains have round-off of displacements. Stresses have that of F = 1, which rotations feel.
  const double product = kProduct * kEpsilon * (std::sqrt(largest / size) + turning / size);
  return std::min(1.0, 0.5 * (product + of_vector(omega_squared)));
}

NormalMode make_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                     const RoundOff& round_off, double omega_squared, const Vector& z) {
  NormalMode mode;
  mode.round_off = round_off.of_frequency(omega_squared);
  // If nothing is known of ω², its sign is not known either.
  const bool is_known = mode.round_off < 1.0;
  mode.kind = omega_squared < 0.0 && is_known ? ModeKind::kUnstable : ModeKind::kElastic;
  mode.omega_squared = is_known ? omega_squared : std::abs(omega_squared);
  mode.shape = stiffness.displacements(z);
  Index largest = 0;
  mode.shape.cwiseAbs().maxCoeff(&largest);
  if (mode.shape[largest] < 0.0) mode.shape = -mode.shape;
  const Vector momentum = stiffness.momentum(mode.shape);
  mode.effective_mass = momentum.reshaped(3, system.vertex_count()).rowwise().sum().cwiseAbs2();
  return mode;
}

NormalMode make_rigid_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                           const Vector& z, bool is_mechanism) {
  NormalMode mode = make_mode(system, stiffness, {}, 1.0, z);
  mode.kind = is_mechanism ? ModeKind::kMechanism : ModeKind::kRigid;
  mode.omega_squared = 0.0;
  mode.round_off = 0.0;
  return mode;
}

void enter_damping(const DampingMatrix& damping, NormalMode& mode) {
  const double rate = std::max(0.0, mode.shape.dot(damping.product(mode.shape)));
  if (is_vibration(mode.kind) && mode.omega_squared > 0.0) {
    mode.damping_ratio = 0.5 * rate / std::sqrt(mode.omega_squared);
  } else if (is_free_of_strain(mode.kind) && rate > 0.0) {
    // A rigid motion strains nothing, so that viscosity gives it round-off only.
    if (mode.shape.dot(damping.product_of_terms(mode.shape)) > 0.0) {
      mode.damping_ratio = std::numeric_limits<double>::infinity();
    }
  }
}

}  // namespace tetraction
