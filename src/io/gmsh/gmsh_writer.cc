#include "gmsh_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "io/mesh/mesh_text.h"
#include "tetraction/fem/rest_state.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using PhysicalTags = std::vector<int>;

struct GmshElement {
  std::int64_t tag = 0;
  std::vector<Index> nodes;
};

// Elements of one dimension that belong to the same physical groups.
struct GmshEntity {
  PhysicalTags physicals;
  std::vector<GmshElement> elements;
};

// Dimension of what the format and this program both know; -1 for the others.
int dimension_of(const RawCell& cell) {
  const std::size_t nodes = cell.vertices.size();
  if (cell.type == CellType::kVertex && nodes == 1) return 0;
  if (cell.type == CellType::kLine && (nodes == 2 || nodes == 3)) return 1;
  if (cell.type == CellType::kTriangle && (nodes == 3 || nodes == 6)) return 2;
  return -1;
}

// The file's own numbers if they are all at least 1, else numbers from 1. id(i): the number of item i.
template <class Id>
std::vector<std::int64_t> positive_ids(Index count, const Id& id) {
  std::vector<std::int64_t> ids;
  ids.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) ids.push_back(id(i));
  const std::int64_t least = *std::min_element(ids.begin(), ids.end());
  if (least < 1) {
    for (std::int64_t& number : ids) number += 1 - least;
  }
  return ids;
}

class GmshWriter {
 public:
  GmshWriter(const TetMesh& mesh, const std::vector<RawCell>& cells) : mesh_(mesh) {
    choose_tags();
    sort_tetrahedra();
    sort_cells(cells);
    number_cells();
  }

  std::string text() {
    std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    append_names(text);
    append_entities(text);
    append_nodes(text);
    append_elements(text);
    for (const auto& [name, values] : mesh_.cell_arrays) {
      append_array(text, "ElementData", name, values, tetrahedron_ids_);
    }
    for (const auto& [name, values] : mesh_.point_arrays) {
      append_array(text, "NodeData", name, values, nodes_);
    }
    return text;
  }

  MeshWriteReport report() && { return std::move(report_); }

 private:
  // A physical tag for each group. A volume group can have its own number only if the tetrahedra of
  // the region of this number all belong to it.
  void choose_tags() {
    std::array<std::set<int>, 4> used;
    for (Index e = 0; e < mesh_.tetrahedron_count(); ++e) used[3].insert(mesh_.region(e));
    std::array<std::set<int>, 4> taken;
    tags_.assign(mesh_.groups.size(), 0);
    for (std::size_t g = 0; g < tags_.size(); ++g) {
      const Group& group = mesh_.groups[g];
      const auto d = static_cast<std::size_t>(group.dimension);
      if (group.tag > 0 && (d < 3 || holds_region(group)) && taken[d].insert(group.tag).second) {
        tags_[g] = group.tag;
        used[d].insert(group.tag);
      }
    }
    for (std::size_t g = 0; g < tags_.size(); ++g) {
      auto& numbers = used[static_cast<std::size_t>(mesh_.groups[g].dimension)];
      if (tags_[g] > 0) continue;
      tags_[g] = 1;
      while (!numbers.insert(tags_[g]).second) ++tags_[g];
    }
  }

  bool holds_region(const Group& group) const {
    for (Index e = 0; e < mesh_.tetrahedron_count(); ++e) {
      if (mesh_.region(e) == group.tag &&
          !std::binary_search(group.tetrahedra.begin(), group.tetrahedra.end(), e)) {
        return false;
      }
    }
    return true;
  }

  GmshEntity& entity(int dimension, const PhysicalTags& physicals) {
    auto& entities = entities_[static_cast<std::size_t>(dimension)];
    const auto [found, inserted] =
        entity_of_.emplace(std::pair{dimension, physicals}, entities.size());
    if (inserted) entities.push_back({physicals, {}});
    return entities[found->second];
  }

