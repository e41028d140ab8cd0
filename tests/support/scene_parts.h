// Parts of scenes and meshes that several tests put together.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction::testing_support {

/// Parameters of a material with Young's modulus, Pa, and Poisson's ratio.
inline MaterialSettings elastic(double youngs_modulus, double poissons_ratio,
                                double density = 1000.0, const std::string& model = "neo-hookean") {
  MaterialSettings material;
  material.model = model;
  material.youngs_modulus = youngs_modulus;
  material.poissons_ratio = poissons_ratio;
  material.density = density;
  return material;
}

inline TetMesh mesh_of(const Scene& scene) {
  return generate_mesh(*scene.mesh.generate);
}

/// A generated body of one material.
inline Scene scene_of(const GeneratorSettings& mesh, const MaterialSettings& material) {
  Scene scene;
  scene.mesh.generate = mesh;
  scene.material = material;
  return scene;
}

/// A load with this vector, of the kind of the list that it is added to.
inline ForceSettings load(Selection select, const Vector3& vector) {
  ForceSettings load;
  load.select = std::move(select);
  load.vector = vector;
  return load;
}

inline FixSettings fix(Selection select, std::array<bool, 3> components = {true, true, true}) {
  FixSettings result;
  result.select = std::move(select);
  result.components = components;
  return result;
}

inline ForceSettings pressure(Selection select, double value) {
  ForceSettings load;
  load.kind = LoadKind::kPressure;
  load.select = std::move(select);
  load.value = value;
  return load;
}

/// Adds a body of linear tetrahedra, moved by `shift`, to a mesh whose vertices and cells are numbered from 0.
inline void append_body(RawMesh& raw, const TetMesh& body, const Vector3& shift) {
  const auto first = static_cast<std::int64_t>(raw.vertices.size());
  for (const Vector3& x : body.vertices) {
    raw.vertex_ids.push_back(static_cast<std::int64_t>(raw.vertices.size()));
    raw.vertices.emplace_back(x + shift);
  }
  for (const auto t : body.tetrahedra) {
    RawCell cell;
    cell.type = CellType::kTetrahedron;
    cell.id = static_cast<std::int64_t>(raw.cells.size());
    cell.vertices = {first + t[0], first + t[1], first + t[2], first + t[3]};
    raw.cells.push_back(cell);
  }
}

}  // namespace tetraction::testing_support
