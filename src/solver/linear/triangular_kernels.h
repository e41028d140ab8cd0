// Triangular solves with part of a sparse Cholesky factor in single precision.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetraction {

// Sizes of the layout that FactorPart describes. They are the same for all instruction sets.
constexpr std::ptrdiff_t kPanelColumns = 64;
constexpr std::ptrdiff_t kBlockColumns = 8;
constexpr std::ptrdiff_t kTileRows = 16;

/// Columns of L with the same rows below their dense triangle.
struct Supernode {
  std::int32_t columns;
  std::int32_t rows;  ///< below the triangle
};

/// Supernodes whose columns follow each other in a vector x.
///
/// A supernode of n columns and m rows below them is a trapezoid of n + m rows. Its columns come in
/// panels of kPanelColumns, those of a panel in blocks of kBlockColumns; the last may be narrower.
/// For each panel `values` has
///   - block by block: the inverse of the block's triangle, by columns from the diagonal down,
///     then the block's rows below that within the panel;
///   - block by block: the block's rows below the panel.
/// Rows of a block lie in tiles of kTileRows, the last one lower if it must, and in a tile column
/// by column. Behind the last tile kTileRows numbers must be readable and finite.
struct FactorPart {
  const Supernode* supernodes;
  std::ptrdiff_t supernode_count;
  const float* values;       ///< of the first supernode
  const float* values_end;   ///< of the last
  const std::int32_t* rows;  ///< the rows below each supernode, as places in x
  const std::int32_t* rows_end;
  std::ptrdiff_t columns;  ///< of all supernodes
};

/// Numbers of a supernode in `values`.
constexpr std::ptrdiff_t trapezoid_size(std::ptrdiff_t columns, std::ptrdiff_t rows) {
  return columns * (columns + 1) / 2 + columns * rows;
}

/// Numbers of work space for a supernode.
constexpr std::ptrdiff_t trapezoid_work(const Supernode& s) {
  return std::ptrdiff_t{s.columns} + s.rows + kTileRows;
}

/// x ← L⁻¹ x in the part's columns. The contributions of these columns to other rows are subtracted
/// from x there. `work` must have the size trapezoid_work() of the largest supernode.
void substitute_forward(const FactorPart& part, float* x, float* work);

/// x ← L⁻ᵀ x in the part's columns. x in the other rows must already be the solution.
void substitute_backward(const FactorPart& part, float* x, float* work);

}  // namespace tetraction
