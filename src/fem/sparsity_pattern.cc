#include "tetraction/fem/sparsity_pattern.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A vertex of each group of coordinates: free and partial vertices stand for themselves, the members
// of an affine set for one another; −1 for held vertices.
std::vector<Index> coordinate_owners(const FreeCoordinates& coordinates) {
  std::vector<Index> owner(static_cast<std::size_t>(coordinates.vertex_count()));
  for (Index v = 0; v < coordinates.vertex_count(); ++v) {
    const Index set = coordinates.set_of(v);
    owner[static_cast<std::size_t>(v)] =
        set >= 0 ? coordinates.sets()[static_cast<std::size_t>(set)].vertices.front()
                 : (coordinates.is_held(v) ? -1 : v);
  }
  return owner;
}

// The elements in which an owner's coordinates take part, ascending.
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

// Greedy colouring in element order: the least colour that no element with the same coordinates has.
// Held vertices count too, so that the order of sums does not depend on what is held.
std::vector<std::vector<Index>> color_elements(const RestState& rest,
                                               const std::vector<Index>& owner) {
  std::vector<std::vector<Index>> colors;
  std::vector<std::vector<Index>> used_by(owner.size());  // colours, per owner
  std::vector<Index> last_use;  // per colour: the last element that found it taken
  const auto colored_as = [&](Index v) {
    const Index o = owner[static_cast<std::size_t>(v)];
    return o < 0 ? v : o;
  };
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) {
      const Index o = colored_as(v);
      for (const Index c : used_by[static_cast<std::size_t>(o)]) {
        last_use[static_cast<std::size_t>(c)] = e;
      }
    }
    std::size_t c = 0;
    while (c < last_use.size() && last_use[c] == e) ++c;
    if (c == last_use.size()) {
      last_use.push_back(-1);
      colors.emplace_back();
    }
    for (const Index v : rest.nodes(e)) {
      auto& list = used_by[static_cast<std::size_t>(colored_as(v))];
      if (list.empty() || list.back() != static_cast<Index>(c))
        list.push_back(static_cast<Index>(c));
    }
    colors[c].push_back(e);
  }
  return colors;
}

}  // namespace

SparsityPattern::SparsityPattern(const RestState& rest, const FreeCoordinates& coordinates)
    : coordinates_(coordinates), rest_(rest) {
  const std::vector<Index> owner = coordinate_owners(coordinates);
  const std::vector<std::vector<Index>> elements = elements_of_owners(rest, owner);

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
    for (const Index e : elements[static_cast<std::size_t>(v)]) {
      for (const Index w : rest.nodes(e)) {
        const Index o = owner[static_cast<std::size_t>(w)];
        if (o < 0) continue;
        const FreeCoordinates::VertexMap map = coordinates.map(o);
        if (map.first >= first) adjacent.emplace_back(map.first, map.count);
      }
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

  slots_.resize(static_cast<std::size_t>(rest.element_count()));
  is_simple_.assign(slots_.size(), 1);
  for (Index e = 0; e < rest.element_count(); ++e) {
    const auto& nodes = rest.nodes(e);
    std::array<int, Shape::kDofs> dofs{};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const bool free = coordinates.is_free(nodes[a]);
      if (!free && !coordinates.is_held(nodes[a])) is_simple_[static_cast<std::size_t>(e)] = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        dofs[3 * a + i] = free ? coordinates.first(nodes[a]) + static_cast<int>(i) : -1;
      }
    }
    if (is_simple_[static_cast<std::size_t>(e)] == 0) continue;
    std::size_t entry = 0;
    for (std::size_t j = 0; j < dofs.size(); ++j) {
      for (std::size_t i = j; i < dofs.size(); ++i, ++entry) {
        slots_[static_cast<std::size_t>(e)][entry] =
            dofs[i] < 0 || dofs[j] < 0
                ? -1
                : find(std::max(dofs[i], dofs[j]), std::min(dofs[i], dofs[j]));
      }
    }
  }
  colors_ = color_elements(rest, owner);
}

int SparsityPattern::find(int row, int column) const {
  const auto begin = row_.begin() + column_begin_[static_cast<std::size_t>(column)];
  const auto end = row_.begin() + column_begin_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - row_.begin());
}

// values += the lower triangle of rowsᵀ block columns. Called for both orders of two vertices, so
// that what one leaves out above the diagonal the other brings below it.
void SparsityPattern::scatter_block(const FreeCoordinates::VertexMap& rows,
                                    const FreeCoordinates::VertexMap& columns, const Matrix3& block,
                                    double* values) const {
  for (int j = 0; j < columns.count; ++j) {
    const Vector3 image = block * columns.columns.col(j);
    for (int i = 0; i < rows.count; ++i) {
      const int row = rows.first + i;
      const int column = columns.first + j;
      const double entry = rows.columns.col(i).dot(image);
      if (row >= column && entry != 0.0) values[find(row, column)] += entry;
    }
  }
}

void SparsityPattern::scatter(Index e, const Shape::DofMatrix& local, double* values) const {
  if (is_simple_[static_cast<std::size_t>(e)] != 0) {
    const auto& slots = slots_[static_cast<std::size_t>(e)];
    std::size_t entry = 0;
    for (int j = 0; j < Shape::kDofs; ++j) {
      for (int i = j; i < Shape::kDofs; ++i, ++entry) {
        if (slots[entry] >= 0) values[slots[entry]] += local(i, j);
      }
    }
    return;
  }
  std::array<FreeCoordinates::VertexMap, Shape::kNodes> maps;
  for (std::size_t a = 0; a < maps.size(); ++a) maps[a] = coordinates_.map(rest_.nodes(e)[a]);
  for (int a = 0; a < Shape::kNodes; ++a) {
    for (int b = 0; b < Shape::kNodes; ++b) {
      scatter_block(maps[static_cast<std::size_t>(a)], maps[static_cast<std::size_t>(b)],
                    local.block<3, 3>(3 * a, 3 * b), values);
    }
  }
}

void SparsityPattern::add_vertex_blocks(const Matrix& blocks, double* values) const {
  for (Index v = 0; v < coordinates_.vertex_count(); ++v) {
    if (coordinates_.is_held(v)) continue;
    const FreeCoordinates::VertexMap map = coordinates_.map(v);
    scatter_block(map, map, blocks.middleCols<3>(3 * v), values);
  }
}

}  // namespace tetraction
