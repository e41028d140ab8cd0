#include "scene_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/console.h"
#include "core/quoting.h"
#include "simulation/facts/obstacle_checks.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

nlohmann::ordered_json json_of(const Vector3& x) {
  return {x.x(), x.y(), x.z()};
}

std::string text_of(const Vector3& x) {
  const Vector3 y = x + Vector3::Zero();  // without −0
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", y.x(), y.y(), y.z());
}

// "1 edge", "2 edges".
std::string count_text(Index count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string triangles_text(Index count) {
  return count_text(count, "triangle", "triangles");
}

std::string vertices_text(Index count) {
  return count_text(count, "vertex", "vertices");
}

std::string letters(const std::array<bool, 3>& components) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    if (components[i]) text += std::string(text.empty() ? "" : ", ") + "xyz"[i];
  }
  return text.empty() ? "no direction" : text;
}

std::string rim_text(const SurfaceFacts& surface) {
  const Index held = surface.rim_held;
  const Index guided = surface.rim_guided;
  const Index free = surface.rim_edges - held - guided;
  std::string text =
      fmt::format("open, its rim has {}, {:.6g} m long, ",
                  count_text(surface.rim_edges, "edge", "edges"), surface.rim_length);
  if (free == surface.rim_edges) return text + "free";
  if (held == surface.rim_edges) return text + "held";
  std::string parts;
  const auto add = [&](Index count, const char* what) {
    if (count > 0) parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", count, what);
  };
  add(held, "held");
  add(guided, "held in part");
  add(free, "free");
  return text + parts;
}

std::string surface_text(const SurfaceFacts& surface) {
  const std::string text =
      fmt::format("{}, {:.6g} m2, ", triangles_text(surface.triangles), surface.area);
  if (!surface.is_closed()) return text + rim_text(surface);
  return text + fmt::format("closed around {:.6g} m3{}", std::abs(surface.volume),
                            surface.volume < 0.0 ? " of a cavity" : "");
}

std::string region_text(const LoadFacts& load) {
  if (load.surface) return surface_text(*load.surface);
  if (load.tetrahedra > 0) {
    return fmt::format("{}, {:.6g} m3, {:.6g} kg",
                       count_text(load.tetrahedra, "tetrahedron", "tetrahedra"), load.volume,
                       load.mass);
  }
  return vertices_text(load.force.vertices);
}

// Resultant, moment, and what the supports take.
std::string force_text(const ForceFacts& force) {
  if (force.vertices == 0) return "no force";
  std::string text =
      fmt::format("resultant {} N, moment {} N m", text_of(force.resultant), text_of(force.moment));
  if (force.held_vertices == force.vertices) {
    return text + "; all of its vertices are held";
  }
  if (force.held_vertices > 0 || !force.held.isZero(0.0)) {
    text += fmt::format("; {} N of it on held directions", text_of(force.held));
    if (force.held_vertices > 0) {
      text +=
          fmt::format(", {} of its {} held", force.held_vertices, vertices_text(force.vertices));
    }
  }
  return text;
}

std::string factor_text(double factor, const std::string& amplitude) {
  std::string text;
  if (factor != 1.0 || !amplitude.empty()) text = fmt::format("; factor {:.6g} at t = 0", factor);
  if (!amplitude.empty()) text += fmt::format(" (amplitude {})", in_quotes(amplitude));
  return text;
}

std::string line_of(const LoadFacts& load) {
  std::string text = fmt::format("  {}: ", load.key);
  if (load.kind == LoadKind::kPressure) text += fmt::format("{:.6g} Pa on ", load.pressure);
  text += region_text(load) + "; " + force_text(load.force);
  text += factor_text(load.factor, load.amplitude);
  if (load.from > 0.0) text += fmt::format("; from {:.6g} s", load.from);
  if (std::isfinite(load.until)) text += fmt::format("; until {:.6g} s", load.until);
  return text;
}

std::string covered_text(const SupportFacts& support) {
  if (support.triangles == 0) return ", which cover no triangle of the boundary";
  return fmt::format(" ({}, {:.6g} m2)", triangles_text(support.triangles), support.area);
}

std::string motion_text(const SupportFacts& support) {
  std::string text;
  if (support.displacement > 0.0) {
    text += fmt::format("; up to {:.6g} m from rest at t = 0", support.displacement);
  }
  if (!support.moves) return text;
  if (!support.velocity.isZero(0.0)) {
    text += fmt::format("; moves with {} m/s", text_of(support.velocity));
  }
  if (!support.angular_velocity.isZero(0.0)) {
    text += fmt::format("; turns with {} rad/s about {}", text_of(support.angular_velocity),
                        text_of(support.center));
  }
  if (!support.amplitude.empty()) {
    text += fmt::format("; moves with the amplitude {}", in_quotes(support.amplitude));
  }
  return text;
}

