#include "tetraction/mesh/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

double diagonal(const TetMesh& mesh) {
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3 x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

template <class Predicate>
std::vector<Index> where(const TetMesh& mesh, const Predicate& predicate) {
  std::vector<Index> found;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (predicate(mesh.vertices[static_cast<std::size_t>(v)])) found.push_back(v);
  }
  return found;
}

struct Selector {
  const TetMesh& mesh;

  std::vector<Index> operator()(const SelectVertices& s) const {
    std::unordered_map<std::int64_t, Index> index_of;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      index_of.emplace(mesh.vertex_id(v), v);
    }
    std::vector<Index> found;
    for (const std::int64_t id : s.ids) {
      const auto v = index_of.find(id);
      if (v == index_of.end()) {
        const auto [low, high] = std::minmax_element(index_of.begin(), index_of.end());
        throw InputError(fmt::format(
            "vertex {} is not in the mesh: its vertices are numbered {} to {}{}.", id, low->first,
            high->first,
            mesh.report.dropped_vertices > 0 ? ", and those that no tetrahedron uses were dropped"
                                             : ""));
      }
      found.push_back(v->second);
    }
    return found;
  }

  std::vector<Index> operator()(const SelectPlane& s) const {
    if (s.axis < 0 || s.axis > 2) {
      throw InputError(
          fmt::format("the axis of a plane is 0, 1 or 2 (x, y or z), not {}.", s.axis));
    }
    const double tolerance = s.tolerance.value_or(1e-6 * diagonal(mesh));
    return where(mesh, [&](const Vector3& x) { return std::abs(x[s.axis] - s.at) <= tolerance; });
  }

  std::vector<Index> operator()(const SelectBox& s) const {
    return where(mesh, [&](const Vector3& x) {
      return (x.array() >= s.min.array()).all() && (x.array() <= s.max.array()).all();
    });
  }

  std::vector<Index> operator()(const SelectSphere& s) const {
    return where(mesh, [&](const Vector3& x) { return (x - s.center).norm() <= s.radius; });
  }

  std::vector<Index> operator()(const SelectNearest& s) const {
    if (!s.point.allFinite()) throw InputError("the point to be nearest to is not finite.");
    Index nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const double distance = (mesh.vertices[static_cast<std::size_t>(v)] - s.point).norm();
      if (distance < least) {
        least = distance;
        nearest = v;
      }
    }
    return {nearest};
  }

  std::vector<Index> operator()(const SelectGroup& s) const {
    std::vector<Index> found;
    bool known = false;
    std::string names;
    for (const Group& group : mesh.groups) {
      names += (names.empty() ? "\"" : ", \"") + group.name + "\"";
      if (group.name != s.name) continue;
      known = true;
      found.insert(found.end(), group.vertices.begin(), group.vertices.end());
    }
    if (!known) {
      throw InputError(fmt::format("the mesh has no group \"{}\"; it has {}.", s.name,
                                   names.empty() ? "none" : names));
    }
    return found;
  }

  std::vector<Index> operator()(const SelectSurface&) const {
    std::vector<Index> found;
    for (const auto& face : boundary_faces(mesh))
      found.insert(found.end(), face.begin(), face.end());
    return found;
  }

  std::vector<Index> operator()(const SelectAll&) const {
    return where(mesh, [](const Vector3&) { return true; });
  }
};

}  // namespace

std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection) {
  if (mesh.vertices.empty()) throw InputError("the mesh has no vertices to select from.");
  std::vector<Index> found = std::visit(Selector{mesh}, selection);
  if (found.empty()) {
    throw InputError(
        "the selection selects no vertex. Selections are in the coordinates of the undeformed mesh "
        "(after mesh.scale); `tetraction mesh info` shows its bounding box and groups.");
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<Index> select_tetrahedra(const TetMesh& mesh, const Selection& selection) {
  std::vector<Index> found;
  if (const auto* group = std::get_if<SelectGroup>(&selection)) {
    for (const Group& candidate : mesh.groups) {
      if (candidate.name != group->name) continue;
      found.insert(found.end(), candidate.tetrahedra.begin(), candidate.tetrahedra.end());
    }
  }
  if (found.empty()) {
    const bool by_centroid = std::holds_alternative<SelectBox>(selection) ||
                             std::holds_alternative<SelectSphere>(selection);
    std::vector<std::uint8_t> chosen(mesh.vertices.size(), 0);
    if (by_centroid) {
      TetMesh centroids;
      for (const auto tetrahedron : mesh.tetrahedra) {
        Vector3 sum = Vector3::Zero();
        for (const Index v : tetrahedron) sum += mesh.vertices[static_cast<std::size_t>(v)];
        centroids.vertices.own().push_back(sum / 4.0);
      }
      found = std::visit(Selector{centroids}, selection);
    } else {
      for (const Index v : select_vertices(mesh, selection)) {
        chosen[static_cast<std::size_t>(v)] = 1;
      }
      for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
        const auto tetrahedron = mesh.tetrahedra[static_cast<std::size_t>(e)];
        if (std::all_of(tetrahedron.begin(), tetrahedron.end(),
                        [&](Index v) { return chosen[static_cast<std::size_t>(v)] != 0; })) {
          found.push_back(e);
        }
      }
    }
  }
  if (found.empty()) {
    throw InputError(
        "the selection selects no tetrahedron. A box or a sphere selects those with their centroid "
        "in it, a group its own, anything else those with all four vertices selected; coordinates "
        "are those of the undeformed mesh (after mesh.scale).");
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace tetraction
