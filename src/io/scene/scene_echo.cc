#include "tetraction/io/scene_echo.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "tetraction/simulation/setting_keys.h"

namespace tetraction {
namespace {

using Json = nlohmann::ordered_json;

Json list(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

// The value of one key as JSON, or null if there is none. Every kind of value has its own function.
template <class S>
struct ValueJson {
  const S& settings;

  Json operator()(int S::*member) const { return settings.*member; }
  Json operator()(double S::*member) const {
    const double value = settings.*member;
    return std::isfinite(value) ? Json(value) : Json();
  }
  Json operator()(std::optional<double> S::*member) const {
    return settings.*member ? Json(*(settings.*member)) : Json();
  }
  Json operator()(Vector3 S::*member) const { return list(settings.*member); }
  Json operator()(std::optional<Vector3> S::*member) const {
    return settings.*member ? list(*(settings.*member)) : Json();
  }
  Json operator()(std::array<bool, 3> S::*member) const { return letters_of(settings.*member); }
  Json operator()(std::string S::*member) const {
    return (settings.*member).empty() ? Json() : Json(settings.*member);
  }
  Json operator()(std::array<std::int64_t, 2> S::*member) const { return settings.*member; }
  Json operator()(std::vector<std::int64_t> S::*member) const { return settings.*member; }
  Json operator()(std::vector<Vector3> S::*member) const {
    Json json;
    for (const Vector3& entry : settings.*member) json.push_back(list(entry));
    return json;
  }
  Json operator()(bool S::*member) const { return settings.*member; }
  Json operator()(std::vector<std::string> S::*member) const {
    return (settings.*member).empty() ? Json() : Json(settings.*member);
  }
  Json operator()(const Choice<S>& choice) const {
    const std::string name = choice.get(settings);
    return name.empty() ? Json() : Json(name);
  }
  Json operator()(const NumberOrAuto<S>& value) const {
    return settings.*value.automatic ? Json("auto") : Json(settings.*value.number);
  }
  Json operator()(const NumberOrArray<S>& value) const {
    const std::string array = value.array(settings);
    if (!array.empty()) return {{"array", array}};
    const std::optional<double> number = value.number(settings);
    return number ? Json(*number) : Json();
  }
  Json operator()(const VectorOrField<S>& value) const {
    const FieldSettings& field = settings.*value.field;
    if (field.empty()) return list(settings.*value.vector);
    return field.file.empty() ? Json{{"formula", field.formula}} : Json{{"file", field.file}};
  }
  Json operator()(const ByHand&) const { return {}; }
};

// All keys of a section that have a meaning with the other settings. `by_hand` returns the JSON of
// a key whose value has its own structure, or null.
template <class S, class ByHandJson>
Json section_json(const S& settings, const ByHandJson& by_hand) {
  const S defaults{};
  Json json = Json::object();
  for (const Key<S>& key : section_of<S>().keys) {
    if (!key.is_used(settings)) continue;
    Json value = std::holds_alternative<ByHand>(key.value)
                     ? by_hand(std::string_view(key.info.name))
                     : std::visit(ValueJson<S>{settings}, key.value);
    if (value.is_null()) continue;
    if (key.info.in_echo == Written::kUnlessDefault &&
        value == std::visit(ValueJson<S>{defaults}, key.value)) {
      continue;
    }
    json[key.info.name] = std::move(value);
  }
  return json;
}

template <class S>
Json section_json(const S& settings) {
  return section_json(settings, [](std::string_view) { return Json(); });
}

Json selection_json(const Selection& selection) {
  struct Visitor {
    Json operator()(const SelectVertices& s) const { return {{"vertices", s.ids}}; }
    Json operator()(const SelectPlane& s) const { return {{"plane", section_json(s)}}; }
    Json operator()(const SelectBox& s) const { return {{"box", section_json(s)}}; }
    Json operator()(const SelectSphere& s) const { return {{"sphere", section_json(s)}}; }
    Json operator()(const SelectNearest& s) const { return {{"nearest", list(s.point)}}; }
    Json operator()(const SelectGroup& s) const { return {{"group", s.name}}; }
    Json operator()(const SelectSurface&) const { return {{"surface", true}}; }
    Json operator()(const SelectAll&) const { return {{"all", true}}; }
    Json operator()(const SelectFaces& s) const { return {{"faces", section_json(s)}}; }
    Json operator()(const SelectSet& s) const {
      Json parts = Json::array();
      for (const SelectionPart& part : s.of) parts.push_back(selection_json(part.selection));
      const std::string name = to_string(s.operation);
      if (s.operation == SetOperation::kNot) return {{name, parts.at(0)}};
      return {{name, parts}};
    }
    Json operator()(const SelectNamed& s) const { return s.name; }
  };
  return std::visit(Visitor{}, selection);
}

// The JSON of settings with a selection.
template <class S>
Json selected_json(const S& settings) {
  return section_json(settings, [&](std::string_view key) {
    return key == "select" ? selection_json(settings.select) : Json();
  });
}

Json load_json(const ForceSettings& load) {
  Json json = visit_load(load, [](const auto& settings) { return selected_json(settings); });
  if (load.total || load.acceleration) json.erase("vector");
  return json;
}

Json amplitude_json(const AmplitudeSettings& a) {
  return section_json(a, [&](std::string_view key) -> Json {
    if (key != to_string(a.kind)) return {};
    switch (a.kind) {
      case AmplitudeKind::kPoints:
        break;
      case AmplitudeKind::kFile:
        return a.file;
      case AmplitudeKind::kSine:
        return {{"frequency", a.frequency}, {"phase", a.phase}, {"offset", a.offset}};
      case AmplitudeKind::kSmoothStep:
        return {{"from", a.from}, {"until", a.until}};
    }
    return a.points;
  });
}

Json generate_json(const GeneratorSettings& g) {
  switch (g.kind) {
    case GeneratorKind::kBeam:
    case GeneratorKind::kBox:
      break;
    case GeneratorKind::kCube:
      return {{"kind", "cube"}, {"size", g.size.x()}, {"cells", g.cells[0]}};
    case GeneratorKind::kTetrahedron:
      return {{"kind", "tetrahedron"}, {"size", g.size.x()}};
  }
  return {{"kind", to_string(g.kind)}, {"size", list(g.size)}, {"cells", g.cells}};
}

Json mesh_json(const MeshSettings& mesh) {
  return section_json(mesh, [&](std::string_view key) {
    if (key == "file" && !mesh.generate) return Json(mesh.file);
    if (key == "generate" && mesh.generate) return generate_json(*mesh.generate);
    return Json();
  });
}

Json material_json(const MaterialSettings& material) {
  if (material.custom) {
    return {{"model", material_name(*material.custom)}, {"density", material.density}};
  }
  return section_json(material);
}

Json initial_json(const InitialSettings& initial) {
  return section_json(initial, [&](std::string_view key) {
    Json list;
    if (key != "momentum") return list;
    for (const MomentumSettings& momentum : initial.momentum) {
      list.push_back(selected_json(momentum));
    }
    return list;
  });
}

}  // namespace

std::string scene_echo(const Scene& scene) {
  Json json;
  json["mesh"] = mesh_json(scene.mesh);
  json["material"] = material_json(scene.material);
  for (const MaterialRegionSettings& region : scene.material_region) {
    Json entry = material_json(region.material);
    entry["select"] = selection_json(region.select);
    json["material_region"].push_back(entry);
  }
  json["time"] = section_json(scene.time);
  json["solver"] = section_json(scene.solver);
  json["damping"] = section_json(scene.damping);
  json["environment"] = section_json(scene.environment);
  for (const FixSettings& fix : scene.fix) json["fix"].push_back(selected_json(fix));
  for (const ConstraintSettings& c : scene.constraint) {
    json["constraint"].push_back(selected_json(c));
  }
  for (const LoadKind kind : load_kinds()) {
    for (const ForceSettings& load : scene.list(kind)) {
      json[to_string(kind)].push_back(load_json(load));
    }
  }
  for (const AmplitudeSettings& amplitude : scene.amplitude) {
    json["amplitude"].push_back(amplitude_json(amplitude));
  }
  json["initial"] = initial_json(scene.initial);
  for (const EventSettings& event : scene.event) json["event"].push_back(Json::parse(event.echo));
  json["output"] = section_json(scene.output);
  for (const NamedSelection& named : scene.selection) {
    json["selection"][named.name] = selection_json(named.select);
  }
  for (const ProbeSettings& probe : scene.probe) json["probe"].push_back(selected_json(probe));
  // A path on the command line need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tetraction
