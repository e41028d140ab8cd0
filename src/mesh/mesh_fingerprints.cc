#include "tetraction/mesh/mesh_fingerprints.h"

#include "core/fingerprint.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {
namespace {

void add_fields(Fingerprint& number, const std::map<std::string, Matrix>& fields) {
  for (const auto& [name, values] : fields) {
    number.add(name);
    for (const double x : values.reshaped()) number.add(x);
  }
}

template <class Nodes>
void add_nodes(Fingerprint& number, const Nodes& nodes) {
  for (const Index v : nodes) number.add(static_cast<std::uint64_t>(v));
}

std::uint64_t number_of_body(const TetMesh& mesh) {
  Fingerprint number;
  number.add(static_cast<std::uint64_t>(mesh.vertex_count()));
  for (const Vector3 x : mesh.vertices) {
    for (const double coordinate : x) number.add(coordinate);
  }
  add_fields(number, mesh.cell_arrays);  // materials may refer to them
  for (const std::array<Index, 4> corners : mesh.tetrahedra) add_nodes(number, corners);
  for (const auto& middles : mesh.edge_vertices) add_nodes(number, middles);
  return number.value();
}

std::uint64_t number_of_numbers(const TetMesh& mesh) {
  Fingerprint number;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    number.add(static_cast<std::uint64_t>(mesh.vertex_id(v)));
  }
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    number.add(static_cast<std::uint64_t>(mesh.tetrahedron_id(e)));
  }
  for (const Group& group : mesh.groups) {
    number.add(group.name);
    add_nodes(number, group.vertices);
    add_nodes(number, group.tetrahedra);
    for (const auto& triangle : group.triangles) add_nodes(number, triangle);
  }
  return number.value();
}

}  // namespace

MeshFingerprints fingerprints_of(const TetMesh& mesh) {
  if (mesh.part) return mesh.part->whole.fingerprints;
  Fingerprint fields;
  add_fields(fields, mesh.point_arrays);
  return {number_of_body(mesh), number_of_numbers(mesh), fields.value()};
}

}  // namespace tetraction
