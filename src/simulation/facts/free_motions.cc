#include "free_motions.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/decompositions.h"
#include "fem/jointed_pieces.h"
#include "potential_restraint.h"
#include "simulation/session/load_stepping.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Modes = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// An eigenvalue of the restraint below this share of the largest is zero. The restraint is a square, so that a motion
// counts as free whose resistance is below 3e-7 of the largest.
//
// free_rigid_motions() of the normal modes (solver/modes/free_modes.cc) answers another question. Here it is whether
// the equilibrium of the body at rest is definite: distances do not hold a body, joints connect parts, and a motion that
// is all but free has no definite amplitude. There it is which columns the eigenvalues zero belong to, at any positions and
// with all equations: a resistance above 1e-9 of its own terms is a stiffness, however soft. A spring that is between 1e-9
// and 3e-7 times as stiff as the others is therefore free here and a slow mode there.
constexpr double kFree = 1e-13;

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
    if (potentials.any) {
      restraint += restraint_of(system_, potentials, vertices_, size_, fields(), spins());
    }
    const SymmetricEigen eigen = symmetric_eigen(Matrix(restraint));
    // Any restraint of a motion is about 1.
    const double limit = kFree * std::max(1.0, eigen.values[5]);
    Index count = 0;
    while (count < 6 && eigen.values[count] <= limit) ++count;
    return eigen.vectors.leftCols(count);
  }

  std::vector<std::string> names_of(const Modes& modes) const;
  const std::vector<Index>& vertices() const { return vertices_; }
  const Vector3& center() const { return center_; }
  double size() const { return size_; }
  // The velocities and angular velocities of all vertices in each of the six motions.
  Matrix fields() const {
    Matrix fields(system_.dof_count(), 6);
    for (int mode = 0; mode < 6; ++mode) fields.col(mode) = field(mode);
    return fields;
  }
  Matrix spins() const {
    Matrix spins = Matrix::Zero(system_.dof_count(), 6);
    for (int mode = 0; mode < 6; ++mode) {
      for (const Index v : vertices_) spins.col(mode).segment<3>(3 * v) = spin(mode);
    }
    return spins;
  }

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
  const std::vector<Vector3> directions = plain_basis(moves * eigen.vectors.leftCols(count));
  names.reserve(directions.size());
  for (const Vector3& direction : directions)
    names.push_back("move along " + direction_name(direction));
  for (const Vector3& axis : plain_basis(spins)) {
    // The combination that rotates about this axis, and the velocity of the centre in it without
    // what the free translations can change.
    Vector combination = Vector::Zero(modes.cols());
    for (Index i = count; i < modes.cols(); ++i) {
      const Vector c = eigen.vectors.col(i);
      combination += (spins * c).dot(axis) / eigen.values[i] * c;
    }
    Vector3 drift = size_ * (moves * combination);
    for (const Vector3& direction : directions) drift -= direction.dot(drift) * direction;
    names.push_back(directions.size() == 3
                        ? "rotate about " + direction_name(axis)
                        : fmt::format("rotate about the line through {} along {}",
                                      list_of(center_ + axis.cross(drift), size_),
                                      direction_name(axis)));
  }
  return names;
}

// Where joints are, for messages.
std::string place_of(const std::vector<Index>& joints, const MechanicalSystem& system,
                     const Vector& x, double size) {
  constexpr std::size_t kMost = 4;
  constexpr double kOnLine = 1e-6;
  std::string text = joints.size() == 1 ? "vertex " : "the vertices ";
  for (std::size_t i = 0; i < std::min(joints.size(), kMost); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ", ", system.mesh().vertex_id(joints[i]));
  }
  if (joints.size() > kMost) text += fmt::format(" and {} more", joints.size() - kMost);
  if (joints.size() < 2) return text;
  const Vector3 first = vertex_block(x, joints.front());
  Vector3 longest = Vector3::Zero();
  for (const Index v : joints) {
    const Vector3 r = vertex_block(x, v) - first;
    if (r.norm() > longest.norm()) longest = r;
  }
  const Vector3 direction = longest.normalized();
  for (const Index v : joints) {
    const Vector3 r = vertex_block(x, v) - first;
    if (r.cross(direction).norm() > kOnLine * size) return text;
  }
  return fmt::format("{} on the line through {} along {}", text, list_of(first, size),
                     direction_name(plain_basis(direction).front()));
}

// The motions of a part that consists of several pieces.
struct PieceMotions {
  Modes whole = Modes(6, 0);
  Mechanism mechanism;
};