  // The region's tag comes last, because this program's reader takes the last tag as the region.
  void sort_tetrahedra() {
    std::vector<PhysicalTags> physicals(mesh_.tetrahedra.size());
    for (std::size_t g = 0; g < tags_.size(); ++g) {
      for (const Index e : mesh_.groups[g].tetrahedra) {
        if (tags_[g] != mesh_.region(e)) physicals[static_cast<std::size_t>(e)].push_back(tags_[g]);
      }
    }
    std::map<PhysicalTags, std::vector<Index>> members;  // in ascending order of the regions
    tetrahedron_ids_ = positive_ids(mesh_.tetrahedron_count(),
                                    [this](Index e) { return mesh_.tetrahedron_id(e); });
    for (Index e = 0; e < mesh_.tetrahedron_count(); ++e) {
      PhysicalTags& own = physicals[static_cast<std::size_t>(e)];
      // A reader takes the last group for the region.
      const int region = mesh_.region(e);
      report_.changed_regions =
          report_.changed_regions || region < 0 || (region == 0 && !own.empty());
      if (region > 0) own.push_back(region);
      members[own].push_back(e);
    }
    const RestState rest(mesh_);
    for (const auto& [own, elements] : members) {
      GmshEntity& target = entity(3, own);
      for (const Index e : elements) {
        const ElementNodes nodes = rest.nodes(e);
        GmshElement element{tetrahedron_ids_[static_cast<std::size_t>(e)],
                            {nodes.begin(), nodes.end()}};
        // Gmsh lists the middles of the edges 23 and 13 in this order.
        if (mesh_.is_quadratic()) std::swap(element.nodes[8], element.nodes[9]);
        target.elements.push_back(std::move(element));
      }
    }
  }

  // Each point, line and triangle once, with all of its groups.
  void sort_cells(const std::vector<RawCell>& cells) {
    std::unordered_map<std::int64_t, Index> index_of_id;
    for (Index v = 0; v < mesh_.vertex_count() && !cells.empty(); ++v) {
      index_of_id.emplace(mesh_.vertex_id(v), v);
    }
    struct Cell {
      int dimension;
      std::vector<Index> nodes;
      std::set<int> physicals;
    };
    std::vector<Cell> kept;
    std::map<std::vector<Index>, std::size_t> known;
    std::vector<bool> whole(mesh_.groups.size(), true);
    std::vector<bool> begun(mesh_.groups.size(), false);
    const auto keep = [&](int dimension, std::vector<Index> nodes, const std::vector<int>& groups) {
      std::vector<Index> key = nodes;
      std::sort(key.begin(), key.end());
      const auto [found, inserted] = known.emplace(std::move(key), kept.size());
      if (inserted) kept.push_back({dimension, std::move(nodes), {}});
      for (const int g : groups) {
        kept[found->second].physicals.insert(tags_[static_cast<std::size_t>(g)]);
      }
    };
    const EdgeVertices edges(mesh_);
    for (const RawCell& cell : cells) {
      const int dimension = dimension_of(cell);
      std::vector<Index> nodes;
      for (const std::int64_t id : cell.vertices) {
        if (const auto found = index_of_id.find(id); found != index_of_id.end()) {
          nodes.push_back(found->second);
        }
      }
      // The cells of a written file have the order of its tetrahedra.
      bool possible = dimension >= 0 && nodes.size() == cell.vertices.size();
      if (possible && dimension > 0) possible = has_order_of_mesh(nodes, dimension, edges);
      for (const int g : cell.groups) {
        (possible ? begun : whole)[static_cast<std::size_t>(g)] = possible;
      }
      if (possible) keep(dimension, std::move(nodes), cell.groups);
    }
    // Without its cells, a group has the triangles or the lines of the mesh.
    for (std::size_t g = 0; g < mesh_.groups.size(); ++g) {
      const Group& group = mesh_.groups[g];
      if (begun[g] || !whole[g] || (group.triangles.empty() && group.lines.empty())) continue;
      begun[g] = true;
      for (const auto& [a, b] : group.lines) {
        std::vector<Index> nodes{a, b};
        if (const Index middle = edges.find(a, b); middle >= 0) nodes.push_back(middle);
        keep(1, std::move(nodes), {static_cast<int>(g)});
      }
      whole[g] = group.detached_triangles.empty() && group.detached_lines == 0;
      for (const auto& triangle : group.triangles) {
        keep(2, edges.of_face(triangle), {static_cast<int>(g)});
      }
    }
    for (Cell& cell : kept) {
      const PhysicalTags own(cell.physicals.begin(), cell.physicals.end());
      // A point has coordinates of its own in the list of entities.
      if (cell.dimension == 0) {
        entities_[0].push_back({own, {{0, std::move(cell.nodes)}}});
      } else {
        entity(cell.dimension, own).elements.push_back({0, std::move(cell.nodes)});
      }
    }
    for (std::size_t g = 0; g < mesh_.groups.size(); ++g) {
      const Group& group = mesh_.groups[g];
      const bool lost = group.dimension == 3 ? group.tetrahedra.empty() : !whole[g] || !begun[g];
      if (lost) report_.lost_groups.push_back(group.name);
    }
  }

