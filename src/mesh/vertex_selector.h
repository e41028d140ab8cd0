// The vertices of selections that are not made of others.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "tetraction/mesh/selection.h"

namespace tetraction {

using Triangle = std::array<Index, 3>;

/// The triangles of the boundary that face in the direction of the selection. Throws InputError for a normal or
/// an angle out of range.
std::vector<Triangle> facing(const TetMesh& mesh, const SelectFaces& s);

/// Visits a selection. Throws InputError for one that does not go with the mesh. Collective for a mesh in parts.
struct VertexSelector {
  const TetMesh& mesh;

  std::vector<Index> operator()(const SelectVertices& s) const;
  std::vector<Index> operator()(const SelectPlane& s) const;
  std::vector<Index> operator()(const SelectBox& s) const;
  std::vector<Index> operator()(const SelectSphere& s) const;
  std::vector<Index> operator()(const SelectNearest& s) const;
  std::vector<Index> operator()(const SelectGroup& s) const;
  std::vector<Index> operator()(const SelectSurface&) const;
  std::vector<Index> operator()(const SelectFaces& s) const;
  std::vector<Index> operator()(const SelectAll&) const;

 private:
  [[noreturn]] void refuse(std::int64_t id, std::int64_t low, std::int64_t high) const;
  // Those of the part. Each must be in some part.
  std::vector<Index> in_part(const SelectVertices& s,
                             const std::unordered_map<std::int64_t, Index>& index_of) const;
  // With the middles of their edges if the mesh is quadratic.
  void add_vertices(const std::vector<Triangle>& faces, std::vector<Index>& found) const;
};

}  // namespace tetraction
