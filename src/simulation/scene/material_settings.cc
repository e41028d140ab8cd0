#include "tetraction/simulation/material_settings.h"
// Makes materials from their names and parameters. The material classes state both.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/quoting.h"
#include "material/parameter_sets.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// "a, b and c"
std::string list_of(const std::vector<MaterialParameter>& parameters) {
  std::string text;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (i > 0) text += i + 1 == parameters.size() ? " and " : ", ";
    text += parameters[i].name;
  }
  return text;
}

const std::string* array_of(const MaterialSettings& s, const std::string& name) {
  const auto found = s.arrays.find(name);
  return found == s.arrays.end() ? nullptr : &found->second;
}
// Also if an array gives the parameter at the same time.
bool has_number_for(const MaterialSettings& s, const std::string& name) {
  if (name == kYoungsModulus.name) return s.youngs_modulus.has_value();
  if (name == kPoissonsRatio.name) return s.poissons_ratio.has_value();
  return s.numbers.contains(name);
}
bool is_given(const MaterialSettings& s, const std::string& name) {
  return number_of(s, name) || array_of(s, name) != nullptr;
}
// The number of entries of a parameter that is a list.
int entry_count(const MaterialSettings& s, const MaterialParameter& list) {
  int count = 0;
  while (count < list.most_entries && is_given(s, entry_of(list, count).name)) ++count;
  return count;
}

// The names of all numbers and arrays of the settings that are parameters of a model.
std::vector<std::string> given_parameters(const MaterialSettings& s) {
  std::vector<std::string> names;
  for (const MaterialParameter& p : {kYoungsModulus, kPoissonsRatio}) {
    if (has_number_for(s, p.name)) names.emplace_back(p.name);
  }
  for (const auto& [name, number] : s.numbers) names.push_back(name);
  for (const auto& [name, array] : s.arrays) {
    if (name != kDensity.name) names.push_back(name);
  }
  return names;
}

// The place of a parameter in the documents, by which messages name the first one that is wrong.
std::size_t place_of(const std::string& name) {
  const std::vector<MaterialParameter>& all = material_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (name == all[i].name) return i;
  }
  return all.size();
}

// Every parameter in `needed` must be given, and no other.
void require(const MaterialSettings& s, const std::vector<MaterialParameter>& needed,
             const std::vector<MaterialParameter>& instead) {
  const std::string wanted = list_of(needed) + ", or " + list_of(instead);
  std::vector<std::string> names = given_parameters(s);
  for (const MaterialParameter& p : needed) {
    const bool there = is_list(p) ? entry_count(s, p) > 0 : is_given(s, p.name);
    if (!there) names.emplace_back(p.name);
  }
  std::ranges::stable_sort(names, {}, place_of);
  for (const std::string& name : names) {
    const bool has_number = has_number_for(s, name);
    const bool has_array = array_of(s, name) != nullptr;
    if (has_number && has_array) {
      throw InputError(
          fmt::format("material.{} has both a number and an array; give one of them.", name));
    }
    const auto list_names = [&](const MaterialParameter& p) {
      return is_list(p) && name.starts_with(std::string(p.name) + ".");
    };
    const auto names_it = [&](const MaterialParameter& p) { return name == p.name; };
    const bool is_entry = std::ranges::any_of(needed, list_names);
    const auto whole = std::ranges::find_if(needed, names_it);
    const bool is_needed = is_entry || whole != needed.end();
    const bool is_there = has_number || has_array;
    if (whole != needed.end() && is_list(*whole) && is_there) {
      throw InputError(
          fmt::format("material.{} must be a list of 1 to {} entries: the {} model needs {}.", name,
                      whole->most_entries, s.model, wanted));
    }
    if (!is_needed) {
      throw InputError(
          fmt::format("material.{} cannot be combined with the other parameters that are given: "
                      "the {} model takes {}, and nothing else.",
                      name, s.model, wanted));
    }
    if (!is_there) {
      throw InputError(
          fmt::format("material.{} is missing: the {} model needs {}.", name, s.model, wanted));
    }
  }
  for (const MaterialParameter& list : needed) {
    if (!is_list(list)) continue;
    const int count = entry_count(s, list);
    const auto is_behind = [&](const std::string& name) {
      const std::string start = std::string(list.name) + ".";
      if (!name.starts_with(start)) return false;
      for (int i = 0; i < count; ++i) {
        if (name == entry_of(list, i).name) return false;
      }
      return true;
    };
    for (const std::string& name : names) {
      if (!is_behind(name)) continue;
      throw InputError(fmt::format(
          "material.{}: {} has {} entries without it, and 1 to {} are allowed without a gap.", name,
          list.name, count, list.most_entries));
    }
  }
}

