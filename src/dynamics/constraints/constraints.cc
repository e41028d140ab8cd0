#include "tetraction/dynamics/constraints/constraints.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/decompositions.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Orthonormal directions in which motion is forbidden, and a point that satisfies them.
class Normals {
 public:
  explicit Normals(const Vector3& point) : point_(point) {}

  // Adds the condition n·x = n·target. Returns false if it contradicts the earlier ones.
  bool add(const Vector3& n, const Vector3& target, double size) {
    constexpr double kParallel = 1e-9;
    Vector3 rest = n;
    for (int i = 0; i < count_; ++i) rest -= n.dot(normals_.col(i)) * normals_.col(i);
    const double gap = n.dot(target - point_);
    if (rest.norm() < kParallel) return std::abs(gap) <= kParallel * size;
    rest.normalize();
    if (gap != 0.0) point_ += gap / rest.dot(n) * rest;
    normals_.col(count_++) = rest;
    return true;
  }

  const Vector3& point() const { return point_; }

  // The remaining directions; they are unit vectors of the axes where possible.
  VertexFreedom freedom() const {
    VertexFreedom freedom;
    freedom.count = 3 - count_;
    Matrix3 taken = normals_;
    for (int filled = count_; filled < 3; ++filled) {
      Vector3 best = Vector3::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        Vector3 candidate = Vector3::Unit(axis);
        for (int i = 0; i < filled; ++i) {
          candidate -= taken.col(i)[axis] * taken.col(i);
        }
        if (candidate.norm() > best.norm() + 1e-12) best = candidate;
      }
      taken.col(filled) = best.normalized();
      freedom.basis.col(filled - count_) = taken.col(filled);
    }
    return freedom;
  }

 private:
  int count_ = 0;
  Matrix3 normals_ = Matrix3::Zero();
  Vector3 point_;
};

// Whether the component `axis` of a vertex has the same motion in both, at all times.
bool same_motion(const PrescribedVertices& a, Index i, const PrescribedVertices& b, Index j,
                 Index axis, double size) {
  constexpr double kTolerance = 1e-12;
  const double time = std::max(a.motion.since, b.motion.since);
  const Vector3 x = a.motion.position(a.start.col(i), time);
  const Vector3 y = b.motion.position(b.start.col(j), time);
  if (std::abs(x[axis] - y[axis]) > kTolerance * std::max(size, std::abs(x[axis]))) return false;
  const auto same = [](const auto& one, const auto& other) {
    return one == other || (one && other && *one == *other);
  };
  if (!same(a.motion.velocity_amplitude, b.motion.velocity_amplitude)) return false;
  // The component of an offset that changes in time.
  const auto offset = [axis](const PrescribedMotion& motion) {
    return motion.offset_amplitude ? motion.offset[axis] : 0.0;
  };
  if (offset(a.motion) != offset(b.motion)) return false;
  if (offset(a.motion) != 0.0 && !same(a.motion.offset_amplitude, b.motion.offset_amplitude)) {
    return false;
  }
  // A rotation does not change the component along its axis, nor a vertex on its axis.
  const auto turns = [&](const PrescribedVertices& held, const Vector3& position) {
    const Vector3& angular = held.motion.angular_velocity;
    if (angular.isZero(0.0)) return false;
    const Vector3 center = held.motion.center + held.motion.elapsed(time) * held.motion.velocity;
    const Vector3 rate = angular.normalized().cross(position - center);
    const double off =
        std::max(std::abs(rate[axis]), std::abs(angular.cross(rate)[axis]) / angular.norm());
    return off > kTolerance * size;
  };
  const bool a_turns = turns(a, x);
  if (a_turns != turns(b, y)) return false;
  if (!a_turns) return a.motion.velocity[axis] == b.motion.velocity[axis];
  if (a.motion.velocity != b.motion.velocity ||
      a.motion.angular_velocity != b.motion.angular_velocity) {
    return false;
  }
  const Vector3 rate = a.motion.rate(a.start.col(i), time);
  const Vector3 other = b.motion.rate(b.start.col(j), time);
  const double speed = a.motion.velocity.norm() + size * a.motion.angular_velocity.norm();
  return (rate - other).cwiseAbs().maxCoeff() <= kTolerance * speed;
}

// Gives names to constraints without one, for messages.
void name_all(ConstraintList& list, const TetMesh& mesh) {
  const auto name = [](auto& constraints, const char* kind) {
    for (auto& constraint : constraints) {
      if (constraint.name.empty()) constraint.name = kind;
    }
  };
  name(list.held, "a fix");
  name(list.guided, "a plane or line");
  name(list.handles, "a rigid handle");
  for (FixedDistance& distance : list.distances) {
    if (!distance.name.empty()) continue;
    distance.name = fmt::format("the distance of vertices {} and {}", mesh.vertex_id(distance.a),
                                mesh.vertex_id(distance.b));
  }
}

}  // namespace

