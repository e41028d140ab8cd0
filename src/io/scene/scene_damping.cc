// [damping]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene_sections.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Largest difference of the shear moduli of a body with `ratio`, relative.
constexpr double kSameModulus = 0.01;

// Whether an array gives a modulus. Then the material cannot be made without the mesh.
bool gives_array(const MaterialSettings& material) {
  return std::ranges::any_of(material.arrays,
                             [](const auto& entry) { return entry.first != kDensity.name; });
}

}  // namespace

void read_damping_ratio(const TomlTable& table, Scene& scene) {
  if (!table.has("ratio")) return;
  for (const char* key : {"mass_damping", "viscosity"}) {
    if (!table.has(key)) continue;
    table.refuse(table.is_override("ratio") ? "ratio" : key,
                 one_key_too_many("damping.ratio", fmt::format("damping.{}", key),
                                  ", and the ratios determine it"));
  }
  DampingRatio ratio;
  read_settings(table.table("ratio", table_keys(section_of<DampingRatio>())), ratio);
  const auto refuse_array = [&](const MaterialSettings& material) {
    if (!gives_array(material)) return;
    table.refuse("ratio",
                 "cannot be had: an array gives moduli, and one viscosity damps different moduli "
                 "differently. Give mass_damping and viscosity instead.");
  };
  refuse_array(scene.material);
  const LameParameters lame = initial_lame(make_material(scene.material));
  for (const MaterialRegionSettings& region : scene.material_region) {
    refuse_array(region.material);
    const double mu = initial_lame(make_material(region.material)).mu;
    if (std::abs(mu - lame.mu) <= kSameModulus * lame.mu) continue;
    table.refuse("ratio",
                 fmt::format("cannot be had: the shear moduli of [material] and of a "
                             "[[material_region]] differ ({:.6g} and {:.6g} Pa), and one viscosity "
                             "damps them differently. Give mass_damping and viscosity instead.",
                             lame.mu, mu));
  }
  try {
    const Damping numbers = rayleigh_damping(ratio, lame);
    scene.damping.mass_damping = numbers.mass_damping;
    scene.damping.viscosity = numbers.viscosity;
  } catch (const InputError& error) {
    table.refuse("ratio", error.what());
  }
  scene.damping_ratio = ratio;
}

}  // namespace tetraction
