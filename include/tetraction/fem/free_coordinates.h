// The free coordinates of a body with linear constraints. The other coordinates are eliminated, so
// that minimisers and matrices contain free coordinates only (compare deal.II's AffineConstraints).
#pragma once

#include <map>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// The directions in which a vertex may move. They are the first `count` columns of the orthonormal
/// matrix `basis`.
struct VertexFreedom {
  int count = 3;  ///< from 0 (the vertex cannot move) to 3 (it is free)
  Matrix3 basis = Matrix3::Identity();

  /// The orthogonal projection of x on these directions.
  Vector3 project(const Vector3& x) const {
    Vector3 result = Vector3::Zero();
    for (int i = 0; i < count; ++i) result += basis.col(i).dot(x) * basis.col(i);
    return result;
  }
};

/// Vertices that move together by an affine map, q_a = c + Σ_j ξ_ja w_j. The centre c and the
/// `rank` vectors w_j are free coordinates. The ξ must satisfy Σ m_a ξ_a = 0 and Σ m_a ξ_ia ξ_ja =
/// Σ m_a δ_ij.
struct AffineSet {
  std::vector<Index> vertices;
  Matrix coordinates;  ///< ξ: rank × vertices, rank 0 to 3
  int rank() const { return static_cast<int>(coordinates.rows()); }
};

/// The linear map δq = T δy from the free coordinates y to the positions of all vertices.
///
/// The coordinates of single vertices come first, in the order of the vertices. Each vertex has one
/// coordinate for every direction in which it may move. The coordinates (c, w_1, …) of the affine
/// sets follow. TᵀMT is diagonal because the ξ of the affine sets are scaled as AffineSet demands.
class FreeCoordinates {
 public:
  /// The three rows of T that belong to one vertex. Only the columns first … first + count − 1 are
  /// not zero. They are in `columns`.
  struct VertexMap {
    int first = 0;
    int count = 0;
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12> columns;
  };

  /// Every vertex is free.
  explicit FreeCoordinates(Index vertex_count);
  /// Vertices that are in neither `freedoms` nor `sets` are free. Throws InputError if a vertex is in
  /// more than one of them or the mesh has more than 2^31 coordinates.
  FreeCoordinates(Index vertex_count, std::map<Index, VertexFreedom> freedoms,
                  std::vector<AffineSet> sets = {});

  Index vertex_count() const { return static_cast<Index>(first_.size()); }
  Index dof_count() const { return 3 * vertex_count(); }
  /// Number of free coordinates.
  Index count() const { return count_; }
  /// Whether the vertex may move in all three directions, independently of other vertices.
  bool is_free(Index vertex) const { return kind_[static_cast<std::size_t>(vertex)] == kFree; }
  /// Whether all three displacements of the vertex are prescribed: it has no free coordinate.
  bool is_fully_prescribed(Index vertex) const {
    return kind_[static_cast<std::size_t>(vertex)] == kFullyPrescribed;
  }
  /// First coordinate of a free vertex.
  int first(Index vertex) const { return first_[static_cast<std::size_t>(vertex)]; }
  VertexMap map(Index vertex) const;
  /// The affine set that the vertex belongs to, or −1.
  Index set_of(Index vertex) const;
  const std::vector<AffineSet>& sets() const { return sets_; }
  int first_of_set(Index set) const { return set_first_[static_cast<std::size_t>(set)]; }

  /// Tᵀ f: the generalised forces of vertex forces.
  Vector restrict(const Vector& full) const;
  /// |Tᵀ f|₂.
  double restricted_norm(const Vector& full) const;
  /// T y: the displacements of the vertices.
  Vector extend(const Vector& free) const;
  /// The diagonal of TᵀMT, kg (`mass`: one per vertex).
  Vector reduced_mass(const Vector& mass) const;
  /// p ← M T (TᵀMT)⁻¹ Tᵀ p: projects momenta on those that motions of the free coordinates have.
  void project_momentum(const Vector& mass, Vector& momentum) const;
  /// v ← T (TᵀMT)⁻¹ TᵀM v: projects velocities on those of motions of the free coordinates.
  void project_velocity(const Vector& mass, Vector& velocity) const;

 private:
  enum Kind : std::uint8_t { kFree, kPartlyPrescribed, kFullyPrescribed, kAffine };

  std::vector<Kind> kind_;
  std::vector<int> first_;                           // per vertex; −1 if it has no coordinates
  std::map<Index, VertexFreedom> freedoms_;          // of the vertices that are not free
  std::map<Index, std::pair<Index, Index>> member_;  // vertex → set, index in the set
  std::vector<AffineSet> sets_;
  std::vector<int> set_first_;
  Index count_ = 0;
};

}  // namespace tetraction
