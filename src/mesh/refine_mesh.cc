// The uniform refinement of a mesh.
#include <algorithm>
#include <array>
#include <utility>

#include "mesh/quadratic_shapes.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

constexpr std::size_t kParts = 8;

// The corners of a part among the ten nodes of a quadratic tetrahedron.
using Corners = std::array<std::size_t, 4>;
using PartCorners = std::array<Corners, kParts>;

// Four parts lie at the corners of the tetrahedron. One of the three diagonals of the octahedron between them divides
// it into four more, each with an edge of the ring around the diagonal.
struct Diagonal {
  std::array<std::size_t, 2> ends;
  std::array<std::size_t, 4> ring;

  constexpr PartCorners parts() const {
    PartCorners corners{{{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}}};
    for (std::size_t i = 0; i < ring.size(); ++i) {
      corners[ring.size() + i] = {ends[0], ends[1], ring[i], ring[(i + 1) % ring.size()]};
    }
    return corners;
  }
};
constexpr std::array<Diagonal, 3> kDiagonals{
    {{{6, 8}, {4, 5, 9, 7}}, {{4, 9}, {5, 6, 7, 8}}, {{7, 5}, {4, 6, 9, 8}}}};

using Nodes = std::array<Index, QuadraticPoints::kNodes>;

Nodes nodes_of(const TetMesh& quadratic, std::size_t e) {
  Nodes nodes{};
  const std::array<Index, 4> corners = quadratic.tetrahedra[e];
  std::copy(corners.begin(), corners.end(), nodes.begin());
  const std::array<Index, 6>& middles = quadratic.edge_vertices[e];
  std::copy(middles.begin(), middles.end(), nodes.begin() + 4);
  return nodes;
}

VolumeCoordinates coordinates_of(std::size_t node) {
  VolumeCoordinates l{};
  if (node < 4) {
    l[node] = 1.0;
  } else {
    for (const std::size_t end : kTetrahedronEdges[node - 4]) l[end] = 0.5;
  }
  return l;
}

// The largest sum of the squared edges of the four parts that a diagonal makes.
double longest_edges(const Diagonal& diagonal, const Nodes& nodes, const VertexArray& places) {
  const auto squared = [&](std::size_t a, std::size_t b) {
    return (places[static_cast<std::size_t>(nodes[a])] - places[static_cast<std::size_t>(nodes[b])])
        .squaredNorm();
  };
  const PartCorners parts = diagonal.parts();
  double largest = 0.0;
  for (std::size_t part = 4; part < kParts; ++part) {
    double sum = 0.0;
    for (const auto& [a, b] : kTetrahedronEdges) sum += squared(parts[part][a], parts[part][b]);
    largest = std::max(largest, sum);
  }
  return largest;
}

// The diagonal whose worst part has the best shape. All parts have the same volume, so that the one with the longest
// edges is the worst (A. Liu, B. Joe, BIT 34, 1994: the mean ratio). With a fixed diagonal repeated refinement would
// make ever flatter tetrahedra. The tetrahedra of a divided cube remain of their kind.
std::size_t best_diagonal(const Nodes& nodes, const VertexArray& places) {
  constexpr double kClearly = 1.0 - 1e-9;  // equal ones differ by round-off
  std::size_t best = 0;
  double shortest = longest_edges(kDiagonals[0], nodes, places);
  for (std::size_t i = 1; i < kDiagonals.size(); ++i) {
    const double edges = longest_edges(kDiagonals[i], nodes, places);
    if (edges >= kClearly * shortest) continue;
    best = i;
    shortest = edges;
  }
  return best;
}

// The shape functions of a tetrahedron in the middles of the edges of a part of it.
std::array<std::array<double, QuadraticPoints::kNodes>, 6> shapes_at_middles(
    const Corners& corners) {
  std::array<std::array<double, QuadraticPoints::kNodes>, 6> shapes{};
  for (std::size_t m = 0; m < shapes.size(); ++m) {
    VolumeCoordinates l = coordinates_of(corners[kTetrahedronEdges[m][0]]);
    const VolumeCoordinates end = coordinates_of(corners[kTetrahedronEdges[m][1]]);
    for (std::size_t i = 0; i < l.size(); ++i) l[i] = 0.5 * (l[i] + end[i]);
    shapes[m] = quadratic_shapes(l);
  }
  return shapes;
}

