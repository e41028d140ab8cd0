#include "vertex_selector.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "bounding_box.h"
#include "core/quoting.h"
#include "named_groups.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

template <class Predicate>
std::vector<Index> where(const TetMesh& mesh, const Predicate& predicate) {
  std::vector<Index> found;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (predicate(mesh.vertices[static_cast<std::size_t>(v)])) found.push_back(v);
  }
  return found;
}

// Visits a selection.
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
  // The caller takes these apart.
  std::vector<Index> operator()(const SelectSet&) const { return {}; }
  std::vector<Index> operator()(const SelectNamed&) const { return {}; }

 private:
  [[noreturn]] void refuse(std::int64_t id, std::int64_t low, std::int64_t high) const;
  // Those of the part. Each must be in some part.
  std::vector<Index> in_part(const SelectVertices& s,
                             const std::unordered_map<std::int64_t, Index>& index_of) const;
  // With the middles of their edges if the mesh is quadratic.
  void add_vertices(const std::vector<Triangle>& faces, std::vector<Index>& found) const;
};

void VertexSelector::refuse(std::int64_t id, std::int64_t low, std::int64_t high) const {
  throw InputError(fmt::format(
      "vertex {} is not in the mesh: its vertices are numbered {} to {}{}.", id, low, high,
      mesh.report.dropped_vertices > 0 ? ", and those that no tetrahedron uses were dropped" : ""));
}

std::vector<Index> VertexSelector::in_part(
    const SelectVertices& s, const std::unordered_map<std::int64_t, Index>& index_of) const {
  std::vector<Index> found;
  Vector known = Vector::Zero(static_cast<Index>(s.ids.size()));
  for (std::size_t i = 0; i < s.ids.size(); ++i) {
    const auto v = index_of.find(s.ids[i]);
    if (v == index_of.end()) continue;
    known[static_cast<Index>(i)] = 1.0;
    found.push_back(v->second);
  }
  mesh.part->largest(known.data(), known.size());
  const auto [low, high] = mesh.part->whole.vertex_ids;
  for (std::size_t i = 0; i < s.ids.size(); ++i) {
    if (known[static_cast<Index>(i)] == 0.0) refuse(s.ids[i], low, high);
  }
  return found;
}

std::vector<Index> VertexSelector::operator()(const SelectVertices& s) const {
  std::unordered_map<std::int64_t, Index> index_of;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    index_of.emplace(mesh.vertex_id(v), v);
  }
  if (mesh.part) return in_part(s, index_of);
  std::vector<Index> found;
  for (const std::int64_t id : s.ids) {
    const auto v = index_of.find(id);
    if (v == index_of.end()) {
      const auto [low, high] = std::minmax_element(index_of.begin(), index_of.end());
      refuse(id, low->first, high->first);
    }
    found.push_back(v->second);
  }
  return found;
}

std::vector<Index> VertexSelector::operator()(const SelectPlane& s) const {
  if (s.axis < 0 || s.axis > 2) {
    throw InputError(fmt::format("the axis of a plane is 0, 1 or 2 (x, y or z), not {}.", s.axis));
  }
  const double tolerance = s.tolerance.value_or(1e-6 * bounding_box(mesh).diagonal());
  return where(mesh, [&](const Vector3& x) { return std::abs(x[s.axis] - s.at) <= tolerance; });
}

std::vector<Index> VertexSelector::operator()(const SelectBox& s) const {
  return where(mesh, [&](const Vector3& x) {
    return (x.array() >= s.min.array()).all() && (x.array() <= s.max.array()).all();
  });
}

std::vector<Index> VertexSelector::operator()(const SelectSphere& s) const {
  return where(mesh, [&](const Vector3& x) { return (x - s.center).norm() <= s.radius; });
}

std::vector<Index> VertexSelector::operator()(const SelectNearest& s) const {
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
  if (!mesh.part) return {nearest};
  const auto id = static_cast<double>(mesh.vertex_id(nearest));
  const bool is_least = least == least_of_parts(mesh.part.get(), least);
  const double chosen =
      least_of_parts(mesh.part.get(), is_least ? id : std::numeric_limits<double>::infinity());
  std::vector<Index> copies;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (static_cast<double>(mesh.vertex_id(v)) == chosen) copies.push_back(v);
  }
  return copies;
}

std::vector<Index> VertexSelector::operator()(const SelectGroup& s) const {
  const std::vector<const Group*> groups = groups_named(mesh, s.name);
  if (groups.empty()) {
    std::vector<std::string_view> names;
    for (const Group& group : mesh.groups) names.push_back(group.name);
    throw InputError(fmt::format("the mesh has no group {}; it has {}.", in_quotes(s.name),
                                 names.empty() ? "none" : quoted_list(names)));
  }
  refuse_several(groups, s.name);
  return groups.front()->vertices;
}

void VertexSelector::add_vertices(const std::vector<Triangle>& faces,
                                  std::vector<Index>& found) const {
  const EdgeVertices edges(mesh);
  for (const Triangle& face : faces) {
    for (const Index v : edges.of_face(face)) found.push_back(v);
  }
}

std::vector<Index> VertexSelector::operator()(const SelectSurface&) const {
  if (mesh.part) return mesh.part->boundary_vertices;
  std::vector<Index> found;
  add_vertices(boundary_faces(mesh), found);
  return found;
}

std::vector<Index> VertexSelector::operator()(const SelectFaces& s) const {
  std::vector<Index> found;
  add_vertices(facing(mesh, s), found);
  if (!mesh.part) return found;
  // A vertex may have such a triangle in another part only.
  Vector marks = Vector::Zero(mesh.vertex_count());
  for (const Index v : found) marks[v] = 1.0;
  mesh.part->add_shared(marks.data(), 1);
  found.clear();
  for (Index v = 0; v < marks.size(); ++v) {
    if (marks[v] != 0.0) found.push_back(v);
  }
  return found;
}

std::vector<Index> VertexSelector::operator()(const SelectAll&) const {
  return where(mesh, [](const Vector3&) { return true; });
}

}  // namespace

std::vector<Triangle> facing(const TetMesh& mesh, const SelectFaces& s) {
  const double length = s.normal.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw InputError("the normal of faces must be finite and not zero.");
  }
  if (!(s.angle >= 0.0 && s.angle <= 180.0)) {
    throw InputError(
        fmt::format("the angle of faces is {} degrees; it must be from 0 to 180.", s.angle));
  }
  constexpr double kRoundOff = 1e-6;  // degrees
  const Vector3 direction = s.normal / length;
  std::vector<Triangle> faces = boundary_faces(mesh);
  std::erase_if(faces, [&](const Triangle& face) {
    const Vector3 origin = mesh.vertices[static_cast<std::size_t>(face[0])];
    const Vector3 normal = (mesh.vertices[static_cast<std::size_t>(face[1])] - origin)
                               .cross(mesh.vertices[static_cast<std::size_t>(face[2])] - origin);
    const double angle = std::atan2(normal.cross(direction).norm(), normal.dot(direction));
    return angle * (180.0 / std::numbers::pi) > s.angle + kRoundOff;
  });
  return faces;
}

std::vector<Index> selected_by(const TetMesh& mesh, const Selection& selection) {
  return std::visit(VertexSelector{mesh}, selection);
}

}  // namespace tetraction
