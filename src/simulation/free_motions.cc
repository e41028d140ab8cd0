// The rigid motions of a body that nothing restrains.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/decompositions.h"
#include "fem/connected_parts.h"
#include "load_stepping.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Modes = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// An eigenvalue of the restraint below this share of the largest is zero.
constexpr double kFree = 1e-13;

// The gradients and the Hessian of all potentials, and what loads that depend on positions add to both. A
// uniform field restrains nothing.
struct Potentials {
  Vector gradient;
  HessianBlocks hessian;
  LoadStiffness loads;
  bool any = false;
};

Potentials potentials_of(const MechanicalSystem& system, const Vector& x, double time) {
  Potentials result;
  result.gradient = Vector::Zero(system.dof_count());
  result.hessian.reset(system.vertex_count());
  const ForcePoint at = system.force_point(x, time);
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->uniform_acceleration()) continue;
    result.any = true;
    term->add_gradient(at, result.gradient);
    term->add_hessian(at, HessianForm::kExact, result.hessian);
  }
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_load() || !term->load_depends_on_position()) continue;
    Vector load = Vector::Zero(system.dof_count());
    term->add_load(at, load);
    result.gradient -= load;
    term->add_load_stiffness(at, result.loads);
  }
  return result;
}

// One part of the body with its six rigid motions: translations along the axes, and rotations about
// the axes through its centre by an angle that moves its farthest vertex by about one metre.
class Part {
 public:
  Part(const MechanicalSystem& system, const std::vector<Index>& vertices, const Vector& x)
      : system_(system), vertices_(vertices), x_(x) {
    for (const Index v : vertices) center_ += vertex_block(x, v) / double(vertices.size());
    for (const Index v : vertices) size_ = std::max(size_, (vertex_block(x, v) - center_).norm());
  }

  // The motions that nothing restrains, as columns.
  Modes free_modes(const Potentials& potentials) const {
    Matrix6 restraint = normalized(constraint_restraint());
    if (potentials.any) restraint += potential_restraint(potentials);
    const SymmetricEigen eigen = symmetric_eigen(Matrix(restraint));
    // What restrains a motion at all is about 1.
    const double limit = kFree * std::max(1.0, eigen.values[5]);
    Index count = 0;
    while (count < 6 && eigen.values[count] <= limit) ++count;
    return eigen.vectors.leftCols(count);
  }

  std::vector<std::string> names_of(const Modes& modes) const;

 private:
  Vector3 velocity(Index v, int mode) const {
    if (mode < 3) return Vector3::Unit(mode);
    return Vector3::Unit(mode - 3).cross(vertex_block(x_, v) - center_) / size_;
  }
  Vector3 spin(int mode) const {
    return mode < 3 ? Vector3(Vector3::Zero()) : Vector3(Vector3::Unit(mode - 3) / size_);
  }
  Vector field(int mode) const {
    Vector u = Vector::Zero(system_.dof_count());
    for (const Index v : vertices_) vertex_block(u, v) = velocity(v, mode);
    return u;
  }
  static Matrix6 normalized(const Matrix6& a) {
    const double largest = a.diagonal().maxCoeff();
    return largest > 0.0 ? Matrix6(a / largest) : a;
  }

  // |R − the part of it that the constraints allow|².
  Matrix6 constraint_restraint() const {
    Matrix lacks(system_.dof_count(), 6);
    for (int mode = 0; mode < 6; ++mode) {
      const Vector u = field(mode);
      Vector allowed = u;
      system_.coordinates().project_velocity(system_.mass(), allowed);
      lacks.col(mode) = u - allowed;
    }
    Matrix6 sum = lacks.transpose() * lacks;
    // The projection has round-off of its own.
    if (sum.diagonal().maxCoeff() < 1e-24 * static_cast<double>(vertices_.size())) sum.setZero();
    return sum;
  }

  // Σ |H v − ω × ∇U|² over the vertices, relative to the size of its terms. If a rigid motion does not
  // change a potential, it only turns its force: then H v = ω × ∇U. What a vertex cannot do does not count.
  Matrix6 potential_restraint(const Potentials& potentials) const {
    Matrix changes = Matrix::Zero(system_.dof_count(), 6);
    double scale = 0.0;
    for (int mode = 0; mode < 6; ++mode) {
      Vector change = Vector::Zero(system_.dof_count());
      const Vector motion = field(mode);
      potentials.hessian.add_product(motion, change);
      potentials.loads.add_product(motion, change);
      for (const Index v : vertices_) {
        vertex_block(change, v) -= spin(mode).cross(vertex_block(potentials.gradient, v));
        if (system_.coordinates().is_free(v) || system_.coordinates().set_of(v) >= 0) continue;
        const auto columns = system_.coordinates().map(v).columns;
        vertex_block(change, v) = columns * (columns.transpose() * vertex_block(change, v)).eval();
      }
      changes.col(mode) = change;
    }
    for (const Index v : vertices_) {
      scale += potentials.hessian.diagonal(v).squaredNorm() +
               vertex_block(potentials.gradient, v).squaredNorm() / (size_ * size_);
    }
    // The vertices are sorted.
    const auto is_own = [this](Index v) {
      return std::binary_search(vertices_.begin(), vertices_.end(), v);
    };
    for (const HessianBlocks::Pair& pair : potentials.hessian.pairs()) {
      if (is_own(pair.row)) scale += 2.0 * pair.block.squaredNorm();
    }
    for (const LoadStiffness::Block& block : potentials.loads.blocks()) {
      if (is_own(block.row)) scale += block.block.squaredNorm();
    }
    return scale > 0.0 ? Matrix6(changes.transpose() * changes / scale) : Matrix6(Matrix6::Zero());
  }

