// The gradients of the volumes of patches.
#pragma once

#include "nodal_patches.h"

namespace tetraction {

/// b = ∂(Σ 6v)/∂x of every patch at given positions, in precision T (float or double). The differences
/// of positions are formed in double precision.
template <class T>
class PatchGradients {
 public:
  using Record = Eigen::Matrix<T, 4, 1>;  ///< (x y z 0)

  /// Keeps a reference to `patches`, which must live longer.
  explicit PatchGradients(const NodalPatches& patches) : patches_(patches), rows_(patches.rows()) {}

  void set(const Positions& x);

  /// store(patch, entry, b) for all entries of all patches (NodalPatches::Rows), once for each entry, in
  /// parallel.
  template <class Store>
  void for_each(const Store& store) const {
    constexpr Index kGrain = 4096;
    parallel_for(static_cast<Index>(rows_.sums.size()) - 1, kGrain, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        const auto* sum = rows_.sums.data() + i;
        Record b = Record::Zero();
        for (std::size_t k = sum->corner_begin; k < sum[1].corner_begin; ++k) {
          b += Eigen::Map<const Record, Eigen::Aligned16>(
              corners_.data() + ElementBlocks::kRecordSize * static_cast<Index>(rows_.corners[k]));
        }
        store(sum->patch, sum->entry, b);
        if (sum->other_patch >= 0) store(sum->other_patch, sum->other_entry, Record(-b));
      }
    });
  }

 private:
  const NodalPatches& patches_;
  const NodalPatches::Rows& rows_;
  AlignedVector<T> corners_;  // ∂(6v)/∂x of the corners of all lanes, as records
};

extern template class PatchGradients<float>;
extern template class PatchGradients<double>;

}  // namespace tetraction
