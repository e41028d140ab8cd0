#include "scene_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <variant>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

void put_if(SceneKeys& keys, const char* name, const std::optional<double>& value,
            const char* unit = "") {
  if (value) keys.push_back({name, toml_number(*value), unit});
}

void put_if(SceneKeys& keys, const char* name, const std::optional<Vector3>& value,
            const char* unit) {
  if (value) keys.push_back({name, toml_list(*value), unit});
}

template <class Values, class Text>
std::string list_text(const Values& values, const Text& text) {
  std::string list = "[";
  for (const auto& value : values) list += (list.size() > 1 ? ", " : "") + text(value);
  return list + "]";
}

}  // namespace

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  // "3" would be read as a whole number, and "-0" lose its sign.
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

std::string toml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string toml_list(const Vector3& value) {
  return list_text(value, toml_number);
}

std::string toml_list(const std::vector<std::int64_t>& values) {
  return list_text(values, [](std::int64_t value) { return std::to_string(value); });
}

std::string toml_list(const std::vector<Vector3>& values) {
  return list_text(values, [](const Vector3& value) { return toml_list(value); });
}

SceneKeys keys_of(const MaterialSettings& material) {
  if (material.custom) {
    throw InputError(fmt::format(
        "The material {} is a program's own: a scene file cannot name it. Take one of the models.",
        material_name(*material.custom)));
  }
  SceneKeys keys{{"model", toml_text(material.model)}};
  put_if(keys, "youngs_modulus", material.youngs_modulus, "Pa");
  put_if(keys, "poissons_ratio", material.poissons_ratio);
  put_if(keys, "mu", material.mu, "Pa");
  put_if(keys, "lambda", material.lambda, "Pa");
  put_if(keys, "mu1", material.mu1, "Pa");
  put_if(keys, "mu2", material.mu2, "Pa");
  put_if(keys, "ratio", material.ratio);
  keys.push_back({"density", toml_number(material.density), "kg/m³"});
  return keys;
}

SceneKeys keys_of(const TimeSettings& time) {
  if (!std::isfinite(time.end)) {
    throw InputError("The run has no end, which a scene file must give: set time.end.");
  }
  return {{"integrator", toml_text(to_string(time.integrator))},
          {"step", time.automatic ? toml_text("auto") : toml_number(time.step),
           time.automatic ? "" : "s"},
          {"end", toml_number(time.end), "s"}};
}

SceneKeys keys_of(const SolverSettings& solver) {
  return {{"kind", toml_text(solver.kind)},
          {"linear", toml_text(to_string(solver.linear))},
          {"tolerance", toml_number(solver.tolerance)},
          {"max_iterations", std::to_string(solver.max_iterations)}};
}

SceneKeys keys_of(const Damping& damping) {
  return {{"drag", toml_number(damping.drag), "kg/s per vertex"},
          {"mass_damping", toml_number(damping.mass_damping), "1/s"},
          {"viscosity", toml_number(damping.viscosity), "Pa s"}};
}

SceneKeys keys_of(const EnvironmentSettings& environment) {
  const char* kind = "none";
  const char* unit = "";
  switch (environment.kind) {
    case EnvironmentKind::kNone:
      break;
    case EnvironmentKind::kGravity:
      kind = "gravity";
      unit = "m/s²";
      break;
    case EnvironmentKind::kAttraction:
      kind = "attraction";
      unit = "N m²";
      break;
    case EnvironmentKind::kCustom:
      throw InputError(
          "The environment is a program's own force field: a scene file cannot name it. Take "
          "none, gravity or attraction.");
  }
  return {{"kind", toml_text(kind)},
          {"strength", toml_number(environment.strength), unit},
          {"direction", toml_list(environment.direction)},
          {"softening", toml_number(environment.softening), "m"}};
}

SceneKeys keys_of(const FixSettings& fix) {
  std::string components;
  for (std::size_t i = 0; i < 3; ++i) {
    if (fix.components[i]) components += static_cast<char>('x' + i);
  }
  SceneKeys keys{{"components", toml_text(components)}};
  put_if(keys, "target", fix.target, "m");
  put_if(keys, "offset", fix.offset, "m");
  if (!fix.targets.empty()) keys.push_back({"targets", toml_list(fix.targets), "m"});
  if (!fix.velocity.isZero(0.0)) keys.push_back({"velocity", toml_list(fix.velocity), "m/s"});
  if (fix.is_penalty) keys.push_back({"mode", toml_text("penalty")});
  if (fix.penalty > 0.0) keys.push_back({"penalty", toml_number(fix.penalty), "N/m"});
  return keys;
}