bool is_given_by_young(const MaterialSettings& s) {
  return is_given(s, kYoungsModulus.name) || is_given(s, kPoissonsRatio.name);
}

// The settings must have the parameters that M needs.
template <class M>
void check(const MaterialSettings& s) {
  const std::vector<MaterialParameter> own(M::kParameters.begin(), M::kParameters.end());
  const std::vector<MaterialParameter> instead = instead_of_own<M>();
  if (!M::kHasVolumetricPart && s.volumetric) {
    throw InputError(
        fmt::format("material.volumetric has no meaning for the {} model, which has one volumetric "
                    "part only: leave it out.",
                    s.model));
  }
  const bool is_by_young = is_given_by_young(s);
  require(s, is_by_young ? instead : own, is_by_young ? own : instead);
}

// The value of a parameter, or the values of the entries of a list. number(parameter) returns one of them.
template <bool kIsList, class Number>
auto value_of(const MaterialParameter& parameter, const MaterialSettings& s, const Number& number) {
  if constexpr (kIsList) {
    std::vector<double> values;
    for (int i = 0; i < entry_count(s, parameter); ++i)
      values.push_back(number(entry_of(parameter, i)));
    return values;
  } else {
    return number(parameter);
  }
}

// make(values…) with the values of the parameters and, if there is a choice, the volumetric part.
template <class M, const auto& kParameters, class Number, class Make>
M made_of(const MaterialSettings& s, const Number& number, const Make& make) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    if constexpr (M::kHasVolumetricPart) {
      return make(value_of<is_list(kParameters[i])>(kParameters[i], s, number)...,
                  s.volumetric.value_or(VolumetricPart::kLogarithmic));
    } else {
      return make(value_of<is_list(kParameters[i])>(kParameters[i], s, number)...);
    }
  }
  (std::make_index_sequence<kParameters.size()>());
}

// The material of settings that check() has accepted. number(parameter) returns the value of a
// parameter.
template <class M, class Number>
M make(const MaterialSettings& s, const Number& number) {
  if (!is_given_by_young(s)) {
    return made_of<M, M::kParameters>(s, number, [](auto... values) { return M(values...); });
  }
  if constexpr (kTakesYoung<M>) {
    const LameParameters lame = lame_from_young(number(kYoungsModulus), number(kPoissonsRatio));
    return made_of<M, M::kBesideYoung>(
        s, number, [&](auto... values) { return M::from_young(lame, values...); });
  } else {
    return made_of<M, M::kInstead>(s, number, [](auto... values) { return M::instead(values...); });
  }
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

// Whether the name is that of a parameter of some model, or of an entry of a list.
bool is_parameter(const std::string& name) {
  return std::ranges::any_of(material_parameters(), [&](const MaterialParameter& p) {
    if (!is_list(p)) return name == p.name;
    for (int i = 0; i < p.most_entries; ++i) {
      if (name == entry_of(p, i).name) return true;
    }
    return false;
  });
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
      throw InputError(
          fmt::format("material.{}: the cell array {} {}has no value at tetrahedron {} (the file "
                      "gives none or NaN); it must have one at each.",
                      parameter.name, in_quotes(array), of_mesh(), mesh_.tetrahedron_id(e)));
    }
    const std::string refusal = parameter.range.refusal(value);
    if (!refusal.empty()) {
      throw InputError(fmt::format(
          "material.{}: the cell array {} {}has the value {} at tetrahedron {}{}", parameter.name,
          in_quotes(array), of_mesh(), value, mesh_.tetrahedron_id(e), refusal));
    }
    return value;
  }

  // The value of a parameter at a tetrahedron.
  double operator()(const MaterialParameter& parameter, Index e) const {
    const std::string* array = array_of(settings_, parameter.name);
    if (array == nullptr) return *number_of(settings_, parameter.name);
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

void check_material(const MaterialSettings& s) {
  if (s.arrays.empty()) {
    make_material(s);
    return;
  }
  for (const auto& [name, array] : s.arrays) {
    if (name == kDensity.name || is_parameter(name)) continue;
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
      return *number_of(s, parameter.name);
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
