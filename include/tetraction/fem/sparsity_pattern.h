// The fixed sparsity pattern of the assembled Hessian: built once, then every element knows where
// its entries go.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// Lower triangle of a symmetric matrix over the free coordinates, compressed by columns with ascending
/// rows: what CHOLMOD takes with stype = −1.
class SparsityPattern {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `rest`, which must live longer.
  SparsityPattern(const RestState& rest, const FreeCoordinates& coordinates);

  /// Number of rows and columns: the free coordinates.
  Index size() const { return static_cast<Index>(column_begin_.size()) - 1; }
  Index nonzeros() const { return static_cast<Index>(row_.size()); }
  /// size() + 1 offsets into rows().
  const std::vector<int>& column_begin() const { return column_begin_; }
  const std::vector<int>& rows() const { return row_; }

  /// Adds Tᵀ K T of the symmetric element matrix K of element e to `values` (nonzeros() numbers).
  void scatter(Index e, const Shape::DofMatrix& local, double* values) const;
  /// Adds Tᵀ B T of symmetric 3 × 3 matrices B, one per vertex (side by side: 3 × 3n).
  void add_vertex_blocks(const Matrix& blocks, double* values) const;

  /// Elements by colour: no two of a colour share a free coordinate, so a colour's elements can be
  /// scattered at once; colours come one after the other, so sums do not depend on the number of
  /// threads.
  const std::vector<std::vector<Index>>& colors() const { return colors_; }

 private:
  static constexpr int kEntries = Shape::kDofs * (Shape::kDofs + 1) / 2;

  int find(int row, int column) const;
  void scatter_block(const FreeCoordinates::VertexMap& rows,
                     const FreeCoordinates::VertexMap& columns, const Matrix3& block,
                     double* values) const;

  FreeCoordinates coordinates_;
  const RestState& rest_;
  std::vector<int> column_begin_;
  std::vector<int> row_;
  // Of elements whose vertices are all free or held; −1: a held vertex takes part. Other elements
  // look their entries up.
  std::vector<std::array<int, kEntries>> slots_;
  std::vector<std::uint8_t> is_simple_;
  std::vector<std::vector<Index>> colors_;
};

}  // namespace tetraction
