// Natural frequencies against closed forms and against motions of the same body.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/runs.h"
#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/dynamics/steppers/oscillator.h"
#include "tetraction/dynamics/terms/rayleigh_damping.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kPi = std::numbers::pi;
constexpr double kModulus = 1e6;
constexpr double kDensity = 1000.0;

NormalModes lowest(const MechanicalSystem& system, Index count) {
  NormalModeOptions options;
  options.count = count;
  return normal_modes(system, system.mesh().rest_positions(), options);
}

// f_n = (β_n²/2π) √(EI/ρA)/L² of Euler and Bernoulli, for a square section of width h.
double bending_frequency(double beta, double width, double length) {
  return beta * beta / (2.0 * kPi) * std::sqrt(kModulus / kDensity / 12.0) * width /
         (length * length);
}

// A free square beam: six rigid modes, then bending modes in pairs. Linear tetrahedra are too stiff
// in bending, by an amount that depends on the direction of their diagonals. The error of the mean
// frequency of a pair has order two, and the two frequencies come together.
TEST(FreeBeam, SixRigidModesAndPairsOfBendingModes) {
  const LameParameters lame = lame_from_young(kModulus, 0.3);
  constexpr double kLength = 2.0;
  constexpr double kWidth = 0.1;
  const double exact = bending_frequency(4.730041, kWidth, kLength);
  std::vector<double> errors;
  std::vector<double> splits;
  for (const int n : {4, 8}) {
    const MechanicalSystem system(generate_box({kLength, kWidth, kWidth}, {10 * n, n, n}),
                                  StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
    const NormalModes modes = lowest(system, 10);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(modes.modes[i].kind, ModeKind::kRigid);
    for (std::size_t i = 6; i < 10; ++i) EXPECT_EQ(modes.modes[i].kind, ModeKind::kElastic);
    const auto frequency = [&](std::size_t i) { return modes.modes[i].frequency(); };
    EXPECT_GT(frequency(8), 2.5 * frequency(7));
    splits.push_back(frequency(7) / frequency(6) - 1.0);
    EXPECT_NEAR(frequency(9) / frequency(8) - 1.0, splits.back(), 0.1 * splits.back());
    errors.push_back(0.5 * (frequency(6) + frequency(7)) / exact - 1.0);
  }
  EXPECT_LT(errors[1], 0.05);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.15);
  EXPECT_LT(splits[1], 0.4 * splits[0]);
}

// A rod that is held at one end along its axis only: f = √(E/ρ)/(4L), with the wave speed of a free
// lateral contraction. The first axial mode has 8/π² of the mass.
TEST(AxialRod, FirstFrequencyWithFreeContraction) {
  const LameParameters lame = lame_from_young(kModulus, 0.3);
  const TetMesh mesh = generate_box({1, 0.05, 0.05}, {60, 3, 3});
  MechanicalSystem system(mesh, StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  PrescribedVertices end =
      prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}), "end");
  end.components = {true, false, false};
  system.set_constraints(Constraints({{end}, {}, {}, {}}, mesh, system.mass()));
  const NormalModes modes = lowest(system, 20);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(modes.modes[i].kind, ModeKind::kRigid);
  const auto axial = std::max_element(modes.modes.begin(), modes.modes.end(),
                                      [](const NormalMode& a, const NormalMode& b) {
                                        return a.effective_mass.x() < b.effective_mass.x();
                                      });
  const double exact = 0.25 * std::sqrt(kModulus / kDensity);
  EXPECT_NEAR(axial->frequency(), exact, 1e-3 * exact);
  EXPECT_NEAR(axial->effective_mass.x() / system.total_mass(), 8.0 / (kPi * kPi), 1e-3);
}

