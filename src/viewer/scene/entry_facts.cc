#include "entry_facts.h"

#include <fmt/format.h>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

std::string range_text(double least, double most, const char* unit) {
  const std::string end = with_unit(most, unit);
  if (least == most) return end;
  return fmt::format("{:.4g} to {}", display_unit(unit).from_si(least), end);
}

double youngs_modulus(const LameParameters& lame) {
  return lame.mu * (3.0 * lame.lambda + 2.0 * lame.mu) / (lame.lambda + lame.mu);
}
double poissons_ratio(const LameParameters& lame) {
  return lame.lambda / (2.0 * (lame.lambda + lame.mu));
}

}  // namespace

bool is_material(const EntryPlace& place, std::size_t& region) {
  const SceneSection& section = section_of_entries(place.section);
  const bool is_region = section.type == typeid(MaterialRegionSettings);
  region = is_region ? place.index + 1 : 0;
  return is_region || section.type == typeid(MaterialSettings);
}

Facts facts_of(const EntryPlace& place, const Settings& settings) {
  std::size_t region = 0;
  if (!is_material(place, region) || region >= settings.materials.size()) return {};
  const LameParameters& least = settings.moduli[region].least;
  const LameParameters& most = settings.moduli[region].most;
  const MaterialSettings& material = settings.materials[region];
  Facts facts{{"μ", range_text(least.mu, most.mu, "Pa")},
              {"λ", range_text(least.lambda, most.lambda, "Pa")},
              {"E", range_text(youngs_modulus(least), youngs_modulus(most), "Pa")},
              {"ν", range_text(poissons_ratio(least), poissons_ratio(most), "")}};
  if (material.arrays.empty()) {
    facts.emplace_back("Wave speed", with_unit(wave_speed(least, material.density), "m/s"));
  }
  return facts;
}

}  // namespace tetraction::viewer
