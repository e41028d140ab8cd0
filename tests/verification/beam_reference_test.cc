// The clamped beam against other codes: 4 × 1 × 1 m, 20 × 4 × 4 cells of six tetrahedra,
// neo-Hookean with E = 1 MPa and ν = 0.4, density 1000, gravity 9.81, 20 steps of 0.01 s from rest.

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

Scene published_beam(Integrator integrator) {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {20, 4, 4}}, elastic(1e6, 0.4));
  scene.time = {integrator, 0.01, false, 0.2};
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

// Mean u_y of the vertices at x = 4.
double tip_displacement(const Session& session) {
  const TetMesh& mesh = session.system().mesh();
  const Vector u = session.state().position - mesh.rest_positions();
  double sum = 0.0;
  const std::vector<Index> tip = select_vertices(mesh, SelectPlane{0, 4.0, {}});
  for (const Index v : tip) sum += u[3 * v + 1];
  return sum / static_cast<double>(tip.size());
}

struct Reference {
  Integrator integrator;
  double tip;
  double digits;  // half of the last digit given
};

class BeamReference : public testing::TestWithParam<Reference> {};

TEST_P(BeamReference, TipAgreesToAllDigitsGiven) {
  Scene scene = published_beam(GetParam().integrator);
  scene.solver.tolerance = 1e-10;
  FinishedRun session(scene);
  EXPECT_EQ(session.state().step, 20);
  EXPECT_NEAR(tip_displacement(session), GetParam().tip, GetParam().digits);
}

TEST_P(BeamReference, DefaultToleranceTakesAtMostFourIterationsAStep) {
  const Scene scene = published_beam(GetParam().integrator);
  FinishedRun session(scene);
  EXPECT_LE(static_cast<double>(session.total_iterations()) / 20.0, 4.0);
  EXPECT_NEAR(tip_displacement(session), GetParam().tip, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(
    OtherCodes, BeamReference,
    testing::Values(Reference{Integrator::kBackwardEuler, -0.2162120364, 0.5e-10},  // Vega FEM 4.0
                    Reference{Integrator::kMidpoint, -0.1985418, 0.5e-7}),  // SOFA's HP solver
    [](const auto& test) {
      return test.param.integrator == Integrator::kMidpoint ? "Midpoint" : "BackwardEuler";
    });

}  // namespace
}  // namespace tetraction
