#include "mesh_distribution.h"

#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "messages.h"
#include "mpi_part.h"
#include "partition.h"
#include "tetraction/core/error.h"

namespace tetraction::petsc {
namespace {

// The system does not get back by itself what many small pieces have needed.
void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

// The chunk of this process. The mesh of process 0 is released.
MeshChunk distribute_chunks(const AllToAll& processes, TetMesh mesh) {
  if (processes.rank() != 0) return unpacked_chunk(receive_list<char>(0));
  return_free_memory();  // of the reader
  const MeshPart::Whole whole = whole_of(mesh);
  for (int p = 1; p < processes.count(); ++p) {
    const std::vector<char> bytes = packed(chunk_of(mesh, whole, p, processes.count()));
    send_list(bytes.data(), bytes.size(), p);
  }
  return chunk_of(mesh, whole, 0, processes.count());
}

}  // namespace

TetMesh distribute_mesh(const Processes& processes, TetMesh mesh) {
  const MpiAllToAll all(processes);
  std::int64_t size = mesh.tetrahedron_count();
  int is_quadratic = mesh.is_quadratic() ? 1 : 0;
  MPI_Bcast(&size, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
  MPI_Bcast(&is_quadratic, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (is_quadratic != 0) {
    throw InputError(
        "A mesh of quadratic tetrahedra does not work in several processes yet: take a mesh of "
        "linear ones, or run "
        "the scene in one process without mpirun and with solver.engine = \"local\".");
  }
  if (size < all.count()) {
    throw InputError(fmt::format(
        "The mesh has {} tetrahedra, fewer than the {} processes of this run: start fewer.", size,
        all.count()));
  }
  if (size > std::numeric_limits<std::int32_t>::max()) {
    throw InputError(fmt::format(
        "The mesh has {} tetrahedra. Several processes can work on 2147483647 at most.", size));
  }
  MeshChunk chunk = distribute_chunks(all, std::move(mesh));
  return_free_memory();
  FaceMatches faces = match_faces(chunk, all);
  const std::vector<int> part =
      partition_mesh(chunk, std::exchange(faces.neighbors, {}), all.count(), all);
  return_free_memory();
  PartData data = collect_part(std::move(chunk), part, faces, all);
  return_free_memory();
  TetMesh own = std::move(data.mesh);
  own.part = std::make_shared<MpiPart>(processes, std::move(data));
  return own;
}

}  // namespace tetraction::petsc
