// [material] and [[material_region]]. The parameters are those that the material classes state.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "number_or_array.h"
#include "sections.h"

namespace tetraction {
namespace {

bool has_volumetric_part(const MaterialSettings& material) {
  const MaterialChoice* choice = find_material(material.model);
  return choice != nullptr && choice->has_volumetric_part;
}

// The member of the settings that holds the value of a parameter.
NumberOrArray<MaterialSettings>::Member member_of(std::string_view parameter) {
  if (parameter == kYoungsModulus.name) return &MaterialSettings::youngs_modulus;
  if (parameter == kPoissonsRatio.name) return &MaterialSettings::poissons_ratio;
  return &MaterialSettings::numbers;
}

// The meaning of a parameter with the models that have it.
std::string help_of(const MaterialParameter& parameter) {
  std::vector<std::string> models;
  for (const MaterialChoice& choice : material_choices()) {
    for (const auto* parameters : {&choice.parameters, &choice.instead}) {
      for (const MaterialParameter& own : *parameters) {
        const std::string model = fmt::format("`{}`", choice.name);
        if (std::string_view(own.name) != parameter.name) continue;
        if (own.most_entries != parameter.most_entries) continue;
        if (models.empty() || models.back() != model) models.push_back(model);
      }
    }
  }
  std::string text = parameter.help;
  // Young's modulus and Poisson's ratio are those of nearly all models.
  if (member_of(parameter.name).index() == 1) return text;
  for (std::size_t i = 0; i < models.size(); ++i) {
    text += (i == 0 ? "; of " : i + 1 < models.size() ? ", " : " and ") + models[i];
  }
  return text;
}

std::vector<Key<MaterialSettings>> material_table() {
  using S = MaterialSettings;
  std::vector<const char*> models;
  for (const MaterialChoice& choice : material_choices()) models.push_back(choice.name);
  std::vector<Key<S>> keys{
      {{.name = "model", .help = "the law of the material"},
       Choice<S>{models, [](const S& s) { return s.custom ? material_name(*s.custom) : s.model; },
                 [](S& s, const std::string& name) { s.model = name; }}}};
  static std::deque<std::string> texts;  // a KeyInfo refers to its texts
  const std::vector<MaterialParameter>& parameters = material_parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const MaterialParameter& parameter = parameters[i];
    const auto has_its_name = [&](const MaterialParameter& p) {
      return std::string_view(p.name) == parameter.name;
    };
    // A number and a list of the same name are one key.
    const auto end = parameters.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find_if(parameters.begin(), end, has_its_name) != end) continue;
    const auto other = std::find_if(end + 1, parameters.end(), has_its_name);
    texts.push_back(help_of(parameter));
    if (other != parameters.end()) texts.back() = help_of(*other) + "; " + texts.back();
    NumberOrArray<S>::List list;
    for (const MaterialParameter& p : parameters) {
      if (!has_its_name(p) || p.most_entries == 0) continue;
      list.most = p.most_entries;
      list.range = p.range;
    }
    list.takes_number = parameter.most_entries == 0 || other != parameters.end();
    keys.push_back({{.name = parameter.name,
                     .unit = parameter.unit,
                     .help = texts.back().c_str(),
                     .range = parameter.range},
                    NumberOrArray<S>{parameter.name, member_of(parameter.name), &S::arrays, list}});
  }
  keys.push_back(
      {{.name = "volumetric",
        .help = "the volumetric part U(J) of `neo-hookean` and `mooney-rivlin`: λ/2 (ln J)² or λ/2 "
                "(J − 1)²",
        .absent = "`\"log\"`"},
       Choice<S>{
           {to_string(VolumetricPart::kLogarithmic), to_string(VolumetricPart::kQuadratic)},
           [](const S& s) { return std::string(s.volumetric ? to_string(*s.volumetric) : ""); },
           [](S& s, const std::string& name) {
             s.volumetric = name == to_string(VolumetricPart::kQuadratic)
                                ? VolumetricPart::kQuadratic
                                : VolumetricPart::kLogarithmic;
           }},
       has_volumetric_part});
  keys.push_back({{.name = kDensity.name,
                   .unit = kDensity.unit,
                   .help = kDensity.help,
                   .range = kDensity.range},
                  NumberOrArray<S>{kDensity.name, &S::density, &S::arrays}});
  // A program's own material has its name and its density only.
  for (Key<S>& key : keys) {
    if (key.info.name == std::string_view("model") ||
        key.info.name == std::string_view(kDensity.name)) {
      continue;
    };
    key.used = [used = key.used](const void* s) {
      return !static_cast<const S*>(s)->custom && (!used || used(s));
    };
  }
  return keys;
}

}  // namespace

SceneSection material_section() {
  using S = MaterialSettings;
  SceneSection section = make_section<S>("material", material_table());
  section.needed = "under [material], give model, youngs_modulus, poissons_ratio and density.";
  section.unwritable = [](const void* settings) -> std::string {
    const auto& custom = static_cast<const S*>(settings)->custom;
    if (!custom) return {};
    return fmt::format(
        "The material {} is a program's own: a scene file cannot name it. Take one of the models.",
        material_name(*custom));
  };
  return section;
}

SceneSection material_region_section() {
  using S = MaterialRegionSettings;
  SceneSection section = make_section<S>(
      "material_region",
      {select_key<S>("the tetrahedra: of a group that consists of tetrahedra its own; of a `box` "
                     "or `sphere` those with their centroid in it; of anything else those with all "
                     "four vertices selected. All keys of `[material]` can stand beside it")});
  section.beside = section_of<MaterialSettings>;
  section.settings_beside = [](void* settings) -> void* {
    return &static_cast<S*>(settings)->material;
  };
  return section;
}

}  // namespace tetraction
