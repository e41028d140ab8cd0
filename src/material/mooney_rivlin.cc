#include <fmt/format.h>

#include "material_parameters.h"
#include "tetraction/core/error.h"
#include "tetraction/material/material.h"

namespace tetraction {

MooneyRivlin::MooneyRivlin(double mu1, double mu2, double lambda, VolumetricPart volumetric)
    : parameters_{mu1, mu2, lambda, volumetric} {
  if (!(mu1 >= 0.0) || !(mu2 >= 0.0)) {
    throw InputError(fmt::format(
        "mooney-rivlin: mu1 = {} Pa and mu2 = {} Pa must both be zero or positive.", mu1, mu2));
  }
  check_lame("mooney-rivlin (small strain: mu = mu1 + mu2, lambda + 2 mu2)", mu1 + mu2,
             lambda + 2.0 * mu2);
}

}  // namespace tetraction
