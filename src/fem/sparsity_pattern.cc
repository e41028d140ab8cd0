#include "tetraction/fem/sparsity_pattern.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include "element_blocks.h"
#include "element_scatter.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// The columns of the coordinates of two vertices.
using SharedColumns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12>;
using SharedBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;

// For every vertex, the vertex that represents its free coordinates, its *owner*. A vertex with free
// coordinates of its own is its own owner. The vertices of an affine set have its first vertex as
// their common owner. The value is −1 for a fully prescribed vertex.
std::vector<Index> coordinate_owners(const FreeCoordinates& coordinates) {
  std::vector<Index> owner(static_cast<std::size_t>(coordinates.vertex_count()));
  for (Index v = 0; v < coordinates.vertex_count(); ++v) {
    const Index set = coordinates.set_of(v);
    owner[static_cast<std::size_t>(v)] =
        set >= 0 ? coordinates.sets()[static_cast<std::size_t>(set)].vertices.front()
                 : (coordinates.is_fully_prescribed(v) ? -1 : v);
  }
  return owner;
}

// For every owner, the ascending list of the elements that depend on its coordinates.
std::vector<std::vector<Index>> elements_of_owners(const RestState& rest,
                                                   const std::vector<Index>& owner) {
  std::vector<std::vector<Index>> elements(owner.size());
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) {
      const Index o = owner[static_cast<std::size_t>(v)];
      if (o < 0) continue;
      auto& list = elements[static_cast<std::size_t>(o)];
      if (list.empty() || list.back() != e) list.push_back(e);
    }
  }
  return elements;
}

// Greedy colouring of items (elements or blocks). Each item, in ascending order, gets the smallest
// colour that no earlier item with a common owner has. for_each_vertex(item, use) must call
// use(vertex) for every vertex of the item. Fully prescribed vertices count as their own owners
// here, so that the order of sums does not depend on the prescribed displacements.
template <class ForEachVertex>
std::vector<std::vector<Index>> color_items(Index count, const std::vector<Index>& owner,
                                            const ForEachVertex& for_each_vertex) {
  std::vector<std::vector<Index>> colors;
  std::vector<std::vector<Index>> colors_of(owner.size());  // per owner
  std::vector<Index> last_conflict;  // per colour: the last item that cannot have it
  const auto owner_of = [&](Index v) {
    const Index o = owner[static_cast<std::size_t>(v)];
    return static_cast<std::size_t>(o < 0 ? v : o);
  };
  for (Index item = 0; item < count; ++item) {
    for_each_vertex(item, [&](Index v) {
      for (const Index c : colors_of[owner_of(v)])
        last_conflict[static_cast<std::size_t>(c)] = item;
    });
    std::size_t c = 0;
    while (c < last_conflict.size() && last_conflict[c] == item) ++c;
    if (c == last_conflict.size()) {
      last_conflict.push_back(-1);
      colors.emplace_back();
    }
    for_each_vertex(item, [&](Index v) {
      auto& list = colors_of[owner_of(v)];
      if (list.empty() || list.back() != static_cast<Index>(c)) {
        list.push_back(static_cast<Index>(c));
      }
    });
    colors[c].push_back(item);
  }
  return colors;
}

}  // namespace

