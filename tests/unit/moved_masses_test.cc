// Masses that move from contact vertices into the body (contact.mass).
#include "tetraction/dynamics/contact/moved_masses.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/mass_properties.h"
#include "support/obstacles.h"
#include "support/rules.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

using namespace testing_support;

Scene block(const Vector3& size, const std::array<int, 3>& cells) {
  Scene scene = scene_of({GeneratorKind::kBox, size, cells}, elastic(1e5, 0.3));
  ObstacleSettings floor = plane_obstacle("floor", {0.0, -0.1, 0.0});
  floor.select = SelectFaces{{0.0, -1.0, 0.0}, {}};
  scene.obstacle = {floor};
  scene.contact.mass = 0.01;
  return scene;
}

std::string refusal(const Scene& scene) {
  return message_of([&] { const Session session(scene, mesh_of(scene)); });
}

// The lower face of a block, linear or quadratic, in one part or in two, with another density in half of it.
TEST(MovedMasses, KeepMassCentreAndInertia) {
  for (const bool is_quadratic : {false, true}) {
    Scene scene = block({0.4, 0.3, 0.2}, {4, 6, 3});
    scene.material_region.resize(1);
    scene.material_region[0].select = SelectBox{{0.0, 0.0, 0.0}, {0.2, 0.3, 0.2}};
    scene.material_region[0].material = elastic(1e5, 0.3, 2500.0);
    TetMesh mesh = mesh_of(scene);
    if (is_quadratic) mesh = with_edge_vertices(std::move(mesh));
    const auto moved = make_system(scene, mesh);
    scene.contact.mass = 1.0;
    const auto whole = make_system(scene, mesh);
    EXPECT_FALSE(whole->has_moved_masses());
    ASSERT_TRUE(moved->has_moved_masses());
    EXPECT_NEAR(moved->total_mass(), whole->total_mass(), 1e-13 * whole->total_mass());
    EXPECT_GT(moved->mass().minCoeff(), 0.0);
    EXPECT_LT((moved->lumped_masses() - whole->mass()).norm(), 1e-15 * whole->mass().norm());
    const Vector rest = mesh.rest_positions();
    for (const Index v : whole->contact()->vertices()) {
      EXPECT_EQ(rest[3 * v + 1], 0.0);
      EXPECT_NEAR(moved->mass()[v], 0.01 * whole->mass()[v], 1e-15 * whole->mass()[v]);
    }
    const MassProperties a = lumped_mass_properties(*moved);
    const MassProperties b = lumped_mass_properties(*whole);
    EXPECT_LT((a.center - b.center).norm(), 1e-13);
    EXPECT_LT((a.inertia - b.inertia).norm(), 1e-12 * b.inertia.norm());
    // Only the layer above gets their mass. The correction changes the others by less than three quarters.
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (rest[3 * v + 1] < 0.11) continue;
      EXPECT_NEAR(moved->mass()[v], whole->mass()[v], 0.75 * whole->mass()[v]) << v;
    }
  }
}

// The elements' shares of masses add up to the masses, and so do the energies of regions.
TEST(MovedMasses, HaveSharesOfElements) {
  Scene scene = block({0.4, 0.3, 0.2}, {3, 5, 2});
  scene.material_region.resize(1);
  scene.material_region[0].select = SelectBox{{0.0, 0.0, 0.0}, {0.2, 0.3, 0.2}};
  scene.material_region[0].material = elastic(1e5, 0.3, 2500.0);
  const auto system = make_system(scene, mesh_of(scene));
  Vector sums = Vector::Zero(system->vertex_count());
  for (Index e = 0; e < system->rest().element_count(); ++e) {
    int a = 0;
    for (const Index v : system->rest().nodes(e)) sums[v] += system->mass_share(e, a++);
  }
  EXPECT_LT((sums - system->mass()).norm(), 1e-14 * sums.norm());
  Vector momentum(system->dof_count());
  for (Index i = 0; i < momentum.size(); ++i) momentum[i] = 0.1 + 0.01 * static_cast<double>(i % 7);
  const double total = kinetic_energy(*system, momentum);
  EXPECT_NEAR(kinetic_energies_by_region(*system, momentum).sum(), total, 1e-13 * total);
}

// A body that turns as a rigid one has the momenta of the body as it was.
TEST(MovedMasses, LeaveRigidMotionsAsTheyAre) {
  Scene scene = block({0.4, 0.3, 0.2}, {4, 6, 3});
  scene.initial.velocity = {1.0, 2.0, -0.5};
  scene.initial.angular_velocity = {3.0, -1.0, 2.0};
  const Session moved(scene, mesh_of(scene));
  scene.contact.mass = 1.0;
  const Session whole(scene, mesh_of(scene));
  const Momenta& a = moved.balance().momenta();
  const Momenta& b = whole.balance().momenta();
  EXPECT_LT((a.linear - b.linear).norm(), 1e-12 * b.linear.norm());
  EXPECT_LT((a.angular - b.angular).norm(), 1e-12 * b.angular.norm());
  EXPECT_NEAR(moved.balance().energies().kinetic(), whole.balance().energies().kinetic(),
              1e-12 * whole.balance().energies().kinetic());
}

