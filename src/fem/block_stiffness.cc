#include "block_stiffness.h"

#include "element_scatter.h"

namespace tetraction {
namespace {

// Adds an element's matrix, in the numbers of tangent_stiffness() with a stride of kBatchLanes.
void scatter_numbers(const SparsityPattern& pattern, const SparsityPattern::ElementEntries& entries,
                     const double* numbers, double* values) {
  constexpr int kLanes = kBatchLanes;
  scatter_element(
      entries, pattern.column_begin(),
      [&](int a, int i, int j) { return numbers[(6 * a + j * (5 - j) / 2 + i) * kLanes]; },
      [&](int k) {
        return StridedBlock{numbers + (24 + 9 * k) * kLanes, 3 * kLanes, kLanes};
      },
      values);
}

}  // namespace

void add_block_stiffness(const ElementBlocks& blocks, const ElementBlocks::Block& block,
                         TangentForm form, const double* state, const SparsityPattern& pattern,
                         double* values, const std::function<void(Index)>& other) {
  alignas(64) double matrices[std::size_t{kStiffnessNumbers} * kBatchLanes];
  const Index numbers = Index{tangent_numbers(form)} * kBatchLanes;
  for (Index batch = 0; batch < block.batch_count; ++batch) {
    tangent_stiffness(form, state + batch * numbers, matrices);
    for (int lane = 0; lane < kBatchLanes; ++lane) {
      const Index e = blocks.element(block.first_batch + batch, lane);
      if (e < 0) continue;
      if (const SparsityPattern::ElementEntries* entries = pattern.element_entries(e)) {
        scatter_numbers(pattern, *entries, matrices + lane, values);
      } else {
        other(e);
      }
    }
  }
}

}  // namespace tetraction