SparsityPattern::SparsityPattern(const RestState& rest, const FreeCoordinates& coordinates,
                                 const std::vector<std::pair<Index, Index>>& pairs)
    : coordinates_(coordinates), rest_(rest) {
  const std::vector<Index> owner = coordinate_owners(coordinates);
  const std::vector<std::vector<Index>> elements = elements_of_owners(rest, owner);
  // For each owner, the owners that are coupled to it by `pairs`.
  std::map<Index, std::vector<Index>> partners;
  for (const auto& [i, j] : pairs) {
    const Index a = owner[static_cast<std::size_t>(i)];
    const Index b = owner[static_cast<std::size_t>(j)];
    if (a < 0 || b < 0 || a == b) continue;
    partners[a].push_back(b);
    partners[b].push_back(a);
  }

  // Owners in the order of their coordinates: vertices first, then affine sets.
  std::vector<std::pair<int, Index>> columns;
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    if (owner[static_cast<std::size_t>(v)] == v) columns.emplace_back(coordinates.map(v).first, v);
  }
  std::sort(columns.begin(), columns.end());
  column_begin_.assign(1, 0);
  std::vector<std::pair<int, int>> adjacent;  // first coordinate and count
  for (const auto& [first, v] : columns) {
    adjacent.clear();
    const auto add = [&, column = first](Index o) {
      if (o < 0) return;
      const FreeCoordinates::VertexMap map = coordinates.map(o);
      if (map.first >= column) adjacent.emplace_back(map.first, map.count);
    };
    for (const Index e : elements[static_cast<std::size_t>(v)]) {
      for (const Index w : rest.nodes(e)) add(owner[static_cast<std::size_t>(w)]);
    }
    if (const auto found = partners.find(v); found != partners.end()) {
      for (const Index o : found->second) add(o);
    }
    std::sort(adjacent.begin(), adjacent.end());
    adjacent.erase(std::unique(adjacent.begin(), adjacent.end()), adjacent.end());
    const int count = coordinates.map(v).count;
    for (int column = first; column < first + count; ++column) {
      for (const auto& [begin, size] : adjacent) {
        for (int row = std::max(begin, column); row < begin + size; ++row) row_.push_back(row);
      }
      if (row_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
        throw InputError("The stiffness matrix has more than 2^31 entries: take an explicit step.");
      }
      column_begin_.push_back(static_cast<int>(row_.size()));
    }
  }

  const auto node_count = static_cast<std::size_t>(rest.nodes_per_element());
  const std::size_t pair_count = node_count * (node_count - 1) / 2;
  const auto element_count = static_cast<std::size_t>(rest.element_count());
  first_.resize(node_count * element_count);
  offset_.resize(pair_count * element_count);
  has_element_entries_.assign(element_count, 1);
  parallel_for(rest.element_count(), 1024, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      const ElementNodes nodes = rest.nodes(e);
      int* first = first_.data() + static_cast<std::size_t>(e) * node_count;
      int* offset = offset_.data() + static_cast<std::size_t>(e) * pair_count;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const bool free = coordinates.is_free(nodes[a]);
        if (!free && !coordinates.is_fully_prescribed(nodes[a]))
          has_element_entries_[static_cast<std::size_t>(e)] = 0;
        first[a] = free ? coordinates.first(nodes[a]) : -1;
      }
      if (has_element_entries_[static_cast<std::size_t>(e)] == 0) continue;
      for (std::size_t a = 0; a < node_count; ++a) {
        for (std::size_t c = a + 1; c < node_count; ++c, ++offset) {
          const auto [column, row] = std::minmax(first[a], first[c]);
          if (column < 0) continue;
          *offset = find(row, column) - column_begin_[static_cast<std::size_t>(column)];
        }
      }
    }
  });
  owner_ = owner;
}

const std::vector<std::vector<Index>>& SparsityPattern::colors() const {
  if (colors_.empty()) {
    colors_ = color_items(rest_.element_count(), owner_, [&](Index e, const auto& use) {
      for (const Index v : rest_.nodes(e)) use(v);
    });
  }
  return colors_;
}

const std::vector<std::vector<Index>>& BlockAccess::colors(const SparsityPattern& pattern,
                                                           const ElementBlocks& blocks) {
  if (pattern.colored_blocks_ != &blocks) {
    pattern.colored_blocks_ = &blocks;
    pattern.block_colors_ =
        color_items(blocks.block_count(), pattern.owner_, [&](Index b, const auto& use) {
          const ElementBlocks::Block& block = blocks.block(b);
          for (Index r = 0; r < block.record_count; ++r) {
            const Index v = blocks.record_vertex(block.first_record + r);
            if (v >= 0) use(v);
          }
        });
  }
  return pattern.block_colors_;
}

int SparsityPattern::find(int row, int column) const {
  const auto begin = row_.begin() + column_begin_[static_cast<std::size_t>(column)];
  const auto end = row_.begin() + column_begin_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - row_.begin());
}

// values += the lower triangle of the block that begins in this row and column.
void SparsityPattern::scatter_block(int first_row, int first_column,
                                    const Eigen::Ref<const Matrix>& block, double* values) const {
  for (Index j = 0; j < block.cols(); ++j) {
    const int column = first_column + static_cast<int>(j);
    // The rows of a vertex are beside each other in every column that has them.
    double* place = nullptr;
    for (Index i = std::max<Index>(0, column - first_row); i < block.rows(); ++i) {
      const double entry = block(i, j);
      if (entry == 0.0) continue;
      const int row = first_row + static_cast<int>(i);
      if (place == nullptr) place = values + find(row, column) - row;
      place[row] += entry;
    }
  }
}