std::string line_of(const SupportFacts& support) {
  const std::string start = fmt::format("  {}: {}", support.key, vertices_text(support.vertices));
  switch (support.kind) {
    case SupportKind::kFix:
      return fmt::format("{}{} held in {}{}", start, covered_text(support),
                         letters(support.components), motion_text(support));
    case SupportKind::kSprings:
      return fmt::format("{}{} on springs of {:.6g} N/m in {}{}", start, covered_text(support),
                         support.stiffness, letters(support.components), motion_text(support));
    case SupportKind::kPlane:
      return fmt::format("{}{} in planes of the normal {}{}", start, covered_text(support),
                         text_of(support.direction), motion_text(support));
    case SupportKind::kLine:
      return fmt::format("{}{} on lines along {}{}", start, covered_text(support),
                         text_of(support.direction), motion_text(support));
    case SupportKind::kDistance:
      return fmt::format("  {}: vertices {} and {} stay {:.6g} m apart", support.key,
                         support.ends[0], support.ends[1], support.length);
    case SupportKind::kFreeHandle:
      return fmt::format("{}{}, {:.6g} kg, move together as one free rigid body", start,
                         covered_text(support), support.mass);
    case SupportKind::kDrivenHandle:
      break;
  }
  return fmt::format("{}{}, {:.6g} kg, driven as one rigid body{}", start, covered_text(support),
                     support.mass, motion_text(support));
}

nlohmann::ordered_json json_of(const ForceFacts& force) {
  return {{"resultant", json_of(force.resultant)},
          {"moment", json_of(force.moment)},
          {"loaded_vertices", force.vertices},
          {"held_vertices", force.held_vertices},
          {"held_force", json_of(force.held)}};
}

nlohmann::ordered_json json_of(const LoadFacts& load) {
  nlohmann::ordered_json json{{"load", load.key}};
  if (load.kind == LoadKind::kPressure) json["pressure"] = load.pressure;
  if (load.surface) {
    const SurfaceFacts& surface = *load.surface;
    json["triangles"] = surface.triangles;
    json["area"] = surface.area;
    json["closed"] = surface.is_closed();
    if (surface.is_closed()) {
      json["enclosed_volume"] = surface.volume;
    } else {
      json["rim"] = {{"edges", surface.rim_edges},
                     {"length", surface.rim_length},
                     {"held_edges", surface.rim_held},
                     {"partly_held_edges", surface.rim_guided}};
    }
  }
  if (load.tetrahedra > 0) {
    json["tetrahedra"] = load.tetrahedra;
    json["volume"] = load.volume;
    json["mass"] = load.mass;
  }
  json.update(json_of(load.force));
  json["factor"] = load.factor;
  if (!load.amplitude.empty()) json["amplitude"] = load.amplitude;
  json["from"] = load.from;
  if (std::isfinite(load.until)) json["until"] = load.until;
  return json;
}

nlohmann::ordered_json json_of(const SupportFacts& support) {
  nlohmann::ordered_json json{
      {"support", support.key}, {"kind", to_string(support.kind)}, {"vertices", support.vertices}};
  if (support.kind == SupportKind::kDistance) {
    json["ends"] = support.ends;
    json["length"] = support.length;
    return json;
  }
  json["triangles"] = support.triangles;
  json["area"] = support.area;
  switch (support.kind) {
    case SupportKind::kSprings:
      json["stiffness"] = support.stiffness;
      [[fallthrough]];
    case SupportKind::kFix:
      json["components"] = support.components;
      break;
    case SupportKind::kPlane:
      json["normal"] = json_of(support.direction);
      break;
    case SupportKind::kLine:
      json["direction"] = json_of(support.direction);
      break;
    case SupportKind::kDrivenHandle:
      json["center"] = json_of(support.center);
      [[fallthrough]];
    case SupportKind::kFreeHandle:
      json["mass"] = support.mass;
      break;
    case SupportKind::kDistance:
      break;
  }
  json["displacement"] = support.displacement;
  json["moves"] = support.moves;
  if (support.moves) {
    json["velocity"] = json_of(support.velocity);
    json["angular_velocity"] = json_of(support.angular_velocity);
  }
  if (!support.amplitude.empty()) json["amplitude"] = support.amplitude;
  return json;
}

nlohmann::ordered_json json_of(const MassProperties& mass) {
  return {{"center", json_of(mass.center)},
          {"moments", json_of(Vector3(mass.inertia.diagonal()))},
          {"products", {mass.inertia(0, 1), mass.inertia(1, 2), mass.inertia(2, 0)}}};
}