// The free cube has the exact mode of statics_and_modes_test.cc, f = √(μ/ρ)/(√2 a), three times.
TEST(FreeCube, ExactModeIsFound) {
  const LameParameters lame = lame_from_young(kModulus, 0.25);
  const double exact = std::sqrt(lame.mu / kDensity) / std::numbers::sqrt2;
  const MechanicalSystem system(generate_box({1, 1, 1}, {10, 10, 10}),
                                StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  const NormalModes modes = lowest(system, 20);
  EXPECT_GE(std::count_if(modes.modes.begin(), modes.modes.end(),
                          [&](const NormalMode& mode) {
                            return std::abs(mode.frequency() / exact - 1.0) < 0.02;
                          }),
            3);
}

// Quadratic elements with their consistent mass give frequencies from above, with order 4. Lumped
// masses would be 1 % too low here.
TEST(FreeCube, QuadraticElementsFindTheExactMode) {
  const LameParameters lame = lame_from_young(kModulus, 0.25);
  const double exact = std::sqrt(lame.mu / kDensity) / std::numbers::sqrt2;
  const MechanicalSystem system(with_edge_vertices(generate_box({1, 1, 1}, {8, 8, 8})),
                                StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  const NormalModes modes = lowest(system, 22);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(modes.modes[i].kind, ModeKind::kRigid);
  EXPECT_EQ(modes.modes[6].kind, ModeKind::kElastic);
  EXPECT_GE(std::count_if(modes.modes.begin(), modes.modes.end(),
                          [&](const NormalMode& mode) {
                            const double error = mode.frequency() / exact - 1.0;
                            return error > 0.0 && error < 1e-3;
                          }),
            3);
  for (const NormalMode& mode : modes.modes) {
    EXPECT_NEAR(mode.shape.dot(consistent_momentum(system, mode.shape)), 1.0, 1e-9);
  }
}

// A rod of quadratic elements that is held along its axis at one end, and a free end that two points
// keep at their distance: the equations of constraints are those of the consistent mass, too.
TEST(AxialRod, QuadraticElementsWithADistance) {
  const LameParameters lame = lame_from_young(kModulus, 0.0);
  const TetMesh mesh = with_edge_vertices(generate_box({1, 0.1, 0.1}, {10, 1, 1}));
  MechanicalSystem system(mesh, StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  PrescribedVertices end =
      prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}), "end");
  const Index a = select_vertices(mesh, SelectNearest{{1.0, 0.0, 0.0}}).front();
  const Index b = select_vertices(mesh, SelectNearest{{1.0, 0.1, 0.0}}).front();
  system.set_constraints(Constraints({{end}, {}, {{a, b, 0.1, "end"}}, {}}, mesh, system.mass()));
  const NormalModes modes = lowest(system, 12);
  const auto axial = std::max_element(modes.modes.begin(), modes.modes.end(),
                                      [](const NormalMode& x, const NormalMode& y) {
                                        return x.effective_mass.x() < y.effective_mass.x();
                                      });
  const double exact = 0.25 * std::sqrt(kModulus / kDensity);
  EXPECT_NEAR(axial->frequency(), exact, 1e-4 * exact);
  EXPECT_NEAR(axial->effective_mass.x() / system.total_mass(), 8.0 / (kPi * kPi), 1e-3);
}

// A cantilever that swings in one of its modes.
class DampedBeam {
 public:
  DampedBeam(double poissons_ratio, const std::array<int, 3>& cells)
      : mesh_(generate_box({1, 0.06, 0.06}, cells)) {
    scene_.material.model = "stvk";
    scene_.material.youngs_modulus = kModulus;
    scene_.material.poissons_ratio = poissons_ratio;
    scene_.fix = {fix(SelectPlane{0, 0.0, {}}),
                  fix(SelectPlane{2, 0.0, {}}, {false, false, true})};  // bending along y only
    lame_ = initial_lame(make_material(scene_.material));
    system_ = make_system(scene_, mesh_);
    make_initial_state(scene_, *system_);
    modes_ = lowest(*system_, 6);
  }

  const LameParameters& lame() const { return lame_; }
  // The bending modes along y.
  const NormalMode& bending(std::size_t number) const {
    for (const NormalMode& mode : modes_.modes) {
      if (mode.effective_mass.y() < 0.05 * modes_.moved_mass.y()) continue;
      if (number-- == 0) return mode;
    }
    throw std::runtime_error("no such mode");
  }

  // (a + φᵀCφ)/2ω with the damping matrix C of the viscosity.
  double modal_ratio(const NormalMode& mode, const Damping& damping) const {
    system_->set_damping(damping);
    Vector force = Vector::Zero(mode.shape.size());
    system_->add_viscous_force(mesh_.rest_positions(), mode.shape, force);
    return (damping.mass_damping - mode.shape.dot(force)) / (4.0 * kPi * mode.frequency());
  }