// The caller calls it for both orders of two vertices. The entries above the diagonal, which one call leaves out,
// are added below the diagonal by the other.
void SparsityPattern::scatter_mapped(const FreeCoordinates::VertexMap& rows,
                                     const FreeCoordinates::VertexMap& columns,
                                     const Matrix3& block, double* values) const {
  const SharedColumns image = block.lazyProduct(columns.columns);
  scatter_block(rows.first, columns.first, SharedBlock(rows.columns.transpose().lazyProduct(image)),
                values);
}

void SparsityPattern::scatter(Index e, const Eigen::Ref<const Matrix>& local,
                              double* values) const {
  if (const auto to = element_entries(e)) {
    scatter_element(
        *to, column_begin_, [&](int a, int i, int j) { return local(3 * a + i, 3 * a + j); },
        [&](int, int a, int b) {
          return StridedBlock{local.data() + 3 * a + 3 * b * local.outerStride(), 1,
                              static_cast<int>(local.outerStride())};
        },
        values);
    return;
  }
  scatter_shared(e, local, values);
}

// Vertices of a rigid handle share their coordinates. Their blocks are added up before they are added to the matrix.
void SparsityPattern::scatter_shared(Index e, const Eigen::Ref<const Matrix>& local,
                                     double* values) const {
  constexpr std::size_t kMostNodes = 10;
  struct Coordinates {
    int first = 0;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3 * kMostNodes, 12> columns;
  };
  std::array<Coordinates, kMostNodes> all;
  std::size_t count = 0;
  const ElementNodes nodes = rest_.nodes(e);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const FreeCoordinates::VertexMap map = coordinates_.map(nodes[a]);
    if (map.count == 0) continue;
    std::size_t i = 0;
    while (i < count && all[i].first != map.first) ++i;
    if (i == count) {
      all[count].first = map.first;
      all[count].columns.setZero(local.rows(), map.count);
      ++count;
    }
    all[i].columns.middleRows<3>(3 * static_cast<Index>(a)) = map.columns;
  }
  for (std::size_t c = 0; c < count; ++c) {
    const Matrix image = local * all[c].columns;
    for (std::size_t r = 0; r < count; ++r) {
      if (all[r].first < all[c].first) continue;
      scatter_block(all[r].first, all[c].first, all[r].columns.transpose() * image, values);
    }
  }
}

void SparsityPattern::add_vertex_blocks(const Matrix& blocks, double* values) const {
  for (Index v = 0; v < coordinates_.vertex_count(); ++v) {
    if (coordinates_.is_fully_prescribed(v)) continue;
    const FreeCoordinates::VertexMap map = coordinates_.map(v);
    scatter_mapped(map, map, blocks.middleCols<3>(3 * v), values);
  }
}

bool SparsityPattern::couples(Index i, Index j) const {
  const FreeCoordinates::VertexMap a = coordinates_.map(i);
  const FreeCoordinates::VertexMap b = coordinates_.map(j);
  if (a.count == 0 || b.count == 0) return true;
  const int column = std::min(a.first, b.first);
  const int row = std::max(a.first, b.first);
  const auto begin = row_.begin() + column_begin_[static_cast<std::size_t>(column)];
  const auto end = row_.begin() + column_begin_[static_cast<std::size_t>(column) + 1];
  return std::binary_search(begin, end, row);
}

void SparsityPattern::add_pair_block(Index i, Index j, const Matrix3& block, double* values) const {
  if (coordinates_.is_fully_prescribed(i) || coordinates_.is_fully_prescribed(j)) return;
  if (coordinates_.is_free(i) && coordinates_.is_free(j)) {
    const bool below = coordinates_.first(i) > coordinates_.first(j);
    const int column = coordinates_.first(below ? j : i);
    // The first column of the block has one more entry above it than the second.
    int place = find(coordinates_.first(below ? i : j), column) -
                column_begin_[static_cast<std::size_t>(column)];
    for (int c = 0; c < 3; ++c, --place) {
      Eigen::Map<Vector3> to(values + column_begin_[static_cast<std::size_t>(column + c)] + place);
      to += below ? Vector3(block.col(c)) : Vector3(block.row(c));
    }
    return;
  }
  const FreeCoordinates::VertexMap rows = coordinates_.map(i);
  const FreeCoordinates::VertexMap columns = coordinates_.map(j);
  scatter_mapped(rows, columns, block, values);
  scatter_mapped(columns, rows, block.transpose(), values);
}

}  // namespace tetraction
