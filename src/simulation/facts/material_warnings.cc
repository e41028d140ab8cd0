// Warnings about materials that are valid but may mislead.
#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <limits>
#include <string>
#include <variant>

#include "tetraction/simulation/warnings.h"

namespace tetraction {
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
      warning = std::visit(
          []<class M>(const M& m) -> std::string {
            if constexpr (std::same_as<M, CustomMaterial>) {
              return {};
            } else {
              return m.instability();
            }
          },
          material.at(e));
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