  // The logarithmic decrement of the amplitude of a mode over two periods, as a damping ratio
  // ζ = δ/√(4π² + δ²). It is taken from the times at which the mode passes zero and its rates there.
  double decay(const NormalMode& mode, const Damping& damping) const {
    Scene scene = scene_;
    scene.damping = damping;
    scene.solver.tolerance = 1e-10;
    const double step = 1.0 / mode.frequency() / 100.0;
    scene.time = {Integrator::kMidpoint, step, false, 2.4 / mode.frequency()};
    Session session(scene, mesh_);
    const Vector momentum = session.system().momentum_of(mode.shape);
    const double speed = 1e-4 * 2.0 * kPi * mode.frequency() / mode.shape.cwiseAbs().maxCoeff();
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (session.system().coordinates().is_fully_prescribed(v)) continue;
      SetMomentum kick;
      kick.change.select = SelectVertices{{v}};
      kick.change.value = speed * momentum.segment<3>(3 * v);
      session.apply(kick);
    }
    const Vector rest = mesh_.rest_positions();
    std::vector<double> peaks;
    double before = 0.0;
    double earlier = 0.0;
    while (session.step()) {
      const double now = momentum.dot(session.state().position - rest);
      if (before > earlier && before > now) {  // the top of the parabola through three points
        peaks.push_back(before -
                        std::pow(now - earlier, 2) / (8.0 * (now - 2.0 * before + earlier)));
      }
      earlier = before;
      before = now;
    }
    EXPECT_GE(peaks.size(), 2U) << session.message();
    const double decrement =
        std::log(peaks.front() / peaks.back()) / static_cast<double>(peaks.size() - 1);
    return decrement / std::hypot(2.0 * kPi, decrement);
  }

 private:
  TetMesh mesh_;
  Scene scene_;
  LameParameters lame_;
  std::unique_ptr<MechanicalSystem> system_;
  NormalModes modes_;
};

// Without lateral contraction all deformations are damped as shear, so that the damping matrix is
// aM + βK exactly: the two ratios that were asked for come out of the motion.
TEST(DampingRatio, OfTheFirstTwoBendingModes) {
  const DampedBeam beam(0.0, {24, 3, 2});
  const std::array<const NormalMode*, 2> modes{&beam.bending(0), &beam.bending(1)};
  const DampingRatio ratio{{modes[0]->frequency(), modes[1]->frequency()}, {0.02, 0.05}};
  const Damping damping = rayleigh_damping(ratio, beam.lame());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(beam.decay(*modes[i], damping), ratio.value[i], 0.01 * ratio.value[i]);
  }
}

// With lateral contraction the motion has the ratio of the mode's own damping matrix C, (a + φᵀCφ)/2ω.
TEST(DampingRatio, IsThatOfTheDampingMatrix) {
  const DampedBeam beam(0.3, {24, 3, 2});
  const NormalMode& mode = beam.bending(0);
  const Damping damping{0.0, 0.02 * 2.0 * kPi * mode.frequency(), 0.004 * beam.lame().mu};
  const double expected = beam.modal_ratio(mode, damping);
  EXPECT_NEAR(beam.decay(mode, damping), expected, 0.01 * expected);
}

