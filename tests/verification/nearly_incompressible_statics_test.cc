// Equilibria of rubber that nearly keeps its volume: closed forms, another solver, and few iterations.
#include <cmath>

#include "support/runs.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

enum class Kind { kNodal, kQuadratic };

Scene rubber(const Vector3& size, const std::array<int, 3>& cells, Kind kind, double ratio) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, size, cells};
  if (kind == Kind::kNodal) scene.mesh.volume = VolumeRule::kNodal;
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = ratio;
  return scene;
}

FinishedEquilibrium equilibrium(const Scene& scene, Kind kind) {
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  return {scene, kind == Kind::kQuadratic ? with_edge_vertices(mesh) : mesh};
}

class NearlyIncompressible : public testing::TestWithParam<std::tuple<Kind, double>> {
 protected:
  Kind kind_ = std::get<0>(GetParam());
  double ratio_ = std::get<1>(GetParam());

  // Solves in few iterations, and again by minimisation alone in small load steps.
  void expect_few_iterations(const Scene& scene, int most) const {
    FinishedEquilibrium session = equilibrium(scene, kind_);
    EXPECT_LE(session.total_iterations(), most);
    Scene other = scene;
    if (kind_ == Kind::kNodal) {
      other.solver.linear = LinearSolver::kCg;
    } else {
      other.solver.kind = "ceres";
    }
    other.solver.max_iterations = 1000;
    FinishedEquilibrium reference = equilibrium(other, kind_);
    const Vector rest = session.system().mesh().rest_positions();
    EXPECT_LT((session.state().position - reference.state().position).norm(),
              1e-8 * (reference.state().position - rest).norm());
  }
};

// μ(t² − 1) + λ ln(l t²) = 0 gives the stretch t across a bar with the stretch l.
TEST_P(NearlyIncompressible, ABarIsStretchedByHalf) {
  Scene scene = rubber({2, 1, 1}, {2, 1, 2}, kind_, ratio_);
  scene.fix = {fix(SelectPlane{0, 0.0, {}}, {true, false, false}),
               fix(SelectPlane{1, 0.0, {}}, {false, true, false}),
               fix(SelectPlane{2, 0.0, {}}, {false, false, true})};
  scene.fix.push_back(shifted(SelectPlane{0, 2.0, {}}, {1.0, 0, 0}, {true, false, false}));
  FinishedEquilibrium session = equilibrium(scene, kind_);
  EXPECT_LE(session.total_iterations(), 12);
  const LameParameters lame = lame_from_young(1e6, ratio_);
  double t = std::sqrt(1.0 / 1.5);
  for (int i = 0; i < 50; ++i) {
    t -= (lame.mu * (t * t - 1.0) + lame.lambda * std::log(1.5 * t * t)) /
         (2.0 * lame.mu * t + 2.0 * lame.lambda / t);
  }
  const TetMesh& mesh = session.system().mesh();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3& x = mesh.vertices[static_cast<std::size_t>(v)];
    const Vector3 exact(1.5 * x.x(), t * x.y(), t * x.z());
    EXPECT_LT((session.state().position.segment<3>(3 * v) - exact).norm(), 1e-9) << v;
  }
}

TEST_P(NearlyIncompressible, ABlockIsPressed) {
  Scene scene = rubber({1, 1, 1}, {3, 3, 3}, kind_, ratio_);
  scene.fix = {fix(SelectPlane{2, 0.0, {}}), shifted(SelectPlane{2, 1.0, {}}, {0, 0, -0.2})};
  expect_few_iterations(scene, 15);
}

TEST_P(NearlyIncompressible, ABeamIsBentFar) {
  Scene scene = rubber({4, 1, 1}, {4, 1, 1}, kind_, ratio_);
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  scene.traction = {traction(SelectPlane{0, 4.0, {}}, {0, 0, 1e4})};
  expect_few_iterations(scene, 25);
}

INSTANTIATE_TEST_SUITE_P(Rubber, NearlyIncompressible,
                         testing::Combine(testing::Values(Kind::kNodal, Kind::kQuadratic),
                                          testing::Values(0.499, 0.4999)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) == Kind::kNodal
                                                  ? "nodal"
                                                  : "quadratic") +
                                  "_" + (std::get<1>(test.param) > 0.4995 ? "0_4999" : "0_499");
                         });

}  // namespace
}  // namespace tetraction
