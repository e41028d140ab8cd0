// Pressure on surfaces with a free rim, which follows the deformation and has no potential: equilibria,
// stability, damping and motions against closed forms and published numbers.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include "support/dense_matrices.h"
#include "support/runs.h"
#include "tetraction/material/neo_hookean.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A bar along x of quadratic elements with a pressure on its end face.
Scene bar(const Vector3& size, const std::array<int, 3>& cells, double value) {
  Scene scene = scene_of({GeneratorKind::kBox, size, cells}, elastic(1e9, 0.3));
  scene.pressure = {pressure(SelectPlane{0, size.x(), {}}, value)};
  return scene;
}

TetMesh quadratic_mesh(const Scene& scene) {
  return with_edge_vertices(generate_mesh(*scene.mesh.generate));
}

Session equilibrium(const Scene& scene) {
  return {scene, quadratic_mesh(scene), Analysis::kEquilibrium};
}

FinishedEquilibrium finished(const Scene& scene) {
  return {scene, quadratic_mesh(scene)};
}

// The stretches of a bar of compressible neo-Hookean material along and across a Cauchy stress σ:
// σ J = μ (a² − 1) + λ ln J along it and 0 = μ (b² − 1) + λ ln J across it, with J = a b².
std::pair<double, double> stretches(double stress, double youngs_modulus, double poissons_ratio) {
  const LameParameters lame = lame_from_young(youngs_modulus, poissons_ratio);
  double a = 1.0;
  double b = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double volume = a * b * b;
    const Eigen::Vector2d residual(
        lame.mu * (a * a - 1.0) + lame.lambda * std::log(volume) - stress * volume,
        lame.mu * (b * b - 1.0) + lame.lambda * std::log(volume));
    Eigen::Matrix2d slope;
    slope << 2.0 * lame.mu * a + lame.lambda / a - stress * b * b,
        2.0 * lame.lambda / b - 2.0 * stress * a * b, lame.lambda / a,
        2.0 * lame.mu * b + 2.0 * lame.lambda / b;
    const Eigen::Vector2d step = slope.inverse() * residual;
    a -= step.x();
    b -= step.y();
  }
  return {a, b};
}

// The stress of the pressure is that of the deformed area, so that the bar is uniformly stretched.
TEST(FollowerStatics, PullAndPushOnTheEndOfABar) {
  constexpr double kYoung = 1e9;
  constexpr double kPoisson = 0.3;
  for (const double stress : {1e8, 3e8, -1e8, -3e8}) {
    Scene scene = bar({1.0, 0.3, 0.3}, {4, 1, 1}, -stress);
    scene.fix = {fix(SelectPlane{0, 0.0, {}}, {true, false, false}),
                 fix(SelectPlane{1, 0.0, {}}, {false, true, false}),
                 fix(SelectPlane{2, 0.0, {}}, {false, false, true})};
    FinishedEquilibrium session = finished(scene);
    EXPECT_TRUE(session.load_path()->limit_points.empty()) << stress;
    // The free edges of the end face let a strong push feed a vibration of this short bar.
    EXPECT_TRUE(stress < 0.0 || !session.load_path()->loss) << stress;
    const auto [along, across] = stretches(stress, kYoung, kPoisson);
    const Vector rest = session.system().mesh().rest_positions();
    const Vector3 factors(along, across, across);
    const Vector expected = rest.cwiseProduct(factors.replicate(rest.size() / 3, 1));
    EXPECT_LT((session.state().position - expected).lpNorm<Eigen::Infinity>(), 1e-9) << stress;
  }
}

// A clamped bar under a pull of a tenth of its modulus is stretched by some tenth.
TEST(FollowerStatics, PullOnTheEndOfAClampedBar) {
  for (const double width : {0.3, 0.5}) {
    for (const double stress : {1e8, 2e8}) {
      Scene scene = bar({1.0, width, width}, {4, 1, 1}, -stress);
      scene.fix = {fix(SelectPlane{0, 0.0, {}})};
      FinishedEquilibrium session = finished(scene);
      EXPECT_TRUE(session.load_path()->limit_points.empty());
      EXPECT_FALSE(session.load_path()->loss);
      const Index v =
          select_vertices(session.system().mesh(), SelectNearest{{1.0, width / 2, width / 2}})
              .front();
      const double stretch = session.state().position[3 * v];
      EXPECT_NEAR(stretch, stretches(stress, 1e9, 0.3).first, 0.012);
      EXPECT_LE(session.load_path()->steps, 2);
    }
  }
}

