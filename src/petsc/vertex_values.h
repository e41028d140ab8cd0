// Values of vertices that processes with chunks of a mesh exchange.
#pragma once

#include <algorithm>
#include <vector>

#include "mesh_chunk.h"

namespace tetraction::petsc {

/// The place of a number that is in the list.
inline Index place_of(const std::vector<Index>& ascending, Index number) {
  return std::lower_bound(ascending.begin(), ascending.end(), number) - ascending.begin();
}

/// Sorts a list of numbers, and keeps each of them once.
inline void sort_and_unite(std::vector<Index>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// The vertices of tetrahedra, ascending.
template <class Tetrahedra>
std::vector<Index> vertices_of(const Tetrahedra& tetrahedra) {
  std::vector<Index> vertices;
  vertices.reserve(4 * tetrahedra.size());
  for (const std::array<Index, 4> corners : tetrahedra) {
    vertices.insert(vertices.end(), corners.begin(), corners.end());
  }
  sort_and_unite(vertices);
  vertices.shrink_to_fit();
  return vertices;
}

/// Ascending vertices by the processes in whose chunks they are.
std::vector<std::vector<Index>> by_process(const MeshChunk& chunk,
                                           const std::vector<Index>& vertices,
                                           const AllToAll& processes);

/// answer(v) of the process whose chunk has the vertex, for each of the ascending vertices. Collective.
/// asked[p]: the vertices about which process p asks this one (an exchange of by_process()).
template <class Answer>
auto answers(const std::vector<std::vector<Index>>& asked, const AllToAll& processes,
             const Answer& answer) {
  std::vector<std::vector<decltype(answer(Index{0}))>> values;
  for (const std::vector<Index>& vertices : asked) {
    values.emplace_back();
    values.back().reserve(vertices.size());
    for (const Index v : vertices) values.back().push_back(answer(v));
  }
  return processes.exchange_joined(values);
}

/// The positions of the vertices about which this process asks; `asked` as for answers(). Collective.
std::vector<Vector3> positions_of(const MeshChunk& chunk,
                                  const std::vector<std::vector<Index>>& asked,
                                  const AllToAll& processes);

}  // namespace tetraction::petsc