PieceMotions motions_of_pieces(const MechanicalSystem& system, const Part& part,
                               const std::vector<Index>& vertices, std::vector<MeshPiece> pieces,
                               const Vector& x, double time, Contact::Support support) {
  std::vector<AffineSet> sets;
  for (const AffineSet& set : system.coordinates().sets()) {
    if (std::binary_search(vertices.begin(), vertices.end(), set.vertices.front())) {
      sets.push_back(set);
    }
  }
  PieceMotions result;
  Mechanism& mechanism = result.mechanism;
  mechanism.vertex = vertices.front();
  mechanism.pieces = pieces.size();
  const JointedPieces jointed(std::move(pieces), sets, x);
  const Matrix all = jointed.motions();
  mechanism.motions = all.cols() - 6;
  if (mechanism.motions == 0) return result;
  const Matrix whole = jointed.whole(part.center(), part.size());
  mechanism.joints = jointed.moving_joints(divide_motions(all, whole).mechanism);
  Matrix free = jointed.motions(system.coordinates());
  const Potentials potentials = potentials_of(system, x, time, support, Potentials::kWithoutLoads);
  if (free.cols() > 0 && potentials.any) {
    Matrix fields(x.size(), free.cols());
    Matrix spins(x.size(), free.cols());
    for (Index j = 0; j < free.cols(); ++j) {
      fields.col(j) = jointed.field(free.col(j));
      spins.col(j) = jointed.spins(free.col(j));
    }
    const SymmetricEigen eigen =
        symmetric_eigen(restraint_of(system, potentials, vertices, part.size(), fields, spins));
    Index count = 0;
    while (count < free.cols() && eigen.values[count] <= kFree) ++count;
    free = (free * eigen.vectors.leftCols(count)).eval();
  }
  if (free.cols() > 0) {
    DividedMotions divided = divide_motions(free, whole);
    result.whole = divided.whole;
    mechanism.free_motions = divided.mechanism.cols();
    if (mechanism.free_motions > 0) {
      mechanism.joints = jointed.moving_joints(divided.mechanism);
    }
  }
  mechanism.place = place_of(mechanism.joints, system, x, part.size());
  return result;
}

// The number of motions of several parts that nothing restrains, those of each part included. A potential of a
// common mean holds fewer of them than it would of each part alone.
Index count_joint_motions(const MechanicalSystem& system, const Potentials& potentials,
                          const Potentials& within_parts, const std::vector<const Part*>& parts) {
  Matrix fields(system.dof_count(), 0);
  Matrix spins = fields;
  std::vector<Index> vertices;
  double size = 0.0;
  for (const Part* part : parts) {
    const Modes modes = part->free_modes(within_parts);
    for (auto [all, of_part] :
         {std::pair(&fields, part->fields()), std::pair(&spins, part->spins())}) {
      all->conservativeResize(Eigen::NoChange, all->cols() + modes.cols());
      all->rightCols(modes.cols()) = of_part * modes;
    }
    vertices.insert(vertices.end(), part->vertices().begin(), part->vertices().end());
    size = std::max(size, part->size());
  }
  std::sort(vertices.begin(), vertices.end());
  const Vector restraints =
      symmetric_eigen(restraint_of(system, potentials, vertices, size, fields, spins)).values;
  return (restraints.array() <= kFree * std::max(1.0, restraints.maxCoeff())).count();
}

std::string list_text(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 < items.size() ? ", " : " and ";
    text += items[i];
  }
  return text;
}

}  // namespace

namespace {

// Parts that have the same free motions.
struct NamedParts {
  std::vector<std::string> motions;
  std::vector<Index> first_vertices;  // of each part

