// Makes materials from their names and parameters. The material classes state both.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {
namespace {

using Value = std::optional<double> MaterialSettings::*;

// The member of the settings that holds the value of a parameter.
constexpr std::pair<std::string_view, Value> kValues[] = {
    {"youngs_modulus", &MaterialSettings::youngs_modulus},
    {"poissons_ratio", &MaterialSettings::poissons_ratio},
    {"mu", &MaterialSettings::mu},
    {"lambda", &MaterialSettings::lambda},
    {"mu1", &MaterialSettings::mu1},
    {"mu2", &MaterialSettings::mu2},
    {"ratio", &MaterialSettings::ratio},
    {"c10", &MaterialSettings::c10},
    {"c20", &MaterialSettings::c20},
    {"c30", &MaterialSettings::c30},
    {"kappa", &MaterialSettings::kappa},
};

constexpr Value value_of(std::string_view name) {
  for (const auto& [known, value] : kValues) {
    if (known == name) return value;
  }
  return nullptr;
}

// A model with a parameter that has no member in the settings does not compile.
template <class M>
constexpr bool has_places() {
  const auto has_place = [](const MaterialParameter& p) { return value_of(p.name) != nullptr; };
  return std::ranges::all_of(M::kParameters, has_place) &&
         std::ranges::all_of(M::kBesideYoung, has_place);
}

// Calls body.operator()<M>() for every model that a scene can name.
template <class Body, class... M>
void for_each_model(const Body& body, const std::variant<M...>*) {
  static_assert((... && has_places<M>()));
  (body.template operator()<M>(), ...);
}
template <class Body>
void for_each_model(const Body& body) {
  for_each_model(body, static_cast<const IsotropicModel*>(nullptr));
}

// "a, b and c"
std::string list_of(const std::vector<MaterialParameter>& parameters) {
  std::string text;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (i > 0) text += i + 1 == parameters.size() ? " and " : ", ";
    text += parameters[i].name;
  }
  return text;
}

// Every parameter in `needed` must be given, and no other.
void require(const MaterialSettings& s, const std::vector<MaterialParameter>& needed,
             const std::vector<MaterialParameter>& instead) {
  const std::string wanted = list_of(needed) + ", or " + list_of(instead);
  for (const MaterialKey& key : material_keys()) {
    const char* name = key.parameter.name;
    const bool is_needed = std::ranges::any_of(
        needed, [&](const MaterialParameter& p) { return std::string_view(p.name) == name; });
    if (!is_needed && (s.*key.value).has_value()) {
      throw InputError(
          fmt::format("material.{} cannot be combined with the other parameters that are given: "
                      "the {} model takes {}, and nothing else.",
                      name, s.model, wanted));
    }
  }
  for (const MaterialParameter& p : needed) {
    if (!(s.*value_of(p.name)).has_value()) {
      throw InputError(
          fmt::format("material.{} is missing: the {} model needs {}.", p.name, s.model, wanted));
    }
  }
}

// make(values…) with the values of the parameters and, if there is a choice, the volumetric part.
template <class M, std::size_t kCount, class Make>
M made_of(const std::array<MaterialParameter, kCount>& parameters, const MaterialSettings& s,
          const Make& make) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    if constexpr (M::kHasVolumetricPart) {
      return make(*(s.*value_of(parameters[i].name))...,
                  s.volumetric.value_or(VolumetricPart::kLogarithmic));
    } else {
      return make(*(s.*value_of(parameters[i].name))...);
    }
  }
  (std::make_index_sequence<kCount>());
}

template <class M>
M make(const MaterialSettings& s) {
  const std::vector<MaterialParameter> own(M::kParameters.begin(), M::kParameters.end());
  std::vector<MaterialParameter> by_young{kYoungsModulus, kPoissonsRatio};
  by_young.insert(by_young.end(), M::kBesideYoung.begin(), M::kBesideYoung.end());
  if (!M::kHasVolumetricPart && s.volumetric) {
    throw InputError(
        fmt::format("material.volumetric has no meaning for the {} model, which has one volumetric "
                    "part only: leave it out.",
                    s.model));
  }
  if (!s.youngs_modulus && !s.poissons_ratio) {
    require(s, own, by_young);
    return made_of<M>(M::kParameters, s, [](auto... values) { return M(values...); });
  }
  require(s, by_young, own);
  const LameParameters lame = lame_from_young(*s.youngs_modulus, *s.poissons_ratio);
  return made_of<M>(M::kBesideYoung, s,
                    [&](auto... values) { return M::from_young(lame, values...); });
}

}  // namespace

const std::vector<MaterialKey>& material_keys() {
  static const std::vector<MaterialKey> keys = [] {
    std::vector<MaterialKey> all;
    const auto add = [&](const MaterialParameter& p) {
      const Value value = value_of(p.name);
      if (std::ranges::none_of(all, [&](const MaterialKey& key) { return key.value == value; })) {
        all.push_back({p, value});
      }
    };
    add(kYoungsModulus);
    add(kPoissonsRatio);
    for_each_model([&]<class M>() {
      for (const MaterialParameter& p : M::kParameters) add(p);
      for (const MaterialParameter& p : M::kBesideYoung) add(p);
    });
    return all;
  }();
  return keys;
}

const std::vector<MaterialChoice>& material_choices() {
  static const std::vector<MaterialChoice> choices = [] {
    std::vector<MaterialChoice> all;
    for_each_model([&]<class M>() {
      all.push_back({M::kName,
                     M::kTitle,
                     M::kHasVolumetricPart,
                     {M::kParameters.begin(), M::kParameters.end()},
                     {M::kBesideYoung.begin(), M::kBesideYoung.end()}});
    });
    return all;
  }();
  return choices;
}

const char* to_string(VolumetricPart part) {
  return part == VolumetricPart::kLogarithmic ? "log" : "quadratic";
}

MaterialModel make_material(const MaterialSettings& s) {
  if (s.custom) return *s.custom;
  std::optional<MaterialModel> made;
  std::string names;
  for_each_model([&]<class M>() {
    if (s.model == M::kName) made = make<M>(s);
    names += fmt::format("{}{}", names.empty() ? "" : ", ", M::kName);
  });
  if (!made) {
    throw InputError(
        fmt::format("material.model = \"{}\" is not a material; there are {}.", s.model, names));
  }
  return *made;
}

}  // namespace tetraction