// Moves the middles of the edges to where the quadratic tetrahedra of the coarse mesh have these points, so that
// curved edges keep their form. Point arrays follow. `diagonals` has the number of that of each coarse tetrahedron.
void take_from_coarse(const TetMesh& coarse, const std::vector<std::size_t>& diagonals,
                      TetMesh& fine) {
  std::vector<Vector3>& vertices = fine.vertices.own();
  for (std::size_t diagonal = 0; diagonal < kDiagonals.size(); ++diagonal) {
    const PartCorners parts = kDiagonals[diagonal].parts();
    for (std::size_t part = 0; part < kParts; ++part) {
      const auto shapes = shapes_at_middles(parts[part]);
      for (std::size_t e = 0; e < coarse.edge_vertices.size(); ++e) {
        if (diagonals[e] != diagonal) continue;
        const Nodes nodes = nodes_of(coarse, e);
        for (std::size_t m = 0; m < shapes.size(); ++m) {
          const Index middle = fine.edge_vertices[kParts * e + part][m];
          Vector3 place = Vector3::Zero();
          for (std::size_t a = 0; a < nodes.size(); ++a) {
            place += shapes[m][a] * coarse.vertices[static_cast<std::size_t>(nodes[a])];
          }
          vertices[static_cast<std::size_t>(middle)] = place;
          for (auto& [name, values] : fine.point_arrays) {
            values.col(middle) =
                coarse.point_arrays.at(name)(Eigen::all, nodes) *
                Eigen::Map<const Vector>(shapes[m].data(), QuadraticPoints::kNodes);
          }
        }
      }
    }
  }
}

}  // namespace

TetMesh refined_mesh(const TetMesh& mesh) {
  constexpr Index kCount = kParts;
  TetMesh fine = with_edge_vertices(mesh);
  const EdgeVertices edges(fine);
  std::vector<std::array<Index, 4>>& tetrahedra = fine.tetrahedra.own();
  std::vector<std::array<Index, 4>> parts;
  parts.reserve(kParts * tetrahedra.size());
  std::vector<std::size_t> diagonals(tetrahedra.size());
  for (std::size_t e = 0; e < tetrahedra.size(); ++e) {
    const Nodes nodes = nodes_of(fine, e);
    diagonals[e] = best_diagonal(nodes, fine.vertices);
    for (const auto& [a, b, c, d] : kDiagonals[diagonals[e]].parts()) {
      parts.push_back({nodes[a], nodes[b], nodes[c], nodes[d]});
    }
  }
  tetrahedra = std::move(parts);
  fine.edge_vertices.clear();
  fine.tetrahedron_ids.clear();
  fine.regions.clear();
  for (const int region : mesh.regions) fine.regions.insert(fine.regions.end(), kParts, region);
  for (auto& [name, values] : fine.cell_arrays) {
    const Matrix of_coarse = values;
    values.resize(of_coarse.rows(), kCount * of_coarse.cols());
    for (Index e = 0; e < of_coarse.cols(); ++e) {
      values.middleCols(kCount * e, kCount).colwise() = of_coarse.col(e);
    }
  }
  for (Group& group : fine.groups) {
    group.triangles = edges.divide(group.triangles);
    for (const Index e : std::exchange(group.tetrahedra, {})) {
      for (Index k = 0; k < kCount; ++k) group.tetrahedra.push_back(kCount * e + k);
    }
    for (const auto& [a, b] : std::exchange(group.lines, {})) {
      const Index middle = edges.find(a, b);
      if (middle < 0) {
        group.lines.push_back({a, b});
      } else {
        group.lines.insert(group.lines.end(), {{a, middle}, {middle, b}});
      }
    }
  }
  if (!mesh.is_quadratic()) return fine;
  fine = with_edge_vertices(std::move(fine));
  take_from_coarse(mesh, diagonals, fine);
  return fine;
}

}  // namespace tetraction
