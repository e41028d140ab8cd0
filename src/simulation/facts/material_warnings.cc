// Warnings about materials that are valid but may mislead.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// No body is meant to be stretched beyond these in all directions.
constexpr double kLargestStretch = 10.0;
constexpr double kSmallestStretch = 0.5;

// The stretch s ≥ 1 of incompressible uniaxial tension with s² + 2/s − 3 = x: the largest root of
// s³ − (3 + x) s + 2 = 0.
double uniaxial_stretch(double x) {
  const double third = 1.0 + x / 3.0;
  return 2.0 * std::sqrt(third) * std::cos(std::acos(-std::pow(third, -1.5)) / 3.0);
}

// Ψ = μ₁/2 (I₁ − 3 − 2 ln J) + μ₂/2 (I₂ − 3 − 4 ln J) + U(J), with U as in VolumetricPart.
struct LawWithVolumetricPart {
  double mu1;
  double mu2;
  double lambda;
  VolumetricPart part;

  bool is_logarithmic() const { return part == VolumetricPart::kLogarithmic; }

  // ⅓ dΨ/ds at F = s I.
  double slope(double s) const {
    const double cube = s * s * s;
    const double volumetric = is_logarithmic() ? 3.0 * std::log(s) / s : s * s * (cube - 1.0);
    return mu1 * (s - 1.0 / s) + 2.0 * mu2 * (cube - 1.0 / s) + lambda * volumetric;
  }
};

// The s at which Ψ(s I) is largest if λ < 0: above 1 for the quadratic part, below 1 for the
// logarithmic one. Nothing if there is none up to the limits above.
std::optional<double> largest_energy(const LawWithVolumetricPart& law) {
  const auto rises = [&](double s) { return law.slope(s) * (s - 1.0) > 0.0; };
  double stable = 1.0;
  double unstable = law.is_logarithmic() ? kSmallestStretch : kLargestStretch;
  if (!(law.lambda < 0.0) || rises(unstable)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(stable * unstable);
    (rises(middle) ? stable : unstable) = middle;
  }
  return stable;
}

std::string volumetric_warning(const char* model, const LawWithVolumetricPart& law) {
  const std::optional<double> stretch = largest_energy(law);
  if (!stretch) return {};
  LawWithVolumetricPart other = law;
  other.part = law.is_logarithmic() ? VolumetricPart::kQuadratic : VolumetricPart::kLogarithmic;
  return fmt::format(
      "the {} material has a negative lambda = {:.4g} Pa and volumetric = \"{}\": its energy has "
      "no "
      "lower bound. A part of the body that is {} {:.3g} times its size in all directions {}. Take "
      "{}parameters with lambda >= 0, such as a larger Poisson's ratio.",
      model, law.lambda, to_string(law.part),
      law.is_logarithmic() ? "compressed below" : "stretched beyond", *stretch,
      law.is_logarithmic() ? "collapses" : "expands without end",
      largest_energy(other) ? "" : fmt::format("volumetric = \"{}\", or ", to_string(other.part)));
}

struct InstabilityWarning {
  std::string operator()(const Yeoh& m) const {
    const double x = m.unstable_from();
    if (!std::isfinite(x)) return {};
    return fmt::format(
        "the yeoh material with c10 = {:.4g}, c20 = {:.4g} and c30 = {:.4g} Pa is unstable: at a "
        "stretch of {:.3g} in uniaxial tension its stress has fallen to zero (c10 + 2 c20 x + 3 "
        "c30 x^2 = 0 with x = I1bar - 3 = {:.3g}), and further strain sets energy free. Keep the "
        "strains well below that, or take parameters that are stable everywhere: c20 and c30 of 0 "
        "or more, or c20^2 < 3 c10 c30.",
        m.c10(), m.c20(), m.c30(), uniaxial_stretch(x), x);
  }
  std::string operator()(const NeoHookean& m) const {
    return volumetric_warning(m.kName, {m.mu(), 0.0, m.lambda(), m.volumetric()});
  }
  std::string operator()(const MooneyRivlin& m) const {
    return volumetric_warning(m.kName, {m.mu1(), m.mu2(), m.lambda(), m.volumetric()});
  }
  std::string operator()(const StVenantKirchhoff&) const { return {}; }  // Ψ ≥ 0 for every E
  std::string operator()(const CustomMaterial&) const { return {}; }
};

}  // namespace

std::string locking_warning(const MechanicalSystem& system) {
  if (system.nodal_volume() != nullptr || system.rest().is_quadratic()) return {};
  double largest = 0.0;
  for (const MaterialField& material : system.materials()) {
    largest = std::max(largest, material.lame_range().most_ratio);
  }
  largest = largest_of_parts(system.part(), largest);
  if (largest < kLockingRatio - 1e-9) return {};
  return fmt::format(
      "a Poisson's ratio of {:.5g} is nearly incompressible, and linear tetrahedra lock: the body "
      "is too stiff, by several times near 0.5, and stresses are wrong. Take mesh.element = "
      "\"quadratic\" or mesh.volume = \"nodal\", or a ratio below {} where the exact change of "
      "volume does not matter, or refine the mesh until results no longer change.",
      largest, kLockingRatio);
}

std::string instability_warning(const MechanicalSystem& system) {
  for (const MaterialField& material : system.materials()) {
    const Index count = material.varies() ? material.parameters().cols() : 1;
    std::string warning;
    Index e = 0;
    for (; e < count; ++e) {
      warning = std::visit(InstabilityWarning(), material.at(e));
      if (!warning.empty()) break;
    }
    // That of the element with the least number, also among the parts of a body.
    const double id = warning.empty() ? std::numeric_limits<double>::infinity()
                                      : static_cast<double>(system.mesh().tetrahedron_id(e));
    const bool is_first = id == least_of_parts(system.part(), id) && !warning.empty();
    if (take_from_first(system.part(), is_first, warning)) return warning;
  }
  return {};
}

}  // namespace tetraction