  // The motions, and whose they are.
  std::vector<std::string> texts(const TetMesh& mesh, bool with_parts) const {
    if (!with_parts) return motions;
    constexpr std::size_t kMostNamed = 3;
    std::vector<std::string> result;
    const Index first = mesh.vertex_id(first_vertices.front());
    if (first_vertices.size() > kMostNamed) {
      for (const std::string& motion : motions) {
        result.push_back(fmt::format("{} (each of {} parts, the first of them with vertex {})",
                                     motion, first_vertices.size(), first));
      }
      return result;
    }
    for (const Index v : first_vertices) {
      for (const std::string& motion : motions) {
        result.push_back(fmt::format("{} (the part with vertex {})", motion, mesh.vertex_id(v)));
      }
    }
    return result;
  }
};

FreeMotions motions_at(const MechanicalSystem& system, const Vector& x, double time,
                       Contact::Support support) {
  constexpr std::size_t kMostParts = 1000;
  const std::vector<std::vector<Index>> parts =
      connected_parts(system.rest(), system.coordinates().sets());
  std::vector<std::vector<MeshPiece>> pieces = pieces_of_parts(system.mesh(), parts);
  FreeMotions result;
  result.parts = parts.size();
  for (const auto& of_part : pieces) result.pieces += of_part.size();
  if (parts.size() > kMostParts) {
    result.is_complete = false;
    return result;
  }
  const Potentials potentials = potentials_of(system, x, time, support, Potentials::kAll);
  std::vector<Part> bodies;
  bodies.reserve(parts.size());
  std::vector<const Part*> coupled;
  Index motions_alone = 0;  // of the coupled parts
  std::vector<NamedParts> named;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = bodies.emplace_back(system, parts[k], x);
    std::optional<Modes> modes;
    if (pieces[k].size() > JointedPieces::kMost) {
      result.is_complete = false;
    } else if (pieces[k].size() > 1) {
      PieceMotions motions =
          motions_of_pieces(system, part, parts[k], std::move(pieces[k]), x, time, support);
      if (motions.mechanism.motions > 0) {
        modes = std::move(motions.whole);
        result.mechanisms.push_back(std::move(motions.mechanism));
      }
    }
    if (!modes) modes = part.free_modes(potentials);
    if (potentials.couple(parts[k])) {
      coupled.push_back(&part);
      motions_alone += modes->cols();
    }
    if (modes->cols() == 0) continue;
    std::vector<std::string> names = part.names_of(*modes);
    const auto known = std::ranges::find(named, names, &NamedParts::motions);
    if (known == named.end()) {
      named.push_back({std::move(names), {parts[k][0]}});
    } else {
      known->first_vertices.push_back(parts[k][0]);
    }
  }
  for (const NamedParts& each : named) {
    for (std::string& name : each.texts(system.mesh(), parts.size() > 1)) {
      result.whole.push_back(std::move(name));
    }
  }
  if (coupled.size() > 1) {
    const Potentials within_parts =
        potentials_of(system, x, time, support, Potentials::kWithoutMeans);
    if (count_joint_motions(system, potentials, within_parts, coupled) > motions_alone) {
      result.whole.push_back(
          fmt::format("move its parts with the vertices {} and {} against each other, as only the "
                      "mean of vertices of both is held",
                      system.mesh().vertex_id(coupled[0]->vertices().front()),
                      system.mesh().vertex_id(coupled[1]->vertices().front())));
    }
  }
  return result;
}

}  // namespace

FreeMotions find_free_motions(const MechanicalSystem& system, double time,
                              Contact::Support support) {
  return motions_at(system, system.mesh().rest_positions(), time, support);
}

std::string mechanism_text(const Mechanism& mechanism) {
  return fmt::format("turn in itself as a mechanism, because pieces of it touch only in {}",
                     mechanism.place);
}

std::string mechanism_warning(const FreeMotions& motions) {
  std::vector<std::string> texts;
  for (const Mechanism& mechanism : motions.mechanisms) {
    if (mechanism.free_motions > 0) texts.push_back(mechanism_text(mechanism));
  }
  if (texts.empty()) return {};
  return fmt::format(
      "the body is a mechanism: without any strain it can {}. Tetrahedra that are to hold together "
      "must share a face. Join the pieces by faces in the mesh, or fix each of them.",
      list_text(texts));
}

namespace {

std::vector<std::string> texts_of(const FreeMotions& motions) {
  std::vector<std::string> texts = motions.whole;
  for (const Mechanism& mechanism : motions.mechanisms) {
    if (mechanism.free_motions > 0) texts.push_back(mechanism_text(mechanism));
  }
  return texts;
}

}  // namespace

std::vector<std::string> motions_beside_obstacles(const MechanicalSystem& system, const State& at,
                                                  double time) {
  if (system.contact() == nullptr) return {};
  return texts_of(motions_at(system, at.position, time, Contact::Support::kPresent));
}

std::vector<std::string> free_motions(const MechanicalSystem& system, double time) {
  return texts_of(find_free_motions(system, time));
}

void refuse_free_motions(const MechanicalSystem& system, double time) {
  const FreeMotions motions = find_free_motions(system, time);
  const std::vector<std::string> texts = texts_of(motions);
  if (texts.empty()) return;
  throw InputError(
      fmt::format("There is no definite equilibrium: the body can still {}. {}Fix it with [[fix]], "
                  "with a plane or line of [[constraint]], or with springs (mode = \"penalty\").{}",
                  list_text(texts),
                  texts.size() > motions.whole.size()
                      ? "Tetrahedra that are to hold together must share a face. "
                      : "",
                  system.constraints().list().distances.empty()
                      ? ""
                      : " Distances are not enough to hold a body in an equilibrium."));
}

}  // namespace tetraction