// Products that are round-off are zero.
std::string text_of(const MassProperties& mass) {
  constexpr double kRoundOff = 1e-12;
  Vector3 products(mass.inertia(0, 1), mass.inertia(1, 2), mass.inertia(2, 0));
  for (double& product : products) {
    if (std::abs(product) <= kRoundOff * mass.inertia.norm()) product = 0.0;
  }
  return fmt::format("moments {} kg m2 (xx, yy, zz), products {} (xy, yz, zx)",
                     text_of(Vector3(mass.inertia.diagonal())), text_of(products));
}

std::string mechanism_line(const Mechanism& mechanism) {
  return fmt::format("  mechanism: pieces that share no face touch in {}; {}\n", mechanism.place,
                     mechanism.free_motions > 0
                         ? count_text(mechanism.free_motions, "motion is free", "motions are free")
                         : std::string("the supports hold them"));
}

std::string start_in_layer(double gap) {
  if (!std::isfinite(gap)) return {};
  return fmt::format(". The body begins in its layer, {:.3g} m from it", gap);
}

void print_obstacles(const MechanicalSystem& system, const std::vector<double>& gaps) {
  const Contact* contact = system.contact();
  if (contact == nullptr) return;
  if (const BodyContact* between = contact->between(); between != nullptr) {
    print_result(
        "contact between {}: thickness {:.4g} m, stiffness {:.4g} Pa, friction {:.4g}; {} may "
        "touch\n",
        between->within_bodies ? "all parts of the surface"
                               : count_text(contact->body_count(), "body", "bodies"),
        between->thickness, between->stiffness, between->friction,
        triangles_text(static_cast<Index>(between->surface.size())));
  }
  if (contact->size() == 0) return;
  print_result("obstacles:\n");
  for (std::size_t i = 0; i < contact->size(); ++i) {
    const Obstacle& obstacle = contact->obstacle(i);
    if (obstacle.removed) continue;
    print_result(
        "  {}: thickness {:.4g} m, stiffness {:.4g} Pa, friction {:.4g}{}; {} may touch it{}\n",
        obstacle.name, obstacle.thickness, obstacle.stiffness, obstacle.friction,
        obstacle.motion.at_rest() ? "" : ", moves",
        triangles_text(static_cast<Index>(obstacle.surface.size())), start_in_layer(gaps[i]));
  }
}

nlohmann::ordered_json obstacles_json(const MechanicalSystem& system,
                                      const std::vector<double>& gaps) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  const Contact* contact = system.contact();
  for (std::size_t i = 0; contact != nullptr && i < contact->size(); ++i) {
    const Obstacle& obstacle = contact->obstacle(i);
    if (obstacle.removed) continue;
    json[obstacle.name] = {
        {"thickness", obstacle.thickness},      {"stiffness", obstacle.stiffness},
        {"friction", obstacle.friction},        {"moves", !obstacle.motion.at_rest()},
        {"triangles", obstacle.surface.size()}, {"gap", gaps[i]}};
  }
  return json;
}

}  // namespace

SceneFacts scene_facts(const Scene& scene, const MechanicalSystem& system,
                       const BodyConstraints& constraints, const Vector& positions) {
  SceneFacts facts;
  facts.loads = load_facts(scene, system, positions);
  facts.environment = environment_facts(scene, system, positions);
  if (facts.environment) {
    facts.environment_factor = system.environment().factor(system.force_point(positions, 0.0));
  }
  facts.pull = pull_facts(scene, system, positions);
  facts.supports = support_facts(constraints, system);
  facts.motions = find_free_motions(system, 0.0, Contact::Support::kPresent);
  if (const Contact* contact = system.contact(); contact != nullptr) {
    for (std::size_t i = 0; i < contact->size(); ++i) {
      facts.gaps.push_back(contact->smallest_gap(system.force_point(positions, 0.0), i));
    }
  }
  facts.mass = mass_properties(system);
  facts.lumped_mass = lumped_mass_properties(system);
  for (const LoadFacts& load : facts.loads) {
    if (load.force.vertices > 0 && load.force.held_vertices == load.force.vertices) {
      facts.warnings.push_back(load.key +
                               ": all of its vertices are held, so that it moves nothing.");
    }
  }
  for (const LoadKind kind : values_of<LoadKind>()) {
    for (const ForceSettings& load : scene.list(kind)) {
      if (std::string warning = volume_group_warning(load, system); !warning.empty()) {
        facts.warnings.push_back(std::move(warning));
      }
    }
  }
  for (std::string& warning : obstacle_warnings(scene, system)) {
    facts.warnings.push_back(std::move(warning));
  }
  if (std::string warning = mechanism_warning(facts.motions); !warning.empty()) {
    facts.warnings.push_back(std::move(warning));
  }
  return facts;
}

