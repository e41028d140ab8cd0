#include "simulation/facts/load_facts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <memory>

#include "dynamics/mass_properties.h"
#include "simulation/facts/support_facts.h"
#include "simulation/scene/initial_state.h"
#include "support/cubes.h"
#include "support/scene_parts.h"
#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A beam of 2 × 1 × 1 m with cells of half a metre, held at x = 0.
Scene beam() {
  Scene scene = scene_of({GeneratorKind::kBeam, {2, 1, 1}, {4, 2, 2}}, elastic(1e6, 0.3, 500.0));
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

struct LoadedBeam {
  Scene scene;
  std::unique_ptr<MechanicalSystem> system;
  BodyConstraints constraints;
  Vector positions;

  LoadedBeam(const Scene& of, TetMesh mesh) : scene(of) {
    system = make_system(scene, std::move(mesh));
    std::string note;
    positions = make_initial_state(scene, *system, constraints, note).position;
  }
  explicit LoadedBeam(const Scene& of) : LoadedBeam(of, generate_mesh(*of.mesh.generate)) {}

  std::vector<LoadFacts> loads() const { return load_facts(scene, *system, positions); }
  std::vector<SupportFacts> supports() const { return support_facts(constraints, *system); }
};

ForceSettings load_of(LoadKind kind, const Selection& select) {
  ForceSettings load;
  load.kind = kind;
  load.select = select;
  return load;
}

void expect_near(const Vector3& a, const Vector3& b, double tolerance) {
  EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " for " << b.transpose();
}

TEST(LoadFacts, EveryKindOfLoad) {
  for (const bool quadratic : {false, true}) {
    Scene scene = beam();
    const SelectPlane end{0, 2.0, {}};
    ForceSettings traction = load_of(LoadKind::kTraction, end);
    traction.vector = {0, -3, 0};
    scene.traction.push_back(traction);
    ForceSettings single = load_of(LoadKind::kForce, end);
    single.vector = {0, 0, 1};
    scene.force.push_back(single);
    ForceSettings total = load_of(LoadKind::kForce, end);
    total.total = Vector3(0, 0, 7);
    scene.force.push_back(total);
    ForceSettings moment = load_of(LoadKind::kMoment, end);
    moment.vector = {5, 0, 0};
    moment.from = 0.5;
    moment.until = 0.75;
    scene.moment.push_back(moment);
    ForceSettings pressure = load_of(LoadKind::kPressure, end);
    pressure.value = 10.0;
    scene.pressure.push_back(pressure);
    pressure.select = SelectSurface{};
    scene.pressure.push_back(pressure);
    ForceSettings body = load_of(LoadKind::kBodyForce, SelectAll{});
    body.acceleration = Vector3(0, -2, 0);
    scene.body_force.push_back(body);
    TetMesh mesh = generate_mesh(*scene.mesh.generate);
    const LoadedBeam all(scene, quadratic ? with_edge_vertices(std::move(mesh)) : std::move(mesh));
    const std::vector<LoadFacts> facts = all.loads();
    ASSERT_EQ(facts.size(), 7U);
    const auto find = [&](const std::string& key) {
      return *std::find_if(facts.begin(), facts.end(),
                           [&](const LoadFacts& load) { return load.key == key; });
    };
    const double tolerance = 1e-10;
    const Vector3 center(2, 0.5, 0.5);
    const LoadFacts t = find("traction.0");
    ASSERT_TRUE(t.surface.has_value());
    EXPECT_EQ(t.surface->triangles, 8);
    EXPECT_NEAR(t.surface->area, 1.0, tolerance);
    EXPECT_EQ(t.surface->rim_edges, 8);
    EXPECT_NEAR(t.surface->rim_length, 4.0, tolerance);
    EXPECT_EQ(t.surface->rim_held, 0);
    expect_near(t.force.resultant, {0, -3, 0}, tolerance);
    expect_near(t.force.moment, center.cross(Vector3(0, -3, 0)), tolerance);
    EXPECT_EQ(t.force.held_vertices, 0);
    EXPECT_EQ(t.factor, 1.0);

    const double vertices = quadratic ? 25.0 : 9.0;
    expect_near(find("force.0").force.resultant, {0, 0, vertices}, tolerance);
    EXPECT_FALSE(find("force.0").surface.has_value());
    expect_near(find("force.1").force.resultant, {0, 0, 7}, tolerance);
    expect_near(find("force.1").force.moment, center.cross(Vector3(0, 0, 7)), tolerance);
    EXPECT_TRUE(find("force.1").surface.has_value());
    const LoadFacts m = find("moment.0");
    expect_near(m.force.resultant, {0, 0, 0}, tolerance);
    expect_near(m.force.moment, {5, 0, 0}, tolerance);
    EXPECT_EQ(m.factor, 0.0);  // it does not act yet
    EXPECT_EQ(m.from, 0.5);

    expect_near(find("pressure.0").force.resultant, {-10, 0, 0}, tolerance);
    expect_near(find("pressure.0").force.moment, center.cross(Vector3(-10, 0, 0)), tolerance);
    const LoadFacts closed = find("pressure.1");
    EXPECT_TRUE(closed.surface->is_closed());
    EXPECT_NEAR(closed.surface->area, 10.0, tolerance);
    EXPECT_NEAR(closed.surface->volume, 2.0, tolerance);
    EXPECT_EQ(closed.force.resultant, Vector3(0, 0, 0));
    EXPECT_EQ(closed.force.moment, Vector3(0, 0, 0));
    // The held end takes its own pressure, 10 Pa on 1 m², and a part of that of the adjacent faces.
    EXPECT_EQ(closed.force.held_vertices, static_cast<Index>(vertices));
    EXPECT_NEAR(closed.force.held.x(), 10.0, tolerance);

    const LoadFacts g = find("body_force.0");
    EXPECT_EQ(g.tetrahedra, all.system->mesh().tetrahedron_count());
    EXPECT_NEAR(g.volume, 2.0, tolerance);
    EXPECT_NEAR(g.mass, 1000.0, 1e-9);
    expect_near(g.force.resultant, {0, -2000, 0}, 1e-9);
    expect_near(g.force.moment, Vector3(1, 0.5, 0.5).cross(Vector3(0, -2000, 0)), 1e-8);
  }
}

TEST(LoadFacts, AmplitudesAndTheEnvironment) {
  Scene scene = beam();
  scene.amplitude.push_back(corners("ramp", {{0.0, 0.0}, {1.0, 1.0}}));
  ForceSettings traction = load_of(LoadKind::kTraction, SelectPlane{0, 0.0, {}});
  traction.vector = {0, -3, 0};
  traction.amplitude = "ramp";
  scene.traction.push_back(traction);
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.environment.strength = 10.0;
  scene.environment.amplitude = "ramp";
  const LoadedBeam body(scene);
  const LoadFacts load = body.loads().front();
  EXPECT_EQ(load.factor, 0.0);
  EXPECT_EQ(load.amplitude, "ramp");
  expect_near(load.force.resultant, {0, -3, 0}, 1e-12);  // with the factor 1
  // It acts on held vertices only.
  EXPECT_EQ(load.force.held_vertices, load.force.vertices);
  expect_near(load.force.held, {0, -3, 0}, 1e-12);
  EXPECT_EQ(load.surface->rim_held, load.surface->rim_edges);
  const auto gravity = environment_facts(scene, *body.system, body.positions);
  ASSERT_TRUE(gravity.has_value());
  expect_near(gravity->resultant, {0, -10000, 0}, 1e-8);
}

// The middles of edges are moved, so that all faces are curved.
TEST(LoadFacts, CurvedFacesEncloseTheVolumeOfTheirElements) {
  Scene scene = beam();
  TetMesh mesh = with_edge_vertices(generate_mesh(*scene.mesh.generate));
  for (const auto& middles : mesh.edge_vertices) {
    for (const Index v : middles) {
      Vector3& x = mesh.vertices.own()[static_cast<std::size_t>(v)];
      x += 0.02 * Vector3(std::sin(7.0 * x.y()), std::sin(5.0 * x.z()), std::sin(3.0 * x.x()));
    }
  }
  ForceSettings pressure = load_of(LoadKind::kPressure, SelectSurface{});
  pressure.value = 1.0;
  scene.fix.clear();
  scene.pressure.push_back(pressure);
  const LoadedBeam body(scene, std::move(mesh));
  double volume = 0.0;
  for (Index e = 0; e < body.system->rest().element_count(); ++e) {
    volume += element_mass_matrix(body.system->rest(), e).sum();
  }
  EXPECT_GT(std::abs(volume - 2.0), 1e-4);
  EXPECT_NEAR(body.loads().front().surface->volume, volume, 1e-12);
}

TEST(LoadFacts, RimsOnPlanesOfSymmetryAndCavities) {
  // 3 × 3 × 3 cubes without the one in the middle.
  std::vector<std::array<int, 3>> places;
  for (int i = 0; i < 27; ++i) {
    if (i != 13) places.push_back({i % 3, i / 3 % 3, i / 9});
  }
  Scene scene = beam();
  scene.fix.clear();
  ConstraintSettings plane = on_plane(SelectPlane{2, 0.0, {}}, {0, 0, 2});
  scene.constraint.push_back(plane);
  ForceSettings pressure = load_of(LoadKind::kPressure, SelectBox{{1, 1, 1}, {2, 2, 2}});
  scene.pressure.push_back(pressure);
  pressure.select = SelectFaces{{1, 0, 0}, 1.0};
  scene.pressure.push_back(pressure);
  pressure.select = SelectSurface{};
  scene.pressure.push_back(pressure);
  const LoadedBeam body(scene, testing_support::cubes(places));
  const std::vector<LoadFacts> loads = body.loads();
  EXPECT_TRUE(loads[0].surface->is_closed());
  EXPECT_NEAR(loads[0].surface->volume, -1.0, 1e-12);
  EXPECT_NEAR(loads[0].surface->area, 6.0, 1e-12);
  // The face x = 3 and a face of the cavity: 12 + 4 edges, of which 3 are on the plane.
  EXPECT_EQ(loads[1].surface->rim_edges, 16);
  EXPECT_EQ(loads[1].surface->rim_guided, 3);
  EXPECT_EQ(loads[1].surface->rim_held, 0);
  EXPECT_NEAR(loads[2].surface->volume, 26.0, 1e-12);

  const SupportFacts support = body.supports().front();
  EXPECT_EQ(support.key, "constraint.0");
  EXPECT_EQ(support.kind, SupportKind::kPlane);
  EXPECT_EQ(support.vertices, 16);
  EXPECT_EQ(support.triangles, 18);
  EXPECT_NEAR(support.area, 9.0, 1e-12);
  expect_near(support.direction, {0, 0, 1}, 1e-15);
}

TEST(SupportFacts, EveryKindOfSupport) {
  Scene scene = beam();
  scene.fix[0].components = {true, false, true};
  scene.fix[0].offset = Vector3(0.01, 0.5, 0.0);
  scene.fix[0].velocity = {0, 0, 2};
  scene.fix.push_back(springs(SelectNearest{{2, 1, 1}}, 30.0));
  scene.constraint.push_back(rod(10, 14));
  ConstraintSettings handle = driven(SelectPlane{0, 2.0, {}}, {}, Vector3(1, 0, 0));
  const LoadedBeam driven([&] {
    Scene with = scene;
    with.fix.pop_back();
    with.constraint.push_back(handle);
    return with;
  }());
  handle.angular_velocity.reset();
  handle.select = SelectPlane{0, 1.5, {}};
  scene.constraint.push_back(handle);
  const LoadedBeam body(scene);
  const std::vector<SupportFacts> facts = body.supports();
  ASSERT_EQ(facts.size(), 4U);
  EXPECT_EQ(facts[0].kind, SupportKind::kFix);
  EXPECT_EQ(facts[0].vertices, 9);
  EXPECT_EQ(facts[0].triangles, 8);
  EXPECT_NEAR(facts[0].displacement, 0.01, 1e-15);  // y is not held
  EXPECT_TRUE(facts[0].moves);
  EXPECT_EQ(facts[1].kind, SupportKind::kSprings);
  EXPECT_EQ(facts[1].stiffness, 60.0);
  EXPECT_EQ(facts[1].triangles, 0);
  EXPECT_FALSE(facts[1].moves);
  EXPECT_EQ(facts[2].kind, SupportKind::kDistance);
  EXPECT_EQ(facts[2].ends, (std::array<std::int64_t, 2>{10, 14}));
  EXPECT_GT(facts[2].length, 0.0);
  EXPECT_EQ(facts[3].kind, SupportKind::kFreeHandle);
  EXPECT_EQ(facts[3].key, "constraint.1");
  EXPECT_EQ(facts[3].vertices, 9);
  EXPECT_EQ(facts[3].triangles, 0);
  EXPECT_NEAR(facts[3].mass, 250.0, 1e-9);  // half a metre of the beam

  const SupportFacts turned = driven.supports().back();
  EXPECT_EQ(turned.kind, SupportKind::kDrivenHandle);
  EXPECT_TRUE(turned.moves);
  expect_near(turned.angular_velocity, {1, 0, 0}, 1e-15);
}

// A box of the mass m has the moments m (b² + c²)/12 and no products.
TEST(MassProperties, OfABox) {
  for (const bool quadratic : {false, true}) {
    double last = 0.0;
    for (const int cells : {2, 4}) {
      TetMesh mesh = generate_box({2, 1, 3}, {cells, cells, cells});
      if (quadratic) mesh = with_edge_vertices(std::move(mesh));
      for (Vector3& x : mesh.vertices.own()) x += Vector3(100, 0, 0);
      const MechanicalSystem system(std::move(mesh), MaterialModel(NeoHookean(1.0, 1.0)), 2.0);
      const MassProperties exact = mass_properties(system);
      const MassProperties lumped = lumped_mass_properties(system);
      expect_near(exact.center, {101, 0.5, 1.5}, 1e-12);
      expect_near(lumped.center, {101, 0.5, 1.5}, 1e-12);
      const Matrix3 box = Vector3(10, 13, 5).asDiagonal();
      EXPECT_LT((exact.inertia - box).norm(), 1e-10);
      // The error of lumping falls with the square of the cells.
      const double error = (lumped.inertia - box).norm();
      EXPECT_GT(error, 1e-3);
      if (cells == 4) {
        EXPECT_NEAR(error, last / 4.0, 1e-9);
      }
      last = error;
    }
  }
}

}  // namespace
}  // namespace tetraction
