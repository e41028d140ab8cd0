#include "tetraction/dynamics/terms/surface_pressure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/decompositions.h"

#include "dynamics/constraints/rigid_motions.h"
#include "load_factor.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

Matrix3 cross_matrix(const Vector3& a) {
  Matrix3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

// The volume of the cones to a quadratic face, ⅓ ∫ x·(∂x/∂ξ × ∂x/∂η) dξ dη with x = Σ N_a x_a, is a sum
// over triples of its nodes: Σ w x_a·(x_b × x_c)/6. These are 15 w.
struct NodeTriple {
  std::array<std::size_t, 3> nodes;
  double weight;
};
constexpr std::array<NodeTriple, 20> kFaceTriples{{
    {{0, 1, 2}, 2},  {{0, 1, 3}, 3},  {{0, 1, 4}, -5}, {{0, 1, 5}, -5},  {{0, 2, 3}, 5},
    {{0, 2, 4}, 5},  {{0, 2, 5}, -3}, {{0, 3, 4}, 4},  {{0, 3, 5}, 24},  {{0, 4, 5}, 4},
    {{1, 2, 3}, -5}, {{1, 2, 4}, 3},  {{1, 2, 5}, -5}, {{1, 3, 4}, -24}, {{1, 3, 5}, -4},
    {{1, 4, 5}, 4},  {{2, 3, 4}, 4},  {{2, 3, 5}, -4}, {{2, 4, 5}, -24}, {{3, 4, 5}, 16},
}};

// Along the edge of a rim with the nodes u, v and m in its middle, the force on node a is
// Σ w x_b × x_c/6 over the pairs (b, c) of nodes, with w = 2 ∫ N_a (N_b N_c' − N_c N_b') ds. The volume
// alone has the sum over a of these weights, half of it at b and half at c. These are 15 w.
struct RimProduct {
  std::size_t from, to;  // among u, v, m
  double weight;         // of the volume
  std::array<double, 3> node_weights;
};
constexpr std::array<RimProduct, 3> kRimProducts{{
    {0, 1, -5.0, {-3.0, -3.0, -4.0}},
    {0, 2, 20.0, {18.0, -2.0, 24.0}},
    {2, 1, 20.0, {-2.0, 18.0, 24.0}},
}};
constexpr double kDivisor = 15.0;

using Columns = decltype(FreeCoordinates::VertexMap::columns);

// Whether the forces Σ w (u − o) × (v − o)/6 of a rim do no work: they have no component in a free direction of
// their vertices, wherever u and v may be. They are polynomials in the motions of the vertices along their
// free directions, each coefficient of which must vanish.
template <class RimTerms>
bool rests_on_supports(const RimTerms& terms, const Vector3& o, const Vector& rest,
                       const FreeCoordinates& coordinates) {
  constexpr double kRoundOff = 1e-9;
  struct Force {
    Vector3 at_rest = Vector3::Zero();
    std::map<Index, Vector3> arms;                       // of u: Σ w (v − o)
    std::map<std::pair<Index, Index>, double> products;  // of u and v: Σ w
    double size = 0.0;
    double length = 0.0;
  };
  std::map<Index, Force> forces;
  for (const auto& [vertex, u, v, weight] : terms) {
    if (coordinates.set_of(vertex) >= 0) return false;
    if (coordinates.map(vertex).count == 0) continue;
    Force& force = forces[vertex];
    const Vector3 arm_u = vertex_block(rest, u) - o;
    const Vector3 arm_v = vertex_block(rest, v) - o;
    force.at_rest += weight * arm_u.cross(arm_v);
    force.arms.try_emplace(u, Vector3::Zero()).first->second += weight * arm_v;
    force.arms.try_emplace(v, Vector3::Zero()).first->second -= weight * arm_u;
    force.products[{std::min(u, v), std::max(u, v)}] += u < v ? weight : -weight;
    force.size = std::max(force.size, std::abs(weight));
    force.length = std::max({force.length, arm_u.norm(), arm_v.norm()});
  }
  for (const auto& [vertex, force] : forces) {
    const Columns free = coordinates.map(vertex).columns;
    const double limit = kRoundOff * force.size;
    const auto acts = [&](const Vector3& part, double scale) {
      double most = 0.0;
      for (Index i = 0; i < free.cols(); ++i)
        most = std::max(most, std::abs(free.col(i).dot(part)));
      return most > limit * scale;
    };
    if (acts(force.at_rest, force.length * force.length)) return false;
    for (const auto& [u, arm] : force.arms) {
      const Columns directions = coordinates.map(u).columns;
      for (Index i = 0; i < directions.cols(); ++i) {
        if (acts(Vector3(directions.col(i)).cross(arm), force.length)) return false;
      }
    }
    for (const auto& [pair, weight] : force.products) {
      const Columns of_u = coordinates.map(pair.first).columns;
      const Columns of_v = coordinates.map(pair.second).columns;
      for (Index i = 0; i < of_u.cols(); ++i) {
        for (Index j = 0; j < of_v.cols(); ++j) {
          if (acts(weight * Vector3(of_u.col(i)).cross(Vector3(of_v.col(j))), 1.0)) return false;
        }
      }
    }
  }
  return true;
}

// p at `at`, Pa.
double pressure_at(const PressureLoad& load, const ForcePoint& at) {
  return load.value * factor_at(load.history, at);
}

}  // namespace

