#include "support_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "tetraction/dynamics/terms/consistent_loads.h"

namespace tetraction {
namespace {

class Facts {
 public:
  explicit Facts(const MechanicalSystem& system)
      : system_(system), boundary_(boundary_faces(system.mesh())) {}

  SupportFacts of(const PrescribedVertices& held) const {
    SupportFacts facts = of_vertices(held.vertices);
    facts.kind = held.penalty > 0.0 ? SupportKind::kSprings : SupportKind::kFix;
    facts.components = held.components;
    facts.stiffness = 2.0 * held.penalty;
    facts.moves = !held.motion.at_rest();
    facts.velocity = held.motion.velocity;
    facts.angular_velocity = held.motion.angular_velocity;
    facts.center = held.motion.center;
    for (std::size_t i = 0; i < held.vertices.size(); ++i) {
      Vector3 way = held.motion.position(held.start.col(static_cast<Index>(i)), 0.0) -
                    system_.rest().position(held.vertices[i]);
      for (int axis = 0; axis < 3; ++axis) {
        if (!held.components[static_cast<std::size_t>(axis)]) way[axis] = 0.0;
      }
      facts.displacement = std::max(facts.displacement, way.norm());
    }
    return facts;
  }

  SupportFacts operator()(const PrescribedVertices& driven) const {
    SupportFacts facts = of(driven);
    facts.kind = SupportKind::kDrivenHandle;
    facts.mass = mass_of(driven.vertices);
    return facts;
  }
  SupportFacts operator()(const GuidedVertices& guided) const {
    SupportFacts facts = of_vertices(guided.vertices);
    facts.kind = guided.directions.cols() == 2 ? SupportKind::kPlane : SupportKind::kLine;
    for (std::size_t i = 0; i < guided.vertices.size(); ++i) {
      const Vector3 way =
          guided.points.col(static_cast<Index>(i)) - system_.rest().position(guided.vertices[i]);
      const Vector3 along = guided.directions * (guided.directions.transpose() * way);
      facts.displacement = std::max(facts.displacement, (way - along).norm());
    }
    return facts;
  }
  SupportFacts operator()(const FixedDistance& distance) const {
    SupportFacts facts;
    facts.kind = SupportKind::kDistance;
    facts.vertices = 2;
    facts.ends = {system_.mesh().vertex_id(distance.a), system_.mesh().vertex_id(distance.b)};
    facts.length = distance.length;
    return facts;
  }
  SupportFacts operator()(const RigidHandle& handle) const {
    SupportFacts facts = of_vertices(handle.vertices);
    facts.kind = SupportKind::kFreeHandle;
    facts.mass = mass_of(handle.vertices);
    return facts;
  }

 private:
  SupportFacts of_vertices(const std::vector<Index>& vertices) const {
    SupportFacts facts;
    facts.vertices = static_cast<Index>(vertices.size());
    std::vector<std::array<Index, 3>> covered;
    for (const auto& triangle : boundary_) {  // the vertices are sorted
      if (std::all_of(triangle.begin(), triangle.end(), [&](Index v) {
            return std::binary_search(vertices.begin(), vertices.end(), v);
          })) {
        covered.push_back(triangle);
      }
    }
    facts.triangles = static_cast<Index>(covered.size());
    if (!covered.empty()) facts.area = surface_distribution(system_.mesh(), covered).total();
    return facts;
  }
  double mass_of(const std::vector<Index>& vertices) const {
    double mass = 0.0;
    for (const Index v : vertices) mass += system_.mass()[v];
    return mass;
  }

  const MechanicalSystem& system_;
  std::vector<std::array<Index, 3>> boundary_;
};

}  // namespace

std::vector<SupportFacts> support_facts(const BodyConstraints& constraints,
                                        const MechanicalSystem& system) {
  const Facts facts_of(system);
  std::vector<SupportFacts> all;
  for (std::size_t i = 0; i < constraints.fixes.size(); ++i) {
    all.push_back(facts_of.of(constraints.fixes[i]));
    all.back().key = fmt::format("fix.{}", i);
    all.back().amplitude = constraints.fix_settings[i].amplitude;
  }
  for (std::size_t i = 0; i < constraints.others.size(); ++i) {
    all.push_back(std::visit(facts_of, constraints.others[i]));
    all.back().key = fmt::format("constraint.{}", i);
    if (const auto& settings = constraints.other_settings[i]) {
      all.back().amplitude = settings->amplitude;
      const bool is_guided =
          settings->kind == ConstraintKind::kPlane || settings->kind == ConstraintKind::kLine;
      if (is_guided) all.back().direction = settings->direction.stableNormalized();
    }
  }
  return all;
}

}  // namespace tetraction
