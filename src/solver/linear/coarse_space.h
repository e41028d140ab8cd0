// The coarse level of a two-level preconditioner for the Hessian of an implicit step.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "coarse_matrix.h"
#include "fem/tangent_operator.h"
#include "outer_products.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "vertex_groups.h"

namespace tetraction {

/// Near-rigid motions of groups of vertices: vertex v of a group moves by
///
///     u_v = w_v (t + ω × a_v),   a_v = (x_v − centre of the group)/(its radius),
///
/// projected to the directions in which the vertex may move (w = 0 for vertices that cannot move).
/// These six motions of every group are the columns of P. The preconditioner is the inverse of the
/// vertices' diagonal blocks plus P (PᵀAP)⁻¹ Pᵀ. The second part reduces the errors that spread
/// over many elements, for which the blocks alone need many iterations (additive two-level Schwarz
/// preconditioner with a coarse space of rigid body modes; Toselli & Widlund 2005, ch. 3 and 8).
/// The number of iterations then depends on the size of the groups, and hardly on the mesh, the
/// stiffness or the step.
///
/// x and A are those of the last update(). A preconditioner need not belong to the current matrix,
/// so that one coarse space can be used for many systems.
///
/// For a body in parts (mesh/mesh_part.h) the groups are those of all parts. Groups of this part come first, and then
/// those of other parts that this part has copies of vertices of. All processes must call the constructor, update()
/// and solve().
template <class T>
class CoarseSpace {
 public:
  using Record = Eigen::Matrix<T, 4, 1>;
  using Motion = CoarseMatrix::Motion;  ///< t, ω
  /// Returns the 3 × 3 block that is added to K at the vertex at a place.
  using VertexTerm = std::function<Matrix3(Index)>;

  CoarseSpace(const MechanicalSystem& system, const VertexGroups& groups);
  CoarseSpace(const CoarseSpace&) = delete;
  CoarseSpace& operator=(const CoarseSpace&) = delete;

  /// Sets A = K + the blocks of the vertices + the outer products, which may be null, with K linearised
  /// at x. Returns false if PᵀAP is not positive definite; then there is no coarse space
  /// until the next update.
  bool update(const TangentOperator<T>& stiffness, const VertexTerm& vertex_term, const Vector& x,
              const OuterProducts<T>* outers = nullptr);

  /// (a_v, w_v) of the vertex at a place.
  Eigen::Map<const Record, Eigen::Aligned16> arm(Index place) const {
    return Eigen::Map<const Record, Eigen::Aligned16>(arms_.data() + 4 * place);
  }
  /// Before solve() the part of Pᵀr of an own group, which the caller sets; afterwards the group's
  /// motion.
  Motion& motion(Index group) { return motions_[static_cast<std::size_t>(group)]; }
  /// After solve() the motion of the group that the vertex at a place belongs to, also of a copy.
  const Motion& motion_of(Index place) const {
    return motions_[static_cast<std::size_t>(group_of_place_[static_cast<std::size_t>(place)])];
  }
  /// motions ← (PᵀAP)⁻¹ motions. Returns the scalar product of the old and the new motions of the whole body.
  double solve() { return matrix_->solve(motions_); }

 private:
  std::vector<std::int32_t> number_groups();
  void set_arms(const Vector& x);
  std::vector<CoarseMatrix::GroupPair> find_neighbors();
  void add_block(const TangentOperator<T>& stiffness, Index block, std::vector<double>& sums) const;
  void flush(Index block, const std::vector<double>& sums);
  void add_outers(const OuterProducts<T>& outers);
  Eigen::Matrix<double, 3, 6> basis(Index place) const;

  const MechanicalSystem& system_;
  const ElementBlocks& blocks_;
  const VertexGroups& groups_;
  AlignedVector<T> arms_;
  std::vector<std::int32_t> group_of_place_;
  std::vector<Motion> motions_;  // of the groups
  // For each block of elements its groups, ascending. For each of its records, which of these
  // groups the vertex belongs to, and the place of the vertex.
  std::vector<std::vector<std::int32_t>> groups_of_block_;
  std::vector<std::uint16_t> group_of_record_;
  std::vector<std::int32_t> place_of_record_;
  std::unique_ptr<CoarseMatrix> matrix_;
};

extern template class CoarseSpace<float>;
extern template class CoarseSpace<double>;

}  // namespace tetraction
