#include "material_parameters.h"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>

#include "tetraction/core/error.h"
#include "tetraction/material/material.h"

namespace tetraction {

void check_lame(const char* material, double mu, double lambda) {
  if (!std::isfinite(mu) || !(mu > 0.0)) {
    throw InputError(fmt::format("{}: mu = {} Pa must be positive and finite.", material, mu));
  }
  if (!std::isfinite(lambda) || !(lambda > -2.0 * mu / 3.0)) {
    throw InputError(fmt::format(
        "{}: lambda = {} Pa must be finite and above -2 mu/3 = {} Pa, or the material has no "
        "resistance to a change of volume.",
        material, lambda, -2.0 * mu / 3.0));
  }
}

const char* to_string(VolumetricPart part) {
  return part == VolumetricPart::kLogarithmic ? "log" : "quadratic";
}

std::vector<MaterialModel> materials_like(const LameParameters& lame) {
  std::vector<MaterialModel> models;
  for_each_model([&]<class M>() { models.push_back(M::like(lame)); });
  return models;
}

std::string material_name(const MaterialModel& material) {
  return std::visit(
      [](const auto& m) -> std::string {
        if constexpr (std::is_same_v<decltype(m), const CustomMaterial&>) {
          return m.name();
        } else {
          return m.kName;
        }
      },
      material);
}

LameParameters initial_lame(const MaterialModel& material) {
  return std::visit([](const auto& m) { return m.initial_lame(); }, material);
}

LameParameters lame_from_young(double youngs_modulus, double poissons_ratio) {
  if (!std::isfinite(youngs_modulus) || !(youngs_modulus > 0.0)) {
    throw InputError(
        fmt::format("youngs_modulus = {} Pa must be positive and finite.", youngs_modulus));
  }
  if (!(poissons_ratio > -1.0 && poissons_ratio < 0.5)) {
    throw InputError(fmt::format(
        "poissons_ratio = {} must lie between -1 and 0.5, both excluded: at 0.5 the material is "
        "incompressible and lambda infinite. Take 0.49 to 0.4999 with quadratic elements or nodal "
        "volumes for rubber-like materials.",
        poissons_ratio));
  }
  const double nu = poissons_ratio;
  return {youngs_modulus / (2.0 * (1.0 + nu)),
          youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))};
}

MooneyRivlin mooney_rivlin_from_young(double youngs_modulus, double poissons_ratio, double ratio) {
  return MooneyRivlin::from_young(lame_from_young(youngs_modulus, poissons_ratio), ratio);
}

double wave_speed(const LameParameters& lame, double density) {
  return std::sqrt((lame.lambda + 2.0 * lame.mu) / density);
}

}  // namespace tetraction
