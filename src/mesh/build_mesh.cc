// Makes the mesh for computations from the contents of a file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "flat_tetrahedra.h"
#include "group_middles.h"
#include "quadratic_rules.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/mesh/tet_mesh.h"
#include "tetrahedron_table.h"

namespace tetraction {

namespace {

bool is_tetrahedron(const RawCell& cell) {
  return cell.type == CellType::kTetrahedron || cell.type == CellType::kQuadraticTetrahedron;
}

// Whether a point, a line or a triangle is in a group of its dimension, which selections take.
bool is_of_group(const RawCell& cell, const std::vector<RawGroup>& groups) {
  const std::array<CellType, 3> types{CellType::kVertex, CellType::kLine, CellType::kTriangle};
  return std::any_of(cell.groups.begin(), cell.groups.end(), [&](int g) {
    if (g < 0 || static_cast<std::size_t>(g) >= groups.size()) return false;
    const int dimension = groups[static_cast<std::size_t>(g)].dimension;
    return dimension >= 0 && dimension < 3 &&
           types[static_cast<std::size_t>(dimension)] == cell.type;
  });
}

class Builder {
 public:
  Builder(RawMesh raw, double scale) : raw_(std::move(raw)), scale_(scale) {}

  TetMesh build() {
    mesh_.source = raw_.source;
    index_vertices();
    take_tetrahedra();
    renumber_vertices();
    orient();
    collect_cell_arrays();
    collect_groups();
    shrink();
    return std::move(mesh_);
  }

 private:
  // Lists that have grown step by step may have twice the memory that they need.
  void shrink() {
    mesh_.vertices.own().shrink_to_fit();
    mesh_.vertex_ids.shrink_to_fit();
    mesh_.tetrahedra.own().shrink_to_fit();
    mesh_.tetrahedron_ids.shrink_to_fit();
    mesh_.regions.shrink_to_fit();
    mesh_.edge_vertices.shrink_to_fit();
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw FileError(raw_.source + ": " + what);
  }

  void index_vertices() {
    if (raw_.vertex_ids.size() != raw_.vertices.size()) {
      refuse("the numbers of vertices and of vertex ids differ.");
    }
    const std::vector<std::int64_t>& ids = raw_.vertex_ids;
    ids_are_consecutive_ = true;
    for (std::size_t i = 1; i < ids.size() && ids_are_consecutive_; ++i) {
      ids_are_consecutive_ = ids[i - 1] < ids[i] && ids[i] - ids[0] == static_cast<std::int64_t>(i);
    }
    if (ids_are_consecutive_) return;
    index_of_id_.reserve(raw_.vertices.size());
    for (std::size_t i = 0; i < raw_.vertices.size(); ++i) {
      if (!index_of_id_.emplace(raw_.vertex_ids[i], i).second) {
        refuse(fmt::format("vertex {} is defined twice.", raw_.vertex_ids[i]));
      }
    }
  }

  std::size_t index_of(std::int64_t id, const RawCell& cell) const {
    if (ids_are_consecutive_) {
      // Any difference of two numbers, without overflow.
      const std::uint64_t index =
          raw_.vertex_ids.empty()
              ? 0
              : static_cast<std::uint64_t>(id) - static_cast<std::uint64_t>(raw_.vertex_ids[0]);
      if (index < raw_.vertex_ids.size()) return index;
    } else if (const auto found = index_of_id_.find(id); found != index_of_id_.end()) {
      return found->second;
    }
    refuse(fmt::format("element {} refers to vertex {}, which the file does not define.", cell.id,
                       id));
  }