PressureLoad pressure_on(const TetMesh& mesh, const std::vector<std::array<Index, 3>>& faces) {
  PressureLoad load;
  const EdgeVertices edges(mesh);
  for (const auto& face : faces) {
    const std::vector<Index> v = edges.of_face(face);
    if (v.size() == 6) {
      load.quadratic_faces.push_back({v[0], v[1], v[2], v[3], v[4], v[5]});
    } else {
      load.triangles.push_back(face);
    }
  }
  return load;
}

std::vector<SurfacePressure::Triangle> SurfacePressure::triangles_of(const PressureLoad& load) {
  std::vector<Triangle> triangles;
  for (const auto& triangle : load.triangles) triangles.push_back({triangle, 1.0});
  for (const auto& face : load.quadratic_faces) {
    for (const auto& [nodes, weight] : kFaceTriples) {
      triangles.push_back({{face[nodes[0]], face[nodes[1]], face[nodes[2]]}, weight / kDivisor});
    }
  }
  return triangles;
}

// The edges of the rim are those without an opposite edge.
void SurfacePressure::add_rim(const PressureLoad& load, Surface& surface) {
  struct Edge {
    int count = 0;  // of the directed edges from the smaller to the larger number, minus the others
    Index middle = -1;  // of a quadratic element
  };
  std::map<std::array<Index, 2>, Edge> edges;
  const auto add = [&](Index from, Index to, Index middle) {
    Edge& edge = edges[{std::min(from, to), std::max(from, to)}];
    edge.count += from < to ? 1 : -1;
    edge.middle = middle;
  };
  for (const auto& triangle : load.triangles) {
    for (std::size_t i = 0; i < 3; ++i) add(triangle[i], triangle[(i + 1) % 3], -1);
  }
  for (const auto& face : load.quadratic_faces) {
    for (std::size_t i = 0; i < 3; ++i) add(face[i], face[(i + 1) % 3], face[i + 3]);
  }
  for (const auto& [ends, edge] : edges) {
    const double count = edge.count;
    const auto& [u, v] = ends;
    if (edge.count == 0) continue;
    if (edge.middle < 0) {
      for (const Index vertex : ends) {
        surface.of_gradient.push_back({vertex, u, v, count});
        surface.of_load.push_back({vertex, u, v, count});
      }
      continue;
    }
    const std::array<Index, 3> nodes{u, v, edge.middle};
    for (const RimProduct& product : kRimProducts) {
      const Index from = nodes[product.from];
      const Index to = nodes[product.to];
      for (const Index vertex : {from, to}) {
        surface.of_gradient.push_back({vertex, from, to, count * product.weight / kDivisor});
      }
      for (std::size_t a = 0; a < 3; ++a) {
        surface.of_load.push_back({nodes[a], from, to, count * product.node_weights[a] / kDivisor});
      }
    }
  }
}

// The point nearest to the center of the surface that lies in the planes in which vertices of the rim
// are held.
Vector3 SurfacePressure::origin_of(const Surface& surface, const Vector& rest,
                                   const FreeCoordinates& coordinates) {
  Vector3 center = Vector3::Zero();
  for (const auto& [vertices, weight] : surface.triangles) {
    for (const Index v : vertices) center += vertex_block(rest, v);
  }
  center /= 3.0 * static_cast<double>(surface.triangles.size());
  std::set<Index> of_rim;
  for (const RimTerm& term : surface.of_load) of_rim.insert(term.vertex);
  Matrix3 normals = Matrix3::Zero();
  Vector3 right = Vector3::Zero();
  for (const Index v : of_rim) {
    const FreeCoordinates::VertexMap map = coordinates.map(v);
    if (map.count != 2 || coordinates.set_of(v) >= 0) continue;
    const Vector3 normal = Vector3(map.columns.col(0)).cross(Vector3(map.columns.col(1)));
    normals += normal * normal.transpose();
    right += normal * normal.dot(vertex_block(rest, v) - center);
  }
  const SymmetricEigen3 eigen = symmetric_eigen(normals);
  Vector3 origin = center;
  for (int i = 0; i < 3; ++i) {
    if (eigen.values[i] <= 1e-9 * eigen.values[2]) continue;
    const Vector3 direction = eigen.vectors.col(i);
    origin += direction.dot(right) / eigen.values[i] * direction;
  }
  return origin;
}

