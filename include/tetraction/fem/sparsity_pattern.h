// The fixed sparsity pattern of the assembled Hessian: built once, then every element knows where
// its entries go.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

class ElementBlocks;

/// Lower triangle of a symmetric matrix over the free coordinates, compressed by columns with ascending
/// rows: what CHOLMOD takes with stype = −1.
class SparsityPattern {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `rest`, which must live longer.
  /// `pairs`: vertices that are coupled in other ways than by an element.
  SparsityPattern(const RestState& rest, const FreeCoordinates& coordinates,
                  const std::vector<std::pair<Index, Index>>& pairs = {});

  /// Number of rows and columns: the free coordinates.
  Index size() const { return static_cast<Index>(column_begin_.size()) - 1; }
  Index nonzeros() const { return static_cast<Index>(row_.size()); }
  /// size() + 1 offsets into rows().
  const std::vector<int>& column_begin() const { return column_begin_; }
  const std::vector<int>& rows() const { return row_; }

  /// Where the entries of an element go whose vertices are all free or held.
  struct Place {
    std::array<int, 4> first;   ///< coordinate of each node; −1: held
    std::array<int, 6> offset;  ///< of each pair's block (01 02 03 12 13 23) in its first column
  };
  /// Place of element e; null if some vertex is neither free nor held.
  const Place* place(Index e) const {
    return is_simple_[static_cast<std::size_t>(e)] != 0 ? &places_[static_cast<std::size_t>(e)]
                                                        : nullptr;
  }

  /// Adds Tᵀ K T of the symmetric element matrix K of element e to `values` (nonzeros() numbers).
  void scatter(Index e, const Shape::DofMatrix& local, double* values) const;
  /// Adds Tᵀ B T of symmetric 3 × 3 matrices B, one per vertex (side by side: 3 × 3n).
  void add_vertex_blocks(const Matrix& blocks, double* values) const;
  /// Whether there is a place for the block of two vertices.
  bool couples(Index i, Index j) const;
  /// Adds Tᵀ(B + Bᵀ)T, B being `block` in the rows of vertex i and the columns of vertex j, which the
  /// pattern must couple.
  void add_pair_block(Index i, Index j, const Matrix3& block, double* values) const;

  /// Elements by colour: no two of a colour share a free coordinate, so a colour's elements can be
  /// scattered at once; colours come one after the other, so sums do not depend on the number of
  /// threads.
  const std::vector<std::vector<Index>>& colors() const;
  /// The same of blocks of elements (private to the library).
  const std::vector<std::vector<Index>>& block_colors(const ElementBlocks& blocks) const;

 private:
  int find(int row, int column) const;
  void scatter_block(const FreeCoordinates::VertexMap& rows,
                     const FreeCoordinates::VertexMap& columns, const Matrix3& block,
                     double* values) const;

  FreeCoordinates coordinates_;
  const RestState& rest_;
  std::vector<int> column_begin_;
  std::vector<int> row_;
  std::vector<Place> places_;
  std::vector<std::uint8_t> is_simple_;                   // other elements look their entries up
  mutable std::vector<std::vector<Index>> colors_;        // made when first needed
  std::vector<Index> owner_;                              // a vertex of each group of coordinates
  mutable std::vector<std::vector<Index>> block_colors_;  // of colored_blocks_
  mutable const ElementBlocks* colored_blocks_ = nullptr;
};

}  // namespace tetraction
