// Pressure on surfaces whose rim is held or lies on planes of symmetry: it has a potential, so that equilibria are
// minimisers and limit points are found.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "support/runs.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

// One eighth of a hollow sphere between the radii 1 − layers/n and 1, of quadratic elements: the outer layers
// of a cube, whose vertices are moved along their rays.
TetMesh hollow_octant(int n, int layers) {
  const TetMesh cube = generate_box({1, 1, 1}, {n, n, n});
  const double hole = 1.0 - static_cast<double>(layers) / n;
  RawMesh raw;
  for (Index v = 0; v < cube.vertex_count(); ++v) {
    raw.vertices.push_back(cube.vertices[static_cast<std::size_t>(v)]);
    raw.vertex_ids.push_back(v);
  }
  for (const auto corners : cube.tetrahedra) {
    Vector3 center = Vector3::Zero();
    for (const Index v : corners) center += 0.25 * cube.vertices[static_cast<std::size_t>(v)];
    if (center.maxCoeff() < hole) continue;
    RawCell cell;
    cell.type = CellType::kTetrahedron;
    cell.id = static_cast<std::int64_t>(raw.cells.size());
    cell.vertices = {corners[0], corners[1], corners[2], corners[3]};
    raw.cells.push_back(cell);
  }
  TetMesh mesh = with_edge_vertices(build_mesh(std::move(raw)));
  for (Vector3& x : mesh.vertices.own()) x *= x.maxCoeff() / x.norm();
  return mesh;
}

// The largest pressure in a hollow sphere of incompressible neo-Hookean material with μ = 1 and the radii a and 1,
// p = ½ (f(λ_b) − f(λ_a)), f(λ) = λ⁻⁴ + 4/λ (Green & Zerna, Theoretical Elasticity, section 3.10).
double limit_pressure(double a) {
  const auto f = [](double stretch) { return std::pow(stretch, -4.0) + 4.0 / stretch; };
  double largest = 0.0;
  for (double inner = 1.0; inner < 3.0; inner += 1e-4) {
    const double outer = std::cbrt(1.0 + (inner * inner * inner - 1.0) * a * a * a);
    largest = std::max(largest, 0.5 * (f(outer) - f(inner)));
  }
  return largest;
}

Session equilibrium(const Scene& scene, const TetMesh& mesh) {
  return {scene, mesh, Analysis::kEquilibrium};
}

TEST(HeldRims, AnOctantOfABalloonHasTheLimitPressureOfTheWhole) {
  const TetMesh mesh = hollow_octant(4, 1);
  Scene scene;
  scene.material.model = "neo-hookean";
  constexpr double kMu = 1e5;
  scene.material.poissons_ratio = 0.495;
  scene.material.youngs_modulus = 2.0 * kMu * 1.495;
  for (int axis = 0; axis < 3; ++axis) {
    scene.fix.push_back(fix(SelectPlane{axis, 0.0, {}}, {axis == 0, axis == 1, axis == 2}));
  }
  const double limit = kMu * limit_pressure(0.75);
  scene.pressure = {pressure(SelectSphere{Vector3::Zero(), 0.7501}, 1.25 * limit)};
  Session session = equilibrium(scene, mesh);
  EXPECT_FALSE(session.system().has_load_of_position());
  session.run();
  const LoadPath& path = *session.load_path();
  ASSERT_GE(path.limit_points.size(), 1U) << session.message();
  EXPECT_NEAR(path.limit_points[0].below * 1.25, 1.0, 0.02) << session.message();
}

// The forces of a pressure on the face that is held act on its support only, so that all sides may carry it.
TEST(HeldRims, ACubeOnAClampIsPressedAsOnAllSides) {
  Scene scene = scene_of({GeneratorKind::kBox, {1, 1, 1}, {2, 2, 2}}, elastic(1e6, 0.3));
  scene.fix = {fix(SelectPlane{1, 0.0, {}})};
  scene.pressure = {pressure(SelectSurface{}, 1e5)};
  const TetMesh mesh = with_edge_vertices(generate_mesh(*scene.mesh.generate));
  FinishedEquilibrium all(scene, mesh);
  scene.pressure[0].select = SelectFaces{{0, 1, 0}, 91.0};
  FinishedEquilibrium sides(scene, mesh);
  EXPECT_EQ(sides.system().pressures()[0].quadratic_faces.size(), 40U);
  EXPECT_FALSE(sides.system().has_load_of_position());
  EXPECT_LT((sides.state().position - all.state().position).cwiseAbs().maxCoeff(), 1e-10);
  // The support carries what the missing side lacks.
  const auto sum = [](const Vector& force) {
    return Vector3(force.reshaped(3, force.size() / 3).rowwise().sum());
  };
  EXPECT_LT((sum(sides.reaction_force()) + sum(sides.external_force())).norm(), 1e-6 * 1e5);
  EXPECT_NEAR(sum(sides.external_force()).y(), -1e5, 1e-6 * 1e5);
}

// Where a rim slides in planes and is clamped, the potential closes the energy balance.
TEST(HeldRims, TheEnergyIsKept) {
  Scene scene = scene_of({GeneratorKind::kBox, {1, 1, 1}, {2, 2, 2}}, elastic(1e5, 0.3));
  scene.fix = {fix(SelectPlane{0, 0.0, {}}, {true, false, false}),
               fix(SelectPlane{2, 0.0, {}}, {false, false, true}), fix(SelectPlane{0, 1.0, {}}),
               fix(SelectPlane{2, 1.0, {}})};
  scene.pressure = {pressure(SelectPlane{1, 1.0, {}}, 3e4)};
  scene.time = {Integrator::kEnergyMomentum, 5e-3, false, 0.2};
  scene.solver.tolerance = 1e-10;
  Session session(scene, generate_mesh(*scene.mesh.generate));
  EXPECT_FALSE(session.system().has_load_of_position());
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  EXPECT_GT(session.balance().external_work(), 1.0);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-9);
}

}  // namespace
}  // namespace tetraction
