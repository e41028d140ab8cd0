#include "partition.h"

#include <petscmat.h>

#include <algorithm>
#include <cstdio>  // for scotch.h
#include <cstdlib>
#include <limits>
#include <utility>

#include "mesh/hilbert_order.h"
#include "petsc_check.h"
#include "vertex_values.h"
#ifdef TETRACTION_HAS_SCOTCH
#include <scotch.h>
#endif

namespace tetraction::petsc {
namespace {

// Pieces of a curve through the centroids, of which every process gets all.
std::vector<int> along_curve(const MeshChunk& chunk, int parts, const AllToAll& processes) {
  const std::vector<Index> vertices = vertices_of(chunk.mesh.tetrahedra);
  const auto asked = processes.exchange(by_process(chunk, vertices, processes));
  const std::vector<Vector3> positions = positions_of(chunk, asked, processes);
  std::vector<float> own;
  own.reserve(3 * chunk.mesh.tetrahedra.size());
  for (const auto t : chunk.mesh.tetrahedra) {
    Vector3 sum = Vector3::Zero();
    for (const Index v : t) sum += positions[at(place_of(vertices, v))];
    for (const double x : sum) own.push_back(static_cast<float>(0.25 * x));
  }
  const std::vector<float> all = processes.gather(own);
  const std::vector<Index> order =
      hilbert_order(Eigen::Map<const Eigen::Matrix<float, 3, Eigen::Dynamic>>(
          all.data(), 3, chunk.whole.tetrahedra));
  std::vector<int> part(chunk.mesh.tetrahedra.size());
  for (Index i = 0; i < chunk.whole.tetrahedra; ++i) {
    const Index own_number = order[at(i)] - chunk.first_tetrahedron;
    if (own_number >= 0 && own_number < static_cast<Index>(part.size())) {
      part[at(own_number)] = static_cast<int>(i * parts / chunk.whole.tetrahedra);
    }
  }
  return part;
}

// The graph in compressed rows. PETSc frees the arrays, and numbers cells by PetscInt.
Mat adjacency_of(const MeshChunk& chunk, std::vector<std::array<std::int32_t, 4>> neighbors) {
  PetscInt* first = nullptr;
  PetscInt* columns = nullptr;
  check(PetscMalloc1(neighbors.size() + 1, &first), "PetscMalloc1");
  check(PetscMalloc1(4 * neighbors.size(), &columns), "PetscMalloc1");
  PetscInt next = 0;
  for (std::size_t e = 0; e < neighbors.size(); ++e) {
    first[e] = next;
    for (const std::int32_t neighbor : neighbors[e]) {
      if (neighbor >= 0) columns[next++] = neighbor;
    }
  }
  first[neighbors.size()] = next;
  const auto rows = static_cast<PetscInt>(neighbors.size());
  neighbors = {};
  Mat adjacency = nullptr;
  check(MatCreateMPIAdj(PETSC_COMM_WORLD, rows, static_cast<PetscInt>(chunk.whole.tetrahedra),
                        first, columns, nullptr, &adjacency),
        "MatCreateMPIAdj");
  return adjacency;
}

// Returns an empty list if PETSc has no PT-Scotch, or if it fails.
std::vector<int> with_scotch(Mat adjacency, int parts) {
#ifdef TETRACTION_HAS_SCOTCH
  // Otherwise each run would have other parts. Scotch's threads take what comes first, too.
  setenv("SCOTCH_PTHREAD_NUMBER", "1", 0);
  SCOTCH_randomSeed(1);
  SCOTCH_randomReset();
#endif
  MatPartitioning partitioning = nullptr;
  check(MatPartitioningCreate(PETSC_COMM_WORLD, &partitioning), "MatPartitioningCreate");
  IS result = nullptr;
  const bool is_done = MatPartitioningSetAdjacency(partitioning, adjacency) == 0 &&
                       MatPartitioningSetType(partitioning, MATPARTITIONINGPTSCOTCH) == 0 &&
                       MatPartitioningSetNParts(partitioning, parts) == 0 &&
                       MatPartitioningApply(partitioning, &result) == 0;
  std::vector<int> part;
  if (is_done) {
    const PetscInt* indices = nullptr;
    PetscInt size = 0;
    check(ISGetLocalSize(result, &size), "ISGetLocalSize");
    check(ISGetIndices(result, &indices), "ISGetIndices");
    part.assign(indices, indices + size);
    check(ISRestoreIndices(result, &indices), "ISRestoreIndices");
    check(ISDestroy(&result), "ISDestroy");
  }
  check(MatPartitioningDestroy(&partitioning), "MatPartitioningDestroy");
  return part;
}

// Whether every part has a tetrahedron, and every tetrahedron of the chunk a part.
bool is_complete(const std::vector<int>& part, std::size_t tetrahedra, int parts,
                 const AllToAll& processes) {
  std::vector<std::uint8_t> has(at(parts), 0);
  std::uint8_t is_valid = part.size() == tetrahedra ? 1 : 0;
  for (const int p : part) {
    if (p < 0 || p >= parts) {
      is_valid = 0;
    } else {
      has[at(p)] = 1;
    }
  }
  const std::vector<std::uint8_t> valid = processes.gather(std::vector<std::uint8_t>{is_valid});
  if (std::find(valid.begin(), valid.end(), 0) != valid.end()) return false;
  std::vector<std::uint8_t> in_some(at(parts), 0);
  const std::vector<std::uint8_t> all = processes.gather(has);
  for (std::size_t i = 0; i < all.size(); ++i) in_some[i % at(parts)] |= all[i];
  return std::find(in_some.begin(), in_some.end(), 0) == in_some.end();
}

}  // namespace

std::vector<int> partition_mesh(const MeshChunk& chunk,
                                std::vector<std::array<std::int32_t, 4>> neighbors, int parts,
                                const AllToAll& processes) {
  const std::size_t tetrahedra = chunk.mesh.tetrahedra.size();
  if (parts == 1) return std::vector<int>(tetrahedra, 0);
  std::vector<int> part;
  if (chunk.whole.tetrahedra < std::numeric_limits<PetscInt>::max() / 4) {
    Mat adjacency = adjacency_of(chunk, std::move(neighbors));
    part = with_scotch(adjacency, parts);
    check(MatDestroy(&adjacency), "MatDestroy");
  }
  if (is_complete(part, tetrahedra, parts, processes)) return part;
  return along_curve(chunk, parts, processes);
}

}  // namespace tetraction::petsc
