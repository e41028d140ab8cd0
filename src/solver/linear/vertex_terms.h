// The part of a Hessian that does not come from elements, for products without a matrix.
#pragma once

#include <cstdint>
#include <vector>

#include "outer_products.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"
#include "vertex_groups.h"

namespace tetraction {

/// The terms of ∇²Φ that are quadratic in single vertices, general force terms, and the outer products of nodal
/// volumes, in precision T. A vector has one record (x y z 0) per vertex in the order of the places of some groups.
template <class T>
class VertexTerms {
 public:
  using Record = Eigen::Matrix<T, 4, 1>;

  /// Keeps references to both.
  VertexTerms(const MechanicalSystem& system, const VertexGroups& groups)
      : system_(system), groups_(groups), outers_(groups, system.nodal_volume()) {}

  /// Takes the terms of the problem at u in this form.
  void set(const MinimizationProblem& problem, const Vector& u, HessianForm form);
  /// To be called before add_product() for p.
  void multiply(const AlignedVector<T>& p) {
    if (has_outers_) outers_.multiply(p);
  }
  /// sum += the part of the product with p at a place.
  void add_product(const AlignedVector<T>& p, Index place, Record& sum) const {
    const Record own = record(p, place);
    sum += record(diagonal_, place).cwiseProduct(own);
    if (has_general_) {
      const Record off = record(off_, place);
      sum += Record(off[0] * own[1] + off[1] * own[2], off[0] * own[0] + off[2] * own[2],
                    off[1] * own[0] + off[2] * own[1], T(0));
    }
    if (!neighbors_begin_.empty()) add_neighbors(p, place, sum);
    if (has_outers_) sum += outers_.product(place);
  }
  /// The block on the diagonal at a place that belongs to the vertex alone: the row (xx yy zz 0), and (xy xz yz 0)
  /// if there are general terms.
  Record diagonal(Index place) const { return record(diagonal_, place); }
  Record off_diagonal(Index place) const { return record(off_, place); }
  bool has_off_diagonal() const { return has_general_; }
  /// The same block.
  Matrix3 block(Index place) const;
  const OuterProducts<T>& outers() const { return outers_; }

 private:
  struct Neighbor {
    std::int32_t place = 0;
    Eigen::Matrix<T, 3, 3> block;
  };

  static Eigen::Map<const Record, Eigen::Aligned16> record(const AlignedVector<T>& field,
                                                           Index place) {
    return Eigen::Map<const Record, Eigen::Aligned16>(field.data() + 4 * place);
  }
  void set_neighbors();
  void add_neighbors(const AlignedVector<T>& p, Index place, Record& sum) const;

  const MechanicalSystem& system_;
  const VertexGroups& groups_;
  HessianBlocks terms_;  // the general ones
  bool has_general_ = false;
  AlignedVector<T> diagonal_;
  AlignedVector<T> off_;
  std::vector<Index> neighbors_begin_;  // of each place; empty without pairs
  std::vector<Neighbor> neighbors_;
  std::vector<std::int32_t> place_of_;  // of each vertex; made for the first pairs
  OuterProducts<T> outers_;             // of nodal volumes and terms
  bool has_outers_ = false;
};

extern template class VertexTerms<float>;
extern template class VertexTerms<double>;

}  // namespace tetraction