  void take_tetrahedra() {
    used_.assign(raw_.vertices.size(), false);
    const auto most = static_cast<std::size_t>(
        std::count_if(raw_.cells.begin(), raw_.cells.end(), is_tetrahedron));
    mesh_.tetrahedra.own().reserve(most);
    mesh_.tetrahedron_ids.reserve(most);
    mesh_.regions.reserve(most);
    if (!raw_.groups.empty()) tetrahedron_of_cell_.assign(raw_.cells.size(), -1);
    TetrahedronTable table(most);
    for (std::size_t c = 0; c < raw_.cells.size(); ++c) {
      const RawCell& cell = raw_.cells[c];
      const bool is_quadratic = cell.type == CellType::kQuadraticTetrahedron;
      if (!is_tetrahedron(cell)) {
        if (!is_of_group(cell, raw_.groups)) ++mesh_.report.skipped_cells[cell.type];
        continue;
      }
      if (is_quadratic && cell.vertices.size() != 10) {
        refuse(fmt::format(
            "element {} is a tetrahedron with {} nodes; there are elements with 4 and with 10. "
            "Write the mesh with first- or second-order elements (Gmsh: -order 2).",
            cell.id, cell.vertices.size()));
      }
      if (!is_quadratic && cell.vertices.size() != 4) {
        refuse(fmt::format("element {} is a tetrahedron with {} vertices.", cell.id,
                           cell.vertices.size()));
      }
      if (!mesh_.tetrahedra.empty() && is_quadratic != mesh_.is_quadratic()) {
        refuse(
            fmt::format("element {} is {}, but element {} is not: a mesh has elements of one "
                        "order. Write it with first-order or with second-order elements only.",
                        cell.id, to_string(cell.type), mesh_.tetrahedron_ids.front()));
      }
      std::array<Index, 4> tetrahedron{};
      for (std::size_t a = 0; a < 4; ++a) {
        const std::size_t v = index_of(cell.vertices[a], cell);
        used_[v] = true;
        tetrahedron[a] = static_cast<Index>(v);
        for (std::size_t b = 0; b < a; ++b) {
          if (tetrahedron[b] == tetrahedron[a]) {
            refuse(fmt::format("element {} has vertex {} twice.", cell.id, cell.vertices[a]));
          }
        }
      }
      const Index first = table.find_or_add(tetrahedron, mesh_.tetrahedra.own());
      if (!tetrahedron_of_cell_.empty()) tetrahedron_of_cell_[c] = first;
      if (first < mesh_.tetrahedron_count()) {
        if (is_quadratic) check_same_middles(cell, first);
        // Files such as Gmsh's version 2 repeat an element for each of its groups.
        ++mesh_.report.skipped_cells[CellType::kTetrahedron];
        continue;
      }
      if (is_quadratic) take_edge_vertices(cell);
      if (!raw_.cell_arrays.empty()) kept_cells_.push_back(static_cast<Index>(c));
      mesh_.tetrahedra.own().push_back(tetrahedron);
      mesh_.tetrahedron_ids.push_back(cell.id);
      mesh_.regions.push_back(cell.region);
    }
    if (mesh_.tetrahedra.empty()) refuse_without_tetrahedra();
    check_element_ids();
  }

  [[noreturn]] void refuse_without_tetrahedra() const {
    std::map<CellType, Index> counts;
    for (const RawCell& cell : raw_.cells) ++counts[cell.type];
    std::string others;
    for (const auto& [type, count] : counts) {
      others += fmt::format("{}{} of type {}", others.empty() ? "" : ", ", count, to_string(type));
    }
    refuse(fmt::format("the mesh holds no tetrahedra ({}). Give a volume mesh of tetrahedra.",
                       others.empty() ? "no cells at all" : "only " + others));
  }

  void check_element_ids() const {
    std::vector<std::int64_t> ids = mesh_.tetrahedron_ids;
    if (!std::is_sorted(ids.begin(), ids.end())) std::sort(ids.begin(), ids.end());
    const auto twice = std::adjacent_find(ids.begin(), ids.end());
    if (twice == ids.end()) return;
    refuse(fmt::format("element {} is defined twice, with different vertices.", *twice));
  }