  // Gives a linear cell of a quadratic mesh the vertices in the middles of its edges. False if the orders
  // then differ.
  bool has_order_of_mesh(std::vector<Index>& nodes, int dimension,
                         const EdgeVertices& edges) const {
    const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
    if (!mesh_.is_quadratic()) return nodes.size() == corners;
    if (nodes.size() == corners && dimension == 1) {
      if (const Index middle = edges.find(nodes[0], nodes[1]); middle >= 0) nodes.push_back(middle);
    } else if (nodes.size() == corners) {
      nodes = edges.of_face({nodes[0], nodes[1], nodes[2]});
    }
    return nodes.size() == (dimension == 1 ? 3 : 6);
  }

  // Numbers that no tetrahedron has.
  void number_cells() {
    std::set<std::int64_t> used;
    for (const GmshEntity& e : entities_[3]) {
      for (const GmshElement& element : e.elements) used.insert(element.tag);
    }
    std::int64_t next = 1;
    for (std::size_t d = 0; d < 3; ++d) {
      for (GmshEntity& e : entities_[d]) {
        for (GmshElement& element : e.elements) {
          while (used.count(next) > 0) ++next;
          element.tag = next++;
        }
      }
    }
  }

  // The name in quotation marks. Line breaks would end it.
  std::string quoted(std::string name) {
    if (name.find('"') != std::string::npos) report_.names_with_quotes.push_back(name);
    std::replace_if(
        name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    return '"' + name + '"';
  }

  void append_names(std::string& text) {
    std::map<std::pair<int, int>, std::string> names;
    for (std::size_t g = 0; g < tags_.size(); ++g) {
      const Group& group = mesh_.groups[g];
      const auto& entities = entities_[static_cast<std::size_t>(group.dimension)];
      const bool there =
          std::any_of(entities.begin(), entities.end(), [&](const GmshEntity& candidate) {
            return std::count(candidate.physicals.begin(), candidate.physicals.end(), tags_[g]) > 0;
          });
      // A group without a name goes by its number.
      if (!there || group.name == std::to_string(tags_[g])) continue;
      names[{group.dimension, tags_[g]}] = quoted(group.name);
    }
    if (names.empty()) return;
    append(text, "$PhysicalNames\n{}\n", names.size());
    for (const auto& [key, name] : names) {
      append(text, "{} {} {}\n", key.first, key.second, name);
    }
    text += "$EndPhysicalNames\n";
  }

  void append_entities(std::string& text) const {
    Vector3 low = mesh_.vertices.front();
    Vector3 high = low;
    for (const Vector3 x : mesh_.vertices) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    text += "$Entities\n";
    for (std::size_t d = 0; d < 4; ++d) {
      append(text, "{}{}", entities_[d].size(), d < 3 ? " " : "\n");
    }
    for (std::size_t d = 0; d < 4; ++d) {
      int number = 0;
      for (const GmshEntity& e : entities_[d]) {
        append(text, "{} ", ++number);
        if (d == 0) {
          const auto node = static_cast<std::size_t>(e.elements.front().nodes.front());
          text += coordinates(mesh_.vertices[node]);
        } else {
          text += coordinates(low) + ' ' + coordinates(high);
        }
        append(text, " {}", e.physicals.size());
        for (const int tag : e.physicals) append(text, " {}", tag);
        text += d == 0 ? "\n" : " 0\n";
      }
    }
    text += "$EndEntities\n";
  }

  void append_nodes(std::string& text) {
    nodes_ = positive_ids(mesh_.vertex_count(), [this](Index v) { return mesh_.vertex_id(v); });
    const auto [first, last] = std::minmax_element(nodes_.begin(), nodes_.end());
    append(text, "$Nodes\n1 {0} {1} {2}\n3 1 0 {0}\n", nodes_.size(), *first, *last);
    for (const std::int64_t id : nodes_) append(text, "{}\n", id);
    for (const Vector3 x : mesh_.vertices) append(text, "{}\n", coordinates(x));
    text += "$EndNodes\n";
  }

  void append_elements(std::string& text) const {
    // By the dimension, of the first and the second order.
    constexpr std::array<std::array<int, 2>, 4> kTypes{{{15, 15}, {1, 8}, {2, 9}, {4, 11}}};
    const std::size_t order = mesh_.is_quadratic() ? 1 : 0;
    std::size_t blocks = 0;
    std::size_t count = 0;
    std::int64_t least = entities_[3].front().elements.front().tag;
    std::int64_t largest = least;
    for (const auto& entities : entities_) {
      blocks += entities.size();
      for (const GmshEntity& e : entities) {
        count += e.elements.size();
        for (const GmshElement& element : e.elements) {
          least = std::min(least, element.tag);
          largest = std::max(largest, element.tag);
        }
      }
    }
    append(text, "$Elements\n{} {} {} {}\n", blocks, count, least, largest);
    for (std::size_t d = 0; d < 4; ++d) {
      int number = 0;
      for (const GmshEntity& e : entities_[d]) {
        append(text, "{} {} {} {}\n", d, ++number, kTypes[d][order], e.elements.size());
        for (const GmshElement& element : e.elements) {
          append(text, "{}", element.tag);
          for (const Index v : element.nodes) {
            append(text, " {}", nodes_[static_cast<std::size_t>(v)]);
          }
          text += '\n';
        }
      }
    }
    text += "$EndElements\n";
  }

  // The format knows arrays of 1, 3 and 9 components. What has no value is left out.
  void append_array(std::string& text, const char* section, const std::string& name,
                    const Matrix& values, const std::vector<std::int64_t>& ids) {
    if (values.rows() != 1 && values.rows() != 3 && values.rows() != 9) {
      report_.lost_arrays.push_back(name);
      return;
    }
    const auto has_value = [&](Index i) { return !values.col(i).hasNaN(); };
    Index rows = 0;
    for (Index i = 0; i < values.cols(); ++i) rows += has_value(i) ? 1 : 0;
    append(text, "${}\n1\n{}\n1\n0\n3\n0\n{}\n{}\n", section, quoted(name), values.rows(), rows);
    for (Index i = 0; i < values.cols(); ++i) {
      if (!has_value(i)) continue;
      append(text, "{}", ids[static_cast<std::size_t>(i)]);
      for (Index k = 0; k < values.rows(); ++k) append(text, " {}", values(k, i));
      text += '\n';
    }
    append(text, "$End{}\n", section);
  }

  const TetMesh& mesh_;
  std::vector<std::int64_t> tetrahedron_ids_;
  std::vector<int> tags_;  // of the groups
  std::array<std::vector<GmshEntity>, 4> entities_;
  std::map<std::pair<int, PhysicalTags>, std::size_t> entity_of_;
  std::vector<std::int64_t> nodes_;
  MeshWriteReport report_;
};

}  // namespace

MeshWriteReport write_gmsh(const TetMesh& mesh, const std::string& path,
                           const std::vector<RawCell>& cells) {
  GmshWriter writer(mesh, cells);
  write_text_file(path, writer.text());
  return std::move(writer).report();
}

}  // namespace tetraction
