#include "patch_gradients.h"

#include "fem/kernels/volume_kernels.h"

namespace tetraction {

template <class T>
void PatchGradients<T>::set(const Positions& x) {
  constexpr Index kNumbers = 4 * ElementBlocks::kRecordSize;  // of a lane
  corners_.resize(static_cast<std::size_t>(kNumbers) * patches_.lane_count());
  patches_.for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                             const double* displacements) {
    element_volume_gradients(patches_.blocks().batches(block), positions, displacements,
                             corners_.data() + kNumbers * kBatchLanes * block.first_batch);
  });
}

template class PatchGradients<float>;
template class PatchGradients<double>;

}  // namespace tetraction
