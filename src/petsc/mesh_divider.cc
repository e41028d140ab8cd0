#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "mesh/bounding_box.h"
#include "mesh_distribution.h"

namespace tetraction::petsc {
namespace {

using Triangle = std::array<Index, 3>;

Triangle sorted(Triangle triangle) {
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

// The numbers of a part's vertices by those of the whole mesh.
class LocalNumbers {
 public:
  explicit LocalNumbers(const std::vector<Index>& vertices) {
    numbers_.reserve(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      numbers_.emplace(vertices[i], static_cast<Index>(i));
    }
  }
  bool has(Index v) const { return numbers_.contains(v); }
  Index operator()(Index v) const { return numbers_.at(v); }

 private:
  std::unordered_map<Index, Index> numbers_;
};

// What a group has in a part. Groups stay in all parts, so that their names are known there.
Group part_of_group(const Group& group, const LocalNumbers& vertex,
                    const std::vector<Index>& tetrahedra) {
  Group part;
  part.name = group.name;
  part.dimension = group.dimension;
  part.tag = group.tag;
  part.detached_triangles = group.detached_triangles;
  part.detached_lines = group.detached_lines;
  for (const Index v : group.vertices) {
    if (vertex.has(v)) part.vertices.push_back(vertex(v));
  }
  std::sort(part.vertices.begin(), part.vertices.end());
  for (const Index e : group.tetrahedra) {
    const auto place = std::lower_bound(tetrahedra.begin(), tetrahedra.end(), e);
    if (place != tetrahedra.end() && *place == e) {
      part.tetrahedra.push_back(place - tetrahedra.begin());
    }
  }
  return part;
}

// Whether all of them are in the part, whose numbers they then get.
template <std::size_t kCount>
bool to_local(const LocalNumbers& vertex, std::array<Index, kCount>& vertices) {
  if (!std::all_of(vertices.begin(), vertices.end(), [&](Index v) { return vertex.has(v); })) {
    return false;
  }
  for (Index& v : vertices) v = vertex(v);
  return true;
}

Matrix columns_of(const Matrix& values, const std::vector<Index>& columns) {
  Matrix result(values.rows(), static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result.col(static_cast<Index>(i)) = values.col(columns[i]);
  }
  return result;
}

}  // namespace

MeshDivider::MeshDivider(const TetMesh& mesh, const std::vector<int>& part_of_tetrahedron,
                         int parts)
    : mesh_(mesh), tetrahedra_(static_cast<std::size_t>(parts)) {
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const int part = part_of_tetrahedron[static_cast<std::size_t>(e)];
    tetrahedra_[static_cast<std::size_t>(part)].push_back(e);
  }
  // For each part in turn, use(v) for each of its vertices, once.
  std::vector<int> last(vertices);
  const auto for_each_use = [&](const auto& use) {
    std::fill(last.begin(), last.end(), -1);
    for (int part = 0; part < parts; ++part) {
      for (const Index e : tetrahedra_[static_cast<std::size_t>(part)]) {
        for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
          if (std::exchange(last[static_cast<std::size_t>(v)], part) != part) use(v, part);
        }
      }
    }
  };
  first_.assign(vertices + 1, 0);
  for_each_use([&](Index v, int) { ++first_[static_cast<std::size_t>(v) + 1]; });
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
  sharers_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for_each_use([&](Index v, int part) { sharers_[next[static_cast<std::size_t>(v)]++] = part; });

  on_boundary_.assign(vertices, 0);
  for (const Triangle& face : boundary_faces(mesh)) {
    for (const Index v : face) on_boundary_[static_cast<std::size_t>(v)] = 1;
    boundary_.push_back(sorted(face));
  }
  std::sort(boundary_.begin(), boundary_.end());

  whole_.vertices = mesh.vertex_count();
  whole_.tetrahedra = mesh.tetrahedron_count();
  whole_.volume = mesh.total_volume();
  whole_.fingerprints = fingerprints_of(mesh);
  const BoundingBox box = bounding_box(mesh);
  whole_.low = box.low;
  whole_.high = box.high;
  whole_.vertex_ids = {std::numeric_limits<std::int64_t>::max(),
                       std::numeric_limits<std::int64_t>::min()};
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    whole_.vertex_ids.first = std::min(whole_.vertex_ids.first, mesh.vertex_id(v));
    whole_.vertex_ids.second = std::max(whole_.vertex_ids.second, mesh.vertex_id(v));
  }
}