  const MechanicalSystem& system_;
  const std::vector<Index>& vertices_;
  const Vector& x_;
  Vector3 center_ = Vector3::Zero();
  double size_ = 0.0;
};

// Numbers that are round-off are written as zero.
std::string list_of(const Vector3& x, double size) {
  std::array<double, 3> c{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = x[static_cast<Index>(i)];
    c[i] = std::abs(value) < 1e-9 * size ? 0.0 : value;
  }
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", c[0], c[1], c[2]);
}

// Directions are the same if their difference is smaller than this.
constexpr double kSame = 1e-6;

// An orthonormal basis of the column space.
Matrix orthonormal_basis(const Matrix& vectors) {
  const SymmetricEigen eigen = symmetric_eigen(Matrix(vectors * vectors.transpose()));
  Index rank = 0;
  while (rank < vectors.rows() && eigen.values[vectors.rows() - 1 - rank] > kSame * kSame) ++rank;
  return eigen.vectors.rightCols(rank);
}

// An orthonormal basis of the column space that consists of coordinate axes where possible.
std::vector<Vector3> plain_basis(const Matrix& vectors) {
  std::vector<Vector3> basis;
  const Matrix space = orthonormal_basis(vectors);
  Matrix left = space;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 e = Vector3::Unit(axis);
    if ((e - space * (space.transpose() * e)).norm() > kSame) continue;
    basis.push_back(e);
    left -= e * (e.transpose() * left);
  }
  const Matrix others = orthonormal_basis(left);
  for (Index i = 0; i < others.cols(); ++i) {
    const Vector3 direction = others.col(i);
    Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    basis.emplace_back(direction[largest] < 0.0 ? Vector3(-direction) : direction);
  }
  return basis;
}

std::string direction_name(const Vector3& direction) {
  for (int axis = 0; axis < 3; ++axis) {
    if (direction == Vector3::Unit(axis)) return std::string(1, "xyz"[axis]);
  }
  return list_of(direction, 1.0);
}

std::vector<std::string> Part::names_of(const Modes& modes) const {
  std::vector<std::string> names;
  const Matrix moves = modes.topRows<3>();
  const Matrix spins = modes.bottomRows<3>();
  // Combinations of the motions without rotation.
  const SymmetricEigen eigen = symmetric_eigen(Matrix(spins.transpose() * spins));
  Index count = 0;
  while (count < modes.cols() && eigen.values[count] < kSame * kSame) ++count;
  const std::vector<Vector3> ways = plain_basis(moves * eigen.vectors.leftCols(count));
  names.reserve(ways.size());
  for (const Vector3& way : ways) names.push_back("move along " + direction_name(way));
  for (const Vector3& axis : plain_basis(spins)) {
    // The combination that rotates about this axis, and the velocity of the centre in it without
    // what the free translations can change.
    Vector combination = Vector::Zero(modes.cols());
    for (Index i = count; i < modes.cols(); ++i) {
      const Vector c = eigen.vectors.col(i);
      combination += (spins * c).dot(axis) / eigen.values[i] * c;
    }
    Vector3 drift = size_ * (moves * combination);
    for (const Vector3& way : ways) drift -= way.dot(drift) * way;
    names.push_back(ways.size() == 3 ? "rotate about " + direction_name(axis)
                                     : fmt::format("rotate about the line through {} along {}",
                                                   list_of(center_ + axis.cross(drift), size_),
                                                   direction_name(axis)));
  }
  return names;
}

}  // namespace

std::vector<std::string> free_motions(const MechanicalSystem& system, double time) {
  const Vector x = system.mesh().rest_positions();
  const Potentials potentials = potentials_of(system, x, time);
  const std::vector<std::vector<Index>> parts =
      connected_parts(system.rest(), system.coordinates().sets());
  std::vector<std::string> names;
  for (const std::vector<Index>& vertices : parts) {
    const Part part(system, vertices, x);
    const Modes modes = part.free_modes(potentials);
    if (modes.cols() == 0) continue;
    for (std::string& name : part.names_of(modes)) {
      if (parts.size() > 1) {
        name += fmt::format(" (the part with vertex {})", system.mesh().vertex_id(vertices[0]));
      }
      names.push_back(std::move(name));
    }
  }
  return names;
}

void refuse_free_motions(const MechanicalSystem& system, double time) {
  const std::vector<std::string> names = free_motions(system, time);
  if (names.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 < names.size() ? ", " : " and ";
    text += names[i];
  }
  throw InputError(
      fmt::format("There is no definite equilibrium: the body can still {}. Fix it with [[fix]], "
                  "with a plane or "
                  "line of [[constraint]], or with springs (mode = \"penalty\").{}",
                  text,
                  system.constraints().list().distances.empty()
                      ? ""
                      : " Distances are not enough to hold a body in an equilibrium."));
}

}  // namespace tetraction