  // Before vertices are renumbered.
  void check_same_middles(const RawCell& cell, Index first) const {
    std::array<Index, 6> own{};
    for (std::size_t k = 0; k < own.size(); ++k) {
      own[k] = static_cast<Index>(index_of(cell.vertices[4 + k], cell));
    }
    std::array<Index, 6> other = mesh_.edge_vertices[static_cast<std::size_t>(first)];
    std::sort(own.begin(), own.end());
    std::sort(other.begin(), other.end());
    if (own == other) return;
    refuse(
        fmt::format("element {} has the corners of element {}, but other vertices in the middles "
                    "of its edges, which is ambiguous.",
                    cell.id, mesh_.tetrahedron_ids[static_cast<std::size_t>(first)]));
  }

  void take_edge_vertices(const RawCell& cell) {
    auto& middles = mesh_.edge_vertices.emplace_back();
    for (std::size_t k = 0; k < middles.size(); ++k) {
      const std::int64_t id = cell.vertices[4 + k];
      if (std::count(cell.vertices.begin(), cell.vertices.end(), id) > 1) {
        refuse(fmt::format("element {} has vertex {} twice.", cell.id, id));
      }
      const std::size_t v = index_of(id, cell);
      used_[v] = true;
      middles[k] = static_cast<Index>(v);
    }
  }

  void renumber_vertices() {
    new_index_.assign(raw_.vertices.size(), -1);
    std::vector<Index> kept;  // for point arrays
    mesh_.vertices.own().reserve(raw_.vertices.size());
    mesh_.vertex_ids.reserve(raw_.vertices.size());
    for (std::size_t i = 0; i < raw_.vertices.size(); ++i) {
      if (!used_[i]) {
        ++mesh_.report.dropped_vertices;
        continue;
      }
      const Vector3 x = scale_ * raw_.vertices[i];
      if (!x.allFinite()) {
        refuse(fmt::format("vertex {}{} has a coordinate that is not finite.", raw_.vertex_ids[i],
                           user_of(i)));
      }
      new_index_[i] = mesh_.vertex_count();
      mesh_.vertices.own().push_back(x);
      mesh_.vertex_ids.push_back(raw_.vertex_ids[i]);
      if (!raw_.point_arrays.empty()) kept.push_back(static_cast<Index>(i));
    }
    for (auto& t : mesh_.tetrahedra.own()) {
      for (Index& v : t) v = new_index_[static_cast<std::size_t>(v)];
    }
    for (auto& middles : mesh_.edge_vertices) {
      for (Index& v : middles) v = new_index_[static_cast<std::size_t>(v)];
    }
    for (const auto& [name, values] : raw_.point_arrays) {
      if (values.cols() != static_cast<Index>(raw_.vertices.size())) continue;
      mesh_.point_arrays[name] = values(Eigen::all, kept);
    }
  }

  // The text " (of element N)" with an element that uses raw vertex i.
  std::string user_of(std::size_t i) const {
    for (std::size_t e = 0; e < mesh_.tetrahedra.size(); ++e) {
      for (const Index v : mesh_.tetrahedra[e]) {
        if (v == static_cast<Index>(i)) {
          return fmt::format(" (of element {})", mesh_.tetrahedron_ids[e]);
        }
      }
    }
    return "";
  }

  void orient() {
    for (Index e = 0; e < mesh_.tetrahedron_count(); ++e) {
      const double longest = longest_edge(mesh_, e);
      // That of the curved element: its corners may be in a plane, or say the contrary.
      const double volume = mesh_.volume(e);
      if (!std::isfinite(longest * longest * longest) || longest == 0.0) {
        refuse(fmt::format("element {} is of a size that double precision does not hold{}.",
                           mesh_.tetrahedron_ids[static_cast<std::size_t>(e)],
                           scale_ == 1.0 ? "" : fmt::format(" at the scale {}", scale_)));
      }
      if (is_flat(volume, longest)) {
        refuse(
            fmt::format("element {} has no volume ({:.3g} m³ with a longest edge of {:.3g} m). "
                        "Repair or remove it.",
                        mesh_.tetrahedron_ids[static_cast<std::size_t>(e)], volume, longest));
      }
      if (volume < 0.0) {
        auto& t = mesh_.tetrahedra.own()[static_cast<std::size_t>(e)];
        std::swap(t[2], t[3]);
        if (mesh_.is_quadratic()) {
          auto& middles = mesh_.edge_vertices[static_cast<std::size_t>(e)];
          std::swap(middles[2], middles[3]);  // of the edges 02 and 03
          std::swap(middles[1], middles[4]);  // of the edges 12 and 13
        }
        ++mesh_.report.reoriented;
      }
    }
    if (mesh_.is_quadratic()) check_edges();
  }

