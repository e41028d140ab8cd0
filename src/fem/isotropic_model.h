// Tells whether the fast element loops can process a material.
#pragma once

#include <concepts>
#include <optional>
#include <variant>

#include "tetraction/material/material.h"

namespace tetraction {

/// The material, or no value if it is a CustomMaterial.
inline std::optional<IsotropicModel> isotropic_model(const MaterialModel& material) {
  return std::visit(
      []<class M>(const M& m) -> std::optional<IsotropicModel> {
        if constexpr (std::same_as<M, CustomMaterial>) {
          return std::nullopt;
        } else {
          return m;
        }
      },
      material);
}

}  // namespace tetraction
