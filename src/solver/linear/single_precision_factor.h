// A copy of CHOLMOD's factor in single precision, as a preconditioner of conjugate gradients.
//
// A solve reads the factor twice and computes little with each number, so that its time is the time
// of reading memory. The copy has less than half the bytes and no zeros of the upper triangle, and
// its numbers are in the order of the solve. The supernodes are distributed to independent subtrees
// of the elimination tree and to a top, which takes the rest. The subtrees are solved at the same
// time on several threads. The distribution depends on the factor alone, and so does the result,
// bitwise.
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
/// S = diag(sᵢ), where sᵢ is the power of two above the largest number of row i of L. Therefore no
/// number of L̃ = S⁻¹ L is larger than one, and A may be as badly scaled as double precision
/// allows. The right-hand side is scaled to the size of one, too. If the condition number of the
/// scaled matrix is beyond 1e7, the solution has no correct digits. Numbers of L must lie between
/// 1e-300 and 1e300.
class SinglePrecisionFactor {
 public:
  /// Copies a real factor L Lᵀ, supernodal or simplicial, with indices of type int and sorted
  /// columns. Throws Error if the factor is of another kind or the matrix was not positive
  /// definite. Memory of an earlier copy of the same size is used again, because a copy to new
  /// memory pages takes longer.
  void assign(const cholmod_factor_struct& factor);

  /// solution ← Pᵀ S⁻¹ L̃⁻ᵀ L̃⁻¹ S⁻¹ P right in the unknowns of A, after assign(). `solution` may
  /// be `right`. Several threads must not call it at the same time.
  void solve(const Eigen::Ref<const Vector>& right, Eigen::Ref<Vector> solution);
  void solve(const Eigen::Ref<const Eigen::VectorXf>& right, Eigen::Ref<Eigen::VectorXf> solution);

  Index size() const { return static_cast<Index>(unknown_.size()); }
  /// Numbers of the factor.
  std::size_t nonzeros() const { return value_count_; }
  /// Memory of the copy.
  std::size_t bytes() const;

 private:
  class Source;

  // A subtree or the top. Its vector has the part's own columns, and then the rows of the top in
  // which these columns have numbers.
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
