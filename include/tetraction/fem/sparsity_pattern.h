// The sparsity pattern of the assembled Hessian. It is built once and knows which entries of the
// sparse matrix belong to each element.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// The lower triangle of a symmetric matrix over the free coordinates, compressed by columns with
/// ascending rows. CHOLMOD takes this format with stype = −1.
class SparsityPattern {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `rest`, which must live longer.
  /// `pairs`: further pairs of vertices that are coupled, besides those of the elements.
  SparsityPattern(const RestState& rest, const FreeCoordinates& coordinates,
                  const std::vector<std::pair<Index, Index>>& pairs = {});

  /// Number of rows and columns: the free coordinates.
  Index size() const { return static_cast<Index>(column_begin_.size()) - 1; }
  Index nonzeros() const { return static_cast<Index>(row_.size()); }
  /// size() + 1 offsets into rows().
  const std::vector<int>& column_begin() const { return column_begin_; }
  const std::vector<int>& rows() const { return row_; }

  /// The position in the sparse matrix of the entries of an element whose vertices are all free or
  /// fully prescribed.
  struct ElementEntries {
    int nodes;         ///< 4 or 10
    const int* first;  ///< first coordinate of each node; −1 if it is fully prescribed
    const int*
        offset;  ///< of the block of each pair of nodes (01 02 03 … 12 13 …): the index of its
                 ///< first entry in the column
  };
  /// The entries of element e. Nothing if a vertex of the element is partly prescribed or belongs to
  /// an affine set.
  std::optional<ElementEntries> element_entries(Index e) const {
    if (has_element_entries_[static_cast<std::size_t>(e)] == 0) return {};
    const int nodes = rest_.nodes_per_element();
    return ElementEntries{nodes, first_.data() + e * nodes,
                          offset_.data() + e * (nodes * (nodes - 1) / 2)};
  }

  /// Adds Tᵀ K T of the symmetric element matrix K of element e to `values` (nonzeros() numbers).
  void scatter(Index e, const Eigen::Ref<const Matrix>& local, double* values) const;
  /// Adds Tᵀ B T of symmetric 3 × 3 matrices B, one per vertex (side by side: 3 × 3n).
  void add_vertex_blocks(const Matrix& blocks, double* values) const;
  /// Whether the pattern contains the entries of the block of two vertices.
  bool couples(Index i, Index j) const;
  /// Adds Tᵀ(B + Bᵀ)T, B being `block` in the rows of vertex i and the columns of vertex j, which
  /// the pattern must couple.
  void add_pair_block(Index i, Index j, const Matrix3& block, double* values) const;

  /// The elements by colour. No two elements of a colour share a free coordinate, so all elements
  /// of a colour can be scattered at the same time. The colours are processed one after the other,
  /// so that sums do not depend on the number of threads.
  const std::vector<std::vector<Index>>& colors() const;

 private:
  friend struct BlockAccess;  // the fast loops of the library (src/fem/element_blocks.h)

  int find(int row, int column) const;
  void scatter_block(int first_row, int first_column, const Eigen::Ref<const Matrix>& block,
                     double* values) const;
  void scatter_mapped(const FreeCoordinates::VertexMap& rows,
                      const FreeCoordinates::VertexMap& columns, const Matrix3& block,
                      double* values) const;
  void scatter_shared(Index e, const Eigen::Ref<const Matrix>& local, double* values) const;

  FreeCoordinates coordinates_;
  const RestState& rest_;
  std::vector<int> column_begin_;
  std::vector<int> row_;
  std::vector<int> first_;  // ElementEntries of all elements
  std::vector<int> offset_;
  std::vector<std::uint8_t> has_element_entries_;   // per element: whether the two above are set
  mutable std::vector<std::vector<Index>> colors_;  // made when first needed
  std::vector<Index> owner_;                        // of the coordinates of each vertex
  mutable std::vector<std::vector<Index>> block_colors_;  // colours of the blocks of elements
  mutable const void* colored_blocks_ = nullptr;          // the blocks that have these colours
};

}  // namespace tetraction