// The square column of Beck (ZAMP 3, 1952) under a force that follows its end: it never buckles, but it
// flutters from P = 20.05 EI/L² on.
constexpr double kBeck = 20.0509;
constexpr double kThickness = 0.05;

double column_pressure(double p) {  // for P = p EI/L²
  return p * 1e9 * kThickness * kThickness / 12.0;
}

Scene column(double p) {
  Scene scene = bar({1.0, kThickness, kThickness}, {8, 1, 1}, column_pressure(p));
  scene.material.poissons_ratio = 0.0;
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  return scene;
}

TEST(FollowerStatics, ColumnOfBeckFlutters) {
  // A shear-flexible column of this thickness flutters a little earlier.
  FinishedEquilibrium stable = finished(column(0.95 * kBeck));
  EXPECT_TRUE(stable.load_path()->limit_points.empty()) << stable.message();
  EXPECT_FALSE(stable.load_path()->loss);
  for (const std::string& warning : stable.warnings()) {
    EXPECT_EQ(warning.find("swing"), std::string::npos) << warning;
  }

  FinishedEquilibrium session = finished(column(1.25 * kBeck));
  const LoadPath& path = *session.load_path();
  EXPECT_TRUE(path.limit_points.empty()) << session.message();
  ASSERT_TRUE(path.loss);
  EXPECT_TRUE(path.loss->is_flutter);
  EXPECT_GT(path.loss->growth_rate, 0.0);
  EXPECT_LE(path.loss->above - path.loss->below, 1.0 / 1024);
  EXPECT_NEAR(1.25 * path.loss->below, 1.0, 0.015);
  ASSERT_FALSE(session.warnings().empty());
  expect_part(session.warnings().back(), "swing further and further");
}

// With a dead load the same column buckles at P = π²/4 EI/L², which is what a force that keeps its direction
// does. A pressure far above that load holds a clamped column straight.
TEST(FollowerStatics, SlenderColumnStandsFarBeyondEulersLoad) {
  Scene scene = bar({1.0, 0.025, 0.025}, {8, 1, 1}, 0.0);
  scene.material.poissons_ratio = 0.0;
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  for (const double p : {-50.0, 2.0, 10.0, 18.0}) {
    scene.pressure[0].value = p * 1e9 * 0.025 * 0.025 / 12.0;
    Session session = equilibrium(scene);
    ASSERT_EQ(session.run(), RunStatus::kFinished) << p << ' ' << session.message();
    EXPECT_TRUE(session.load_path()->limit_points.empty()) << p;
    EXPECT_FALSE(session.load_path()->loss) << p;
    const Vector3 load =
        session.external_force().reshaped(3, session.external_force().size() / 3).rowwise().sum();
    EXPECT_LT(load.tail<2>().norm(), 1e-6 * load.norm());
  }
}

// A shallow arch whose lateral edges are free snaps through under a pressure on its back.
TEST(FollowerStatics, ArchWithFreeEdgesSnapsThrough) {
  TetMesh mesh = generate_box({4, 0.1, 0.4}, {32, 2, 2});
  for (Vector3& x : mesh.vertices.own()) x.y() += 0.1 * x.x() * (4.0 - x.x());
  Scene scene = scene_of(elastic(1e6, 0.3));
  scene.fix = {fix(SelectPlane{0, 0.0, {}}), fix(SelectPlane{0, 4.0, {}})};
  scene.pressure = {pressure(SelectFaces{{0, 1, 0}, 45.0}, 800.0)};
  FinishedRun arch(scene, mesh, Analysis::kEquilibrium, 0.125);
  const LoadPath& path = *arch.load_path();
  ASSERT_GE(path.limit_points.size(), 1U) << arch.message();
  EXPECT_TRUE(path.limit_points[0].passed);
  EXPECT_FALSE(path.loss);
  EXPECT_LE(path.residual, std::max(path.residual_limit, 1e-9));
  const Index crown = select_vertices(mesh, SelectNearest{{2, 0.45, 0.2}}).front();
  EXPECT_LT(arch.state().position[3 * crown + 1], 0.0);
}

