// Rayleigh damping: mass damping and viscosity from two damping ratios.
#pragma once

#include <array>

#include "tetraction/core/enum_names.h"
#include "tetraction/dynamics/terms/damping.h"
#include "tetraction/material/material_concept.h"

namespace tetraction {

/// Damping ratios ζ (parts of the critical damping, –) at two different frequencies.
struct DampingRatio {
  std::array<double, 2> frequency{};  ///< Hz, above 0
  std::array<double, 2> value{};      ///< ζ at these frequencies, 0 or more

  bool operator==(const DampingRatio&) const = default;
};

/// The kinds of deformation that viscosity damps differently.
enum class DeformationKind {
  kShear,        ///< of constant volume: S = 2ηĖ is β = η/μ times the elastic stress
  kBending,      ///< bending and tension of slender bodies, with free lateral contraction
  kVolumeChange  ///< equal strains in all directions
};

template <>
struct EnumNames<DeformationKind> {
  static constexpr std::array names{"shear", "bending and tension", "volume change"};
};

/// The mass damping a and the viscosity η = βμ for which shear of a material with these moduli has
/// the given damping ratios: ζ(ω) = a/(2ω) + βω/2 with ω = 2πf at both frequencies (Rayleigh; R. W.
/// Clough and J. Penzien, Dynamics of Structures, 12.5). `drag` is 0 in the result.
///
/// Throws InputError, with a text that completes "damping.ratio …", for frequencies that are not
/// positive or are equal, for ratios that are negative, and for two ratios that need a negative a or
/// η: ζ₂/ζ₁ must lie between f₁/f₂ and f₂/f₁.
Damping rayleigh_damping(const DampingRatio& ratio, const LameParameters& lame);

/// The relaxation time β, s, of a kind of deformation: the dissipated power over the rate at which
/// the elastic energy density is stored at the same strain rates, each of them quadratic in the
/// rate. It is η/μ in shear, η(1+2ν²)/(μ(1+ν)) in bending and tension, and 2η/(3κ) in changes of
/// volume. In bending the strains across are −ν times the strain along, as without damping. The
/// result is infinite if the material has no stiffness against the deformation.
double viscous_time(DeformationKind kind, double viscosity, const LameParameters& lame);

/// ζ at the frequency f, Hz: a/(2ω) + βω/2 with ω = 2πf. Drag is not included.
double damping_ratio(DeformationKind kind, const Damping& damping, const LameParameters& lame,
                     double frequency);

}  // namespace tetraction
