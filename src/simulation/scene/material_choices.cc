#include "tetraction/simulation/material_settings.h"
// The models that a scene can name, and their parameters.
#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <string_view>

#include "material/parameter_sets.h"

namespace tetraction {
namespace {

// The number of terms of a law whose parameters are lists.
template <class M>
int term_count(const M& material) {
  if constexpr (requires { material.term_count(); }) {
    return material.term_count();
  } else {
    return 0;
  }
}

template <class M>
void set_like(MaterialSettings& s, const LameParameters& lame) {
  const M material = M::like(lame);
  const auto values = material.parameter_values();
  s.youngs_modulus.reset();
  s.poissons_ratio.reset();
  s.numbers.clear();
  std::size_t next = 0;
  for (const MaterialParameter& p : M::kParameters) {
    if (!is_list(p)) s.numbers[p.name] = values[next++];
    for (int i = 0; i < p.most_entries; ++i, ++next) {
      if (i < term_count(material)) s.numbers[entry_of(p, i).name] = values[next];
    }
  }
}

}  // namespace

const std::vector<MaterialParameter>& material_parameters() {
  static const std::vector<MaterialParameter> parameters = [] {
    std::vector<MaterialParameter> all;
    const auto add = [&](const MaterialParameter& p) {
      const auto is_same = [&](const MaterialParameter& other) {
        return std::string_view(other.name) == p.name && is_list(other) == is_list(p);
      };
      if (std::ranges::none_of(all, is_same)) all.push_back(p);
    };
    add(kYoungsModulus);
    add(kPoissonsRatio);
    for_each_model([&]<class M>() {
      for (const MaterialParameter& p : M::kParameters) add(p);
      for (const MaterialParameter& p : instead_of_own<M>()) add(p);
    });
    return all;
  }();
  return parameters;
}

MaterialParameter entry_of(const MaterialParameter& parameter, int i) {
  MaterialParameter entry = parameter;
  entry.most_entries = 0;
  // The names of entries live as long as the program.
  static std::mutex mutex;
  static std::set<std::string> names;
  const std::lock_guard<std::mutex> lock(mutex);
  entry.name = names.insert(fmt::format("{}.{}", parameter.name, i)).first->c_str();
  return entry;
}

std::optional<double> number_of(const MaterialSettings& s, const std::string& parameter) {
  if (s.arrays.contains(parameter)) return std::nullopt;
  if (parameter == kYoungsModulus.name) return s.youngs_modulus;
  if (parameter == kPoissonsRatio.name) return s.poissons_ratio;
  const auto found = s.numbers.find(parameter);
  return found == s.numbers.end() ? std::nullopt : std::optional(found->second);
}

void set_number(MaterialSettings& s, const std::string& parameter, double value) {
  if (parameter == kYoungsModulus.name) {
    s.youngs_modulus = value;
  } else if (parameter == kPoissonsRatio.name) {
    s.poissons_ratio = value;
  } else {
    s.numbers[parameter] = value;
  }
}

const std::vector<MaterialChoice>& material_choices() {
  static const std::vector<MaterialChoice> choices = [] {
    std::vector<MaterialChoice> all;
    for_each_model([&]<class M>() {
      MaterialChoice choice{M::kName,
                            M::kTitle,
                            M::kHasVolumetricPart,
                            {M::kParameters.begin(), M::kParameters.end()},
                            instead_of_own<M>(),
                            {},
                            M::kDefinedForAnyJacobian,
                            set_like<M>};
      if constexpr (kTakesYoung<M>) {
        choice.beside_young = {M::kBesideYoung.begin(), M::kBesideYoung.end()};
      }
      all.push_back(choice);
    });
    return all;
  }();
  return choices;
}

const MaterialChoice* find_material(const std::string& name) {
  const std::vector<MaterialChoice>& choices = material_choices();
  const auto found = std::ranges::find_if(
      choices, [&](const MaterialChoice& choice) { return choice.name == name; });
  return found == choices.end() ? nullptr : &*found;
}

}  // namespace tetraction