// A pressure turns and moves with the body, so that it restrains no rigid motion, whether its surface is
// closed or has a rim.
TEST(FollowerStatics, RestrainsNoRigidMotion) {
  const auto count = [](const std::vector<FixSettings>& fixes,
                        const std::vector<ForceSettings>& loads) {
    Scene scene = bar({4.0, 1.0, 1.0}, {4, 2, 2}, 0.0);
    scene.fix = fixes;
    scene.pressure = loads;
    const std::unique_ptr<MechanicalSystem> system =
        make_system(scene, generate_mesh(*scene.mesh.generate));
    make_initial_state(scene, *system);
    return free_motions(*system).size();
  };
  const std::vector<FixSettings> slides{fix(SelectPlane{0, 0.0, {}}, {false, true, true}),
                                        fix(SelectPlane{0, 4.0, {}}, {false, true, true})};
  for (const double value : {1.0, 1e3, -1e3}) {
    EXPECT_EQ(count({}, {pressure(SelectSurface{}, value)}), 6U) << value;
    EXPECT_EQ(count({}, {pressure(SelectPlane{0, 0.0, {}}, value)}), 6U) << value;
    EXPECT_EQ(count({}, {pressure(SelectPlane{0, 0.0, {}}, value),
                         pressure(SelectPlane{0, 4.0, {}}, value)}),
              6U);
    EXPECT_EQ(count(slides, {pressure(SelectPlane{1, 1.0, {}}, value)}), 1U) << value;
    // Along x, and about the axes in the plane whose vertices may move along x only.
    EXPECT_EQ(count({slides[0]}, {pressure(SelectPlane{0, 4.0, {}}, value)}), 3U) << value;
    EXPECT_EQ(count({fix(SelectPlane{0, 0.0, {}})}, {pressure(SelectSurface{}, value)}), 0U);
  }
}

// Forces of a very slender bar balance up to round-off only. Newton's corrections tell that its positions are
// known all the same.
TEST(FollowerStatics, VerySlenderBar) {
  for (const double value : {0.8354, -0.8354, 0.16}) {
    Scene scene = bar({1000.0, 1.0, 1.0}, {20, 1, 1}, value);
    scene.material.youngs_modulus = 1e6;
    scene.material.poissons_ratio = 0.0;
    scene.fix = {fix(SelectPlane{0, 0.0, {}})};
    FinishedEquilibrium session = finished(scene);
    EXPECT_FALSE(session.load_path()->loss);
    const Vector moved = session.state().position - session.system().mesh().rest_positions();
    EXPECT_NEAR(moved.cwiseAbs().maxCoeff(), 1e-3 * std::abs(value), 2e-6 * std::abs(value));
  }
}

// A column that is pushed off its axis bends more and more toward Euler's load, without any jump.
TEST(FollowerStatics, SmoothBendingIsNoLimitPoint) {
  Scene scene = bar({20.0, 1.0, 1.0}, {10, 1, 1}, 0.0);
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.0;
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  ForceSettings push;
  push.kind = LoadKind::kTraction;
  push.select = SelectPlane{0, 20.0, {}};
  const double critical = std::numbers::pi * std::numbers::pi / 4.0 * 1e6 / 12.0 / 400.0;
  push.vector = Vector3(-0.97 * critical, 0, 0);
  scene.traction = {push};
  scene.pressure = {pressure(SelectPlane{1, 1.0, {}}, 0.02)};
  for (const double increment : {1.0, 0.1}) {
    FinishedRun session(scene, quadratic_mesh(scene), Analysis::kEquilibrium, increment);
    EXPECT_TRUE(session.load_path()->limit_points.empty()) << session.message();
    EXPECT_FALSE(session.load_path()->loss);
  }
}