void enter_facts(const SceneFacts& facts, const MechanicalSystem& system,
                 nlohmann::ordered_json& json) {
  json["inertia"] = json_of(facts.mass);
  json["lumped_inertia"] = json_of(facts.lumped_mass);
  json["loads"] = nlohmann::ordered_json::array();
  for (const LoadFacts& load : facts.loads) json["loads"].push_back(json_of(load));
  if (facts.environment) {
    json["environment"] = json_of(*facts.environment);
    json["environment"]["factor"] = facts.environment_factor;
  }
  if (facts.pull) json["pull"] = json_of(*facts.pull);
  json["supports"] = nlohmann::ordered_json::array();
  for (const SupportFacts& support : facts.supports) json["supports"].push_back(json_of(support));
  json["obstacles"] = obstacles_json(system, facts.gaps);
  json["parts"] = facts.motions.parts;
  json["pieces"] = facts.motions.pieces;
  json["free_motions"] = facts.motions.whole;
  json["mechanisms"] = nlohmann::ordered_json::array();
  for (const Mechanism& mechanism : facts.motions.mechanisms) {
    nlohmann::ordered_json joints = nlohmann::ordered_json::array();
    for (const Index v : mechanism.joints) joints.push_back(system.mesh().vertex_id(v));
    json["mechanisms"].push_back({{"vertex", system.mesh().vertex_id(mechanism.vertex)},
                                  {"pieces", mechanism.pieces},
                                  {"motions", mechanism.motions},
                                  {"free_motions", mechanism.free_motions},
                                  {"joints", joints}});
  }
}

void print_inertia(const SceneFacts& facts) {
  constexpr double kRoundOff = 1e-9;
  print_result("centre of mass: {} m; inertia about it: {}\n", text_of(facts.mass.center),
               text_of(facts.mass));
  const Matrix3 error = facts.lumped_mass.inertia - facts.mass.inertia;
  const double largest = facts.mass.inertia.diagonal().maxCoeff();
  if (!(error.cwiseAbs().maxCoeff() > kRoundOff * largest)) return;
  const double product =
      std::max({std::abs(error(0, 1)), std::abs(error(1, 2)), std::abs(error(2, 0))});
  print_result("  of the lumped masses, with which steps are made: {}\n",
               text_of(facts.lumped_mass));
  if (product > kRoundOff * largest) {
    print_result(
        "  lumping adds products of inertia of {:.2g} of the largest moment, because the diagonals "
        "of the mesh favour a direction: a spinning body feels them. A finer mesh lessens them\n",
        product / largest);
  }
}

void print_loads_and_supports(const SceneFacts& facts, const Scene& scene,
                              const MechanicalSystem& system) {
  const bool any = !facts.loads.empty() || facts.environment || facts.pull;
  print_result("\nloads{}\n",
               any ? ", with moments about the origin at the positions of t = 0:" : ": none");
  for (const LoadFacts& load : facts.loads) write_result(line_of(load) + "\n");
  if (facts.environment) {
    print_result("  environment: {}; {}{}\n", to_string(scene.environment.kind),
                 force_text(*facts.environment),
                 factor_text(facts.environment_factor, scene.environment.amplitude));
  }
  if (facts.pull) print_result("  pull: {}\n", force_text(*facts.pull));
  print_result("supports{}\n", facts.supports.empty() ? ": none" : ":");
  for (const SupportFacts& support : facts.supports) write_result(line_of(support) + "\n");
  print_obstacles(system, facts.gaps);
  if (facts.motions.parts > 1) {
    print_result("  the body consists of {} parts that do not touch each other\n",
                 facts.motions.parts);
  }
  for (const Mechanism& mechanism : facts.motions.mechanisms) {
    write_result(mechanism_line(mechanism));
  }
  std::string free;
  for (const std::string& motion : facts.motions.whole) {
    free += (free.empty() ? "" : ", ") + motion;
  }
  if (!facts.motions.is_complete) {
    print_result(
        "  free motions: not examined, because the body has {} pieces that share no face\n",
        facts.motions.pieces);
  } else if (system.constraints().list().distances.empty()) {
    print_result("  free motions: {}\n", free.empty() ? "none" : free);
  } else {
    print_result("  free motions, if distances did not count: {}\n", free.empty() ? "none" : free);
  }
  if (system.contact() != nullptr && !free.empty()) {
    print_result(
        "  (obstacles count where the body is in their layers at rest; static takes all)\n");
  }
}

}  // namespace tetraction
