#include "jointed_pieces.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <utility>

#include "core/decompositions.h"
#include "core/disjoint_sets.h"

namespace tetraction {
namespace {

// A restraint of a motion has an eigenvalue of about the square of a lever over a size.
constexpr double kFree = 1e-12;

// A quadratic form whose largest diagonal entry is 1, or 0.
template <class Form>
void normalize(Form& form) {
  const double largest = form.diagonal().maxCoeff();
  if (largest > 0.0) form /= largest;
}

}  // namespace

std::vector<std::vector<Index>> connected_parts(const RestState& rest,
                                                const std::vector<AffineSet>& sets) {
  DisjointSets joined(rest.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    for (const Index v : nodes) joined.join(nodes[0], v);
  }
  for (const AffineSet& set : sets) {
    for (const Index v : set.vertices) joined.join(set.vertices.front(), v);
  }
  Index count = 0;
  const std::vector<Index> part = joined.numbers(count);
  std::vector<std::vector<Index>> parts(static_cast<std::size_t>(count));
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    parts[static_cast<std::size_t>(part[static_cast<std::size_t>(v)])].push_back(v);
  }
  return parts;
}

std::vector<std::vector<MeshPiece>> pieces_of_parts(const TetMesh& mesh,
                                                    const std::vector<std::vector<Index>>& parts) {
  std::vector<std::size_t> part_of(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (const Index v : parts[k]) part_of[static_cast<std::size_t>(v)] = k;
  }
  std::vector<std::vector<MeshPiece>> pieces(parts.size());
  for (MeshPiece& piece : mesh_pieces(mesh)) {
    pieces[part_of[static_cast<std::size_t>(piece.vertices.front())]].push_back(std::move(piece));
  }
  return pieces;
}

JointedPieces::JointedPieces(std::vector<MeshPiece> pieces, const std::vector<AffineSet>& sets,
                             const Vector& x)
    : x_(x) {
  for (MeshPiece& piece : pieces) add_body(std::move(piece.vertices), false);
  for (const AffineSet& set : sets) add_body(set.vertices, true);
  join();
}

void JointedPieces::add_body(std::vector<Index> vertices, bool is_set) {
  Body body{std::move(vertices), Vector3::Zero(), 0.0, is_set};
  for (const Index v : body.vertices) {
    body.center += vertex_block(x_, v) / static_cast<double>(body.vertices.size());
  }
  for (const Index v : body.vertices) {
    body.size = std::max(body.size, (vertex_block(x_, v) - body.center).norm());
  }
  if (!(body.size > 0.0)) body.size = 1.0;  // a set of one vertex
  bodies_.push_back(std::move(body));
}

JointedPieces::Map JointedPieces::map(const Body& body, Index vertex) const {
  const Vector3 r = (vertex_block(x_, vertex) - body.center) / body.size;
  Map map = Map::Zero();
  map.leftCols<3>().setIdentity();
  for (int i = 0; i < 3; ++i) map.col(3 + i) = Vector3::Unit(i).cross(r);
  return map;
}

void JointedPieces::join() {
  std::map<Index, std::vector<std::size_t>> bodies_of;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    for (const Index v : bodies_[k].vertices) bodies_of[v].push_back(k);
  }
  using Form = Eigen::Matrix<double, 12, 12>;
  std::map<std::pair<std::size_t, std::size_t>, Form> of_pairs;
  for (auto& [vertex, bodies] : bodies_of) {
    if (bodies.size() < 2) continue;
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      Eigen::Matrix<double, 3, 12> difference;
      difference << map(bodies_[bodies[0]], vertex), -map(bodies_[bodies[i]], vertex);
      Form& form = of_pairs.try_emplace({bodies[0], bodies[i]}, Form::Zero()).first->second;
      form += difference.transpose() * difference;
    }
    shared_.emplace_back(vertex, std::move(bodies));
  }
  const auto size = 6 * static_cast<Index>(bodies_.size());
  joints_ = Matrix::Zero(size, size);
  for (auto& [pair, form] : of_pairs) {
    normalize(form);
    const auto a = 6 * static_cast<Index>(pair.first);
    const auto b = 6 * static_cast<Index>(pair.second);
    joints_.block<6, 6>(a, a) += form.topLeftCorner<6, 6>();
    joints_.block<6, 6>(a, b) += form.topRightCorner<6, 6>();
    joints_.block<6, 6>(b, a) += form.bottomLeftCorner<6, 6>();
    joints_.block<6, 6>(b, b) += form.bottomRightCorner<6, 6>();
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (bodies_[k].is_set) hold_turns_without_effect(k);
  }
}