// Implicit motions of the column under half of the flutter load go to the equilibrium at once or swing
// about it, whatever the step.
// Round-off of the forces of a slender body is not taken for a load that it cannot carry. In other units the same body
// ends at another level of round-off.
TEST(FollowerStatics, RoundOffIsNoLimitPoint) {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    Scene scene = scene_of({GeneratorKind::kBox, unit * Vector3(20.0, 0.7, 0.5), {18, 1, 1}},
                           elastic(682812763.0267657, 0.49, "stvk"));
    scene.fix = {fix(SelectPlane{0, 0.0, {}})};
    SelectFaces up;
    up.normal = Vector3(0, 0, 1);
    scene.pressure = {pressure(up, -588.0927542862386)};
    FinishedEquilibrium session = finished(scene);
    EXPECT_TRUE(session.load_path()->limit_points.empty()) << session.message();
    EXPECT_EQ(session.load_path()->steps, 1);
    EXPECT_LT(session.total_iterations(), 100);
    const TetMesh& mesh = session.system().mesh();
    const Index tip = select_vertices(mesh, SelectNearest{unit * Vector3(20, 0, 0.5)}).front();
    const Vector3 moved =
        session.state().position.segment<3>(3 * tip) - mesh.vertices[static_cast<std::size_t>(tip)];
    EXPECT_NEAR(moved.norm() / unit, 1.4714, 1e-4);
  }
}

TEST(FollowerMotion, ImplicitStepsUnderLargePressure) {
  FinishedEquilibrium found = finished(column(10.0));
  for (const Integrator rule :
       {Integrator::kMidpoint, Integrator::kBackwardEuler, Integrator::kEnergyMomentum}) {
    for (const double step : {1e-3, 0.1}) {
      Scene scene = column(10.0);
      scene.damping.mass_damping = 20.0;
      scene.initial.is_static = true;
      scene.initial.velocity = {0.0, 1e-3, 0.0};
      scene.time = {rule, step, false, 20 * step};
      Session session(scene, quadratic_mesh(scene));
      EXPECT_EQ(session.run(), RunStatus::kFinished)
          << to_string(rule) << ' ' << step << ": " << session.message();
      const Vector moved = session.state().position - found.state().position;
      EXPECT_LT(moved.lpNorm<Eigen::Infinity>(), 1e-3) << to_string(rule) << ' ' << step;
    }
  }
}

// Damping of the material lets the column flutter far below the load of Beck (Ziegler, Ing.-Archiv 20, 1952);
// that of the surroundings does not. The roots of the whole damped problem, without any modes, tell the
// growth.
class DampedColumn {
 public:
  explicit DampedColumn(double p, double viscosity, double mass_damping)
      : scene_(scene(p, viscosity, mass_damping)), session_(equilibrium(scene_)) {
    EXPECT_EQ(session_.run(), RunStatus::kFinished) << session_.message();
  }
  NormalModes modes(Index count) const {
    NormalModeOptions options;
    options.count = count;
    options.with_loads = true;
    return normal_modes(session_.system(), session_.state().position, options);
  }
  // All λ of λ² M y + λ C y + K y = 0 with Im λ > 0, in the order of |λ|.
  std::vector<std::complex<double>> roots() const {
    return rates_of(dense_matrices(session_.system(), session_.state().position),
                    [](const std::complex<double>& value) { return value.imag() > 0.0; });
  }

 private:
  static Scene scene(double p, double viscosity, double mass_damping) {
    Scene scene = column(p);
    scene.mesh.generate->cells = {4, 1, 1};
    scene.damping.viscosity = viscosity;
    scene.damping.mass_damping = mass_damping;
    return scene;
  }

  Scene scene_;
  Session session_;
};

