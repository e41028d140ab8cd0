// Parts of a mesh on their way to other processes.
#include "mesh_distribution.h"

#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "messages.h"
#include "mpi_part.h"
#include "tetraction/core/error.h"

namespace tetraction::petsc {
namespace {

// Numbers, texts and lists of them as bytes.
class Writer {
 public:
  template <class Number>
  void put(const Number& number) {
    static_assert(std::is_trivially_copyable_v<Number>);
    const auto* bytes = reinterpret_cast<const char*>(&number);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(Number));
  }
  template <class Item>
  void put(const std::vector<Item>& items) {
    put(items.size());
    append(items.data(), items.size() * sizeof(Item));
  }
  void put(const std::string& text) {
    put(text.size());
    append(text.data(), text.size());
  }
  void put(const Matrix& matrix) {
    put(matrix.rows());
    put(matrix.cols());
    append(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  void append(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }
  std::vector<char> bytes_;
};

class Reader {
 public:
  explicit Reader(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  template <class Number>
  void take(Number& number) {
    copy(&number, sizeof(Number));
  }
  template <class Item>
  void take(std::vector<Item>& items) {
    std::size_t size = 0;
    take(size);
    items.resize(size);
    copy(items.data(), size * sizeof(Item));
  }
  void take(std::string& text) {
    std::size_t size = 0;
    take(size);
    text.resize(size);
    copy(text.data(), size);
  }
  void take(Matrix& matrix) {
    Index rows = 0;
    Index cols = 0;
    take(rows);
    take(cols);
    matrix.resize(rows, cols);
    copy(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }

 private:
  void copy(void* to, std::size_t size) {
    if (size > 0) std::memcpy(to, bytes_.data() + next_, size);
    next_ += size;
  }
  std::vector<char> bytes_;
  std::size_t next_ = 0;
};

std::vector<Vector3> positions_of(const TetMesh& mesh) {
  return {mesh.vertices.begin(), mesh.vertices.end()};
}
std::vector<std::array<Index, 4>> corners_of(const TetMesh& mesh) {
  return {mesh.tetrahedra.begin(), mesh.tetrahedra.end()};
}

// The same list for both directions.
template <class Archive, class Data>
void pass(Archive& archive, Data& data, const auto& item) {
  auto& mesh = data.mesh;
  item(archive, mesh.source);
  item(archive, mesh.vertex_ids);
  item(archive, mesh.tetrahedron_ids);
  item(archive, mesh.regions);
  item(archive, mesh.report.reoriented);
  item(archive, mesh.report.dropped_vertices);
  item(archive, data.owned_vertices);
  item(archive, data.boundary_faces);
  item(archive, data.boundary_vertices);
  item(archive, data.vertex_numbers);
  item(archive, data.whole.vertices);
  item(archive, data.whole.tetrahedra);
  item(archive, data.whole.volume);
  item(archive, data.whole.vertex_ids.first);
  item(archive, data.whole.vertex_ids.second);
  item(archive, data.whole.fingerprints);
  for (Index i = 0; i < 3; ++i) {
    item(archive, data.whole.low[i]);
    item(archive, data.whole.high[i]);
  }
}

std::vector<char> packed(const PartData& data) {
  Writer writer;
  pass(writer, data, [](Writer& to, const auto& value) { to.put(value); });
  writer.put(positions_of(data.mesh));
  writer.put(corners_of(data.mesh));
  writer.put(data.mesh.report.skipped_cells.size());
  for (const auto& [type, count] : data.mesh.report.skipped_cells) {
    writer.put(type);
    writer.put(count);
  }
  writer.put(data.neighbors.size());
  for (const Neighbor& neighbor : data.neighbors) {
    writer.put(neighbor.rank);
    writer.put(neighbor.shared);
  }
  writer.put(data.mesh.groups.size());
  for (const Group& group : data.mesh.groups) {
    writer.put(group.name);
    writer.put(group.dimension);
    writer.put(group.tag);
    writer.put(group.vertices);
    writer.put(group.tetrahedra);
    writer.put(group.triangles);
    writer.put(group.detached_triangles);
    writer.put(group.lines);
    writer.put(group.detached_lines);
  }
  for (const auto* arrays : {&data.mesh.point_arrays, &data.mesh.cell_arrays}) {
    writer.put(arrays->size());
    for (const auto& [name, values] : *arrays) {
      writer.put(name);
      writer.put(values);
    }
  }
  return writer.bytes();
}

PartData unpacked(std::vector<char> bytes) {
  PartData data;
  Reader reader(std::move(bytes));
  pass(reader, data, [](Reader& from, auto& value) { from.take(value); });
  std::vector<Vector3> positions;
  reader.take(positions);
  data.mesh.vertices.own() = std::move(positions);
  reader.take(data.mesh.tetrahedra.own());
  std::size_t count = 0;
  reader.take(count);
  for (std::size_t i = 0; i < count; ++i) {
    CellType type{};
    Index cells = 0;
    reader.take(type);
    reader.take(cells);
    data.mesh.report.skipped_cells[type] = cells;
  }
  reader.take(count);
  data.neighbors.resize(count);
  for (Neighbor& neighbor : data.neighbors) {
    reader.take(neighbor.rank);
    reader.take(neighbor.shared);
  }
  reader.take(count);
  data.mesh.groups.resize(count);
  for (Group& group : data.mesh.groups) {
    reader.take(group.name);
    reader.take(group.dimension);
    reader.take(group.tag);
    reader.take(group.vertices);
    reader.take(group.tetrahedra);
    reader.take(group.triangles);
    reader.take(group.detached_triangles);
    reader.take(group.lines);
    reader.take(group.detached_lines);
  }
  for (auto* arrays : {&data.mesh.point_arrays, &data.mesh.cell_arrays}) {
    reader.take(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::string name;
      reader.take(name);
      reader.take((*arrays)[name]);
    }
  }
  return data;
}

// The system does not get back by itself what the partition and the whole mesh have needed, in many pieces.
void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

// The part of process 0, after all others were sent.
PartData divide(const TetMesh& mesh, int parts) {
  const std::vector<int> part_of_tetrahedron = partition_mesh(mesh, parts);
  return_free_memory();
  const MeshDivider divider(mesh, part_of_tetrahedron, parts);
  for (int part = 1; part < parts; ++part) {
    const std::vector<char> bytes = packed(divider.part(part));
    send_list(bytes.data(), bytes.size(), part);
  }
  return divider.part(0);
}

}  // namespace

TetMesh distribute_mesh(const Processes& processes, TetMesh mesh) {
  const int parts = processes.count();
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
  if (size < parts) {
    throw InputError(fmt::format(
        "The mesh has {} tetrahedra, fewer than the {} processes of this run: start fewer.", size,
        parts));
  }
  PartData data;
  if (processes.is_first()) {
    data = divide(mesh, parts);
    mesh = {};
    return_free_memory();
  } else {
    data = unpacked(receive_list<char>(0));
  }
  TetMesh part = std::move(data.mesh);
  part.part = std::make_shared<MpiPart>(processes, std::move(data));
  return part;
}

}  // namespace tetraction::petsc
