// ∇²W(q) as an operator that is applied to vectors without assembling a matrix.
#pragma once

#include "element_blocks.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

/// The stiffness of elastic and viscous energy at a fixed q, in precision T (float or double), for
/// isotropic materials. A vector has one record of four numbers (x y z 0) per vertex and is aligned
/// to cache lines. Its records may be in the order of the vertices or in another order, for instance
/// one that keeps neighbours together. The *place* of a vertex is its index in this order.
///
/// Products are bitwise the same for any number of threads.
template <class T>
class TangentOperator {
 public:
  /// Whether all materials are isotropic models, which the kernels can process.
  static bool supports(const ElasticPotential& elastic);

  /// Keeps a reference to `elastic`, which must live longer. `order` lists the vertices by place;
  /// if it is empty, the place of a vertex is its number.
  explicit TangentOperator(const ElasticPotential& elastic, std::vector<std::int32_t> order = {});

  /// Linearises W at q, where it must be defined.
  void set(const Vector& q) { set(q, nullptr, q, nullptr); }
  /// Linearises W + D at q, where D is the dissipation potential of a step that has led to q by
  /// `displacement` (fem/viscous_potential.h). With `tensions` t of all lanes, Pa, which may be null, it
  /// linearises W + D + Σ t_e v_e at constant t, where v_e are the present volumes of the elements.
  void set(const Vector& q, const ViscousPotential& viscous, const Vector& displacement,
           const double* tensions = nullptr) {
    set(q, viscous.factor() == 0.0 ? nullptr : &viscous, displacement, tensions);
  }

  /// Makes K positive semidefinite, or nearly so, until the next set(). In every element it adds that
  /// multiple of the deformed metric to the initial stress with which the smallest principal stress
  /// becomes zero. For neo-Hookean and Saint Venant–Kirchhoff solids K is then exactly positive
  /// semidefinite.
  void convexify();

  /// Computes K x in the records of all blocks. record_sum() gives its value at a vertex.
  void multiply(const T* x);
  /// The sum of the records of the vertex at a place, after multiply().
  Eigen::Matrix<T, 4, 1> record_sum(Index place) const { return sum(records_, place); }

  /// The matrices of the points of a batch of a block, in the format of tangent_stiffness().
  void element_matrices(Index block, Index batch, double* matrices) const;

  /// The diagonal 3 × 3 blocks of K: at each place a record (xx yy zz 0) in `on` and a record
  /// (xy xz yz 0) in `off`.
  void diagonal(AlignedVector<T>& on, AlignedVector<T>& off);

  /// Whether a sufficient condition shows that no element is inverted anywhere between q and q + x.
  bool step_is_safe(const T* x) const;

 private:
  using Record = Eigen::Matrix<T, 4, 1>;

  void set(const Vector& q, const ViscousPotential* viscous, const Vector& displacement,
           const double* tensions);
  Record sum(const AlignedVector<T>& records, Index place) const {
    const Index vertex = order_.empty() ? place : order_[static_cast<std::size_t>(place)];
    Record total = Record::Zero();
    for (const std::int32_t* r = blocks_.records_begin(vertex); r != blocks_.records_end(vertex);
         ++r) {
      total += Eigen::Map<const Record, Eigen::Aligned16>(records.data() +
                                                          ElementBlocks::kRecordSize * *r);
    }
    return total;
  }
  void add_quadratic_diagonal(Index b, AlignedVector<T>& other);
  TangentForm form(const ElementBlocks::Block& block) const;
  static void convexify(TangentForm kind, T* state);
  const T* state(Index b) const { return state_.data() + begin_[static_cast<std::size_t>(b)]; }
  void copy_records(const ElementBlocks::Block& block, const T* x, T* records) const {
    const std::int32_t* places = record_place_.empty() ? nullptr : record_place_.data();
    blocks_.copy_records(block, x, records, places);
  }

  const ElasticPotential& elastic_;
  const ElementBlocks& blocks_;
  bool viscous_ = false;
  std::vector<std::int32_t> order_;
  std::vector<std::int32_t> record_place_;  // place of each record's vertex; −1 for padding
  std::vector<std::size_t> begin_;          // begin of each block in state_
  AlignedVector<T> state_;
  AlignedVector<T> records_;
};

extern template class TangentOperator<float>;
extern template class TangentOperator<double>;

}  // namespace tetraction
