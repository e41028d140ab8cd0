// Makes materials from their names and parameters. The material classes state both.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/quoting.h"
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

const std::string* array_of(const MaterialSettings& s, const char* name) {
  const auto found = s.arrays.find(name);
  return found == s.arrays.end() ? nullptr : &found->second;
}

// Every parameter in `needed` must be given, and no other.
void require(const MaterialSettings& s, const std::vector<MaterialParameter>& needed,
             const std::vector<MaterialParameter>& instead) {
  const std::string wanted = list_of(needed) + ", or " + list_of(instead);
  for (const MaterialKey& key : material_keys()) {
    const char* name = key.parameter.name;
    const bool is_needed = std::ranges::any_of(
        needed, [&](const MaterialParameter& p) { return std::string_view(p.name) == name; });
    const bool has_number = (s.*key.value).has_value();
    const bool has_array = array_of(s, name) != nullptr;
    if (has_number && has_array) {
      throw InputError(
          fmt::format("material.{} has both a number and an array; give one of them.", name));
    }
    if (!is_needed && (has_number || has_array)) {
      throw InputError(
          fmt::format("material.{} cannot be combined with the other parameters that are given: "
                      "the {} model takes {}, and nothing else.",
                      name, s.model, wanted));
    }
    if (is_needed && !has_number && !has_array) {
      throw InputError(
          fmt::format("material.{} is missing: the {} model needs {}.", name, s.model, wanted));
    }
  }
}

bool is_given_by_young(const MaterialSettings& s) {
  return s.youngs_modulus || s.poissons_ratio || array_of(s, kYoungsModulus.name) != nullptr ||
         array_of(s, kPoissonsRatio.name) != nullptr;
}

// The settings must have the parameters that M needs.
template <class M>
void check(const MaterialSettings& s) {
  const std::vector<MaterialParameter> own(M::kParameters.begin(), M::kParameters.end());
  std::vector<MaterialParameter> by_young{kYoungsModulus, kPoissonsRatio};
  by_young.insert(by_young.end(), M::kBesideYoung.begin(), M::kBesideYoung.end());
  if (!M::kHasVolumetricPart && s.volumetric) {
    throw InputError(
        fmt::format("material.volumetric has no meaning for the {} model, which has one volumetric "
                    "part only: leave it out.",
                    s.model));
  }
  const bool is_by_young = is_given_by_young(s);
  require(s, is_by_young ? by_young : own, is_by_young ? own : by_young);
}

// make(values…) with the values of the parameters and, if there is a choice, the volumetric part.
template <class M, std::size_t kCount, class Number, class Make>
M made_of(const std::array<MaterialParameter, kCount>& parameters, const MaterialSettings& s,
          const Number& number, const Make& make) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    if constexpr (M::kHasVolumetricPart) {
      return make(number(parameters[i])..., s.volumetric.value_or(VolumetricPart::kLogarithmic));
    } else {
      return make(number(parameters[i])...);
    }
  }
  (std::make_index_sequence<kCount>());
}

// The material of settings that check() has accepted. number(parameter) returns the value of a
// parameter.
template <class M, class Number>
M make(const MaterialSettings& s, const Number& number) {
  if (!is_given_by_young(s)) {
    return made_of<M>(M::kParameters, s, number, [](auto... values) { return M(values...); });
  }
  const LameParameters lame = lame_from_young(number(kYoungsModulus), number(kPoissonsRatio));
  return made_of<M>(M::kBesideYoung, s, number,
                    [&](auto... values) { return M::from_young(lame, values...); });
}

// Returns body.operator()<M>() with the model of the settings.
template <class Body>
void with_model(const MaterialSettings& s, const Body& body) {
  bool found = false;
  std::string names;
  for_each_model([&]<class M>() {
    if (s.model == M::kName) {
      found = true;
      body.template operator()<M>();
    }
    names += fmt::format("{}{}", names.empty() ? "" : ", ", M::kName);
  });
  if (!found) {
    throw InputError(fmt::format("material.model = {} is not a material; there are {}.",
                                 in_quotes(s.model), names));
  }
}

// The parameters of the settings at single tetrahedra.
class ElementNumbers {
 public:
  ElementNumbers(const MaterialSettings& settings, const TetMesh& mesh)
      : settings_(settings), mesh_(mesh) {}

