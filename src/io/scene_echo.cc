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
  json["time"] = time_json(scene.time);
  json["solver"] = {{"kind", scene.solver.kind},
                    {"tolerance", scene.solver.tolerance},
                    {"max_iterations", scene.solver.max_iterations}};
  json["environment"] = {
      {"kind", scene.environment.kind == EnvironmentKind::kGravity ? "gravity" : "none"},
      {"strength", scene.environment.strength},
      {"direction", list(scene.environment.direction)}};
  for (const FixSettings& fix : scene.fix) json["fix"].push_back(fix_json(fix));
  for (const ForceSettings& force : scene.force) json["force"].push_back(force_json(force));
  json["initial"] = initial_json(scene.initial);
  json["output"] = {{"directory", scene.output.directory}, {"every", scene.output.every}};
  // A path on the command line need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tetraction