PartData MeshDivider::part(int number) const {
  PartData data;
  data.whole = whole_;
  const std::vector<Index>& tetrahedra = tetrahedra_[static_cast<std::size_t>(number)];
  std::vector<Index> own;
  std::vector<Index> copies;
  std::map<int, std::vector<Index>> shared;  // by the neighbour, in the numbers of the whole mesh
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    const auto begin =
        sharers_.begin() + static_cast<std::ptrdiff_t>(first_[static_cast<std::size_t>(v)]);
    const auto end =
        sharers_.begin() + static_cast<std::ptrdiff_t>(first_[static_cast<std::size_t>(v) + 1]);
    if (!std::binary_search(begin, end, number)) continue;
    // Owners take turns.
    const int owner = *(begin + v % (end - begin));
    (owner == number ? own : copies).push_back(v);
    for (auto other = begin; other != end; ++other) {
      if (*other != number) shared[*other].push_back(v);
    }
  }
  data.owned_vertices = static_cast<Index>(own.size());
  std::vector<Index> vertices = std::move(own);
  vertices.insert(vertices.end(), copies.begin(), copies.end());
  const LocalNumbers local(vertices);
  for (auto& [rank, list] : shared) {
    Neighbor neighbor{rank, {}};
    for (const Index v : list) neighbor.shared.push_back(local(v));
    data.neighbors.push_back(std::move(neighbor));
  }

  TetMesh& mesh = data.mesh;
  mesh.vertices.own().reserve(vertices.size());
  mesh.vertex_ids.reserve(vertices.size());
  mesh.tetrahedra.own().reserve(tetrahedra.size());
  mesh.tetrahedron_ids.reserve(tetrahedra.size());
  if (!mesh_.regions.empty()) mesh.regions.reserve(tetrahedra.size());
  mesh.source = mesh_.source;
  mesh.report = mesh_.report;
  for (const Index v : vertices) {
    mesh.vertices.own().push_back(mesh_.vertices[static_cast<std::size_t>(v)]);
    mesh.vertex_ids.push_back(mesh_.vertex_id(v));
    if (on_boundary_[static_cast<std::size_t>(v)] != 0) data.boundary_vertices.push_back(local(v));
  }
  std::sort(data.boundary_vertices.begin(), data.boundary_vertices.end());
  for (const Index e : tetrahedra) {
    std::array<Index, 4> corners{};
    std::size_t a = 0;
    for (const Index v : mesh_.tetrahedra[static_cast<std::size_t>(e)]) corners[a++] = local(v);
    mesh.tetrahedra.own().push_back(corners);
    mesh.tetrahedron_ids.push_back(mesh_.tetrahedron_id(e));
    if (!mesh_.regions.empty()) mesh.regions.push_back(mesh_.region(e));
  }
  // Not the faces that the part has in common with others.
  const auto is_boundary = [this](const Triangle& face) {
    return std::binary_search(boundary_.begin(), boundary_.end(), sorted(face));
  };
  std::set<Triangle> own_faces;
  for (const Triangle& face : boundary_faces(mesh)) {
    if (!is_boundary({vertices[static_cast<std::size_t>(face[0])],
                      vertices[static_cast<std::size_t>(face[1])],
                      vertices[static_cast<std::size_t>(face[2])]})) {
      continue;
    }
    data.boundary_faces.push_back(face);
    own_faces.insert(sorted(face));
  }
  for (const Group& group : mesh_.groups) {
    Group part = part_of_group(group, local, tetrahedra);
    for (Triangle triangle : group.triangles) {
      const bool is_outer = is_boundary(triangle);
      if (!to_local(local, triangle)) continue;
      // A triangle of the boundary belongs to the part of its tetrahedron.
      if (!is_outer || own_faces.contains(sorted(triangle))) part.triangles.push_back(triangle);
    }
    for (std::array<Index, 2> line : group.lines) {
      if (to_local(local, line)) part.lines.push_back(line);
    }
    mesh.groups.push_back(std::move(part));
  }
  for (const auto& [name, values] : mesh_.point_arrays) {
    mesh.point_arrays[name] = columns_of(values, vertices);
  }
  for (const auto& [name, values] : mesh_.cell_arrays) {
    mesh.cell_arrays[name] = columns_of(values, tetrahedra);
  }
  data.vertex_numbers = std::move(vertices);
  return data;
}

}  // namespace tetraction::petsc
