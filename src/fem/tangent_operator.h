// ∇²W(q) as an operator: applied to vectors without a matrix.
#pragma once

#include "element_blocks.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

/// The stiffness of elastic and viscous energy at a fixed q, in precision T (float or double), for
/// isotropic materials. Vectors are rows of four numbers per vertex (x y z 0), cache-line aligned, in
/// the order of the vertices or in another one, for instance one that keeps neighbours together: a
/// vertex' place in it.
///
/// Products are bitwise the same for any number of threads.
template <class T>
class TangentOperator {
 public:
  /// Whether all materials are of the kernels' kinds.
  static bool supports(const ElasticPotential& elastic);

  /// Keeps references, which must live longer. `order`: the vertices by place; empty: by number.
  explicit TangentOperator(const ElasticPotential& elastic, std::vector<std::int32_t> order = {});

  /// Linearises W at q, where it must be defined.
  void set(const Vector& q) { set(q, nullptr, q); }
  /// Linearises W + D, of a step that has led to q by `displacement` (fem/viscous_potential.h).
  void set(const Vector& q, const ViscousPotential& viscous, const Vector& displacement) {
    set(q, viscous.factor() == 0.0 ? nullptr : &viscous, displacement);
  }

  /// Makes K (nearly) positive semidefinite: takes the compressive part of every element's initial
  /// stress away, as a multiple of the deformed metric on which the smallest principal stress vanishes.
  /// Exactly positive semidefinite for neo-Hookean and Saint Venant–Kirchhoff solids. Until set().
  void convexify();

  /// The rows of K x: a vertex' part is the sum over its rows (record_sum).
  void multiply(const T* x);
  /// Σ of the rows of the vertex at a place after multiply().
  Eigen::Matrix<T, 4, 1> record_sum(Index place) const { return sum(rows_, place); }

  /// The elements' matrices of a block's batch, in the numbers of tangent_stiffness().
  void element_matrices(Index block, Index batch, double* matrices) const;

  /// The diagonal 3 × 3 blocks: rows (xx yy zz 0) and (xy xz yz 0) per place.
  void diagonal(AlignedVector<T>& on, AlignedVector<T>& off);

  /// Whether no element can be inverted anywhere between q and q + x, judged by a bound.
  bool step_is_safe(const T* x) const;

 private:
  using Row = Eigen::Matrix<T, 4, 1>;

  void set(const Vector& q, const ViscousPotential* viscous, const Vector& displacement);
  Row sum(const AlignedVector<T>& rows, Index place) const {
    const Index vertex = order_.empty() ? place : order_[static_cast<std::size_t>(place)];
    Row total = Row::Zero();
    for (const std::int32_t* r = blocks_.rows_begin(vertex); r != blocks_.rows_end(vertex); ++r) {
      total +=
          Eigen::Map<const Row, Eigen::Aligned16>(rows.data() + ElementBlocks::kRecordSize * *r);
    }
    return total;
  }
  TangentForm form(const ElementBlocks::Block& block) const;
  static void convexify(TangentForm kind, T* state);
  const T* state(Index b) const { return state_.data() + begin_[static_cast<std::size_t>(b)]; }
  void copy_records(const ElementBlocks::Block& block, const T* x, T* rows) const {
    const std::int32_t* places = record_place_.empty() ? nullptr : record_place_.data();
    blocks_.copy_records(block, x, rows, places);
  }

  const ElasticPotential& elastic_;
  const ElementBlocks& blocks_;
  bool viscous_ = false;
  std::vector<std::int32_t> order_;
  std::vector<std::int32_t> record_place_;  // of each row of the blocks, or −1: padding
  std::vector<std::size_t> begin_;          // of each block's state
  AlignedVector<T> state_;
  AlignedVector<T> rows_;
};

extern template class TangentOperator<float>;
extern template class TangentOperator<double>;

}  // namespace tetraction
