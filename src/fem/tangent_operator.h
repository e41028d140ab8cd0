// ∇²W(q) as an operator that is applied to vectors without assembling a matrix.
#pragma once

#include "element_blocks.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

/// The stiffness of elastic and viscous energy at a fixed q, in precision T (float or double), for
/// isotropic materials. A vector has one record of four numbers per vertex (x y z 0) and is aligned
/// to cache lines. The records are in the order of the vertices or in another order, for instance
/// one that keeps neighbours together. The position of a vertex in this order is its place.
///
/// Products are bitwise the same for any number of threads.
template <class T>
class TangentOperator {
 public:
  /// Whether the kernels know all materials.
  static bool supports(const ElasticPotential& elastic);

  /// Keeps a reference to `elastic`, which must live longer. `order` lists the vertices by place;
  /// if it is empty, the place of a vertex is its number.
  explicit TangentOperator(const ElasticPotential& elastic, std::vector<std::int32_t> order = {});

  /// Linearises W at q, where it must be defined.
  void set(const Vector& q) { set(q, nullptr, q); }
  /// Linearises W + D at q, where D is the dissipation potential of a step that has led to q by
  /// `displacement` (fem/viscous_potential.h).
  void set(const Vector& q, const ViscousPotential& viscous, const Vector& displacement) {
    set(q, viscous.factor() == 0.0 ? nullptr : &viscous, displacement);
  }

  /// Makes K (nearly) positive semidefinite until the next set(). It removes the compressive part
  /// of the initial stress of every element: it adds the multiple of the deformed metric with which
  /// the smallest principal stress vanishes. For neo-Hookean and Saint Venant–Kirchhoff solids K is
  /// then exactly positive semidefinite.
  void convexify();

  /// Computes K x in the records of all blocks. The value at a vertex is the sum over its records
  /// (record_sum()).
  void multiply(const T* x);
  /// The sum of the records of the vertex at a place, after multiply().
  Eigen::Matrix<T, 4, 1> record_sum(Index place) const { return sum(rows_, place); }

  /// The element matrices of a batch of a block, in the format of tangent_stiffness().
  void element_matrices(Index block, Index batch, double* matrices) const;

  /// The diagonal 3 × 3 blocks, as records (xx yy zz 0) and (xy xz yz 0) per place.
  void diagonal(AlignedVector<T>& on, AlignedVector<T>& off);

  /// Whether a bound shows that no element is inverted anywhere between q and q + x.
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
  std::vector<std::int32_t> record_place_;  // of each record of the blocks, or −1: padding
  std::vector<std::size_t> begin_;          // of each block's state
  AlignedVector<T> state_;
  AlignedVector<T> rows_;
};

extern template class TangentOperator<float>;
extern template class TangentOperator<double>;

}  // namespace tetraction
