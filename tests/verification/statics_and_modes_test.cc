// Frequencies and static answers against closed forms and published numbers.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A bar that cannot move sideways, fixed at x = 0: c = √((λ + 2μ)/ρ), f₁ = c/(4L). Started in its
// first mode at rest, it is back after one period.
TEST(BarWave, FirstFixedFreeFrequency) {
  constexpr double kLength = 1.0;
  constexpr double kAmplitude = 1e-6;
  const LameParameters lame = lame_from_young(1e6, 0.3);
  const TetMesh mesh = generate_box({kLength, 0.1, 0.1}, {40, 1, 1});
  MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
  PrescribedVertices end_face =
      prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}));
  PrescribedVertices sides = prescribe_at_rest(mesh, select_vertices(mesh, SelectAll{}));
  sides.components = {false, true, true};
  system.set_constraints(Constraints({{end_face, sides}, {}, {}, {}}, mesh, system.mass()));
  State state = system.rest_state();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    state.position[3 * v] +=
        kAmplitude *
        std::sin(0.5 * std::numbers::pi * mesh.vertices[static_cast<std::size_t>(v)].x() / kLength);
  }
  const double frequency = wave_speed(lame, 1000.0) / (4.0 * kLength);
  const double step = 1.0 / frequency / 2000.0;
  const auto stepper = make_verlet_stepper(system);
  // Time of the end's second passage through zero upward: three quarters of a period.
  const Index end = 3 * (mesh.vertex_count() - 1);
  const double rest = kLength;
  double crossing = 0.0;
  double before = state.position[end] - rest;
  for (int k = 0; k < 2000 && crossing == 0.0; ++k) {
    ASSERT_TRUE(stepper->step(state, step).ok());
    const double now = state.position[end] - rest;
    if (before < 0.0 && now >= 0.0) crossing = (k + before / (before - now)) * step;
    before = now;
  }
  EXPECT_NEAR(0.75 / crossing, frequency, 2e-3 * frequency);
}

// The free cube's exact mode u = (cos(πx/a) sin(πy/a), −sin(πx/a) cos(πy/a), 0):
// f = √(μ/ρ)/(√2 a) for every ν. The Rayleigh quotient of the mesh's own stiffness and mass comes
// down to it with order 2.
TEST(FreeCube, ExactModeWithOrderTwo) {
  const double pi = std::numbers::pi;
  const LameParameters lame = lame_from_young(1e6, 0.25);
  const double exact = std::sqrt(lame.mu / 1000.0) / std::numbers::sqrt2;
  std::vector<double> errors;
  for (const int n : {6, 12}) {
    const MechanicalSystem system(generate_box({1, 1, 1}, {n, n, n}),
                                  StVenantKirchhoff(lame.mu, lame.lambda), 1000.0);
    Vector mode(system.dof_count());
    for (Index v = 0; v < system.vertex_count(); ++v) {
      const Vector3& x = system.mesh().vertices[static_cast<std::size_t>(v)];
      mode.segment<3>(3 * v) = Vector3(std::cos(pi * x.x()) * std::sin(pi * x.y()),
                                       -std::sin(pi * x.x()) * std::cos(pi * x.y()), 0.0);
    }
    Vector force;
    system.elastic().product(system.rest_state().position, mode, force);
    double mass = 0.0;
    for (Index i = 0; i < mode.size(); ++i) mass += system.mass()[i / 3] * mode[i] * mode[i];
    errors.push_back(std::abs(std::sqrt(mode.dot(force) / mass) / (2.0 * pi) / exact - 1.0));
  }
  EXPECT_LT(errors[1], 0.02);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.2);
}

// Turek & Hron CSM1: a St. Venant–Kirchhoff beam 0.35 × 0.02 m under gravity 2, plane strain, at
// rest. Clamped flat at x = 0.25, the finite-element answer of the continuum is u_y = −65.54e-3 at
// the tip; one layer of linear tetrahedra locks by a known amount: 61.1e-3 × 65.54/66.10 for 6,720.
// The state at rest is found by large backward Euler steps, which take the energy out.
TEST(TurekHron, Csm1WithLinearTetrahedra) {
  Scene scene = scene_of({GeneratorKind::kBeam, {0.35, 0.02, 0.005}, {140, 8, 1}},
                         elastic(1.4e6, 0.4, "stvk"));
  scene.time = {Integrator::kBackwardEuler, 1.0, false, 60.0};
  scene.environment = {EnvironmentKind::kGravity, 2.0, {0.0, -1.0, 0.0}};
  scene.fix = {fix(SelectPlane{0, 0.0, {}}), fix(SelectAll{}, {false, false, true})};
  FinishedRun session(scene);
  EXPECT_LT(session.balance().energies().kinetic(), 1e-12);
  const TetMesh& mesh = session.system().mesh();
  const Index tip = select_vertices(mesh, SelectNearest{{0.35, 0.01, 0.0}}).front();
  const Vector3 u =
      session.state().position.segment<3>(3 * tip) - mesh.vertices[static_cast<std::size_t>(tip)];
  EXPECT_NEAR(u.y(), -61.1e-3 * 65.54 / 66.10, 0.02 * 61.1e-3);
  EXPECT_LT(u.x(), 0.0);
  // At rest the reactions carry the weight, up to the sum of the residuals that round-off leaves in
  // a body whose stiffest and softest modes differ by nine orders of magnitude.
  double reaction = 0.0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) reaction += session.reaction_force()[3 * v + 1];
  EXPECT_NEAR(reaction, 2.0 * session.system().total_mass(),
              1e-7 * 2.0 * session.system().total_mass());
}

}  // namespace
}  // namespace tetraction
