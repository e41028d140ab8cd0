#include "tetraction/dynamics/constraints.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::int64_t id_of(const TetMesh& mesh, Index vertex) {
  return mesh.vertex_id(vertex);
}

Matrix3 rotation(const Vector3& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0.0) return Matrix3::Identity();
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

// Orthonormal directions that motion is forbidden in, and a point that obeys them.
class Normals {
 public:
  explicit Normals(const Vector3& point) : point_(point) {}

  // n·x = n·target. Returns false if that contradicts the directions before it.
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

  // The directions that are left, unit vectors of the axes where these are among them.
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

bool same_motion(const HeldVertices& a, Index i, const HeldVertices& b, Index j, int axis) {
  constexpr double kTolerance = 1e-12;
  const double time = std::max(a.motion.since, b.motion.since);
  const Vector3 x = a.motion.position(a.start.col(i), time);
  const Vector3 y = b.motion.position(b.start.col(j), time);
  const bool both_rest = a.motion.at_rest() && b.motion.at_rest();
  const bool same_rate = a.motion.velocity == b.motion.velocity &&
                         a.motion.angular_velocity.isZero(0.0) &&
                         b.motion.angular_velocity.isZero(0.0);
  return std::abs(x[axis] - y[axis]) <= kTolerance * std::abs(x[axis]) && (both_rest || same_rate);
}

}  // namespace

Vector3 PrescribedMotion::position(const Vector3& start, double time) const {
  if (at_rest()) return start;
  const double tau = time - since;
  if (angular_velocity.isZero(0.0)) return start + tau * velocity;
  return center + tau * velocity + rotation(tau * angular_velocity) * (start - center);
}

Vector3 PrescribedMotion::rate(const Vector3& start, double time) const {
  if (angular_velocity.isZero(0.0)) return velocity;
  const double tau = time - since;
  return velocity + angular_velocity.cross(rotation(tau * angular_velocity) * (start - center));
}

HeldVertices hold_at_rest(const TetMesh& mesh, std::vector<Index> vertices, std::string name) {
  HeldVertices held;
  held.start.resize(3, static_cast<Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    held.start.col(static_cast<Index>(i)) = mesh.vertices[static_cast<std::size_t>(vertices[i])];
  }
  held.vertices = std::move(vertices);
  held.name = std::move(name);
  return held;
}

Constraints::Constraints(Index vertex_count) : coordinates_(vertex_count) {}

Constraints::Constraints(ConstraintList list, const TetMesh& mesh, const Vector& mass)
    : list_(std::move(list)), coordinates_(mesh.vertex_count()), mass_(mass) {
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
  if (coordinates_.count() == 0) {
    throw InputError(
        "Every vertex is fixed: there is nothing left to move. Let [[fix]] select fewer vertices.");
  }
  make_selector();
}

void Constraints::add_held(std::map<Index, Prescribed>& vertices, const TetMesh& mesh) {
  spring_stiffness_ = Vector::Zero(3 * mesh.vertex_count());
  for (std::size_t h = 0; h < list_.held.size(); ++h) {
    const HeldVertices& held = list_.held[h];
    if (held.penalty > 0.0) {
      springs_.push_back(static_cast<Index>(h));
      for (const Index v : held.vertices) {
        for (int i = 0; i < 3; ++i) {
          if (!held.components[static_cast<std::size_t>(i)]) continue;
          spring_stiffness_[3 * v + i] += 2.0 * held.penalty;
        }
      }
      continue;
    }
    moving_ = moving_ || !held.motion.at_rest();
    for (std::size_t place = 0; place < held.vertices.size(); ++place) {
      const Index v = held.vertices[place];
      Prescribed& vertex = vertices[v];
      vertex.vertex = v;
      for (std::size_t i = 0; i < 3; ++i) {
        if (!held.components[i]) continue;
        if (vertex.held[i] >= 0) {
          const HeldVertices& other = this->held(vertex.held[i]);
          if (!same_motion(other, vertex.place[i], held, static_cast<Index>(place),
                           static_cast<int>(i))) {
            throw InputError(fmt::format(
                "{}: vertex {} is fixed twice, to different targets (also by {}). Let only one of "
                "them select it.",
                held.name, id_of(mesh, v), other.name));
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
  const double size = mesh.rest_positions().cwiseAbs().maxCoeff() + 1.0;
  std::map<Index, Normals> normals;
  for (const GuidedVertices& guide : list_.guided) {
    for (std::size_t place = 0; place < guide.vertices.size(); ++place) {
      const Index v = guide.vertices[place];
      Prescribed& vertex = vertices[v];
      vertex.vertex = v;
      const Vector3 through = guide.points.col(static_cast<Index>(place));
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
                guide.name, id_of(mesh, v), held(h).name));
          }
          const Vector3 target = held(h).start.col(vertex.place[static_cast<std::size_t>(i)]);
          found->second.add(Vector3::Unit(i), target, size);
        }
      }
      // The directions forbidden by this guide: all that its own directions leave.
      Eigen::JacobiSVD<Matrix> svd(guide.directions, Eigen::ComputeFullU);
      for (Index k = guide.directions.cols(); k < 3; ++k) {
        if (found->second.add(svd.matrixU().col(k), through, size)) continue;
        throw InputError(fmt::format(
            "{}: vertex {} cannot be there and obey the other constraints on it, which hold it "
            "elsewhere. Let only one of them select it, or let them meet.",
            guide.name, id_of(mesh, v)));
      }
      vertex.freedom = found->second.freedom();
      vertex.point = found->second.point();
      vertex.guided = true;
    }
  }
}

