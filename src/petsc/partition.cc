// Partitions of the graph whose nodes are the tetrahedra and whose edges are their common faces.
#include <petscmat.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "fem/hilbert_order.h"
#include "mesh_distribution.h"
#include "petsc_check.h"

namespace tetraction::petsc {
namespace {

// Pieces of a curve through the centroids.
std::vector<int> along_curve(const TetMesh& mesh, int parts) {
  const Index count = mesh.tetrahedron_count();
  Eigen::Matrix<float, 3, Eigen::Dynamic> centroids(3, count);
  for (Index e = 0; e < count; ++e) {
    Vector3 sum = Vector3::Zero();
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      sum += mesh.vertices[static_cast<std::size_t>(v)];
    }
    centroids.col(e) = (0.25 * sum).cast<float>();
  }
  const std::vector<Index> order = hilbert_order(centroids);
  std::vector<int> part(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    part[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])] =
        static_cast<int>(i * parts / count);
  }
  return part;
}

// The neighbours of the tetrahedra in compressed rows. PETSc frees arrays of its own.
struct Graph {
  PetscInt* first = nullptr;
  PetscInt* neighbors = nullptr;
};

Graph dual_graph(const TetMesh& mesh) {
  struct Face {
    std::array<Index, 3> key;
    Index tetrahedron;
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const auto t = mesh.tetrahedra[static_cast<std::size_t>(e)];
    for (std::size_t omitted = 0; omitted < 4; ++omitted) {
      Face face{{t[(omitted + 1) % 4], t[(omitted + 2) % 4], t[(omitted + 3) % 4]}, e};
      std::sort(face.key.begin(), face.key.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.tetrahedron < b.tetrahedron;
  });
  std::vector<std::pair<PetscInt, PetscInt>> pairs;
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    if (faces[i].key != faces[i + 1].key) continue;
    const auto a = static_cast<PetscInt>(faces[i].tetrahedron);
    const auto b = static_cast<PetscInt>(faces[i + 1].tetrahedron);
    pairs.emplace_back(a, b);
    pairs.emplace_back(b, a);
  }
  faces = {};
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Graph graph;
  const std::size_t count = mesh.tetrahedra.size();
  check(PetscMalloc1(count + 1, &graph.first), "PetscMalloc1");
  check(PetscMalloc1(std::max<std::size_t>(1, pairs.size()), &graph.neighbors), "PetscMalloc1");
  std::fill(graph.first, graph.first + count + 1, 0);
  for (const auto& [row, column] : pairs) ++graph.first[row + 1];
  std::partial_sum(graph.first, graph.first + count + 1, graph.first);
  for (std::size_t i = 0; i < pairs.size(); ++i) graph.neighbors[i] = pairs[i].second;
  return graph;
}

// Returns false if PETSc has no PT-Scotch, or if it fails.
bool with_scotch(const TetMesh& mesh, int parts, std::vector<int>& part) {
  const Graph graph = dual_graph(mesh);
  const auto count = static_cast<PetscInt>(mesh.tetrahedron_count());
  Mat adjacency = nullptr;
  check(MatCreateMPIAdj(PETSC_COMM_SELF, count, count, graph.first, graph.neighbors, nullptr,
                        &adjacency),
        "MatCreateMPIAdj");
  MatPartitioning partitioning = nullptr;
  check(MatPartitioningCreate(PETSC_COMM_SELF, &partitioning), "MatPartitioningCreate");
  IS result = nullptr;
  const bool is_done = MatPartitioningSetAdjacency(partitioning, adjacency) == 0 &&
                       MatPartitioningSetType(partitioning, MATPARTITIONINGPTSCOTCH) == 0 &&
                       MatPartitioningSetNParts(partitioning, parts) == 0 &&
                       MatPartitioningApply(partitioning, &result) == 0;
  if (is_done) {
    const PetscInt* indices = nullptr;
    check(ISGetIndices(result, &indices), "ISGetIndices");
    part.assign(indices, indices + count);
    check(ISRestoreIndices(result, &indices), "ISRestoreIndices");
    check(ISDestroy(&result), "ISDestroy");
  }
  check(MatPartitioningDestroy(&partitioning), "MatPartitioningDestroy");
  check(MatDestroy(&adjacency), "MatDestroy");
  return is_done;
}

// Whether every part has a tetrahedron.
bool is_complete(const std::vector<int>& part, int parts) {
  std::vector<char> has(static_cast<std::size_t>(parts), 0);
  for (const int p : part) {
    if (p < 0 || p >= parts) return false;
    has[static_cast<std::size_t>(p)] = 1;
  }
  return std::find(has.begin(), has.end(), 0) == has.end();
}

}  // namespace

std::vector<int> partition_mesh(const TetMesh& mesh, int parts) {
  if (parts == 1) return std::vector<int>(mesh.tetrahedra.size(), 0);
  std::vector<int> part;
  const bool fits = mesh.tetrahedron_count() < std::numeric_limits<PetscInt>::max() / 4;
  if (fits && with_scotch(mesh, parts, part) && is_complete(part, parts)) return part;
  return along_curve(mesh, parts);
}

}  // namespace tetraction::petsc
