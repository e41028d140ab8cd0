#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <unordered_set>
#include <utility>

#include "core/quoting.h"
#include "groups_by_number.h"
#include "io/text/file_kind.h"
#include "io/text/text_scanner.h"
#include "plain_readers.h"

namespace tetraction {
namespace {

// TetGen's comments go from # to the end of the line. They are replaced by blanks, so that line
// numbers stay right.
std::string without_comments(std::string text) {
  bool comment = false;
  for (char& c : text) {
    if (c == '#') comment = true;
    if (c == '\n') comment = false;
    if (comment) c = ' ';
  }
  return text;
}

std::string read_tetgen_text(const std::string& path) {
  std::string text = read_file(path);
  refuse_other_kinds(path, text, kTetgenKind);
  return without_comments(std::move(text));
}

void read_nodes(TextScanner& in, RawMesh& mesh, std::vector<std::string>& unused) {
  const std::int64_t nodes = in.count("the number of points", 7);
  if (in.integer("the dimension") != 3) in.fail("the dimension is not 3.");
  const std::int64_t attributes = in.count("the number of attributes", 2);
  const std::int64_t markers = in.integer("the boundary-marker flag");
  if (markers != 0 && markers != 1) in.fail("the boundary-marker flag is neither 0 nor 1.");
  if (attributes > 0) unused.push_back(fmt::format("{} attributes of each point", attributes));
  if (markers == 1) unused.emplace_back("the boundary markers of the points");
  mesh.vertex_ids.reserve(static_cast<std::size_t>(nodes));
  mesh.vertices.reserve(static_cast<std::size_t>(nodes));
  for (std::int64_t i = 0; i < nodes; ++i) {
    mesh.vertex_ids.push_back(in.integer("a point number"));
    Vector3 x;
    for (Index c = 0; c < 3; ++c) x[c] = in.real("a coordinate");
    mesh.vertices.push_back(x);
    for (std::int64_t a = 0; a < attributes; ++a) in.real("a point attribute");
    if (markers == 1) in.integer("a boundary marker");
  }
}

void read_elements(TextScanner& in, RawMesh& mesh, std::vector<std::string>& unused) {
  const std::int64_t elements = in.count("the number of tetrahedra", 9);
  const std::int64_t nodes = in.integer("the number of nodes of a tetrahedron");
  if (nodes != 4 && nodes != 10) in.fail("tetrahedra have neither 4 nor 10 nodes.");
  const std::int64_t attributes = in.count("the number of attributes", 2);
  if (attributes > 1) unused.emplace_back("all attributes of the tetrahedra but the first");
  mesh.cells.reserve(static_cast<std::size_t>(elements));
  std::unordered_set<std::int64_t> ids;
  ids.reserve(static_cast<std::size_t>(elements));
  for (std::int64_t e = 0; e < elements; ++e) {
    RawCell cell;
    cell.vertices.reserve(static_cast<std::size_t>(nodes));
    cell.type = nodes == 4 ? CellType::kTetrahedron : CellType::kQuadraticTetrahedron;
    cell.id = in.integer("a tetrahedron number");
    if (!ids.insert(cell.id).second) in.fail(fmt::format("element {} is defined twice.", cell.id));
    for (std::int64_t n = 0; n < nodes; ++n) cell.vertices.push_back(in.integer("a node"));
    for (std::int64_t a = 0; a < attributes; ++a) {
      const double value = in.real("an attribute");
      if (a > 0) continue;
      if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
        in.fail(fmt::format("the region attribute {} of element {} is not an integer.", value,
                            cell.id));
      }
      cell.region = static_cast<int>(value);
    }
    mesh.cells.push_back(std::move(cell));
  }
}

// TetGen has its own order of the nodes in the middles of edges, and other writers of its format have
// theirs. So the node nearest to the middle of an edge belongs to it.
void order_edge_nodes(RawMesh& mesh) {
  std::unordered_map<std::int64_t, std::size_t> index_of_id;
  for (std::size_t i = 0; i < mesh.vertex_ids.size(); ++i) {
    index_of_id.emplace(mesh.vertex_ids[i], i);
  }
  for (RawCell& cell : mesh.cells) {
    if (cell.type != CellType::kQuadraticTetrahedron) continue;
    std::array<Vector3, 10> x;
    bool known = true;
    for (std::size_t a = 0; a < x.size() && known; ++a) {
      const auto found = index_of_id.find(cell.vertices[a]);
      known = found != index_of_id.end();
      if (known) x[a] = mesh.vertices[found->second];
    }
    if (!known) continue;  // build_mesh() names the vertex
    const std::vector<std::int64_t> given = cell.vertices;
    for (std::size_t k = 0; k < kTetrahedronEdges.size(); ++k) {
      const Vector3 middle = 0.5 * (x[kTetrahedronEdges[k][0]] + x[kTetrahedronEdges[k][1]]);
      const auto nearest =
          std::min_element(x.begin() + 4, x.end(), [&](const auto& a, const auto& b) {
            return (a - middle).squaredNorm() < (b - middle).squaredNorm();
          });
      cell.vertices[4 + k] = given[static_cast<std::size_t>(nearest - x.begin())];
    }
  }
}

// The triangles that have a boundary marker. Those of each marker but 0 are a group with its number as
// its name.
void read_faces(TextScanner& in, RawMesh& mesh) {
  const std::int64_t faces = in.count("the number of faces", 7);
  const std::int64_t markers = in.integer("the boundary-marker flag");
  if (markers != 0 && markers != 1) in.fail("the boundary-marker flag is neither 0 nor 1.");
  const std::unordered_set<std::int64_t> known(mesh.vertex_ids.begin(), mesh.vertex_ids.end());
  const bool quadratic =
      !mesh.cells.empty() && mesh.cells.front().type == CellType::kQuadraticTetrahedron;
  GroupsByNumber groups(mesh, 2);
  std::unordered_set<std::int64_t> ids;
  std::map<std::array<std::int64_t, 3>, std::int64_t> marker_of;
  for (std::int64_t f = 0; f < faces; ++f) {
    RawCell cell;
    cell.type = CellType::kTriangle;
    cell.id = in.integer("a face number");
    if (!ids.insert(cell.id).second) in.fail(fmt::format("face {} is defined twice.", cell.id));
    for (int n = 0; n < 3; ++n) {
      cell.vertices.push_back(in.integer("a node"));
      if (!known.contains(cell.vertices.back())) {
        in.fail(fmt::format("face {} refers to point {}, which the .node file does not have.",
                            cell.id, cell.vertices.back()));
      }
    }
    for (int n = 3; quadratic && n < 6; ++n) in.integer("a node");
    const std::vector<std::int64_t>& v = cell.vertices;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
      in.fail(fmt::format("face {} has a point twice.", cell.id));
    }
    if (markers == 1) {
      const std::int64_t marker = in.integer("a boundary marker");
      if (marker != static_cast<std::int32_t>(marker)) {
        in.fail(fmt::format("{} is not a boundary marker (an integer of 32 bits).", marker));
      }
      std::array<std::int64_t, 3> corners{v[0], v[1], v[2]};
      std::sort(corners.begin(), corners.end());
      if (marker_of.emplace(corners, marker).first->second != marker) {
        in.fail(fmt::format("face {} is there already with another marker.", cell.id));
      }
      groups.add(cell, marker);
    }
    // TetGen may write the tetrahedra on both sides here.
    TextScanner rest(in.path(), in.line());
    for (int side = 0; !rest.at_end(); ++side) {
      std::int64_t number = 0;
      const std::string_view word = rest.token("a tetrahedron");
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (side == 2 || error != std::errc() || end != word.data() + word.size()) {
        in.fail(fmt::format("{} after face {} is not one of the tetrahedra on its two sides.",
                            in_quotes(word), cell.id));
      }
    }
    mesh.cells.push_back(std::move(cell));
  }
}

}  // namespace