  void check_edges() const {
    EdgeVertices edges;
    const auto position = [&](Index v) -> Vector3 {
      return mesh_.vertices[static_cast<std::size_t>(v)];
    };
    const auto id = [&](Index v) { return mesh_.vertex_ids[static_cast<std::size_t>(v)]; };
    std::vector<bool> is_corner(mesh_.vertices.size(), false);
    for (const auto t : mesh_.tetrahedra) {
      for (const Index v : t) is_corner[static_cast<std::size_t>(v)] = true;
    }
    for (std::size_t e = 0; e < mesh_.edge_vertices.size(); ++e) {
      const auto t = mesh_.tetrahedra[e];
      const std::int64_t element = mesh_.tetrahedron_ids[e];
      for (std::size_t k = 0; k < kTetrahedronEdges.size(); ++k) {
        const Index a = t[kTetrahedronEdges[k][0]];
        const Index b = t[kTetrahedronEdges[k][1]];
        const Index middle = mesh_.edge_vertices[e][k];
        if (is_corner[static_cast<std::size_t>(middle)]) {
          refuse(
              fmt::format("vertex {} is in the middle of an edge of element {} and a corner of "
                          "another element.",
                          id(middle), element));
        }
        if (edges.add(a, b, middle) != middle) {
          refuse(
              fmt::format("the edge between the vertices {} and {} has vertex {} in its middle in "
                          "element {}, but another one in another element.",
                          id(a), id(b), id(middle), element));
        }
        const Vector3 chord = position(b) - position(a);
        const Vector3 off = position(middle) - 0.5 * (position(a) + position(b));
        if (!(off.norm() < 0.5 * chord.norm())) {
          refuse(
              fmt::format("vertex {} of element {} should be near the middle of the edge between "
                          "the vertices {} and {}, but it is {:.3g} m away, more than half of the "
                          "edge. Its nodes may be in the order of another program.",
                          id(middle), element, id(a), id(b), off.norm()));
        }
      }
      for (const Matrix3& at_point : rest_edges_at_points(mesh_, static_cast<Index>(e))) {
        const double volume = at_point.determinant() / 6.0;
        if (!(volume > 0.0)) {
          refuse(fmt::format(
              "element {} is turned inside out by its curved edges: at one of its quadrature "
              "points det(∂X/∂ξ) is {:.3g} m³. Repair the mesh, or straighten its edges.",
              element, 24.0 * volume));
        }
      }
    }
  }

  void collect_cell_arrays() {
    for (const auto& [name, values] : raw_.cell_arrays) {
      if (values.cols() != static_cast<Index>(raw_.cells.size())) continue;
      mesh_.cell_arrays[name] = values(Eigen::all, kept_cells_);
    }
  }