// C = a M gives ζ = a/(2ω), with the consistent mass of quadratic elements, too.
TEST(DampingRatio, OfTheMassOfQuadraticElements) {
  const LameParameters lame = lame_from_young(kModulus, 0.3);
  MechanicalSystem system(with_edge_vertices(generate_box({4, 1, 1}, {4, 1, 1})),
                          StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  system.set_damping({0.0, 2.0, 0.0});
  const NormalModes modes = lowest(system, 12);
  for (std::size_t i = 6; i < modes.modes.size(); ++i) {
    const NormalMode& mode = modes.modes[i];
    EXPECT_NEAR(mode.damping_ratio * std::sqrt(mode.omega_squared), 1.0, 1e-9) << i;
  }
}

// Bending is damped less than shear by viscosity, as the formula says. Stiff tetrahedra hinder the
// lateral contraction on coarse meshes; with the order two of the mesh this goes away. A clamp would
// hinder it as well, so the beam is free.
TEST(DampingRatio, OfBendingWithLateralContraction) {
  const LameParameters lame = lame_from_young(kModulus, 0.3);
  std::vector<double> ratios;
  for (const int n : {1, 2}) {
    MechanicalSystem system(generate_box({1, 0.06, 0.06}, {24 * n, 4 * n, 4 * n}),
                            StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
    system.set_damping({0.0, 0.0, lame.mu});
    const NormalModes modes = lowest(system, 7);
    const NormalMode& mode = modes.modes[6];
    const Vector& shape = mode.shape;
    Vector force = Vector::Zero(shape.size());
    system.add_viscous_force(system.mesh().rest_positions(), shape, force);
    const double ratio = -shape.dot(force) / (4.0 * kPi * mode.frequency());
    ratios.push_back(
        ratio / damping_ratio(DeformationKind::kBending, system.damping(), lame, mode.frequency()));
  }
  EXPECT_NEAR((4.0 * ratios[1] - ratios[0]) / 3.0, 1.0, 0.01) << ratios[0] << ' ' << ratios[1];
}

// A strip between two ends that are held apart by the strain, along x.
struct StretchedString {
  TetMesh mesh = generate_box({1, 0.002, 0.002}, {200, 1, 1});
  MechanicalSystem system;
  Equilibrium equilibrium;

  explicit StretchedString(double strain)
      : system(mesh, StVenantKirchhoff(lame_from_young(kModulus, 0.0).mu, 0.0), kDensity) {
    const auto end = [&](double x, double offset) {
      PrescribedVertices held =
          prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, x, {}}), "end");
      held.start.row(0).array() += offset;
      return held;
    };
    system.set_constraints(
        Constraints({{end(0.0, 0.0), end(1.0, strain)}, {}, {}, {}}, mesh, system.mass()));
    equilibrium = find_equilibrium(system);
    EXPECT_TRUE(equilibrium.found) << equilibrium.message;
  }

  NormalModes modes(Index count) const {
    NormalModeOptions options;
    options.count = count;
    options.with_loads = true;
    return normal_modes(system, equilibrium.position, options);
  }
  // The force that pulls on the held end x = 1, N.
  double tension() const {
    double force = 0.0;
    for (const Index v : select_vertices(mesh, SelectPlane{0, 1.0, {}})) {
      force += equilibrium.reaction[3 * v];
    }
    return force;
  }
};

// The frequency of small oscillations about an equilibrium, from the passages of the mode through zero
// in a run of `verlet`, whose period error is taken out.
double frequency_of_motion(const MechanicalSystem& system, const Vector& equilibrium,
                           const NormalMode& mode) {
  const double omega = 2.0 * kPi * mode.frequency();
  const double step = 0.4 * stability_limit(system, equilibrium, Integrator::kVerlet).critical_step;
  const Vector momentum = system.momentum_of(mode.shape);
  State state = system.rest_state();
  state.position = equilibrium + 1e-5 / mode.shape.cwiseAbs().maxCoeff() * mode.shape;
  const auto stepper = make_verlet_stepper(system);
  std::vector<double> passages;
  double before = 1.0;
  while (passages.size() < 5 && state.time < 4.0 / mode.frequency()) {
    if (!stepper->step(state, step).ok()) break;
    const double now = momentum.dot(state.position - equilibrium);
    if ((before < 0.0) != (now < 0.0)) passages.push_back(state.time - step * now / (now - before));
    before = now;
  }
  EXPECT_EQ(passages.size(), 5U);
  if (passages.size() < 5) return 0.0;
  const double period = (passages[4] - passages[0]) / 2.0;
  return (1.0 + oscillator_response(Integrator::kVerlet, omega * step).period_error) / period;
}

TEST(Prestressed, FrequencyIsThatOfTheMotion) {
  const StretchedString string(0.2);
  const NormalModes modes = string.modes(1);
  const NormalMode& mode = modes.modes.front();
  EXPECT_NEAR(frequency_of_motion(string.system, string.equilibrium.position, mode),
              mode.frequency(), 1e-3 * mode.frequency());
}

// A cantilever with a pressure on triangles of its surface, whose rim is free.
struct PressedCantilever {
  TetMesh mesh = generate_box({1, 0.2, 0.1}, {10, 2, 1});
  MechanicalSystem system;
  Equilibrium equilibrium;