RawMesh read_tetgen(const std::string& path, std::vector<std::string>& unused) {
  RawMesh mesh;
  mesh.source = path;
  // Either both endings are in capitals or neither is.
  const std::string given = std::filesystem::path(path).extension().string();
  const bool upper = given == ".NODE" || given == ".ELE";
  const auto sibling = [&](const char* extension) {
    return std::filesystem::path(path).replace_extension(extension).string();
  };
  const std::string node_path = sibling(upper ? ".NODE" : ".node");
  const std::string node_text = read_tetgen_text(node_path);
  TextScanner nodes(node_path, node_text);
  read_nodes(nodes, mesh, unused);
  const std::string element_path = sibling(upper ? ".ELE" : ".ele");
  const std::string element_text = read_tetgen_text(element_path);
  TextScanner elements(element_path, element_text);
  read_elements(elements, mesh, unused);
  order_edge_nodes(mesh);
  const auto check_end = [](TextScanner& in) {
    if (!in.at_end()) in.fail("there is more in the file than its first line announces.");
  };
  check_end(nodes);
  check_end(elements);
  const std::string face_path = sibling(upper ? ".FACE" : ".face");
  // read_file() refuses a file that cannot be read, such as a link to itself.
  std::error_code error;
  if (std::filesystem::exists(face_path, error) || error) {
    const std::string face_text = read_tetgen_text(face_path);
    TextScanner faces(face_path, face_text);
    read_faces(faces, mesh);
    check_end(faces);
  }
  return mesh;
}

}  // namespace tetraction
