#include "vertex_values.h"

namespace tetraction::petsc {

std::vector<std::vector<Index>> by_process(const MeshChunk& chunk,
                                           const std::vector<Index>& vertices,
                                           const AllToAll& processes) {
  const EqualRanges ranges = chunk.vertex_ranges(processes.count());
  std::vector<std::vector<Index>> lists(static_cast<std::size_t>(processes.count()));
  for (const Index v : vertices) {
    lists[static_cast<std::size_t>(ranges.process_of(v))].push_back(v);
  }
  return lists;
}

std::vector<Vector3> positions_of(const MeshChunk& chunk,
                                  const std::vector<std::vector<Index>>& asked,
                                  const AllToAll& processes) {
  const auto numbers = answers(asked, processes, [&](Index v) {
    const Vector3 x = chunk.mesh.vertices[static_cast<std::size_t>(v - chunk.first_vertex)];
    return std::array<double, 3>{x[0], x[1], x[2]};
  });
  std::vector<Vector3> positions;
  positions.reserve(numbers.size());
  for (const auto& x : numbers) positions.emplace_back(x[0], x[1], x[2]);
  return positions;
}

}  // namespace tetraction::petsc
