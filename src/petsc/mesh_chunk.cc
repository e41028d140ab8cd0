#include "mesh_chunk.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "mesh/bounding_box.h"

namespace tetraction::petsc {
namespace {

// Numbers, texts and lists of them as bytes.
class Writer {
 public:
  void reserve(std::size_t size) { bytes_.reserve(size); }
  template <class Number>
  void put(const Number& number) {
    static_assert(std::is_trivially_copyable_v<Number>);
    append(&number, sizeof(Number));
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
  std::vector<char> take_bytes() { return std::move(bytes_); }

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

// The same list for both directions.
void pass(MeshChunk& chunk, const auto& item) {
  TetMesh& mesh = chunk.mesh;
  item(chunk.first_vertex);
  item(chunk.first_tetrahedron);
  item(mesh.source);
  item(mesh.vertices.own());
  item(mesh.tetrahedra.own());
  item(mesh.vertex_ids);
  item(mesh.tetrahedron_ids);
  item(mesh.regions);
  item(mesh.report.reoriented);
  item(mesh.report.dropped_vertices);
  item(chunk.whole.vertices);
  item(chunk.whole.tetrahedra);
  item(chunk.whole.volume);
  item(chunk.whole.vertex_ids.first);
  item(chunk.whole.vertex_ids.second);
  item(chunk.whole.fingerprints);
  for (Index i = 0; i < 3; ++i) {
    item(chunk.whole.low[i]);
    item(chunk.whole.high[i]);
  }
}

void pass_group(Group& group, const auto& item) {
  item(group.name);
  item(group.dimension);
  item(group.tag);
  item(group.vertices);
  item(group.tetrahedra);
  item(group.triangles);
  item(group.detached_triangles);
  item(group.lines);
  item(group.detached_lines);
}

Index at_or_after(const std::vector<Index>& ascending, Index number) {
  return std::lower_bound(ascending.begin(), ascending.end(), number) - ascending.begin();
}

// Those of the ascending numbers that are in [begin, end).
std::vector<Index> in_range(const std::vector<Index>& ascending, Index begin, Index end) {
  return {ascending.begin() + at_or_after(ascending, begin),
          ascending.begin() + at_or_after(ascending, end)};
}

// Those whose least vertex is in [begin, end).
template <std::size_t kCount>
std::vector<std::array<Index, kCount>> with_least_vertex_in(
    const std::vector<std::array<Index, kCount>>& cells, Index begin, Index end) {
  std::vector<std::array<Index, kCount>> found;
  for (const auto& vertices : cells) {
    const Index least = *std::min_element(vertices.begin(), vertices.end());
    if (least >= begin && least < end) found.push_back(vertices);
  }
  return found;
}

}  // namespace

MeshPart::Whole whole_of(const TetMesh& mesh) {
  MeshPart::Whole whole;
  whole.vertices = mesh.vertex_count();
  whole.tetrahedra = mesh.tetrahedron_count();
  whole.volume = mesh.total_volume();
  whole.fingerprints = fingerprints_of(mesh);
  const BoundingBox box = bounding_box(mesh);
  whole.low = box.low;
  whole.high = box.high;
  whole.vertex_ids = {std::numeric_limits<std::int64_t>::max(),
                      std::numeric_limits<std::int64_t>::min()};
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    whole.vertex_ids.first = std::min(whole.vertex_ids.first, mesh.vertex_id(v));
    whole.vertex_ids.second = std::max(whole.vertex_ids.second, mesh.vertex_id(v));
  }
  return whole;
}

MeshChunk chunk_of(const TetMesh& mesh, const MeshPart::Whole& whole, int number, int processes) {
  MeshChunk chunk;
  chunk.whole = whole;
  const EqualRanges vertices = chunk.vertex_ranges(processes);
  const EqualRanges tetrahedra = chunk.tetrahedron_ranges(processes);
  const Index begin = chunk.first_vertex = vertices.first(number);
  const Index end = begin + vertices.size(number);
  const Index begin_e = chunk.first_tetrahedron = tetrahedra.first(number);
  const Index end_e = begin_e + tetrahedra.size(number);

  TetMesh& part = chunk.mesh;
  part.source = mesh.source;
  part.report = mesh.report;
  part.vertices.own().reserve(static_cast<std::size_t>(end - begin));
  part.vertex_ids.reserve(static_cast<std::size_t>(end - begin));
  for (Index v = begin; v < end; ++v) {
    part.vertices.own().push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    part.vertex_ids.push_back(mesh.vertex_id(v));
  }
  part.tetrahedra.own().reserve(static_cast<std::size_t>(end_e - begin_e));
  part.tetrahedron_ids.reserve(static_cast<std::size_t>(end_e - begin_e));
  for (Index e = begin_e; e < end_e; ++e) {
    part.tetrahedra.own().push_back(mesh.tetrahedra[static_cast<std::size_t>(e)]);
    part.tetrahedron_ids.push_back(mesh.tetrahedron_id(e));
    if (!mesh.regions.empty()) part.regions.push_back(mesh.region(e));
  }
  for (const Group& group : mesh.groups) {
    Group own;
    own.name = group.name;
    own.dimension = group.dimension;
    own.tag = group.tag;
    own.detached_triangles = group.detached_triangles;
    own.detached_lines = group.detached_lines;
    own.vertices = in_range(group.vertices, begin, end);
    own.tetrahedra = in_range(group.tetrahedra, begin_e, end_e);
    own.triangles = with_least_vertex_in(group.triangles, begin, end);
    own.lines = with_least_vertex_in(group.lines, begin, end);
    part.groups.push_back(std::move(own));
  }
  for (const auto& [name, values] : mesh.point_arrays) {
    part.point_arrays[name] = values.middleCols(begin, end - begin);
  }
  for (const auto& [name, values] : mesh.cell_arrays) {
    part.cell_arrays[name] = values.middleCols(begin_e, end_e - begin_e);
  }
  return chunk;
}

std::vector<char> packed(MeshChunk chunk) {
  Writer writer;
  // The size of positions, corners, ids and regions, which are nearly everything.
  writer.reserve(32 * chunk.mesh.vertices.size() + 44 * chunk.mesh.tetrahedra.size() + (1 << 16));
  const auto put = [&](const auto& value) { writer.put(value); };
  pass(chunk, put);
  put(chunk.mesh.report.skipped_cells.size());
  for (const auto& [type, count] : chunk.mesh.report.skipped_cells) {
    put(type);
    put(count);
  }
  put(chunk.mesh.groups.size());
  for (Group& group : chunk.mesh.groups) pass_group(group, put);
  for (const auto* arrays : {&chunk.mesh.point_arrays, &chunk.mesh.cell_arrays}) {
    put(arrays->size());
    for (const auto& [name, values] : *arrays) {
      put(name);
      put(values);
    }
  }
  return writer.take_bytes();
}

MeshChunk unpacked_chunk(std::vector<char> bytes) {
  MeshChunk chunk;
  Reader reader(std::move(bytes));
  const auto take = [&](auto& value) { reader.take(value); };
  pass(chunk, take);
  std::size_t count = 0;
  take(count);
  for (std::size_t i = 0; i < count; ++i) {
    CellType type{};
    Index cells = 0;
    take(type);
    take(cells);
    chunk.mesh.report.skipped_cells[type] = cells;
  }
  take(count);
  chunk.mesh.groups.resize(count);
  for (Group& group : chunk.mesh.groups) pass_group(group, take);
  for (auto* arrays : {&chunk.mesh.point_arrays, &chunk.mesh.cell_arrays}) {
    take(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::string name;
      take(name);
      take((*arrays)[name]);
    }
  }
  return chunk;
}

}  // namespace tetraction::petsc