std::vector<AffineSet> Constraints::add_handles(const std::map<Index, Prescribed>& vertices,
                                                const TetMesh& mesh) {
  std::vector<AffineSet> sets;
  std::map<Index, const std::string*> owner;
  for (const RigidHandle& handle : list_.handles) {
    const auto count = static_cast<Index>(handle.vertices.size());
    double total = 0.0;
    Vector3 center = Vector3::Zero();
    for (Index i = 0; i < count; ++i) {
      const Index v = handle.vertices[static_cast<std::size_t>(i)];
      const bool held = vertices.count(v) > 0;
      if (held || owner.count(v) > 0) {
        throw InputError(fmt::format(
            "{}: vertex {} is already {}. The vertices of a rigid handle cannot be constrained in "
            "another way: let only one of them select it.",
            handle.name, id_of(mesh, v), held ? "fixed or guided" : "in " + *owner[v]));
      }
      owner[v] = &handle.name;
      total += mass_[v];
      center += mass_[v] * handle.shape.col(i);
    }
    center /= total;
    Matrix3 moment = Matrix3::Zero();
    for (Index i = 0; i < count; ++i) {
      const Vector3 arm = handle.shape.col(i) - center;
      moment += mass_[handle.vertices[static_cast<std::size_t>(i)]] / total * arm * arm.transpose();
    }
    // Radii of gyration along the principal axes, largest first; flat directions have none.
    constexpr double kFlat = 1e-6;  // round-off in the squares is of the order of 1e-8
    const Eigen::SelfAdjointEigenSolver<Matrix3> axes(moment);
    Matrix3 directions;  // right-handed, so that w never has to be a mirror image
    directions.col(0) = axes.eigenvectors().col(2);
    directions.col(1) = axes.eigenvectors().col(1);
    directions.col(2) = directions.col(0).cross(directions.col(1));
    const double largest = std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
    int rank = 0;
    while (rank < 3 && std::sqrt(std::max(0.0, axes.eigenvalues()[2 - rank])) > kFlat * largest) {
      ++rank;
    }
    if (rank == 0) {
      throw InputError(fmt::format(
          "{}: all its vertices are in one place: a rigid handle needs two or more.", handle.name));
    }

    Equation equation;
    equation.first_entry = configuration_size_;
    equation.first_equation = equation_count_;
    equation.rank = rank;
    equation.name = handle.name;
    AffineSet set;
    set.vertices = handle.vertices;
    set.coordinates.resize(rank, count);
    for (Index i = 0; i < count; ++i) {
      const Index v = handle.vertices[static_cast<std::size_t>(i)];
      Vector3 weights = Vector3::Zero();
      for (int j = 0; j < rank; ++j) {
        const double radius = std::sqrt(axes.eigenvalues()[2 - j]);
        equation.scale[j] = radius;
        set.coordinates(j, i) = directions.col(j).dot(handle.shape.col(i) - center) / radius;
        weights[j] = mass_[v] / total * set.coordinates(j, i);
      }
      equation.weights.emplace_back(v, weights);
    }
    configuration_size_ += equation.entries();
    equation_count_ += equation.count();
    equations_.push_back(std::move(equation));
    sets.push_back(std::move(set));
  }
  return sets;
}

void Constraints::add_distances(const TetMesh& mesh) {
  for (const FixedDistance& distance : list_.distances) {
    if (distance.a == distance.b || !(distance.length > 0.0) || !std::isfinite(distance.length)) {
      throw InputError(fmt::format(
          "{}: a distance must be kept between two different vertices and be above 0; between {} "
          "and {} it is {} m.",
          distance.name, id_of(mesh, distance.a), id_of(mesh, distance.b), distance.length));
    }
    Equation equation;
    equation.first_entry = configuration_size_;
    equation.first_equation = equation_count_;
    equation.scale[0] = distance.length;
    equation.weights = {{distance.a, Vector3::UnitX()}, {distance.b, -Vector3::UnitX()}};
    equation.name = distance.name;
    configuration_size_ += equation.entries();
    equation_count_ += equation.count();
    equations_.push_back(std::move(equation));
  }
}

void Constraints::make_selector() {
  selector_.resize(coordinates_.count(), configuration_size_);
  Vector unit = Vector::Zero(configuration_size_);
  for (Index i = 0; i < configuration_size_; ++i) {
    unit[i] = 1.0;
    selector_.col(i) = coordinates_.restrict(vertex_forces(unit));
    unit[i] = 0.0;
  }
  reduced_mass_ = coordinates_.reduced_mass(mass_);
  inverse_mass_ = selector_.transpose() * reduced_mass_.cwiseInverse().asDiagonal() * selector_;
}

}  // namespace tetraction