bool has_selection(const ConstraintSettings& constraint) {
  return constraint.kind != ConstraintKind::kDistance;
}

SceneKeys keys_of(const ConstraintSettings& constraint) {
  SceneKeys keys{{"kind", toml_text(to_string(constraint.kind))}};
  switch (constraint.kind) {
    case ConstraintKind::kDistance:
      keys.push_back({"vertices", toml_list(std::vector<std::int64_t>(constraint.vertices.begin(),
                                                                      constraint.vertices.end()))});
      put_if(keys, "length", constraint.length, "m");
      break;
    case ConstraintKind::kPlane:
    case ConstraintKind::kLine:
      put_if(keys, "point", constraint.point, "m");
      keys.push_back({constraint.kind == ConstraintKind::kPlane ? "normal" : "direction",
                      toml_list(constraint.direction)});
      break;
    case ConstraintKind::kRigid:
      put_if(keys, "velocity", constraint.velocity, "m/s");
      put_if(keys, "angular_velocity", constraint.angular_velocity, "rad/s");
      break;
  }
  return keys;
}

SceneKeys keys_of(const ForceSettings& force) {
  SceneKeys keys{{"vector", toml_list(force.vector), "N on each vertex"},
                 {"from", toml_number(force.from), "s"}};
  if (std::isfinite(force.until)) keys.push_back({"until", toml_number(force.until), "s"});
  return keys;
}

SceneKeys keys_of(const MomentumSettings& momentum) {
  return {{"value", toml_list(momentum.value), "kg m/s of each vertex"}};
}

SceneKeys keys_of(const ShiftSettings& shift) {
  SceneKeys keys{{"vertices", toml_list(shift.vertices)}};
  if (!shift.displacement.empty()) {
    keys.push_back({"displacement", toml_list(shift.displacement), "m"});
  }
  if (!shift.impulse.empty()) keys.push_back({"impulse", toml_list(shift.impulse), "N s"});
  return keys;
}

SceneKeys keys_of(const Selection& selection) {
  struct Visitor {
    SceneKeys operator()(const SelectVertices& s) const { return {{"vertices", toml_list(s.ids)}}; }
    SceneKeys operator()(const SelectPlane& s) const {
      SceneKeys keys{{"plane.axis", toml_text(std::string(1, static_cast<char>('x' + s.axis)))},
                     {"plane.at", toml_number(s.at)}};
      put_if(keys, "plane.tolerance", s.tolerance);
      return keys;
    }
    SceneKeys operator()(const SelectBox& s) const {
      return {{"box.min", toml_list(s.min)}, {"box.max", toml_list(s.max)}};
    }
    SceneKeys operator()(const SelectSphere& s) const {
      return {{"sphere.center", toml_list(s.center)}, {"sphere.radius", toml_number(s.radius)}};
    }
    SceneKeys operator()(const SelectNearest& s) const { return {{"nearest", toml_list(s.point)}}; }
    SceneKeys operator()(const SelectGroup& s) const { return {{"group", toml_text(s.name)}}; }
    SceneKeys operator()(const SelectSurface&) const { return {{"surface", "true"}}; }
    SceneKeys operator()(const SelectAll&) const { return {{"all", "true"}}; }
  };
  return std::visit(Visitor{}, selection);
}

std::string inline_selection(const Selection& selection) {
  const SceneKeys keys = keys_of(selection);
  const auto dot = keys.front().name.find('.');
  if (dot == std::string::npos) return inline_table(keys);
  SceneKeys inner = keys;
  for (SceneKey& key : inner) key.name.erase(0, dot + 1);
  return inline_table({{keys.front().name.substr(0, dot), inline_table(inner)}});
}

std::string inline_table(const SceneKeys& keys, const Selection* select) {
  std::string text = select != nullptr ? "select = " + inline_selection(*select) : std::string();
  for (const SceneKey& key : keys) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key.name, key.value);
  }
  return "{ " + text + " }";
}

}  // namespace tetraction
