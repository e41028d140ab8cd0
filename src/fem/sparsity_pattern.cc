#include "tetraction/fem/sparsity_pattern.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Vertices that share an element with `vertex`, itself included, ascending.
void neighbours(const RestState& rest, Index vertex, std::vector<Index>& result) {
  result.clear();
  for (auto* i = rest.incidence_begin(vertex); i != rest.incidence_end(vertex); ++i) {
    const auto& nodes = rest.nodes(i->element);
    result.insert(result.end(), nodes.begin(), nodes.end());
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
}

// Greedy colouring in element order: the least colour that no element at the same vertices has.
std::vector<std::vector<Index>> color_elements(const RestState& rest) {
  std::vector<std::vector<Index>> colors;
  std::vector<int> color_of(static_cast<std::size_t>(rest.element_count()), -1);
  std::vector<Index> last_use;  // per colour: the last element that found it taken
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) {
      for (auto* i = rest.incidence_begin(v); i != rest.incidence_end(v); ++i) {
        const int taken = color_of[static_cast<std::size_t>(i->element)];
        if (taken >= 0) last_use[static_cast<std::size_t>(taken)] = e;
      }
    }
    std::size_t c = 0;
    while (c < last_use.size() && last_use[c] == e) ++c;
    if (c == last_use.size()) {
      last_use.push_back(-1);
      colors.emplace_back();
    }
    color_of[static_cast<std::size_t>(e)] = static_cast<int>(c);
    colors[c].push_back(e);
  }
  return colors;
}

}  // namespace

SparsityPattern::SparsityPattern(const RestState& rest, const DofConstraints& constraints) {
  column_begin_.assign(1, 0);
  std::vector<Index> adjacent;
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    neighbours(rest, v, adjacent);
    for (Index i = 0; i < 3; ++i) {
      const int column = constraints.reduced(3 * v + i);
      if (column < 0) continue;
      for (const Index w : adjacent) {
        for (Index j = 0; j < 3; ++j) {
          const int row = constraints.reduced(3 * w + j);
          if (row >= column) row_.push_back(row);
        }
      }
      if (row_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
        throw InputError("The stiffness matrix has more than 2^31 entries: take an explicit step.");
      }
      column_begin_.push_back(static_cast<int>(row_.size()));
    }
  }

  slots_.resize(static_cast<std::size_t>(rest.element_count()));
  for (Index e = 0; e < rest.element_count(); ++e) {
    const auto& nodes = rest.nodes(e);
    std::array<int, Shape::kDofs> dofs{};
    for (std::size_t a = 0; a < dofs.size(); ++a) {
      dofs[a] = constraints.reduced(3 * nodes[a / 3] + static_cast<Index>(a % 3));
    }
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

  diagonal_slot_.resize(static_cast<std::size_t>(constraints.dof_count()), -1);
  for (Index i = 0; i < constraints.dof_count(); ++i) {
    const int r = constraints.reduced(i);
    if (r >= 0) diagonal_slot_[static_cast<std::size_t>(i)] = find(r, r);
  }
  colors_ = color_elements(rest);
}

int SparsityPattern::find(int row, int column) const {
  const auto begin = row_.begin() + column_begin_[static_cast<std::size_t>(column)];
  const auto end = row_.begin() + column_begin_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - row_.begin());
}

void SparsityPattern::scatter(Index e, const Shape::DofMatrix& local, double* values) const {
  const auto& slots = slots_[static_cast<std::size_t>(e)];
  std::size_t entry = 0;
  for (int j = 0; j < Shape::kDofs; ++j) {
    for (int i = j; i < Shape::kDofs; ++i, ++entry) {
      if (slots[entry] >= 0) values[slots[entry]] += local(i, j);
    }
  }
}

void SparsityPattern::add_diagonal(const Vector& diagonal, double* values) const {
  for (std::size_t i = 0; i < diagonal_slot_.size(); ++i) {
    if (diagonal_slot_[i] >= 0) values[diagonal_slot_[i]] += diagonal[static_cast<Index>(i)];
  }
}

}  // namespace tetraction
