// The coarse level of a two-level preconditioner for the Hessian of an implicit step.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "fem/tangent_operator.h"
#include "tetraction/dynamics/step_problem.h"
#include "vertex_groups.h"

namespace tetraction {

/// Near-rigid motions of groups of vertices: vertex v of a group moves by
///
///     u_v = w_v (t + ω × a_v),   a_v = (x_v − centre of the group)/(its radius),
///
/// projected to the directions that constraints leave it (w = 0 for held vertices). With these six
/// motions a group as the columns of P, P (PᵀAP)⁻¹ Pᵀ added to the inverse of the vertices' diagonal
/// blocks takes those errors away that spread over many elements and that the blocks alone need
/// many iterations for (additive two-level Schwarz preconditioner with a coarse space of rigid body
/// modes; Toselli & Widlund 2005, ch. 3 and 8). The number of iterations then depends on the size
/// of a group, and hardly on the mesh, the stiffness or the step.
///
/// x and A are those of the last update(). A preconditioner need not be of the matrix at hand, so one
/// serves for as many systems as it is good for.
template <class T>
class CoarseSpace {
 public:
  using Record = Eigen::Matrix<T, 4, 1>;
  using Motion = Eigen::Matrix<double, 6, 1>;  ///< t, ω
  /// What is added to K at the vertex at a place.
  using VertexTerm = std::function<Matrix3(Index)>;

  CoarseSpace(const MechanicalSystem& system, const VertexGroups& groups);
  ~CoarseSpace();
  CoarseSpace(const CoarseSpace&) = delete;
  CoarseSpace& operator=(const CoarseSpace&) = delete;

  /// Takes A = K + the vertices' terms, K being linearised at x. False if PᵀAP is not positive
  /// definite: then there is no coarse space until the next update.
  bool update(const TangentOperator<T>& stiffness, const VertexTerm& vertex_term, const Vector& x);

  /// (a_v, w_v) of the vertex at a place.
  Eigen::Map<const Record, Eigen::Aligned16> arm(Index place) const {
    return Eigen::Map<const Record, Eigen::Aligned16>(arms_.data() + 4 * place);
  }
  /// Pᵀr of a group, which the caller fills, and after solve() the motion of the group.
  Motion& motion(Index group) { return motions_[static_cast<std::size_t>(group)]; }
  /// motions ← (PᵀAP)⁻¹ motions; returns the product of the two.
  double solve();

 private:
  struct Factor;

  void set_arms(const Vector& x);
  void find_neighbors();
  void add_block(const TangentOperator<T>& stiffness, Index block, std::vector<double>& sums) const;
  void flush(Index block, const std::vector<double>& sums);
  Eigen::Matrix<double, 3, 6> basis(Index place) const;

  const MechanicalSystem& system_;
  const ElementBlocks& blocks_;
  const VertexGroups& groups_;
  AlignedVector<T> arms_;
  std::vector<Motion> motions_;
  // Of each block of elements: its groups, ascending; of each of its rows, which of these, and the
  // vertex' place.
  std::vector<std::vector<std::int32_t>> groups_of_block_;
  std::vector<std::uint16_t> group_of_record_;
  std::vector<std::int32_t> place_of_record_;
  std::unique_ptr<Factor> factor_;
};

extern template class CoarseSpace<float>;
extern template class CoarseSpace<double>;

}  // namespace tetraction
