// The contact of bodies with each other, as a unit of Contact, and what penetrates.
#include "tetraction/dynamics/contact/body_contact.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "contact_surface.h"
#include "contact_unit.h"
#include "core/disjoint_sets.h"
#include "dynamics/contact/pairs/box_tree.h"
#include "dynamics/contact/pairs/pair_distance.h"
#include "self_contact.h"
#include "tetraction/core/error.h"
#include "touch_share.h"

namespace tetraction {
namespace {

void check_number(const char* name, double value, bool may_be_zero = false) {
  if (std::isfinite(value) && (value > 0.0 || (may_be_zero && value == 0.0))) return;
  throw InputError(fmt::format("The contact of bodies has the {} {}; it must be {} and finite.",
                               name, value, may_be_zero ? "zero or more" : "above zero"));
}

// The number of the body of each vertex of the surface.
std::vector<Index> bodies_of(const TetMesh& mesh, const ContactSurface& surface) {
  DisjointSets sets(mesh.vertex_count());
  for (const auto& corners : mesh.tetrahedra) {
    for (const Index v : corners) sets.join(corners[0], v);
  }
  const auto vertex = [&](Index i) { return surface.vertices[static_cast<std::size_t>(i)]; };
  // The middles of edges.
  for (const auto& [a, b, c] : surface.triangles) {
    sets.join(vertex(a), vertex(b));
    sets.join(vertex(a), vertex(c));
  }
  Index count = 0;
  const std::vector<Index> all = sets.numbers(count);
  std::vector<Index> bodies;
  bodies.reserve(surface.vertices.size());
  for (const Index v : surface.vertices) bodies.push_back(all[static_cast<std::size_t>(v)]);
  return bodies;
}

// A layer that is thicker than a body is long reaches through it.
void refuse_thick_layer(const TetMesh& mesh, const ContactSurface& surface,
                        const std::vector<Index>& body_of, double thickness) {
  std::map<Index, std::pair<Box, Index>> boxes;  // of the bodies, with their first vertices
  for (std::size_t i = 0; i < body_of.size(); ++i) {
    const auto [entry, is_new] = boxes.try_emplace(body_of[i], Box{}, surface.vertices[i]);
    entry->second.first.add(vertex_block(surface.rest, static_cast<Index>(i)));
  }
  for (const auto& [body, each] : boxes) {
    const double length = (each.first.upper - each.first.lower).maxCoeff();
    if (!(thickness > length)) continue;
    throw InputError(fmt::format(
        "The contact of bodies has the thickness {:.4g} m (contact.thickness), but what may touch "
        "of the body with vertex {} is {:.4g} m long only: a layer is a small part of an element "
        "thick, usually a tenth of an edge. Take a much smaller thickness, and check its unit.",
        thickness, mesh.vertex_id(each.second), length));
  }
}

// The surfaces of single bodies at some positions.
class BodySurfaces {
 public:
  BodySurfaces(const ContactSurface& surface, const std::vector<Index>& body_of, const Vector& x)
      : surface_(surface), body_of_(body_of), x_(x) {
    const Index count = *std::max_element(body_of.begin(), body_of.end()) + 1;
    triangles_.resize(static_cast<std::size_t>(count));
    vertices_.resize(static_cast<std::size_t>(count));
    boxes_.resize(static_cast<std::size_t>(count));
    for (Index i = 0; i < x.size() / 3; ++i) {
      vertices_[body(i)].push_back(i);
      boxes_[body(i)].add(vertex_block(x, i));
    }
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      triangles_[body(surface.triangles[t][0])].push_back(t);
    }
  }

  std::size_t body_count() const { return vertices_.size(); }
  const std::vector<Index>& vertices(std::size_t body) const { return vertices_[body]; }
  bool may_meet(std::size_t a, std::size_t b) const {
    return a != b && !vertices_[a].empty() && !vertices_[b].empty() &&
           boxes_[a].widened(0.0).overlaps(boxes_[b]);
  }

