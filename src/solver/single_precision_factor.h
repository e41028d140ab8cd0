// A copy of CHOLMOD's factor in single precision, for conjugate gradients to precondition with.
//
// A solve reads the factor twice and does next to nothing with each number: its time is that of
// memory. The copy has less than half the bytes, no zeros of the upper triangle, and lies in memory
// in the order of the solve. The supernodes are dealt out to independent subtrees of the elimination
// tree and a top that takes what these leave; the subtrees are solved at once on several threads.
// How they are dealt out depends on the factor alone: so does the result, to the bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "fem/element_blocks.h"
#include "tetraction/core/types.h"
#include "triangular_kernels.h"

struct cholmod_factor_struct;

namespace tetraction {

/// S⁻¹ P A Pᵀ S⁻¹ = L̃ L̃ᵀ in single precision, P the permutation of the factor L Lᵀ = P A Pᵀ.
///
/// S = diag(sᵢ), sᵢ the power of two above the largest number of row i of L, makes no number of
/// L̃ = S⁻¹ L larger than one: A may be as badly scaled as double precision allows. The right-hand
/// side is brought to the size of one, too. What remains is the condition of the scaled matrix:
/// beyond 1e7 the solution has no digits. Numbers of L must lie between 1e-300 and 1e300.
class SinglePrecisionFactor {
 public:
  /// Copies a real L Lᵀ, supernodal or simplicial, with indices of type int and sorted columns. Throws
  /// Error if it is of another kind or the matrix was not positive definite. Memory of an earlier copy
  /// of the same size is used again: on new pages a copy takes longer.
  void assign(const cholmod_factor_struct& factor);

  /// solution ← Pᵀ S⁻¹ L̃⁻ᵀ L̃⁻¹ S⁻¹ P right in the unknowns of A, after `assign`. `solution` may be
  /// `right`. Not for several threads at once.
  void solve(const Eigen::Ref<const Vector>& right, Eigen::Ref<Vector> solution);
  void solve(const Eigen::Ref<const Eigen::VectorXf>& right, Eigen::Ref<Eigen::VectorXf> solution);

  Index size() const { return static_cast<Index>(unknown_.size()); }
  /// Numbers of the factor.
  std::size_t nonzeros() const { return value_count_; }
  /// Memory of the copy.
  std::size_t bytes() const;

 private:
  class Source;

  // A part's vector has its own columns and then the rows of the top that these reach.
  struct Part {
    std::size_t first_supernode = 0;
    std::size_t supernode_count = 0;
    std::int32_t first_column = 0;
    std::int32_t columns = 0;
    std::size_t values = 0;  // begin and end in values_
    std::size_t values_end = 0;
    std::size_t rows = 0;  // in rows_
    std::size_t rows_end = 0;
    std::size_t reach = 0;  // in reach_
    std::size_t reach_end = 0;
    std::size_t vector = 0;  // in vectors_
    std::size_t work = 0;
  };

  void arrange(const Source& source, const std::vector<std::size_t>& order,
               const std::vector<std::int32_t>& part, std::vector<std::int32_t>& place);
  void connect(const Source& source, const std::vector<std::size_t>& order,
               const std::vector<std::int32_t>& place);
  FactorPart view(const Part& p) const;
  template <class T>
  void solve_in(const T* right, T* solution);

  std::vector<Part> parts_;            // the top comes last
  std::vector<Supernode> supernodes_;  // one part's after another's
  std::unique_ptr<float[], void (*)(void*)> values_{nullptr, std::free};
  std::size_t value_count_ = 0;
  std::vector<std::int32_t> rows_;     // below the supernodes, as places in the part's vector
  std::vector<std::int32_t> reach_;    // places in the top's vector
  std::vector<std::int32_t> unknown_;  // of the parts' columns
  std::vector<double> inverse_scale_;  // of the unknowns
  AlignedVector<float> vectors_;       // and work space, of every part its own
};

}  // namespace tetraction