double SurfacePressure::cone_volume(const Surface& surface, const Vector3& o, const Vector& x) {
  double volume = 0.0;
  for (const auto& [v, weight] : surface.triangles) {
    volume += weight / 6.0 *
              (vertex_block(x, v[0]) - o)
                  .dot((vertex_block(x, v[1]) - o).cross(Vector3(vertex_block(x, v[2]) - o)));
  }
  return volume;
}

double SurfacePressure::cone_volume_change(const Surface& surface, const Vector3& o,
                                           const Vector& from, const Vector& to) {
  double change = 0.0;
  for (const auto& [v, weight] : surface.triangles) {
    const auto& [a, b, c] = v;
    const Vector3 a0 = vertex_block(from, a) - o;
    const Vector3 b0 = vertex_block(from, b) - o;
    const Vector3 b1 = vertex_block(to, b) - o;
    const Vector3 c1 = vertex_block(to, c) - o;
    const Vector3 da = vertex_block(to, a) - vertex_block(from, a);
    const Vector3 db = vertex_block(to, b) - vertex_block(from, b);
    const Vector3 dc = vertex_block(to, c) - vertex_block(from, c);
    change += weight / 6.0 * (da.dot(b1.cross(c1)) + a0.dot(db.cross(c1)) + a0.dot(b0.cross(dc)));
  }
  return change;
}

Vector3 SurfacePressure::rim_vector(const RimTerm& term, const Vector3& o, const Vector& x) {
  return term.weight / 6.0 *
         (vertex_block(x, term.u) - o).cross(Vector3(vertex_block(x, term.v) - o));
}

SurfacePressure::SurfacePressure(std::vector<PressureLoad> loads, const Vector& rest,
                                 const FreeCoordinates& coordinates)
    : loads_(std::move(loads)) {
  for (const PressureLoad& load : loads_) {
    Surface surface;
    surface.triangles = triangles_of(load);
    add_rim(load, surface);
    surface.origin = origin_of(surface, rest, coordinates);
    if (rests_on_supports(surface.of_load, surface.origin, rest, coordinates)) {
      // The whole force is taken for the gradient, which is right in all free directions. In the others it acts on
      // supports.
      for (RimTerm term : surface.of_load) {
        term.weight = -term.weight;
        surface.of_gradient.push_back(term);
      }
      surface.of_load.clear();
    }
    surfaces_.push_back(std::move(surface));
  }
}

bool SurfacePressure::has_load() const {
  for (const Surface& surface : surfaces_) {
    if (!surface.of_load.empty()) return true;
  }
  return false;
}

double SurfacePressure::energy(const ForcePoint& at) const {
  double energy = 0.0;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    energy +=
        pressure_at(loads_[i], at) * cone_volume(surfaces_[i], surfaces_[i].origin, at.position);
  }
  return energy;
}

double SurfacePressure::energy_change(const ForcePoint& from, const ForcePoint& to) const {
  double change = 0.0;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double before = pressure_at(loads_[i], from);
    const double after = pressure_at(loads_[i], to);
    change +=
        after * cone_volume_change(surfaces_[i], surfaces_[i].origin, from.position, to.position);
    if (after != before) {
      change += (after - before) * cone_volume(surfaces_[i], surfaces_[i].origin, from.position);
    }
  }
  return change;
}

void SurfacePressure::add_gradient(const ForcePoint& at, Vector& gradient) const {
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    if (pressure == 0.0) continue;
    // The forces of the triangles themselves, whose sum is zero over a closed surface, and minus
    // those of the rim.
    for (const auto& [vertices, weight] : surfaces_[i].triangles) {
      const auto& [a, b, c] = vertices;
      const Vector3 x = vertex_block(at.position, a);
      const Vector3 area =
          (vertex_block(at.position, b) - x).cross(Vector3(vertex_block(at.position, c) - x));
      const Vector3 share = pressure * weight / 6.0 * area;
      for (const Index v : vertices) vertex_block(gradient, v) += share;
    }
    const Vector3& o = surfaces_[i].origin;
    for (const RimTerm& term : surfaces_[i].of_gradient) {
      vertex_block(gradient, term.vertex) -= pressure * rim_vector(term, o, at.position);
    }
  }
}