Constraints::Constraints(Index vertex_count) : coordinates_(vertex_count) {}

Constraints::Constraints(ConstraintList list, const TetMesh& mesh, const Vector& mass)
    : list_(std::move(list)), coordinates_(mesh.vertex_count()), mass_(mass) {
  name_all(list_, mesh);
  std::map<Index, Prescribed> vertices;
  add_held(vertices, mesh);
  add_guided(vertices, mesh);
  std::vector<AffineSet> sets = add_handles(vertices, mesh);
  add_distances(mesh);

  std::map<Index, VertexFreedom> freedoms;
  for (const auto& [v, vertex] : vertices) {
    freedoms[v] = vertex.freedom;
    prescribed_.push_back(vertex);
  }
  coordinates_ = FreeCoordinates(mesh.vertex_count(), std::move(freedoms), std::move(sets));
  make_selector();
}

void Constraints::add_held(std::map<Index, Prescribed>& vertices, const TetMesh& mesh) {
  const double size = mesh.rest_positions().cwiseAbs().maxCoeff();
  springs_ = PenaltySprings(list_.held, mesh.vertex_count());
  for (std::size_t h = 0; h < list_.held.size(); ++h) {
    const PrescribedVertices& held = list_.held[h];
    if (held.penalty > 0.0) continue;  // a spring
    moving_ = moving_ || !held.motion.at_rest();
    for (std::size_t place = 0; place < held.vertices.size(); ++place) {
      const Index v = held.vertices[place];
      Prescribed& vertex = vertices[v];
      vertex.vertex = v;
      for (std::size_t i = 0; i < 3; ++i) {
        if (!held.components[i]) continue;
        if (vertex.held[i] >= 0) {
          const PrescribedVertices& other = this->held(vertex.held[i]);
          if (!same_motion(other, vertex.place[i], held, static_cast<Index>(place),
                           static_cast<Index>(i), size)) {
            throw InputError(fmt::format(
                "{}: vertex {} is fixed twice, to different targets (also by {}). Let only one of "
                "them select it.",
                held.name, mesh.vertex_id(v), other.name));
          }
          continue;
        }
        vertex.held[i] = static_cast<Index>(h);
        vertex.place[i] = static_cast<Index>(place);
      }
    }
  }
  for (auto& [v, vertex] : vertices) {
    vertex.freedom.count = 0;
    for (int i = 0; i < 3; ++i) {
      if (vertex.held[static_cast<std::size_t>(i)] >= 0) continue;
      vertex.freedom.basis.col(vertex.freedom.count++) = Vector3::Unit(i);
    }
  }
}

void Constraints::add_guided(std::map<Index, Prescribed>& vertices, const TetMesh& mesh) const {
  const double extent = mesh.rest_positions().cwiseAbs().maxCoeff();
  std::map<Index, Normals> normals;
  for (const GuidedVertices& guide : list_.guided) {
    for (std::size_t place = 0; place < guide.vertices.size(); ++place) {
      const Index v = guide.vertices[place];
      Prescribed& vertex = vertices[v];
      vertex.vertex = v;
      const Vector3 through = guide.points.col(static_cast<Index>(place));
      const double size = std::max(extent, through.cwiseAbs().maxCoeff());
      auto found = normals.find(v);
      if (found == normals.end()) {
        found = normals.emplace(v, Normals(through)).first;
        for (int i = 0; i < 3; ++i) {
          const Index h = vertex.held[static_cast<std::size_t>(i)];
          if (h < 0) continue;
          if (!held(h).motion.at_rest()) {
            throw InputError(fmt::format(
                "{}: vertex {} is already moved by {}. A vertex that moves as prescribed cannot be "
                "guided as well: let only one of them select it.",
                guide.name, mesh.vertex_id(v), held(h).name));
          }
          const Vector3 target = held(h).start.col(vertex.place[static_cast<std::size_t>(i)]);
          found->second.add(Vector3::Unit(i), target, size);
        }
      }
      // This guide forbids all directions that are orthogonal to its own.
      const Matrix across = singular_vectors(guide.directions).u;
      for (Index k = guide.directions.cols(); k < 3; ++k) {
        if (found->second.add(across.col(k), through, size)) continue;
        throw InputError(fmt::format(
            "{}: vertex {} cannot be there and obey the other constraints on it, which hold it "
            "elsewhere. Let only one of them select it, or let them meet.",
            guide.name, mesh.vertex_id(v)));
      }
      vertex.freedom = found->second.freedom();
      vertex.point = found->second.point();
      vertex.guided = true;
    }
  }
}

}  // namespace tetraction
