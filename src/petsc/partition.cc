// Partitions of the graph whose nodes are the tetrahedra and whose edges are their common faces.
#include <petscmat.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>

#include "fem/hilbert_order.h"
#include "mesh_distribution.h"
#include "petsc_check.h"
#ifdef TETRACTION_HAS_SCOTCH
#include <scotch.h>
#endif

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

// The faces are matched by ranges of their smallest vertex, because all of them together would need several
// times the memory of the mesh.
Graph dual_graph(const TetMesh& mesh) {
  struct Face {
    std::array<std::int32_t, 3> key;
    std::int32_t tetrahedron;
  };
  constexpr Index kPasses = 16;
  constexpr PetscInt kNone = -1;
  const auto count = static_cast<std::size_t>(mesh.tetrahedron_count());
  Graph graph;
  check(PetscMalloc1(count + 1, &graph.first), "PetscMalloc1");
  check(PetscMalloc1(4 * count, &graph.neighbors), "PetscMalloc1");
  std::fill(graph.neighbors, graph.neighbors + 4 * count, kNone);
  const auto add = [&](std::int32_t e, std::int32_t neighbor) {
    PetscInt* const row = graph.neighbors + 4 * static_cast<std::size_t>(e);
    PetscInt* const free = std::find(row, row + 4, kNone);
    if (free != row + 4 && std::find(row, free, neighbor) == free) *free = neighbor;
  };
  std::vector<Face> faces;
  const Index vertices = mesh.vertex_count();
  for (Index pass = 0; pass < kPasses; ++pass) {
    const Index low = vertices * pass / kPasses;
    const Index high = vertices * (pass + 1) / kPasses;
    faces.clear();
    for (std::size_t e = 0; e < count; ++e) {
      const auto t = mesh.tetrahedra[e];
      for (std::size_t omitted = 0; omitted < 4; ++omitted) {
        std::array<Index, 3> key{t[(omitted + 1) % 4], t[(omitted + 2) % 4], t[(omitted + 3) % 4]};
        std::sort(key.begin(), key.end());
        if (key[0] < low || key[0] >= high) continue;
        faces.push_back({{static_cast<std::int32_t>(key[0]), static_cast<std::int32_t>(key[1]),
                          static_cast<std::int32_t>(key[2])},
                         static_cast<std::int32_t>(e)});
      }
    }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
      return a.key != b.key ? a.key < b.key : a.tetrahedron < b.tetrahedron;
    });
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
      if (faces[i].key != faces[i + 1].key) continue;
      add(faces[i].tetrahedron, faces[i + 1].tetrahedron);
      add(faces[i + 1].tetrahedron, faces[i].tetrahedron);
    }
  }
  // The rows of four become rows of as many as there are, sorted.
  PetscInt next = 0;
  for (std::size_t e = 0; e < count; ++e) {
    PetscInt* const row = graph.neighbors + 4 * e;
    PetscInt* const end = std::find(row, row + 4, kNone);
    std::sort(row, end);
    graph.first[e] = next;
    next = static_cast<PetscInt>(std::copy(row, end, graph.neighbors + next) - graph.neighbors);
  }
  graph.first[count] = next;
  return graph;
}

// Returns false if PETSc has no PT-Scotch, or if it fails.
bool with_scotch(const TetMesh& mesh, int parts, std::vector<int>& part) {
  const Graph graph = dual_graph(mesh);
#ifdef TETRACTION_HAS_SCOTCH
  // Otherwise each run would have other parts. Scotch's threads take what comes first, too.
  setenv("SCOTCH_PTHREAD_NUMBER", "1", 0);
  SCOTCH_randomSeed(1);
  SCOTCH_randomReset();
#endif
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