void SurfacePressure::add_hessian(const ForcePoint& at, HessianForm form,
                                  HessianBlocks& hessian) const {
  // The Hessian of a volume has as many negative as positive eigenvalues. The positive semidefinite
  // matrix that stands for it is zero: the stiffness of the body is far larger.
  if (form == HessianForm::kConvex) return;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    if (pressure == 0.0) continue;
    const Vector3& o = surfaces_[i].origin;
    for (const auto& [v, weight] : surfaces_[i].triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        // a·(b × c): the derivative b × c with respect to a has the derivative −[c]× with respect
        // to b.
        const Vector3 c = vertex_block(at.position, v[(k + 2) % 3]) - o;
        hessian.add_pair(v[k], v[(k + 1) % 3], -pressure * weight / 6.0 * cross_matrix(c));
      }
    }
  }
}

void SurfacePressure::add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                            Vector& gradient) const {
  const TimeSpan span{from.time, to.time};
  const Vector middle = 0.5 * (from.position + to.position);
  const Vector half = 0.5 * (to.position - from.position);
  const ForcePoint at{from.mass, middle, 0.5 * (from.time + to.time), span};
  add_gradient(at, gradient);
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    if (pressure == 0.0) continue;
    if (!surfaces_[i].of_gradient.empty()) {  // it has a rim
      for (const auto& [vertices, weight] : surfaces_[i].triangles) {
        const auto& [a, b, c] = vertices;
        const double factor = pressure * weight / 18.0;
        const Vector3 da = vertex_block(half, a);
        const Vector3 db = vertex_block(half, b);
        const Vector3 dc = vertex_block(half, c);
        vertex_block(gradient, a) += factor * db.cross(dc);
        vertex_block(gradient, b) += factor * dc.cross(da);
        vertex_block(gradient, c) += factor * da.cross(db);
      }
      continue;
    }
    std::vector<bool> acts(static_cast<std::size_t>(from.mass.size()));
    for (const auto& [vertices, weight] : surfaces_[i].triangles) {
      for (const Index v : vertices) acts[static_cast<std::size_t>(v)] = true;
    }
    const Vector along = without_rigid_motion(middle, half, acts);
    const double square = along.squaredNorm();
    if (!(square > 0.0)) continue;
    // V_0(Δq/2). It vanishes for the rigid part ω × x + t of Δq/2, whose map is singular.
    const Vector rigid = half - along;
    const double volume = cone_volume_change(surfaces_[i], Vector3::Zero(), rigid, half);
    gradient += pressure * volume / square * along;
  }
}

double SurfacePressure::driven_work(const ForcePoint& from, const ForcePoint& to) const {
  // The pressure of the step does the work −p (V(to) − V(from)). What is not a decrease of U is
  // driven work.
  const TimeSpan step{from.time, to.time};
  double work = energy_change(from, to);
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    work -= loads_[i].value * loads_[i].history.mean(step) *
            cone_volume_change(surfaces_[i], surfaces_[i].origin, from.position, to.position);
  }
  return work;
}

void SurfacePressure::add_load(const ForcePoint& at, Vector& force) const {
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    for (const RimTerm& term : surfaces_[i].of_load) {
      vertex_block(force, term.vertex) -=
          pressure * rim_vector(term, surfaces_[i].origin, at.position);
    }
  }
}

void SurfacePressure::add_load_stiffness(const ForcePoint& at, LoadStiffness& stiffness) const {
  // The force −p w (u − o) × (v − o)/6 at a vertex has minus the derivatives −p w [v − o]×/6 with
  // respect to u and p w [u − o]×/6 with respect to v.
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    if (pressure == 0.0) continue;
    const Vector3& o = surfaces_[i].origin;
    for (const auto& [vertex, u, v, weight] : surfaces_[i].of_load) {
      const double factor = pressure * weight / 6.0;
      const auto arm = [&](Index end) -> Vector3 { return vertex_block(at.position, end) - o; };
      stiffness.add(vertex, u, -factor * cross_matrix(arm(v)));
      stiffness.add(vertex, v, factor * cross_matrix(arm(u)));
    }
  }
}

}  // namespace tetraction
