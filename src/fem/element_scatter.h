// Adds element matrices to an assembled matrix.
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

/// Adds the symmetric matrix of an element to the lower triangle in `values`. Two functions give the
/// blocks of the matrix: diagonal(a, i, j) is entry (i, j), i ≥ j, of the diagonal block of node a, and
/// pair(k, a, b) is the block with the rows of node a and the columns of node b, which is pair k in the
/// order of SparsityPattern::ElementEntries::offset.
template <class Diagonal, class Pair>
void scatter_element(const SparsityPattern::ElementEntries& element,
                     const std::vector<int>& column_begin, const Diagonal& diagonal,
                     const Pair& pair, double* values) {
  const auto column = [&](int j) { return values + column_begin[static_cast<std::size_t>(j)]; };
  for (int a = 0; a < element.nodes; ++a) {
    const int first = element.first[a];
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
  int k = 0;
  for (int a = 0; a < element.nodes; ++a) {
    for (int b = a + 1; b < element.nodes; ++b, ++k) {
      const int first = element.first[a];
      const int second = element.first[b];
      if (first < 0 || second < 0) continue;
      // The block in the lower triangle has the rows of the node with the larger first coordinate.
      const StridedBlock block = pair(k, a, b);
      const int along_row = first > second ? block.row : block.column;
      const int along_column = first > second ? block.column : block.row;
      for (int c = 0; c < 3; ++c) {
        double* entries = column(std::min(first, second) + c) + element.offset[k] - c;
        const double* from = block.begin + c * along_column;
        entries[0] += from[0];
        entries[1] += from[along_row];
        entries[2] += from[2 * along_row];
      }
    }
  }
}

}  // namespace tetraction
