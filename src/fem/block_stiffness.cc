#include "block_stiffness.h"

#include <algorithm>

namespace tetraction {
namespace {

// Adds an element matrix of tangent_stiffness(), with a stride of kBatchLanes, to the lower triangle
// of the sparse matrix.
void scatter_matrix(const SparsityPattern::ElementEntries& entries,
                    const std::vector<int>& column_begin, const double* matrix, double* values) {
  const auto number = [&](int k) { return matrix[k * kBatchLanes]; };
  const auto column = [&](int j) { return values + column_begin[static_cast<std::size_t>(j)]; };
  for (std::size_t a = 0; a < 4; ++a) {
    const int first = entries.first[a];
    if (first < 0) continue;
    const int from = 6 * static_cast<int>(a);
    double* c = column(first);
    c[0] += number(from);
    c[1] += number(from + 1);
    c[2] += number(from + 2);
    c = column(first + 1);
    c[0] += number(from + 3);
    c[1] += number(from + 4);
    column(first + 2)[0] += number(from + 5);
  }
  constexpr int kPairs[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  for (int pair = 0; pair < 6; ++pair) {
    const int a = entries.first[static_cast<std::size_t>(kPairs[pair][0])];
    const int b = entries.first[static_cast<std::size_t>(kPairs[pair][1])];
    if (a < 0 || b < 0) continue;
    // The block in the lower triangle has the rows of the node with the larger first coordinate.
    const int along_row = a > b ? 3 : 1;
    const int along_column = a > b ? 1 : 3;
    for (int c = 0; c < 3; ++c) {
      double* to = column(std::min(a, b) + c) + entries.offset[static_cast<std::size_t>(pair)] - c;
      const int from = 24 + 9 * pair + c * along_column;
      to[0] += number(from);
      to[1] += number(from + along_row);
      to[2] += number(from + 2 * along_row);
    }
  }
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
        scatter_matrix(*entries, pattern.column_begin(), matrices + lane, values);
      } else {
        other(e);
      }
    }
  }
}

}  // namespace tetraction