  PressedCantilever(const Selection& faces, double pressure)
      : system(mesh,
               NeoHookean(lame_from_young(kModulus, 0.3).mu, lame_from_young(kModulus, 0.3).lambda),
               kDensity) {
    const PrescribedVertices clamp =
        prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}), "clamp");
    system.set_constraints(Constraints({{clamp}, {}, {}, {}}, mesh, system.mass()));
    system.set_pressures({PressureLoad{select_triangles(mesh, faces), pressure, {}}});
    equilibrium = find_equilibrium(system);
    EXPECT_TRUE(equilibrium.found) << equilibrium.message;
  }
  NormalModes modes() const {
    NormalModeOptions options;
    options.count = 6;
    options.with_loads = true;
    return normal_modes(system, equilibrium.position, options);
  }
};

// The forces on a free rim have no potential. Their stiffness, which is not symmetric, is in the modes all
// the same.
TEST(Prestressed, FrequencyUnderAPressureWithAFreeRim) {
  struct Case {
    Selection faces;
    double pressure;
  };
  for (const Case& c : {Case{SelectPlane{0, 1.0, {}}, 2e3}, Case{SelectPlane{0, 1.0, {}}, -2e4},
                        Case{SelectFaces{{0, 0, 1}, 1.0}, 100.0}}) {
    const PressedCantilever body(c.faces, c.pressure);
    const NormalModes modes = body.modes();
    for (std::size_t i = 0; i < 2; ++i) {
      const NormalMode& mode = modes.modes[i];
      EXPECT_EQ(mode.kind, ModeKind::kElastic);
      EXPECT_NEAR(frequency_of_motion(body.system, body.equilibrium.position, mode),
                  mode.frequency(), 1e-4 * mode.frequency())
          << i << ' ' << c.pressure;
    }
  }
}

// f = ½√(T/(m L)) of a string of mass m and length L between its ends under tension T. The stiffness
// in bending adds less than 1 % at these tensions.
TEST(Prestressed, FrequencyOfAStringRisesAsTheRootOfTheTension) {
  for (const double strain : {0.2, 0.4, 0.8}) {
    const StretchedString string(strain);
    const double tension = string.tension();
    // Second Piola–Kirchhoff stress E(λ² − 1)/2 at the stretch λ.
    const double stretch = 1.0 + strain;
    EXPECT_NEAR(tension, 4e-6 * kModulus * 0.5 * stretch * (stretch * stretch - 1.0),
                1e-3 * tension);
    const double mass = string.system.total_mass();
    const double exact = 0.5 * std::sqrt(tension / (mass * stretch));
    const NormalModes modes = string.modes(2);
    for (const NormalMode& mode : modes.modes) {
      EXPECT_EQ(mode.kind, ModeKind::kElastic);
      EXPECT_NEAR(mode.frequency(), exact, 0.01 * exact) << strain;
    }
  }
}

// A straight beam that is compressed beyond its buckling load is no stable equilibrium: it has an
// unstable mode for each of the two directions in which it can buckle. Below the load it has none.
TEST(Prestressed, UnstableModesBeyondTheBucklingLoad) {
  const LameParameters lame = lame_from_young(kModulus, 0.0);
  const TetMesh mesh = generate_box({1, 0.05, 0.05}, {40, 2, 2});
  MechanicalSystem system(mesh, StVenantKirchhoff(lame.mu, lame.lambda), kDensity);
  std::vector<PrescribedVertices> held;
  for (const double x : {0.0, 1.0}) {
    held.push_back(prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, x, {}}), "end"));
  }
  system.set_constraints(Constraints({held, {}, {}, {}}, mesh, system.mass()));
  const auto kinds = [&](double strain) {
    Vector q = system.rest_state().position;
    for (Index v = 0; v < mesh.vertex_count(); ++v) q[3 * v] *= 1.0 - strain;
    NormalModeOptions options;
    options.count = 4;
    const NormalModes modes = normal_modes(system, q, options);
    return std::count_if(modes.modes.begin(), modes.modes.end(),
                         [](const NormalMode& mode) { return mode.kind == ModeKind::kUnstable; });
  };
  // Both ends are clamped: ε = 4π²I/(A L²) = 4π²h²/(12 L²) = 0.0082, more for a mesh that is too stiff
  // in bending.
  EXPECT_EQ(kinds(0.006), 0);
  EXPECT_GE(kinds(0.03), 2);
}

}  // namespace
}  // namespace tetraction
