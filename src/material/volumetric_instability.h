// Materials whose volumetric part has a negative λ.
#pragma once

#include <string>

#include "tetraction/material/volumetric_law.h"

namespace tetraction {

/// Ψ = μ₁/2 (I₁ − 3 − 2 ln J) + μ₂/2 (I₂ − 3 − 4 ln J) + U(J), with U as in VolumetricPart.
struct LawWithVolumetricPart {
  double mu1;
  double mu2;
  double lambda;
  VolumetricPart part;
};

/// A warning if λ < 0. Ψ then has no lower bound: for large J with VolumetricPart::kQuadratic, for small J with
/// kLogarithmic. The warning names the stretch of F = s I at which Ψ is largest. Empty if that does not lie
/// between 0.5 and 10.
std::string volumetric_instability(const char* model, const LawWithVolumetricPart& law);

}  // namespace tetraction
