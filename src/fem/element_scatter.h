// The places of an element's matrix in an assembled matrix.
#pragma once

#include <algorithm>
#include <vector>

#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// A 3 × 3 block inside an array: entry (i, j) is begin[i * row + j * column].
struct StridedBlock {
  const double* begin;
  int row;
  int column;
};

/// The pairs of nodes of a tetrahedron, in the order of SparsityPattern::ElementEntries::offset.
constexpr int kNodePairs[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// Adds the symmetric 12 × 12 matrix of an element to the lower triangle in `values`. The matrix is
/// given by blocks of two functions: `diagonal(a, i, j)` is entry (i, j), i ≥ j, of the block of node
/// a, and `pair(k)` is the block in the rows of the first node and the columns of the second node of
/// pair k of kNodePairs.
template <class Diagonal, class Pair>
void scatter_element(const SparsityPattern::ElementEntries& places,
                     const std::vector<int>& column_begin, const Diagonal& diagonal,
                     const Pair& pair, double* values) {
  const auto column = [&](int j) { return values + column_begin[static_cast<std::size_t>(j)]; };
  for (int a = 0; a < 4; ++a) {
    const int first = places.first[static_cast<std::size_t>(a)];
    if (first < 0) continue;
    double* entries = column(first);
    entries[0] += diagonal(a, 0, 0);
    entries[1] += diagonal(a, 1, 0);
    entries[2] += diagonal(a, 2, 0);
    entries = column(first + 1);
    entries[0] += diagonal(a, 1, 1);
    entries[1] += diagonal(a, 2, 1);
    column(first + 2)[0] += diagonal(a, 2, 2);
  }
  for (int k = 0; k < 6; ++k) {
    const int first = places.first[static_cast<std::size_t>(kNodePairs[k][0])];
    const int second = places.first[static_cast<std::size_t>(kNodePairs[k][1])];
    if (first < 0 || second < 0) continue;
    // The rows are those of the node whose coordinates come later.
    const StridedBlock block = pair(k);
    const int along_row = first > second ? block.row : block.column;
    const int along_column = first > second ? block.column : block.row;
    for (int c = 0; c < 3; ++c) {
      double* entries =
          column(std::min(first, second) + c) + places.offset[static_cast<std::size_t>(k)] - c;
      const double* from = block.begin + c * along_column;
      entries[0] += from[0];
      entries[1] += from[along_row];
      entries[2] += from[2 * along_row];
    }
  }
}

}  // namespace tetraction
