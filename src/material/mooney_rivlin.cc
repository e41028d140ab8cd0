#include <fmt/format.h>

#include <cmath>

#include "material_parameters.h"
#include "tetraction/core/error.h"
#include "tetraction/material/material.h"
#include "volumetric_instability.h"

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

MooneyRivlin MooneyRivlin::from_young(const LameParameters& lame, double ratio,
                                      VolumetricPart volumetric) {
  if (!std::isfinite(ratio) || !(ratio >= 0.0)) {
    throw InputError(fmt::format("ratio = mu2/mu1 = {} must be zero or positive.", ratio));
  }
  const double mu1 = lame.mu / (1.0 + ratio);
  const double mu2 = lame.mu - mu1;
  return {mu1, mu2, lame.lambda - 2.0 * mu2, volumetric};
}

MooneyRivlin MooneyRivlin::like(const LameParameters& lame) {
  constexpr double kRatio = 0.25;
  const double mu2 = lame.mu * kRatio / (1.0 + kRatio);
  return {lame.mu - mu2, mu2, lame.lambda - 2.0 * mu2};
}

std::string MooneyRivlin::instability() const {
  return volumetric_instability(kName, {mu1(), mu2(), lambda(), volumetric()});
}

}  // namespace tetraction