// A plate of three layers cannot keep its inertia with masses above zero, but its centre of mass.
TEST(MovedMasses, KeepTheCentreOfAPlate) {
  Scene scene = block({0.4, 0.15, 0.4}, {6, 3, 6});
  const auto moved = make_system(scene, mesh_of(scene));
  scene.contact.mass = 1.0;
  const auto whole = make_system(scene, mesh_of(scene));
  const MassProperties a = lumped_mass_properties(*moved);
  const MassProperties b = lumped_mass_properties(*whole);
  EXPECT_NEAR(moved->total_mass(), whole->total_mass(), 1e-13 * whole->total_mass());
  EXPECT_LT((a.center - b.center).norm(), 1e-13);
  EXPECT_GT((a.inertia - b.inertia).norm(), 1e-6 * b.inertia.norm());
  EXPECT_GT(moved->mass().minCoeff(), 0.0);
}

// Where all faces of a cube may touch, corners have no neighbours inside, and the nearest vertices take their mass.
TEST(MovedMasses, FindTheNearestVerticesInside) {
  Scene scene = block({0.4, 0.4, 0.4}, {8, 8, 8});
  scene.obstacle[0].select = SelectAll{};
  scene.contact.mass = 0.5;
  const auto moved = make_system(scene, mesh_of(scene));
  scene.contact.mass = 1.0;
  const auto whole = make_system(scene, mesh_of(scene));
  const MassProperties a = lumped_mass_properties(*moved);
  const MassProperties b = lumped_mass_properties(*whole);
  EXPECT_LT((a.center - b.center).norm(), 1e-13);
  EXPECT_LT((a.inertia - b.inertia).norm(), 1e-12 * b.inertia.norm());
  EXPECT_GT(moved->mass().minCoeff(), 0.0);
}

TEST(MovedMasses, AreRefusedWhereTheyCannotBe) {
  const auto expect = [](const Scene& scene, const std::string& part) {
    EXPECT_NE(refusal(scene).find(part), std::string::npos) << refusal(scene);
  };
  expect(block({0.4, 0.1, 0.4}, {4, 1, 4}), "too few vertices");
  expect(block({0.4, 0.1, 0.4}, {4, 2, 4}), "too few vertices");
  Scene scene = block({0.4, 0.1, 0.4}, {4, 1, 4});
  scene.obstacle[0].select = SelectAll{};
  expect(scene, "no place inside");
  scene = block({0.4, 0.3, 0.2}, {4, 6, 3});
  scene.obstacle.clear();
  expect(scene, "neither an [[obstacle]] nor contact.between");
  scene = block({0.4, 0.3, 0.2}, {4, 6, 3});
  for (const double mass : {0.0, -1.0, 1.5}) {
    scene.contact.mass = mass;
    expect(scene, "contact.mass");
  }
  scene.contact.mass = 0.01;
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    scene.time.integrator = rule;
    expect(scene, "contact.mass is for implicit steps");
  }
  // An event that takes an explicit rule is refused before the run.
  scene.time.integrator = Integrator::kEnergyMomentum;
  EXPECT_EQ(refusal(scene), "accepted");
  TimeSettings later = scene.time;
  later.integrator = Integrator::kVerlet;
  scene.event.resize(1);
  scene.event[0].at = 0.5 * scene.time.end;
  scene.event[0].edits = {SetTime{later}};
  expect(scene, "contact.mass is for implicit steps");
}

// Statics have no masses, but weights, which stay where they are.
TEST(MovedMasses, LeaveEquilibriaAsTheyAre) {
  Scene scene = block({0.2, 0.3, 0.2}, {2, 4, 2});
  scene.obstacle[0].point = {0.0, -0.001, 0.0};
  scene.environment = gravity(9.81);
  scene.fix.push_back(fix(SelectVertices{{0}}, {true, false, true}));
  scene.fix.push_back(fix(SelectNearest{{0.2, 0.0, 0.0}}, {false, false, true}));
  const FinishedEquilibrium moved(scene);
  scene.contact.mass = 1.0;
  const FinishedEquilibrium whole(scene);
  const Vector sag = whole.state().position - whole.system().mesh().rest_positions();
  EXPECT_LT((moved.state().position - whole.state().position).norm(), 1e-10 * sag.norm());
}

}  // namespace
}  // namespace tetraction
