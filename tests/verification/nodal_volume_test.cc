// mesh.volume = "nodal": conservation with every rule and solver, bits, and rubber that does not lock.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "support/corner_scenes.h"
#include "support/same_run.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/simulation/checkpoint.h"

namespace tetraction {
namespace {

using namespace testing_support;

Scene nodal(Scene scene, double ratio) {
  scene.mesh.volume = VolumeRule::kNodal;
  scene.material.poissons_ratio = ratio;
  return scene;
}

double stable_step(const Scene& scene) {
  return Session(scene, mesh_of(scene)).initial_limit().critical_step;
}

// All vertices of the boundary move as an affine map says; those inside follow exactly.
TEST(NodalVolumePatch, InnerVerticesFollowAnAffineMap) {
  Matrix3 f;
  f << 1.1, 0.15, -0.05, 0.0, 0.92, 0.1, 0.05, -0.1, 1.02;
  for (const double ratio : {0.3, 0.4999}) {
    Scene scene = nodal({}, ratio);
    scene.material.youngs_modulus = 1e6;
    TetMesh mesh = generate_box({2, 1, 1}, {5, 4, 4});
    std::vector<std::int64_t> held;
    std::vector<bool> is_held(mesh.vertices.size());
    for (const auto& face : boundary_faces(mesh)) {
      for (const Index v : face) is_held[static_cast<std::size_t>(v)] = true;
    }
    Vector shaken = jiggled(mesh.rest_positions(), 0.03);
    FixSettings fix;
    for (std::size_t v = 0; v < is_held.size(); ++v) {
      if (is_held[v]) {
        held.push_back(static_cast<std::int64_t>(v));
        fix.targets.emplace_back(f * mesh.vertices[v]);
      } else {
        mesh.vertices.own()[v] = shaken.segment<3>(3 * static_cast<Index>(v));
      }
    }
    fix.select = SelectVertices{held};
    scene.fix = {fix};
    FinishedRun session(scene, mesh, Analysis::kEquilibrium);
    for (std::size_t v = 0; v < is_held.size(); ++v) {
      const Vector3 exact = f * mesh.vertices[v];
      EXPECT_LT((session.state().position.segment<3>(3 * static_cast<Index>(v)) - exact).norm(),
                2e-12);
    }
  }
}

class NodalVolumeRules : public testing::TestWithParam<Integrator> {
 protected:
  ~NodalVolumeRules() override { set_thread_count(0); }
};

TEST_P(NodalVolumeRules, KeepWhatTheyPromise) {
  const Integrator rule = GetParam();
  Scene scene = nodal(spinning_block(rule, 1e-6, 1e-6), 0.499);
  scene.solver.tolerance = 1e-10;
  const double limit = stable_step(scene);
  const double step = is_implicit(rule) ? 5.0 * limit : 0.3 * limit;
  scene.time = {rule, step, false, (is_implicit(rule) ? 200 : 3000) * step};
  FinishedRun session(scene);
  const Balance& balance = session.balance();
  EXPECT_LT(balance.linear_momentum_drift(), rule == Integrator::kBackwardEuler ? 1e-9 : 1e-12);
  if (rule != Integrator::kBackwardEuler) {
    EXPECT_LT(balance.angular_momentum_drift(), is_implicit(rule) ? 1e-8 : 1e-12);
  }
  if (rule == Integrator::kEnergyMomentum) {
    EXPECT_LT(balance.max_relative_energy_drift(), 1e-9);
  } else if (rule == Integrator::kBackwardEuler) {
    EXPECT_LT(balance.energy_error(), 0.0);
  } else {
    // The energy of an oscillator in steps of symplectic Euler stays below E/(1 − hω/2), and hω/2 is
    // 0.3 here.
    EXPECT_LT(balance.max_relative_energy_drift(),
              rule == Integrator::kExplicit ? 1.0 / (1.0 - 0.3) - 1.0 : 0.1);
  }
  EXPECT_NEAR(session.system().elastic_energies_by_region(session.state().position).sum(),
              balance.energies().elastic(), 1e-10 * balance.energies().total());
}

TEST_P(NodalVolumeRules, HaveTheSameBitsWithAnyNumberOfThreads) {
  Scene scene = nodal(clamped_beam({4, 1, 1}, {14, 12, 12}), 0.49);
  const Integrator rule = GetParam();
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.initial.angular_velocity = {0.3, 0.2, 0.5};
  const double step = is_implicit(rule) ? 1e-2 : 2e-5;
  scene.time = {rule, step, false, (is_implicit(rule) ? 1.0 : 6.0) * step};
  State first;
  std::vector<double> sums;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    Session session(scene, mesh_of(scene));
    ASSERT_GT(session.system().vertex_count(), 2048);
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    if (threads == 1) {
      first = session.state();
      sums = numbers_of(session.balance().sums());
      continue;
    }
    EXPECT_EQ(session.state().position, first.position);
    EXPECT_EQ(session.state().momentum, first.momentum);
    EXPECT_EQ(numbers_of(session.balance().sums()), sums);
  }
}

TEST_P(NodalVolumeRules, GoOnFromACheckpointWithTheSameBits) {
  const Integrator rule = GetParam();
  Scene scene = nodal(clamped_beam({2, 1, 1}, {4, 2, 2}), 0.49);
  const double h = is_implicit(rule) ? 4e-3 : 5e-5;
  scene.time = {rule, h, false, 30 * h};
  scene.environment.kind = EnvironmentKind::kGravity;
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 0.8e6;
  scene.event.push_back({12.0 * h, {SetMaterial{0, softer}}, {}, {}});
  Session continued(scene, mesh_of(scene));
  for (int k = 0; k < 8; ++k) ASSERT_TRUE(continued.step()) << continued.message();
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(continued.step()) << continued.message();
    ASSERT_TRUE(restored.step()) << restored.message();
    expect_same(continued, restored);
  }
  // An edit counts with the energy that it makes of the whole material.
  EXPECT_NE(continued.balance().edit_work(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(All, NodalVolumeRules, testing::ValuesIn(all_rules()), name_of_rule);

TEST(NodalVolumeSolvers, FindTheSameMotion) {
  for (const Integrator rule : {Integrator::kMidpoint, Integrator::kEnergyMomentum}) {
    Vector reference;
    for (const LinearSolver linear : {LinearSolver::kFactor, LinearSolver::kCg,
                                      LinearSolver::kMatrixFree, LinearSolver::kAuto}) {
      if (rule == Integrator::kEnergyMomentum && linear == LinearSolver::kCg) continue;
      Scene scene = nodal(clamped_beam({2, 1, 1}, {6, 3, 3}), 0.499);
      scene.environment.kind = EnvironmentKind::kGravity;
      scene.time = {rule, 5e-3, false, 0.1};
      scene.solver.linear = linear;
      scene.solver.tolerance = 1e-10;
      FinishedRun session(scene);
      EXPECT_LT(session.balance().max_relative_energy_drift(),
                rule == Integrator::kMidpoint ? 0.05 : 1e-8);
      if (reference.size() == 0) reference = session.state().position;
      EXPECT_LT((session.state().position - reference).lpNorm<Eigen::Infinity>(), 1e-6);
    }
  }
}

TEST(NodalVolumeEdits, RefuseAMaterialWithoutAVolumetricPartAndChangeNothing) {
  Scene scene = nodal(clamped_beam({2, 1, 1}, {4, 2, 2}), 0.49);
  Session session(scene, mesh_of(scene));
  const double before = session.system().materials()[0].lame_range().most.lambda;
  MaterialSettings stvk = scene.material;
  stvk.model = "stvk";
  EXPECT_THROW(session.apply(SetMaterial{0, stvk}, "stvk"), InputError);
  EXPECT_EQ(session.system().materials()[0].lame_range().most.lambda, before);
  EXPECT_TRUE(session.step()) << session.message();
  scene.event.push_back({1e-3, {SetMaterial{0, stvk}}, {}, {}});
  EXPECT_THROW(Session(scene, mesh_of(scene)), InputError);
  scene.event.clear();
  scene.material = stvk;
  EXPECT_THROW(Session(scene, mesh_of(scene)), InputError);
}

// A tube of cells of six tetrahedra: radii 8 and 20 mm, 30 mm long.
TetMesh bushing_mesh(Index radial, Index around, Index along) {
  TetMesh mesh;
  std::vector<Vector3>& positions = mesh.vertices.own();
  for (Index k = 0; k <= along; ++k) {
    for (Index j = 0; j < around; ++j) {
      for (Index i = 0; i <= radial; ++i) {
        const double r = 0.008 + 0.012 * double(i) / double(radial);
        const double angle = 2.0 * std::numbers::pi * double(j) / double(around);
        positions.emplace_back(r * std::cos(angle), r * std::sin(angle),
                               0.03 * double(k) / double(along));
      }
    }
  }
  const auto vertex = [&](const std::array<Index, 3>& c) {
    return c[0] + (radial + 1) * (c[1] % around + around * c[2]);
  };
  constexpr std::array<std::array<std::size_t, 3>, 6> kPaths{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};
  for (Index k = 0; k < along; ++k) {
    for (Index j = 0; j < around; ++j) {
      for (Index i = 0; i < radial; ++i) {
        for (std::size_t p = 0; p < kPaths.size(); ++p) {
          std::array<Index, 3> corner{i, j, k};
          std::array<Index, 4> nodes{vertex(corner)};
          for (std::size_t a = 0; a < 3; ++a) {
            ++corner[kPaths[p][a]];
            nodes[a + 1] = vertex(corner);
          }
          if (p >= 3) std::swap(nodes[2], nodes[3]);
          mesh.tetrahedra.own().push_back(nodes);
        }
      }
    }
  }
  return mesh;
}

// The torque that turns the outer face by 30°, divided by that of a long bushing in azimuthal shear.
double torque_ratio(TetMesh mesh, double ratio, VolumeRule volume) {
  constexpr double kTurn = std::numbers::pi / 6.0;
  Scene scene;
  scene.mesh.volume = volume;
  scene.material.youngs_modulus = 3e6;
  scene.material.poissons_ratio = ratio;
  FixSettings inner;
  FixSettings outer;
  std::vector<std::int64_t> inside;
  std::vector<std::int64_t> outside;
  const Matrix3 turn = Eigen::AngleAxisd(kTurn, Vector3::UnitZ()).toRotationMatrix();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
    const double r = std::hypot(x.x(), x.y());
    if (r < 0.00801) inside.push_back(v);
    if (r > 0.01999) {
      outside.push_back(v);
      outer.targets.emplace_back(turn * x);
    }
  }
  inner.select = SelectVertices{inside};
  outer.select = SelectVertices{outside};
  scene.fix = {inner, outer};
  Session session(scene, std::move(mesh), Analysis::kEquilibrium);
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  double torque = 0.0;
  for (const std::int64_t v : outside) {
    const Vector3 x = session.state().position.segment<3>(3 * v);
    const Vector3 f = session.reaction_force().segment<3>(3 * v);
    torque += x.x() * f.y() - x.y() * f.x();
  }
  const double mu = lame_from_young(3e6, ratio).mu;
  const double exact =
      4.0 * std::numbers::pi * mu * 0.03 * kTurn / (1.0 / (0.008 * 0.008) - 1.0 / (0.02 * 0.02));
  return torque / exact;
}

TEST(Bushing, DoesNotLockWithNodalVolumes) {
  EXPECT_NEAR(torque_ratio(bushing_mesh(2, 20, 5), 0.45, VolumeRule::kElement), 2.91, 0.1);
  EXPECT_NEAR(torque_ratio(bushing_mesh(2, 20, 5), 0.45, VolumeRule::kNodal), 1.33, 0.05);
  EXPECT_NEAR(torque_ratio(bushing_mesh(2, 20, 5), 0.499, VolumeRule::kNodal), 1.58, 0.05);
  EXPECT_NEAR(torque_ratio(bushing_mesh(3, 30, 8), 0.45, VolumeRule::kNodal), 1.16, 0.05);
  EXPECT_LT(torque_ratio(bushing_mesh(3, 30, 8), 0.4999, VolumeRule::kNodal), 1.4);
}

}  // namespace
}  // namespace tetraction