  // The value of an array at a tetrahedron.
  double operator()(const std::string& array, const MaterialParameter& parameter, Index e) const {
    const auto found = mesh_.cell_arrays.find(array);
    if (found == mesh_.cell_arrays.end()) {
      std::vector<std::string_view> names;
      for (const auto& [name, values] : mesh_.cell_arrays) names.push_back(name);
      throw InputError(
          fmt::format("material.{}: the mesh {}has no cell array {}; {}.", parameter.name,
                      mesh_name(), in_quotes(array),
                      names.empty() ? "it has none at all (VTU, VTK and Gmsh files can hold them)"
                                    : "it has " + quoted_list(names)));
    }
    const Matrix& values = found->second;
    if (values.rows() != 1) {
      throw InputError(fmt::format(
          "material.{}: the cell array {} has {} numbers for each tetrahedron, not one.",
          parameter.name, in_quotes(array), values.rows()));
    }
    if (values.cols() != mesh_.tetrahedron_count()) {
      throw InputError(fmt::format(
          "material.{}: the cell array {} has {} numbers, but the mesh has {} tetrahedra.",
          parameter.name, in_quotes(array), values.cols(), mesh_.tetrahedron_count()));
    }
    const double value = values(0, e);
    if (std::isnan(value)) {
      throw InputError(fmt::format(
          "material.{}: the cell array {} {}has no value at tetrahedron {} (the file gives none or "
          "NaN); it must have one at each.",
          parameter.name, in_quotes(array), of_mesh(), mesh_.tetrahedron_id(e)));
    }
    const std::string refusal = parameter.range.refusal(value);
    if (!refusal.empty()) {
      throw InputError(fmt::format(
          "material.{}: the cell array {} {}has the value {} at "
          "tetrahedron {}{}",
          parameter.name, in_quotes(array), of_mesh(), value, mesh_.tetrahedron_id(e), refusal));
    }
    return value;
  }

  // The value of a parameter at a tetrahedron.
  double operator()(const MaterialParameter& parameter, Index e) const {
    const std::string* array = array_of(settings_, parameter.name);
    if (array == nullptr) return *(settings_.*value_of(parameter.name));
    return (*this)(*array, parameter, e);
  }

 private:
  std::string mesh_name() const { return mesh_.source.empty() ? "" : mesh_.source + " "; }
  std::string of_mesh() const { return mesh_.source.empty() ? "" : "of " + mesh_.source + " "; }

  const MaterialSettings& settings_;
  const TetMesh& mesh_;
};

// A message about the material of a tetrahedron with its place in the scene. If the message begins
// with a key, it names the tetrahedron itself.
std::string placed(const MaterialSettings& s, const TetMesh& mesh, Index e,
                   const std::string& message) {
  const std::string own = "material";
  const std::string where = s.where.empty() ? own : s.where;
  if (message.starts_with(own + ".")) return where + message.substr(own.size());
  return fmt::format("{}: tetrahedron {}: {}", where, mesh.tetrahedron_id(e), message);
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
                     {M::kBesideYoung.begin(), M::kBesideYoung.end()},
                     M::kDefinedForAnyJacobian});
    });
    return all;
  }();
  return choices;
}

const char* to_string(VolumetricPart part) {
  return part == VolumetricPart::kLogarithmic ? "log" : "quadratic";
}

void check_material(const MaterialSettings& s) {
  if (s.arrays.empty()) {
    make_material(s);
    return;
  }
  for (const auto& [name, array] : s.arrays) {
    if (name == kDensity.name || value_of(name) != nullptr) continue;
    throw InputError(fmt::format("material.{} cannot be an array.", name));
  }
  if (!s.custom) with_model(s, [&]<class M>() { check<M>(s); });
}

MaterialModel make_material(const MaterialSettings& s) {
  if (s.custom) return *s.custom;
  std::optional<MaterialModel> made;
  with_model(s, [&]<class M>() {
    check<M>(s);
    made = make<M>(s, [&](const MaterialParameter& parameter) {
      if (array_of(s, parameter.name) != nullptr) {
        throw InputError(fmt::format(
            "material.{} is an array, which has no meaning without a mesh.", parameter.name));
      }
      return *(s.*value_of(parameter.name));
    });
  });
  return *made;
}

MaterialField make_material(const MaterialSettings& s, const TetMesh& mesh,
                            const std::vector<Index>& elements) {
  check_material(s);
  const bool varies =
      std::ranges::any_of(s.arrays, [](const auto& entry) { return entry.first != kDensity.name; });
  if (s.custom || !varies) return make_material(s);
  std::optional<MaterialField> made;
  with_model(s, [&]<class M>() {
    const ElementNumbers numbers(s, mesh);
    const auto model_of = [&](Index e) -> IsotropicModel {
      try {
        return make<M>(s, [&](const MaterialParameter& p) { return numbers(p, e); });
      } catch (const InputError& error) {
        throw InputError(placed(s, mesh, e, error.what()));
      }
    };
    // Elements of other regions get the material of one that belongs to this region.
    const Index first = elements.empty() ? 0 : elements.front();
    std::vector<IsotropicModel> models(mesh.tetrahedra.size(), model_of(first));
    for (const Index e : elements) models[static_cast<std::size_t>(e)] = model_of(e);
    made = MaterialField(models);
  });
  return *made;
}

std::vector<double> make_densities(const MaterialSettings& s, const TetMesh& mesh,
                                   const std::vector<Index>& elements) {
  const std::string* array = array_of(s, kDensity.name);
  if (array == nullptr) return {};
  const ElementNumbers numbers(s, mesh);
  std::vector<double> densities(mesh.tetrahedra.size(), 0.0);
  for (const Index e : elements) {
    try {
      densities[static_cast<std::size_t>(e)] = numbers(*array, kDensity, e);
    } catch (const InputError& error) {
      throw InputError(placed(s, mesh, e, error.what()));
    }
  }
  return densities;
}

}  // namespace tetraction