  void collect_groups() {
    for (const RawGroup& group : raw_.groups) {
      mesh_.groups.push_back({group.name, group.dimension, group.tag, {}, {}});
    }
    for (std::size_t c = 0; c < raw_.cells.size(); ++c) {
      const RawCell& cell = raw_.cells[c];
      for (const int g : cell.groups) {
        if (g < 0 || static_cast<std::size_t>(g) >= mesh_.groups.size()) {
          refuse(fmt::format("element {} belongs to group {}, which does not exist.", cell.id, g));
        }
        Group& group = mesh_.groups[static_cast<std::size_t>(g)];
        for (const std::int64_t id : cell.vertices) {
          const Index v = new_index_[index_of(id, cell)];
          if (v >= 0) group.vertices.push_back(v);
        }
        if (tetrahedron_of_cell_[c] >= 0) group.tetrahedra.push_back(tetrahedron_of_cell_[c]);
      }
    }
    collect_triangles();
    collect_lines();
    if (mesh_.is_quadratic() && !mesh_.groups.empty()) {
      // The triangles and lines of a file may be linear although its tetrahedra are not.
      const EdgeVertices edges(mesh_);
      for (Group& group : mesh_.groups) add_middles(mesh_, edges, group);
    }
    for (Group& group : mesh_.groups) {
      std::sort(group.vertices.begin(), group.vertices.end());
      group.vertices.erase(std::unique(group.vertices.begin(), group.vertices.end()),
                           group.vertices.end());
      std::sort(group.tetrahedra.begin(), group.tetrahedra.end());
      group.tetrahedra.erase(std::unique(group.tetrahedra.begin(), group.tetrahedra.end()),
                             group.tetrahedra.end());
    }
  }

  void collect_triangles() {
    using Triangle = std::array<Index, 3>;
    const auto key_of = [](Triangle triangle) {
      std::sort(triangle.begin(), triangle.end());
      return triangle;
    };
    std::map<Triangle, Triangle> outward;  // the boundary's triangles by their sorted vertices
    for (const RawCell& cell : raw_.cells) {
      const bool is_triangle = cell.vertices.size() == 3 || cell.vertices.size() == 6;
      if (cell.type != CellType::kTriangle || !is_triangle) continue;
      for (const int g : cell.groups) {
        Group& group = mesh_.groups[static_cast<std::size_t>(g)];
        if (group.dimension != 2) continue;
        if (outward.empty()) {
          for (const Triangle& face : boundary_faces(mesh_)) outward.emplace(key_of(face), face);
        }
        Triangle triangle{};
        for (std::size_t a = 0; a < 3; ++a) {
          triangle[a] = new_index_[index_of(cell.vertices[a], cell)];
        }
        if (std::any_of(triangle.begin(), triangle.end(), [](Index v) { return v < 0; })) {
          group.detached_triangles.push_back(
              {cell.vertices[0], cell.vertices[1], cell.vertices[2]});
          continue;
        }
        const auto face = outward.find(key_of(triangle));
        group.triangles.push_back(face != outward.end() ? face->second : triangle);
      }
    }
  }

  void collect_lines() {
    for (const RawCell& cell : raw_.cells) {
      if (cell.type != CellType::kLine || cell.vertices.size() < 2) continue;
      for (const int g : cell.groups) {
        Group& group = mesh_.groups[static_cast<std::size_t>(g)];
        if (group.dimension != 1) continue;
        const Index a = new_index_[index_of(cell.vertices[0], cell)];
        const Index b = new_index_[index_of(cell.vertices[1], cell)];
        if (a >= 0 && b >= 0) {
          group.lines.push_back({a, b});
        } else {
          ++group.detached_lines;
        }
      }
    }
  }

  RawMesh raw_;
  double scale_;
  TetMesh mesh_;
  bool ids_are_consecutive_ = false;
  std::unordered_map<std::int64_t, std::size_t> index_of_id_;  // unless they are
  std::vector<bool> used_;
  std::vector<Index> new_index_;
  std::vector<Index> tetrahedron_of_cell_;  // −1: none; empty without groups
  std::vector<Index> kept_cells_;  // of the file, one for each tetrahedron; for cell arrays
};

}  // namespace

TetMesh build_mesh(RawMesh raw, double scale) {
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    throw InputError(
        fmt::format("The scale of a mesh must be positive and finite, not {}.", scale));
  }
  return Builder(std::move(raw), scale).build();
}

}  // namespace tetraction