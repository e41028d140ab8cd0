#include "tetraction/mesh/selection.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/quoting.h"
#include "named_groups.h"
#include "tetraction/core/error.h"
#include "vertex_selector.h"

namespace tetraction {
namespace {

Triangle sorted(Triangle triangle) {
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

std::string text_of(const TetMesh& mesh, const Triangle& triangle) {
  return fmt::format("({}, {}, {})", mesh.vertex_id(triangle[0]), mesh.vertex_id(triangle[1]),
                     mesh.vertex_id(triangle[2]));
}

// Which of the vertices, triangles or tetrahedra are selected.
using Marks = std::vector<std::uint8_t>;

std::vector<Index> numbers_of(const Marks& marks) {
  std::vector<Index> numbers;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i] != 0) numbers.push_back(static_cast<Index>(i));
  }
  return numbers;
}

Marks marks_of(const std::vector<Index>& numbers, std::size_t count) {
  Marks marks(count, 0);
  for (const Index i : numbers) marks[static_cast<std::size_t>(i)] = 1;
  return marks;
}

// `marks(selection)` returns the marks of a part.
template <class MarksOf>
Marks marks_of(const SelectSet& set, const MarksOf& marks) {
  const std::string name = to_string(set.operation);
  if (set.of.empty() || (set.operation == SetOperation::kNot && set.of.size() != 1)) {
    throw InputError(fmt::format("{} has {} selections; it takes {}.", name, set.of.size(),
                                 set.operation == SetOperation::kNot ? "one" : "one or more"));
  }
  Marks result = marks(set.of.front().selection);
  for (std::size_t p = 1; p < set.of.size(); ++p) {
    const Marks next = marks(set.of[p].selection);
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = set.operation == SetOperation::kAllOf ? result[i] & next[i] : result[i] | next[i];
    }
  }
  if (set.operation == SetOperation::kNot) {
    for (std::uint8_t& mark : result) mark = mark == 0 ? 1 : 0;
  }
  return result;
}

const Selection& selection_of(const SelectNamed& named) {
  if (named.of.size() != 1) {
    throw InputError(fmt::format("the selection {} stands for {} selections, not for one.",
                                 in_quotes(named.name), named.of.size()));
  }
  return named.of.front().selection;
}

template <class MarksOf>
Marks marks_of(const SelectNamed& named, const MarksOf& marks) {
  const Selection& selection = selection_of(named);
  try {
    return marks(selection);
  } catch (const InputError& error) {
    throw InputError(fmt::format("selection {}: {}", in_quotes(named.name), error.what()));
  }
}

// The groups of a name that are of the wanted kind. Throws InputError if they are several.
template <class IsWanted>
std::vector<const Group*> groups_of(const TetMesh& mesh, const SelectGroup& s,
                                    const IsWanted& is_wanted) {
  std::vector<const Group*> groups = groups_named(mesh, s.name);
  std::erase_if(groups, [&](const Group* group) { return !is_wanted(*group); });
  refuse_several(groups, s.name);
  return groups;
}

// The marks of vertices.
struct VertexMarks {
  const TetMesh& mesh;

  Marks of(const Selection& selection) const { return std::visit(*this, selection); }

  Marks operator()(const SelectSet& set) const {
    return marks_of(set, [this](const Selection& part) { return of(part); });
  }
  Marks operator()(const SelectNamed& named) const {
    return marks_of(named, [this](const Selection& part) { return of(part); });
  }
  template <class Leaf>
  Marks operator()(const Leaf& leaf) const {
    return marks_of(selected_by(mesh, leaf), mesh.vertices.size());
  }
};

// The marks of simplices all of whose vertices are marked.
template <class Simplices>
Marks with_all_vertices(const Simplices& simplices, const Marks& vertices) {
  Marks marks;
  marks.reserve(simplices.size());
  for (const auto simplex : simplices) {
    marks.push_back(std::all_of(simplex.begin(), simplex.end(), [&](Index v) {
      return vertices[static_cast<std::size_t>(v)] != 0;
    }));
  }
  return marks;
}