  // How far vertex i is inside a body, m; negative outside it, where it is minus the distance.
  double depth(Index i, std::size_t body) const {
    const Vector3 place = vertex_block(x_, i);
    double squared = std::numeric_limits<double>::infinity();
    double angle = 0.0;  // under which the surface is seen from inside; 4 π there, 0 outside
    for (const std::size_t t : triangles_[body]) {
      PairPoints points;
      points.col(0) = place;
      for (int k = 0; k < 3; ++k) {
        points.col(k + 1) = vertex_block(x_, surface_.triangles[t][static_cast<std::size_t>(k)]);
      }
      squared = std::min(squared, pair_distance(PairKind::kPointTriangle, points).squared);
      // The solid angle of a triangle (van Oosterom and Strackee 1983).
      const Vector3 a = points.col(1) - place;
      const Vector3 b = points.col(2) - place;
      const Vector3 c = points.col(3) - place;
      const double la = a.norm();
      const double lb = b.norm();
      const double lc = c.norm();
      angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                                la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    const double distance = std::sqrt(squared);
    return angle > 2.0 * std::numbers::pi ? distance : -distance;
  }

 private:
  std::size_t body(Index i) const {
    return static_cast<std::size_t>(body_of_[static_cast<std::size_t>(i)]);
  }

  const ContactSurface& surface_;
  const std::vector<Index>& body_of_;
  const Vector& x_;
  std::vector<std::vector<std::size_t>> triangles_;
  std::vector<std::vector<Index>> vertices_;
  std::vector<Box> boxes_;
};

}  // namespace

Contact::Unit Contact::Unit::between(const TetMesh& mesh, const BodyContact& bodies) {
  check_number("thickness", bodies.thickness);
  check_number("stiffness", bodies.stiffness);
  check_number("friction", bodies.friction, true);
  check_number("slip speed", bodies.slip_speed);
  Unit unit;
  unit.obstacle.name = "another body";
  unit.obstacle.thickness = bodies.thickness;
  unit.obstacle.stiffness = bodies.stiffness;
  unit.obstacle.friction = bodies.friction;
  unit.obstacle.slip_speed = bodies.slip_speed;
  unit.obstacle.surface = bodies.surface;
  unit.surface = contact_surface(mesh, unit.obstacle);
  unit.body_of = bodies_of(mesh, unit.surface);
  if (!bodies.within_bodies && unit.body_count() < 2) {
    throw InputError(
        "All faces that may touch each other belong to one body, so that contact between bodies "
        "has no effect: take contact.between = \"all\", with which a body touches itself, too, or "
        "leave it out.");
  }
  refuse_thick_layer(mesh, unit.surface, unit.body_of, bodies.thickness);
  unit.law = std::make_shared<SelfContact>(unit.surface, unit.body_of, bodies.within_bodies,
                                           Barrier{bodies.thickness, bodies.stiffness});
  return unit;
}

Index Contact::Unit::body_count() const {
  return static_cast<Index>(std::set<Index>(body_of.begin(), body_of.end()).size());
}

// Where edges of a single body cross its own faces, there is no depth.
std::vector<Contact::Penetration> Contact::Unit::body_penetrations(std::size_t number,
                                                                   const Vector& x) const {
  std::vector<Penetration> found;
  const auto add = [&](Index i, double depth) {
    found.push_back({number, surface.vertices[static_cast<std::size_t>(i)], depth});
  };
  const Index first = law->penetrating_vertex(x);
  if (first < 0 && law->smallest_gap(x) < kTouchShare * obstacle.thickness) {
    Vector gaps;
    law->vertex_gaps(x, gaps);
    for (Index i = 0; i < gaps.size(); ++i) {
      if (gaps[i] < kTouchShare * obstacle.thickness) add(i, 0.0);
    }
    return found;
  }
  // A body may be as a whole inside another one, where nothing crosses.
  const BodySurfaces bodies(surface, body_of, x);
  for (std::size_t a = 0; a < bodies.body_count(); ++a) {
    for (std::size_t b = 0; b < bodies.body_count(); ++b) {
      if (!bodies.may_meet(a, b)) continue;
      const std::size_t before = found.size();
      for (const Index i : bodies.vertices(a)) {
        const double depth = bodies.depth(i, b);
        if (depth > -kTouchShare * obstacle.thickness && (first >= 0 || depth > 0.0)) {
          add(i, depth > kTouchShare * obstacle.thickness ? depth : 0.0);
        }
        // As nothing crosses, all vertices of the body are on the side of the first one.
        if (found.size() == before && first < 0) break;
      }
    }
  }
  if (found.empty() && first >= 0) add(first, std::numeric_limits<double>::quiet_NaN());
  return found;
}

std::vector<Contact::Penetration> Contact::penetrations(const ForcePoint& at) const {
  std::vector<Penetration> found;
  for (std::size_t k = 0; k < units_.size(); ++k) {
    const Unit& unit = units_[k];
    const Vector x = unit.local(at);
    if (unit.is_between_bodies()) {
      const std::vector<Penetration> bodies = unit.body_penetrations(k, x);
      found.insert(found.end(), bodies.begin(), bodies.end());
      continue;
    }
    const Index first = unit.law->penetrating_vertex(x);
    if (first < 0) continue;
    Vector gaps;
    unit.law->vertex_gaps(x, gaps);
    bool any = false;
    for (Index i = 0; i < gaps.size(); ++i) {
      if (gaps[i] > 0.0) continue;
      found.push_back({k, unit.surface.vertices[static_cast<std::size_t>(i)], -gaps[i]});
      any = true;
    }
    if (!any) {
      found.push_back({k, unit.surface.vertices[static_cast<std::size_t>(first)],
                       std::numeric_limits<double>::quiet_NaN()});
    }
  }
  return found;
}

std::string Contact::partner(std::size_t i) const {
  if (i < size()) return fmt::format("the obstacle \"{}\"", units_[i].obstacle.name);
  return between_->within_bodies ? "another part of the surface" : "another body";
}

double Contact::thickness(std::size_t i) const {
  return units_.at(i).obstacle.thickness;
}

double Contact::least_thickness() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Unit& unit : units_) {
    if (!unit.obstacle.removed) least = std::min(least, unit.obstacle.thickness);
  }
  return least;
}

}  // namespace tetraction
