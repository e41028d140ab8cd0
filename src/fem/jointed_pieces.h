// The connected parts of a body, and pieces that touch only in edges and vertices: rigid bodies with joints.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh/mesh_pieces.h"
#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// The vertices of each part that hangs together through elements, ascending, and through `sets`: all
/// vertices of a set belong to the same part.
std::vector<std::vector<Index>> connected_parts(const RestState& rest,
                                                const std::vector<AffineSet>& sets = {});

/// The pieces that hang together through faces, for each of these parts of the mesh.
std::vector<std::vector<MeshPiece>> pieces_of_parts(const TetMesh& mesh,
                                                    const std::vector<std::vector<Index>>& parts);

/// The pieces of one connected part of a body, each as a rigid body. Vertices that two pieces share stay
/// together: one vertex is a ball joint, vertices on a line are a hinge, and three that are not on a line
/// join two pieces rigidly. Such motions cause no strain, so that a body which has more than the six of a
/// single rigid body is a mechanism.
///
/// A motion has six numbers for each piece: the velocity t of its centre c and its angular velocity θ/s,
/// where s is the distance of c from its farthest vertex: v(x) = t + θ × (x − c)/s.
class JointedPieces {
 public:
  /// More pieces than this are not examined: the cost grows with the cube of their number.
  static constexpr std::size_t kMost = 150;

  /// `sets`: vertices of the part that move as a rigid body (free handles). `x`: positions, 3 per vertex,
  /// m. Refers to x, which must live longer.
  JointedPieces(std::vector<MeshPiece> pieces, const std::vector<AffineSet>& sets, const Vector& x);

  /// An orthonormal basis of the motions that the joints allow.
  Matrix motions() const { return null_space(joints_); }
  /// The same for the motions that the constraints of single vertices allow, too.
  Matrix motions(const FreeCoordinates& coordinates) const;
  /// The motions of all pieces together: three translations along the axes, and three rotations about the
  /// axes through `center` with angular velocities of 1/size.
  Matrix whole(const Vector3& center, double size) const;

  /// The velocities of the vertices of the pieces in a motion (3 per vertex of the body); 0 elsewhere.
  Vector field(const Vector& motion) const;
  /// The angular velocity of the first piece that has each vertex, in the order of field().
  Vector spins(const Vector& motion) const;
  /// The vertices, ascending, that two pieces of elements share which turn against each other in one of
  /// the motions.
  std::vector<Index> moving_joints(const Matrix& motions) const;

 private:
  struct Body {
    std::vector<Index> vertices;
    Vector3 center = Vector3::Zero();
    double size = 1.0;
    bool is_set = false;
  };
  using Map = Eigen::Matrix<double, 3, 6>;

  void add_body(std::vector<Index> vertices, bool is_set);
  void join();
  void hold_turns_without_effect(std::size_t body);
  // The velocity of a vertex by the six numbers of a body.
  Map map(const Body& body, Index vertex) const;
  static Matrix null_space(const Matrix& restraint);

  const Vector& x_;
  std::vector<Body> bodies_;
  // For each vertex that more than one body has: these bodies.
  std::vector<std::pair<Index, std::vector<std::size_t>>> shared_;
  Matrix joints_;  // Σ |difference of velocities|² as a quadratic form
};

/// Divides the space of `motions` (orthonormal columns) by the space of `whole`: the motions that are in
/// it, and those orthogonal to these, with orthonormal columns.
struct DividedMotions {
  Matrix whole;      ///< coefficients of the columns of `whole`
  Matrix mechanism;  ///< motions of pieces against each other
};
DividedMotions divide_motions(const Matrix& motions, const Matrix& whole);

}  // namespace tetraction
