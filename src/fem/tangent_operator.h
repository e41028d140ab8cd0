// ∇²W(q) as an operator: applied to vectors without a matrix.
#pragma once

#include "element_blocks.h"
#include "tangent_kernels.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

/// The stiffness of elastic and viscous energy at a fixed q, in precision T (float or double), for
/// isotropic materials. Vectors are rows of four numbers per vertex (x y z 0), cache-line aligned.
///
/// Products are bitwise the same for any number of threads.
template <class T>
class TangentOperator {
 public:
  /// Whether all materials are of the kernels' kinds.
  static bool supports(const ElasticPotential& elastic);

  /// Keeps references, which must live longer.
  explicit TangentOperator(const ElasticPotential& elastic);

  /// Linearises at q; W must be defined there.
  void set(const Vector& q, const ViscousPotential& viscous);

  /// The rows of K x: a vertex' part is the sum over its rows (row_sum).
  void multiply(const T* x);
  /// Σ of a vertex' rows after multiply().
  Eigen::Matrix<T, 4, 1> row_sum(Index vertex) const { return sum(rows_, vertex); }

  /// The diagonal 3 × 3 blocks: rows (xx yy zz 0) and (xy xz yz 0) per vertex.
  void diagonal(AlignedVector<T>& on, AlignedVector<T>& off);

  /// Whether no element can be inverted anywhere between q and q + x, judged by a bound.
  bool step_is_safe(const T* x) const;

 private:
  using Row = Eigen::Matrix<T, 4, 1>;

  Row sum(const AlignedVector<T>& rows, Index vertex) const {
    Row total = Row::Zero();
    for (const std::int32_t* r = blocks_.rows_begin(vertex); r != blocks_.rows_end(vertex); ++r) {
      total += Eigen::Map<const Row, Eigen::Aligned16>(rows.data() + ElementBlocks::kRowSize * *r);
    }
    return total;
  }
  TangentForm form(const ElementBlocks::Block& block) const;
  const T* state(Index b) const { return state_.data() + begin_[static_cast<std::size_t>(b)]; }
  void add_viscosity(Index b, const Vector& q, const ViscousPotential& viscous);

  const ElasticPotential& elastic_;
  const ElementBlocks& blocks_;
  bool viscous_ = false;
  std::vector<std::size_t> begin_;  // of each block's state
  AlignedVector<T> state_;
  AlignedVector<T> rows_;
};

extern template class TangentOperator<float>;
extern template class TangentOperator<double>;

}  // namespace tetraction