// The marks of tetrahedra.
struct TetrahedronMarks {
  const TetMesh& mesh;

  Marks of(const Selection& selection) const { return std::visit(*this, selection); }

  Marks operator()(const SelectSet& set) const {
    return marks_of(set, [this](const Selection& part) { return of(part); });
  }
  Marks operator()(const SelectNamed& named) const {
    return marks_of(named, [this](const Selection& part) { return of(part); });
  }
  Marks operator()(const SelectBox& box) const { return by_centroid(box); }
  Marks operator()(const SelectSphere& sphere) const { return by_centroid(sphere); }
  Marks operator()(const SelectGroup& group) const {
    // A part may have none of the tetrahedra of such a group.
    const std::vector<const Group*> volumes =
        groups_of(mesh, group, [this](const Group& candidate) {
          return !candidate.tetrahedra.empty() || (mesh.part && candidate.dimension == 3);
        });
    return volumes.empty() ? by_vertices(group)
                           : marks_of(volumes.front()->tetrahedra, mesh.tetrahedra.size());
  }
  template <class Leaf>
  Marks operator()(const Leaf& leaf) const {
    return by_vertices(leaf);
  }

 private:
  template <class Leaf>
  Marks by_vertices(const Leaf& leaf) const {
    return with_all_vertices(mesh.tetrahedra, VertexMarks{mesh}(leaf));
  }
  template <class Leaf>
  Marks by_centroid(const Leaf& leaf) const {
    TetMesh centroids;
    for (const auto tetrahedron : mesh.tetrahedra) {
      Vector3 sum = Vector3::Zero();
      for (const Index v : tetrahedron) sum += mesh.vertices[static_cast<std::size_t>(v)];
      centroids.vertices.own().push_back(sum / 4.0);
    }
    return VertexMarks{centroids}(leaf);
  }
};

// Whether a selection has a part that consists of triangles.
struct HasTriangles {
  const TetMesh& mesh;

  bool any(const std::vector<SelectionPart>& parts) const {
    return std::any_of(parts.begin(), parts.end(), [this](const SelectionPart& part) {
      return std::visit(*this, part.selection);
    });
  }
  bool operator()(const SelectSet& set) const { return any(set.of); }
  bool operator()(const SelectNamed& named) const { return any(named.of); }
  bool operator()(const SelectFaces&) const { return true; }
  bool operator()(const SelectGroup& s) const { return !surfaces(s).empty(); }
  std::vector<const Group*> surfaces(const SelectGroup& s) const {
    return groups_of(mesh, s, [this](const Group& group) {
      return !group.triangles.empty() || !group.detached_triangles.empty() ||
             (mesh.part && group.dimension == 2);
    });
  }
  template <class Leaf>
  bool operator()(const Leaf&) const {
    return false;
  }
};

// The marks of the triangles of the boundary.
struct TriangleMarks {
  const TetMesh& mesh;
  const std::vector<Triangle>& boundary;  // in the order of boundary_faces(), by sorted vertices

  Marks of(const Selection& selection) const { return std::visit(*this, selection); }

  Marks operator()(const SelectSet& set) const {
    return marks_of(set, [this](const Selection& part) { return of(part); });
  }
  Marks operator()(const SelectNamed& named) const {
    return marks_of(named, [this](const Selection& part) { return of(part); });
  }
  Marks operator()(const SelectFaces& faces) const {
    Marks marks(boundary.size(), 0);
    for (const Triangle& face : facing(mesh, faces)) mark(face, marks);
    return marks;
  }
  Marks operator()(const SelectGroup& s) const {
    const std::vector<const Group*> surfaces = HasTriangles{mesh}.surfaces(s);
    if (surfaces.empty()) return by_vertices(s);
    const Group& group = *surfaces.front();
    if (!group.detached_triangles.empty()) {
      const auto& triangle = group.detached_triangles.front();
      refuse(group, fmt::format("({}, {}, {})", triangle[0], triangle[1], triangle[2]));
    }
    Marks marks(boundary.size(), 0);
    for (const Triangle& triangle : group.triangles) {
      if (!mark(triangle, marks)) refuse(group, text_of(mesh, triangle));
    }
    return marks;
  }
  template <class Leaf>
  Marks operator()(const Leaf& leaf) const {
    return by_vertices(leaf);
  }

