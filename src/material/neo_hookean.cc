#include "material_parameters.h"
#include "tetraction/material/material.h"
#include "volumetric_instability.h"

namespace tetraction {

NeoHookean::NeoHookean(double mu, double lambda, VolumetricPart volumetric)
    : parameters_{mu, lambda, volumetric} {
  check_lame(kName, mu, lambda);
}

std::string NeoHookean::instability() const {
  return volumetric_instability(kName, {mu(), 0.0, lambda(), volumetric()});
}

}  // namespace tetraction