// A set of vertices on a line does not move when it turns about the line.
void JointedPieces::hold_turns_without_effect(std::size_t body) {
  Matrix3 turns = Matrix3::Zero();
  for (const Index v : bodies_[body].vertices) {
    const Matrix3 part = map(bodies_[body], v).rightCols<3>();
    turns += part.transpose() * part;
  }
  normalize(turns);
  const SymmetricEigen3 eigen = symmetric_eigen(turns);
  const Index first = 6 * static_cast<Index>(body) + 3;
  for (int i = 0; i < 3; ++i) {
    if (eigen.values[i] > kFree) continue;
    joints_.block<3, 3>(first, first) += eigen.vectors.col(i) * eigen.vectors.col(i).transpose();
  }
}

Matrix JointedPieces::null_space(const Matrix& restraint) {
  const SymmetricEigen eigen = symmetric_eigen(restraint);
  const double limit = kFree * std::max(1.0, eigen.values[eigen.values.size() - 1]);
  Index count = 0;
  while (count < eigen.values.size() && eigen.values[count] <= limit) ++count;
  return eigen.vectors.leftCols(count);
}

Matrix JointedPieces::motions(const FreeCoordinates& coordinates) const {
  Matrix restraint = joints_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero();
    for (const Index v : bodies_[k].vertices) {
      if (coordinates.is_free(v) || coordinates.set_of(v) >= 0) continue;
      const auto allowed = coordinates.map(v);
      Map lacks = map(bodies_[k], v);
      lacks -= allowed.columns * (allowed.columns.transpose() * lacks).eval();
      held += lacks.transpose() * lacks;
    }
    normalize(held);
    const Index first = 6 * static_cast<Index>(k);
    restraint.block<6, 6>(first, first) += held;
  }
  return null_space(restraint);
}

Matrix JointedPieces::whole(const Vector3& center, double size) const {
  Matrix motions = Matrix::Zero(6 * static_cast<Index>(bodies_.size()), 6);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Index first = 6 * static_cast<Index>(k);
    for (int i = 0; i < 3; ++i) {
      const Vector3 axis = Vector3::Unit(i);
      motions.block<3, 1>(first, i) = axis;
      motions.block<3, 1>(first, 3 + i) = axis.cross(bodies_[k].center - center) / size;
      motions.block<3, 1>(first + 3, 3 + i) = axis * (bodies_[k].size / size);
    }
  }
  return motions;
}

Vector JointedPieces::field(const Vector& motion) const {
  Vector velocity = Vector::Zero(x_.size());
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    for (const Index v : bodies_[k].vertices) {
      vertex_block(velocity, v) = map(bodies_[k], v) * motion.segment<6>(6 * static_cast<Index>(k));
    }
  }
  return velocity;
}

Vector JointedPieces::spins(const Vector& motion) const {
  Vector spins = Vector::Zero(x_.size());
  for (std::size_t k = bodies_.size(); k-- > 0;) {
    for (const Index v : bodies_[k].vertices) {
      vertex_block(spins, v) = motion.segment<3>(6 * static_cast<Index>(k) + 3) / bodies_[k].size;
    }
  }
  return spins;
}

std::vector<Index> JointedPieces::moving_joints(const Matrix& motions) const {
  constexpr double kTurns = 1e-6;
  const auto spin = [&](std::size_t body) {
    return Matrix(motions.middleRows<3>(6 * static_cast<Index>(body) + 3) / bodies_[body].size);
  };
  std::vector<Index> joints;
  for (const auto& [vertex, bodies] : shared_) {
    const std::size_t first = bodies.front();
    const bool turns = std::any_of(bodies.begin() + 1, bodies.end(), [&](std::size_t k) {
      if (bodies_[first].is_set || bodies_[k].is_set) return false;
      const double size = std::min(bodies_[first].size, bodies_[k].size);
      return size * (spin(first) - spin(k)).norm() > kTurns;
    });
    if (turns) joints.push_back(vertex);
  }
  return joints;
}

DividedMotions divide_motions(const Matrix& motions, const Matrix& whole) {
  constexpr double kInside = 1e-9;
  if (motions.cols() == 0) return {Matrix(whole.cols(), 0), motions};
  const Eigen::HouseholderQR<Matrix> qr(whole);
  const Matrix basis = qr.householderQ() * Matrix::Identity(whole.rows(), whole.cols());
  const Matrix shares = basis.transpose() * motions;
  const SymmetricEigen eigen = symmetric_eigen(Matrix(shares.transpose() * shares));
  Index outside = 0;
  while (outside < motions.cols() && eigen.values[outside] < 1.0 - kInside) ++outside;
  const Matrix inside = motions * eigen.vectors.rightCols(motions.cols() - outside);
  return {qr.solve(inside), motions * eigen.vectors.leftCols(outside)};
}

}  // namespace tetraction