 private:
  [[noreturn]] static void refuse(const Group& group, const std::string& triangle) {
    throw InputError(fmt::format(
        "the triangle of the vertices {} of the group {} is not on the boundary of the body. A "
        "selection of triangles takes such triangles only.",
        triangle, in_quotes(group.name)));
  }
  // False if the triangle is not on the boundary.
  bool mark(const Triangle& triangle, Marks& marks) const {
    const Triangle key = sorted(triangle);
    const auto found =
        std::lower_bound(boundary.begin(), boundary.end(), key,
                         [](const Triangle& a, const Triangle& b) { return sorted(a) < b; });
    if (found == boundary.end() || sorted(*found) != key) return false;
    marks[static_cast<std::size_t>(found - boundary.begin())] = 1;
    return true;
  }
  template <class Leaf>
  Marks by_vertices(const Leaf& leaf) const {
    return with_all_vertices(boundary, VertexMarks{mesh}(leaf));
  }
};

void require_vertices(const TetMesh& mesh) {
  if (mesh.vertices.empty()) throw InputError("the mesh has no vertices to select from.");
}

}  // namespace

// Written out, because clang 14 does not survive defaulted comparisons of a type that contains itself.
bool SelectSet::operator==(const SelectSet& other) const {
  return operation == other.operation && of == other.of;
}
bool SelectNamed::operator==(const SelectNamed& other) const {
  return name == other.name && of == other.of;
}

std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection) {
  require_vertices(mesh);
  std::vector<Index> found = numbers_of(VertexMarks{mesh}.of(selection));
  if (everywhere(mesh.part.get(), found.empty())) {
    throw InputError(
        "the selection selects no vertex. Selections are in the coordinates of the undeformed mesh "
        "(after mesh.scale and mesh.unit); `tetraction mesh info` shows its bounding box and "
        "groups.");
  }
  return found;
}

std::vector<Index> select_tetrahedra(const TetMesh& mesh, const Selection& selection) {
  require_vertices(mesh);
  std::vector<Index> found = numbers_of(TetrahedronMarks{mesh}.of(selection));
  if (everywhere(mesh.part.get(), found.empty())) {
    throw InputError(
        "the selection selects no tetrahedron. A box or a sphere selects those with their centroid "
        "in it, a group its own, anything else those with all four vertices selected; coordinates "
        "are those of the undeformed mesh (after mesh.scale and mesh.unit).");
  }
  return found;
}

std::vector<Triangle> select_triangles(const TetMesh& mesh, const Selection& selection) {
  require_vertices(mesh);
  const std::vector<Triangle> boundary = boundary_faces(mesh);
  const Marks marks = std::visit(HasTriangles{mesh}, selection)
                          ? TriangleMarks{mesh, boundary}.of(selection)
                          : with_all_vertices(boundary, VertexMarks{mesh}.of(selection));
  std::vector<Triangle> found;
  for (const Index t : numbers_of(marks)) found.push_back(boundary[static_cast<std::size_t>(t)]);
  if (everywhere(mesh.part.get(), found.empty())) {
    throw InputError(
        "the selection selects no triangle of the boundary. Faces and groups of triangles select "
        "their own, anything else those with all three vertices selected; coordinates are those of "
        "the undeformed mesh (after mesh.scale and mesh.unit).");
  }
  return found;
}

}  // namespace tetraction
