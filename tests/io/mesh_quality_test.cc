#include "tetraction/io/mesh_quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

TetMesh regular_tetrahedron() {
  RawMesh raw;
  raw.source = "regular";
  raw.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  raw.vertex_ids = {1, 2, 3, 4};
  RawCell cell;
  cell.type = CellType::kTetrahedron;
  cell.id = 17;
  cell.vertices = {1, 2, 3, 4};
  raw.cells.push_back(cell);
  return build_mesh(raw);
}

TEST(MeshQuality, RegularTetrahedronIsIdeal) {
  const auto measures = mesh_quality(regular_tetrahedron());
  ASSERT_EQ(measures.size(), 4u);
  for (const QualityMeasure& m : measures) {
    EXPECT_NEAR(m.min, 1.0, 1e-12) << m.name;
    EXPECT_NEAR(m.max, 1.0, 1e-12) << m.name;
    EXPECT_EQ(m.worst_element, 17) << m.name;
    ASSERT_EQ(m.values.size(), 1u);
  }
}

TEST(MeshQuality, CornerTetrahedronHasKnownValues) {
  const auto measures = mesh_quality(generate_tetrahedron());
  ASSERT_EQ(measures.size(), 4u);
  // Scaled Jacobian: det 1 over the largest product of three edge lengths at a vertex, √2·√2·1 at
  // the ends of the axes, times √2 for the regular tetrahedron's 1.
  EXPECT_EQ(measures[0].name, "scaled Jacobian");
  EXPECT_NEAR(measures[0].min, std::sqrt(2.0) / 2.0, 1e-12);
  // Radius ratio: circumradius √3/2 over three inradii (3V/A = 1/(3 + √3)).
  EXPECT_EQ(measures[1].name, "radius ratio");
  EXPECT_NEAR(measures[1].max, std::sqrt(3.0) / 2.0 * (3.0 + std::sqrt(3.0)) / 3.0, 1e-12);
  // Edge ratio: √2 to 1.
  EXPECT_EQ(measures[3].name, "edge ratio");
  EXPECT_NEAR(measures[3].max, std::sqrt(2.0), 1e-12);
}

TEST(MeshQuality, NamesTheWorstElementByTheFilesNumber) {
  TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  for (auto& id : mesh.tetrahedron_ids) id += 1000;
  // Pull one inner corner of element 7 towards the others: nothing else is as thin.
  const auto corners = mesh.tetrahedra[7];
  const auto at = [&](int a) -> Vector3& {
    return mesh.vertices.own()[static_cast<std::size_t>(corners[static_cast<std::size_t>(a)])];
  };
  const Vector3 middle = (at(1) + at(2) + at(3)) / 3.0;
  at(0) = 0.01 * at(0) + 0.99 * middle;
  const auto measures = mesh_quality(mesh);
  for (const QualityMeasure& m : measures) {
    ASSERT_EQ(m.values.size(), mesh.tetrahedra.size());
    double sum = 0.0;
    for (const double value : m.values) {
      EXPECT_GE(value, m.min);
      EXPECT_LE(value, m.max);
      sum += value;
    }
    EXPECT_NEAR(m.mean, sum / static_cast<double>(m.values.size()), 1e-12);
    const auto worst = static_cast<std::size_t>(m.worst_element - 1000);
    ASSERT_LT(worst, m.values.size());
    const bool large_is_bad = m.name == "radius ratio" || m.name == "edge ratio";
    EXPECT_EQ(m.values[worst], large_is_bad ? m.max : m.min) << m.name;
  }
  // The flattened element is worst in volume: its scaled Jacobian is not the one of the others.
  EXPECT_LT(measures[0].min, 0.1);
}

TEST(MeshQuality, EmptyMeshHasNoMeasures) {
  EXPECT_TRUE(mesh_quality(TetMesh{}).empty());
}

}  // namespace
}  // namespace tetraction
