#include "material_parameters.h"
#include "tetraction/material/material.h"

namespace tetraction {

NeoHookean::NeoHookean(double mu, double lambda, VolumetricPart volumetric)
    : parameters_{mu, lambda, volumetric} {
  check_lame(kName, mu, lambda);
}

}  // namespace tetraction
