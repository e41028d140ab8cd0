// Columns beyond Euler's load go over to the elastica (Euler 1744; Timoshenko & Gere 1961, section 2.7).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene_parts.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Half of a column with hinged ends, 1 × 0.02 × 0.01 m: the plane x = 0 is its middle.
Scene half_column(double load_ratio, int cells) {
  const double pi = std::numbers::pi;
  const double euler = pi * pi * 1e9 * 0.01 * 0.01 / 12.0;  // π²EI/L² over the cross-section
  Scene scene =
      scene_of({GeneratorKind::kBox, {0.5, 0.02, 0.01}, {cells, 1, 2}}, elastic(1e9, 0.0, "stvk"));
  FixSettings hinge;
  SelectSet end;
  end.operation = SetOperation::kAllOf;
  end.of = {{SelectPlane{0, 0.5, {}}}, {SelectPlane{2, 0.005, {}}}};
  hinge.select = end;
  hinge.components = {false, false, true};
  scene.fix = {fix(SelectPlane{0, 0.0, {}}, {true, false, false}),
               fix(SelectPlane{1, 0.0, {}}, {false, true, false}), hinge};
  scene.traction = {traction(SelectPlane{0, 0.5, {}}, {-load_ratio * euler, 0.0, 0.0})};
  return scene;
}

// The modulus k of the elastica: K(k) = π/2 √(P/P_E).
double modulus_of(double load_ratio) {
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double k = 0.5 * (low + high);
    const bool is_below = std::comp_ellint_1(k) < 0.5 * std::numbers::pi * std::sqrt(load_ratio);
    (is_below ? low : high) = k;
  }
  return low;
}

// The default settings but for the kind of solver. `tolerance` is relative.
void expect_elastica(double load_ratio, int cells, const std::string& solver, double tolerance) {
  Scene scene = half_column(load_ratio, cells);
  scene.solver.kind = solver;
  const auto system = make_system(scene, with_edge_vertices(generate_mesh(*scene.mesh.generate)));
  make_initial_state(scene, *system);
  const Equilibrium found = find_equilibrium(*system, scene.solver);
  ASSERT_TRUE(found.found) << load_ratio << ": " << found.message;
  ASSERT_EQ(found.path.limit_points.size(), 1U) << found.message;
  const LimitPoint& limit = found.path.limit_points[0];
  EXPECT_TRUE(limit.passed);
  // The axis is shortened by (π/100)²/12 before it buckles, and shear is as small.
  EXPECT_NEAR(0.5 * (limit.below + limit.above) * load_ratio, 1.0, 0.002);

  const double k = modulus_of(load_ratio);
  const double deflection = k / std::comp_ellint_1(k);
  const double shortening = 1.0 - std::comp_ellint_2(k) / std::comp_ellint_1(k);
  const Vector rest = system->mesh().rest_positions();
  int compared = 0;
  for (Index v = 0; v < system->vertex_count(); ++v) {
    const Vector3 at = vertex_block(rest, v);
    const Vector3 moved = Vector3(vertex_block(found.position, v)) - at;
    if (std::abs(at.z() - 0.005) > 1e-9) continue;  // not on the axis
    if (at.x() == 0.0) {
      EXPECT_NEAR(std::abs(moved.z()), deflection, tolerance * deflection);
    } else if (at.x() > 0.5 - 1e-9) {
      EXPECT_NEAR(-moved.x(), shortening, 2.0 * tolerance * shortening);
    } else {
      continue;
    }
    ++compared;
  }
  EXPECT_GE(compared, 4);
}

// Just beyond the load of buckling the deflection grows with the root of the excess, which the axial strain
// changes by a hundredth.
TEST(PostBuckling, JustBeyondEulersLoad) {
  expect_elastica(1.01, 40, "newton", 0.025);
}

TEST(PostBuckling, FarBeyondEulersLoad) {
  expect_elastica(1.5, 20, "newton", 0.01);
  expect_elastica(2.0, 20, "newton", 0.01);
}

TEST(PostBuckling, WithCeres) {
  expect_elastica(1.5, 16, "ceres", 0.01);
}

}  // namespace
}  // namespace tetraction
