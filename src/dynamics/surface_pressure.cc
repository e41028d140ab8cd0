#include "tetraction/dynamics/surface_pressure.h"

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <utility>

#include "core/decompositions.h"

#include "load_factor.h"
#include "rigid_motions.h"

namespace tetraction {
namespace {

Matrix3 cross_matrix(const Vector3& a) {
  Matrix3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

// The edges of the triangles that have no opposite edge.
std::vector<std::array<Index, 2>> rim_of(const std::vector<std::array<Index, 3>>& triangles) {
  std::set<std::array<Index, 2>> edges;
  for (const auto& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.insert({triangle[i], triangle[(i + 1) % 3]});
  }
  std::vector<std::array<Index, 2>> rim;
  for (const auto& edge : edges) {
    if (!edges.contains({edge[1], edge[0]})) rim.push_back(edge);
  }
  return rim;
}

// The point nearest to `center` that lies in the planes in which vertices of the rim are held.
Vector3 origin_of(const std::vector<std::array<Index, 2>>& rim, const Vector3& center,
                  const Vector& rest, const FreeCoordinates& coordinates) {
  Matrix3 normals = Matrix3::Zero();
  Vector3 right = Vector3::Zero();
  for (const auto& edge : rim) {
    const FreeCoordinates::VertexMap map = coordinates.map(edge[0]);
    if (map.count != 2 || coordinates.set_of(edge[0]) >= 0) continue;
    const Vector3 normal = Vector3(map.columns.col(0)).cross(Vector3(map.columns.col(1)));
    normals += normal * normal.transpose();
    right += normal * normal.dot(vertex_block(rest, edge[0]) - center);
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

// p at `at`, Pa.
double pressure_at(const PressureLoad& load, const ForcePoint& at) {
  return load.value * factor_at(load.history, at);
}

// V_o at positions x.
double cone_volume(const PressureLoad& load, const Vector3& o, const Vector& x) {
  double volume = 0.0;
  for (const auto& [a, b, c] : load.triangles) {
    volume += (vertex_block(x, a) - o)
                  .dot((vertex_block(x, b) - o).cross(Vector3(vertex_block(x, c) - o))) /
              6.0;
  }
  return volume;
}

// V_o(to) − V_o(from) without cancellation of the volumes.
double cone_volume_change(const PressureLoad& load, const Vector3& o, const Vector& from,
                          const Vector& to) {
  double change = 0.0;
  for (const auto& [a, b, c] : load.triangles) {
    const Vector3 a0 = vertex_block(from, a) - o;
    const Vector3 b0 = vertex_block(from, b) - o;
    const Vector3 b1 = vertex_block(to, b) - o;
    const Vector3 c1 = vertex_block(to, c) - o;
    const Vector3 da = vertex_block(to, a) - vertex_block(from, a);
    const Vector3 db = vertex_block(to, b) - vertex_block(from, b);
    const Vector3 dc = vertex_block(to, c) - vertex_block(from, c);
    change += (da.dot(b1.cross(c1)) + a0.dot(db.cross(c1)) + a0.dot(b0.cross(dc))) / 6.0;
  }
  return change;
}

}  // namespace

SurfacePressure::SurfacePressure(std::vector<PressureLoad> loads, const Vector& rest,
                                 const FreeCoordinates& coordinates)
    : loads_(std::move(loads)) {
  for (const PressureLoad& load : loads_) {
    Surface surface;
    surface.rim = rim_of(load.triangles);
    Vector3 center = Vector3::Zero();
    for (const auto& triangle : load.triangles) {
      for (const Index v : triangle) center += vertex_block(rest, v);
    }
    center /= 3.0 * static_cast<double>(load.triangles.size());
    surface.origin = origin_of(surface.rim, center, rest, coordinates);
    surfaces_.push_back(std::move(surface));
  }
}

bool SurfacePressure::has_load() const {
  for (const Surface& surface : surfaces_) {
    if (!surface.rim.empty()) return true;
  }
  return false;
}

double SurfacePressure::energy(const ForcePoint& at) const {
  double energy = 0.0;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    energy += pressure_at(loads_[i], at) * cone_volume(loads_[i], surfaces_[i].origin, at.position);
  }
  return energy;
}

double SurfacePressure::volume_change(std::size_t load, const Vector& from,
                                      const Vector& to) const {
  return cone_volume_change(loads_[load], surfaces_[load].origin, from, to);
}

double SurfacePressure::energy_change(const ForcePoint& from, const ForcePoint& to) const {
  double change = 0.0;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double before = pressure_at(loads_[i], from);
    const double after = pressure_at(loads_[i], to);
    change += after * volume_change(i, from.position, to.position);
    if (after != before) {
      change += (after - before) * cone_volume(loads_[i], surfaces_[i].origin, from.position);
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
    for (const auto& [a, b, c] : loads_[i].triangles) {
      const Vector3 x = vertex_block(at.position, a);
      const Vector3 area =
          (vertex_block(at.position, b) - x).cross(Vector3(vertex_block(at.position, c) - x));
      const Vector3 share = pressure / 6.0 * area;
      for (const Index v : {a, b, c}) vertex_block(gradient, v) += share;
    }
    const Vector3& o = surfaces_[i].origin;
    for (const auto& [u, w] : surfaces_[i].rim) {
      const Vector3 share =
          pressure / 6.0 *
          (vertex_block(at.position, u) - o).cross(Vector3(vertex_block(at.position, w) - o));
      vertex_block(gradient, u) -= share;
      vertex_block(gradient, w) -= share;
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
    for (const auto& triangle : loads_[i].triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        // a·(b × c): the derivative b × c with respect to a has the derivative −[c]× with respect
        // to b.
        const Vector3 c = vertex_block(at.position, triangle[(k + 2) % 3]) - o;
        hessian.add_pair(triangle[k], triangle[(k + 1) % 3], -pressure / 6.0 * cross_matrix(c));
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
    if (!surfaces_[i].rim.empty()) {
      for (const auto& [a, b, c] : loads_[i].triangles) {
        const Vector3 da = vertex_block(half, a);
        const Vector3 db = vertex_block(half, b);
        const Vector3 dc = vertex_block(half, c);
        vertex_block(gradient, a) += pressure / 18.0 * db.cross(dc);
        vertex_block(gradient, b) += pressure / 18.0 * dc.cross(da);
        vertex_block(gradient, c) += pressure / 18.0 * da.cross(db);
      }
      continue;
    }
    std::vector<bool> acts(static_cast<std::size_t>(from.mass.size()));
    for (const auto& triangle : loads_[i].triangles) {
      for (const Index v : triangle) acts[static_cast<std::size_t>(v)] = true;
    }
    const Vector along = without_rigid_motion(middle, half, acts);
    const double square = along.squaredNorm();
    if (!(square > 0.0)) continue;
    // V_0(Δq/2). It vanishes for the rigid part ω × x + t of Δq/2, whose map is singular.
    const Vector rigid = half - along;
    const double volume = cone_volume_change(loads_[i], Vector3::Zero(), rigid, half);
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
            volume_change(i, from.position, to.position);
  }
  return work;
}

void SurfacePressure::add_load(const ForcePoint& at, Vector& force) const {
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    const Vector3& o = surfaces_[i].origin;
    for (const auto& [u, w] : surfaces_[i].rim) {
      const Vector3 share =
          -pressure / 6.0 *
          (vertex_block(at.position, u) - o).cross(Vector3(vertex_block(at.position, w) - o));
      vertex_block(force, u) += share;
      vertex_block(force, w) += share;
    }
  }
}

void SurfacePressure::add_load_stiffness(const ForcePoint& at, HessianBlocks& stiffness) const {
  // The force −p (u − o) × (w − o)/6 at both ends of u → w has minus the derivatives −p [w − o]×/6
  // with respect to u and p [u − o]×/6 with respect to w. The blocks of a vertex with itself are
  // skew-symmetric; what remains couples the two ends.
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const double pressure = pressure_at(loads_[i], at);
    if (pressure == 0.0) continue;
    const Vector3& o = surfaces_[i].origin;
    for (const auto& [u, w] : surfaces_[i].rim) {
      const Vector3 arms = (vertex_block(at.position, u) - o) + (vertex_block(at.position, w) - o);
      stiffness.add_pair(u, w, pressure / 12.0 * cross_matrix(arms));
    }
  }
}

}  // namespace tetraction