// A weak pressure with a free rim changes neither frequencies nor damping ratios, which are those of the
// symmetric problem then, φᵀCφ/(2ω), whatever the unit of time: the lowest ω² is 10¹² 1/s² here, 1 1/s², and
// 10⁻²⁰ 1/s².
TEST(FollowerModes, DampingRatiosInAnyUnits) {
  struct Body {
    double size, youngs_modulus, density, viscosity;
  };
  for (const Body& body : {Body{1e-4, 1.6e11, 2330.0, 10.0},
                           {1e-2, 1.6e11, 2330.0, 1e3},
                           {1e-6, 1e12, 2330.0, 0.2},
                           {1e3, 1e-10, 1e3, 1e-3}}) {
    Scene scene = bar(body.size * Vector3(1.0, 0.1, 0.1), {8, 2, 1}, 0.0);
    scene.material.youngs_modulus = body.youngs_modulus;
    scene.material.poissons_ratio = 0.22;
    scene.material.density = body.density;
    scene.damping.viscosity = body.viscosity;
    scene.fix = {fix(SelectPlane{0, 0.0, {}})};
    scene.pressure = {pressure(SelectPlane{1, 0.1 * body.size, {}}, 6.25e-7 * body.youngs_modulus)};
    FinishedEquilibrium session = finished(scene);
    EXPECT_FALSE(session.load_path()->loss) << body.size;
    NormalModeOptions options;
    options.count = 6;
    const NormalModes symmetric = normal_modes(session.system(), session.state().position, options);
    options.with_loads = true;
    const NormalModes modes = normal_modes(session.system(), session.state().position, options);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_EQ(modes.modes[i].kind, ModeKind::kElastic) << body.size << ' ' << i;
      const double expected = symmetric.modes[i].damping_ratio;
      EXPECT_GT(expected, 1e-5);
      EXPECT_NEAR(modes.modes[i].damping_ratio, expected, 1e-3 * expected) << body.size << ' ' << i;
    }
  }
}

// If two modes flutter together, the one that grows comes first, so that it is not cut off.
TEST(FollowerModes, TheModeThatGrowsComesFirst) {
  const DampedColumn body(26.0, 0.0, 5.0);
  const NormalModes all = body.modes(6);
  for (std::size_t count = 1; count <= 6; ++count) {
    const NormalModes some = body.modes(static_cast<Index>(count));
    ASSERT_EQ(some.modes.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(some.modes[i].kind, all.modes[i].kind) << count << ' ' << i;
    }
  }
  EXPECT_EQ(all.modes[0].kind, ModeKind::kFlutter);
}

TEST(FollowerModes, DampingThatLetsAColumnFlutter) {
  struct Case {
    double p, viscosity, mass_damping;
    bool grows;
  };
  for (const Case& c :
       {Case{10.0, 1e5, 0.0, false}, Case{16.0, 1e5, 0.0, true}, Case{16.0, 0.0, 5.0, false},
        Case{16.0, 1e5, 5.0, false}, Case{26.0, 1e4, 0.0, true}}) {
    const DampedColumn body(c.p, c.viscosity, c.mass_damping);
    const std::vector<std::complex<double>> roots = body.roots();
    const NormalModes modes = body.modes(6);
    bool grows = false;
    double growth = 0.0;
    for (std::size_t i = 0; i < 6; ++i) {
      const NormalMode& mode = modes.modes[i];
      grows = grows || mode.kind == ModeKind::kFlutter;
      // The nearest root, by the damping ratio.
      double least = 1.0;
      for (std::size_t k = 0; k < 10; ++k) {
        const double ratio = -roots[k].real() / std::abs(roots[k]);
        const double frequency = std::abs(std::abs(roots[k]) / std::sqrt(mode.omega_squared) - 1.0);
        if (frequency < 0.1) least = std::min(least, std::abs(ratio - mode.damping_ratio));
      }
      EXPECT_LT(least, 1e-3 * std::abs(mode.damping_ratio) + 1e-8) << c.p << ' ' << i;
      EXPECT_EQ(mode.kind == ModeKind::kFlutter, mode.damping_ratio < -1e-9);
      growth = std::max(growth, mode.growth_rate);
    }
    EXPECT_EQ(grows, c.grows) << c.p;
    double fastest = roots.front().real();
    for (const std::complex<double>& root : roots) fastest = std::max(fastest, root.real());
    if (c.grows) {
      EXPECT_NEAR(growth, fastest, 1e-3 * fastest);
    } else {
      EXPECT_LT(fastest, 0.0);
    }
  }
}

}  // namespace
}  // namespace tetraction
