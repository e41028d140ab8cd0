#include "scene_echo.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

namespace tetraction {
namespace {

using Json = nlohmann::ordered_json;

Json list(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

void put_if(Json& json, const char* key, const std::optional<double>& value) {
  if (value) json[key] = *value;
}

Json selection_json(const Selection& selection) {
  struct Visitor {
    Json operator()(const SelectVertices& s) const { return {{"vertices", s.ids}}; }
    Json operator()(const SelectPlane& s) const {
      Json plane{{"axis", std::string(1, static_cast<char>('x' + s.axis))}, {"at", s.at}};
      put_if(plane, "tolerance", s.tolerance);
      return {{"plane", plane}};
    }
    Json operator()(const SelectBox& s) const {
      return {{"box", {{"min", list(s.min)}, {"max", list(s.max)}}}};
    }
    Json operator()(const SelectSphere& s) const {
      return {{"sphere", {{"center", list(s.center)}, {"radius", s.radius}}}};
    }
    Json operator()(const SelectNearest& s) const { return {{"nearest", list(s.point)}}; }
    Json operator()(const SelectGroup& s) const { return {{"group", s.name}}; }
    Json operator()(const SelectSurface&) const { return {{"surface", true}}; }
    Json operator()(const SelectAll&) const { return {{"all", true}}; }
  };
  return std::visit(Visitor{}, selection);
}

Json mesh_json(const MeshSettings& mesh) {
  Json json;
  if (!mesh.generate) {
    json["file"] = mesh.file;
  } else {
    const GeneratorSettings& g = *mesh.generate;
    Json generate;
    switch (g.kind) {
      case GeneratorKind::kBeam:
      case GeneratorKind::kBox:
        generate["kind"] = g.kind == GeneratorKind::kBeam ? "beam" : "box";
        generate["size"] = list(g.size);
        generate["cells"] = g.cells;
        break;
      case GeneratorKind::kCube:
        generate = {{"kind", "cube"}, {"size", g.size.x()}, {"cells", g.cells[0]}};
        break;
      case GeneratorKind::kTetrahedron:
        generate = {{"kind", "tetrahedron"}, {"size", g.size.x()}};
        break;
    }
    json["generate"] = generate;
  }
  json["scale"] = mesh.scale;
  return json;
}

Json material_json(const MaterialSettings& material) {
  if (material.custom) {
    return {{"model", material_name(*material.custom)}, {"density", material.density}};
  }
  Json json{{"model", material.model}};
  put_if(json, "youngs_modulus", material.youngs_modulus);
  put_if(json, "poissons_ratio", material.poissons_ratio);
  put_if(json, "mu", material.mu);
  put_if(json, "lambda", material.lambda);
  put_if(json, "mu1", material.mu1);
  put_if(json, "mu2", material.mu2);
  put_if(json, "ratio", material.ratio);
  json["density"] = material.density;
  return json;
}

Json constraint_json(const ConstraintSettings& c) {
  Json json{{"kind", to_string(c.kind)}};
  switch (c.kind) {
    case ConstraintKind::kDistance:
      json["vertices"] = c.vertices;
      put_if(json, "length", c.length);
      return json;
    case ConstraintKind::kPlane:
    case ConstraintKind::kLine:
      json["select"] = selection_json(c.select);
      if (c.point) json["point"] = list(*c.point);
      json[c.kind == ConstraintKind::kPlane ? "normal" : "direction"] = list(c.direction);
      return json;
    case ConstraintKind::kRigid:
      break;
  }
  json["select"] = selection_json(c.select);
  if (c.velocity) json["velocity"] = list(*c.velocity);
  if (c.angular_velocity) json["angular_velocity"] = list(*c.angular_velocity);
  return json;
}

const char* environment_name(EnvironmentKind kind) {
  switch (kind) {
    case EnvironmentKind::kNone:
      return "none";
    case EnvironmentKind::kGravity:
      return "gravity";
    case EnvironmentKind::kAttraction:
      return "attraction";
    case EnvironmentKind::kCustom:
      break;
  }
  return "custom";
}

Json time_json(const TimeSettings& time) {
  Json json{{"integrator", to_string(time.integrator)}};
  if (time.automatic) {
    json["step"] = "auto";
  } else {
    json["step"] = time.step;
  }
  json["end"] = time.end;
  return json;
}

Json fix_json(const FixSettings& fix) {
  std::string components;
  for (std::size_t i = 0; i < 3; ++i) {
    if (fix.components[i]) components += static_cast<char>('x' + i);
  }
  Json json{{"select", selection_json(fix.select)}, {"components", components}};
  if (fix.target) json["target"] = list(*fix.target);
  if (fix.offset) json["offset"] = list(*fix.offset);
  for (const Vector3& target : fix.targets) json["targets"].push_back(list(target));
  if (!fix.velocity.isZero(0.0)) json["velocity"] = list(fix.velocity);
  json["mode"] = fix.is_penalty ? "penalty" : "exact";
  if (fix.is_penalty) json["penalty"] = fix.penalty;
  return json;
}

Json force_json(const ForceSettings& force) {
  Json json{{"select", selection_json(force.select)},
            {"vector", list(force.vector)},
            {"from", force.from}};
  if (std::isfinite(force.until)) json["until"] = force.until;
  return json;
}

Json initial_json(const InitialSettings& initial) {
  Json json{{"velocity", list(initial.velocity)},
            {"angular_velocity", list(initial.angular_velocity)},
            {"stretch", list(initial.stretch)}};
  if (!initial.displacement_array.empty()) json["displacement_array"] = initial.displacement_array;
  if (!initial.velocity_array.empty()) json["velocity_array"] = initial.velocity_array;
  for (const MomentumSettings& m : initial.momentum) {
    json["momentum"].push_back({{"select", selection_json(m.select)}, {"value", list(m.value)}});
  }
  return json;
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
  json["time"] = time_json(scene.time);
  json["solver"] = {{"kind", scene.solver.kind},
                    {"linear", to_string(scene.solver.linear)},
                    {"tolerance", scene.solver.tolerance},
                    {"max_iterations", scene.solver.max_iterations}};
  json["damping"] = {{"drag", scene.damping.drag},
                     {"mass_damping", scene.damping.mass_damping},
                     {"viscosity", scene.damping.viscosity}};
  json["environment"] = {{"kind", environment_name(scene.environment.kind)},
                         {"strength", scene.environment.strength},
                         {"direction", list(scene.environment.direction)},
                         {"softening", scene.environment.softening}};
  for (const FixSettings& fix : scene.fix) json["fix"].push_back(fix_json(fix));
  for (const ConstraintSettings& c : scene.constraint) {
    json["constraint"].push_back(constraint_json(c));
  }
  for (const ForceSettings& force : scene.force) json["force"].push_back(force_json(force));
  json["initial"] = initial_json(scene.initial);
  for (const EventSettings& event : scene.event) json["event"].push_back(Json::parse(event.echo));
  json["output"] = {{"directory", scene.output.directory}, {"every", scene.output.every}};
  // A path on the command line need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tetraction
