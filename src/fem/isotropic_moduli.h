// What the fast kernels need of a material.
#pragma once

#include <optional>

#include "kernels/element_kernels.h"
#include "tetraction/material/material.h"

namespace tetraction {

/// The moduli, if the material is one of the kernels' kinds.
inline std::optional<IsotropicModuli> isotropic_moduli(const MaterialModel& material) {
  if (const auto* m = std::get_if<NeoHookean>(&material)) {
    return IsotropicModuli{MaterialKind::kNeoHookean, m->mu(), 0.0, m->lambda()};
  }
  if (const auto* m = std::get_if<MooneyRivlin>(&material)) {
    return IsotropicModuli{MaterialKind::kMooneyRivlin, m->mu1(), m->mu2(), m->lambda()};
  }
  if (const auto* m = std::get_if<StVenantKirchhoff>(&material)) {
    return IsotropicModuli{MaterialKind::kStVenantKirchhoff, m->mu(), 0.0, m->lambda()};
  }
  return std::nullopt;
}

}  // namespace tetraction
