#include "tetraction/mesh/mesh_part.h"

#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "support/bodies.h"
#include "support/lone_part.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block as the only part of itself, of which the vertices with x < `shared_to` count as shared.
struct BodyInOnePart {
  explicit BodyInOnePart(const std::array<int, 3>& cells, double shared_to = -1.0)
      : mesh(small_block(cells)),
        part(std::make_shared<LonePart>(mesh.vertex_count(), mesh.tetrahedron_count())) {
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
      if (x[0] < shared_to) part->shared_vertices.push_back(v);
    }
    part->whole.volume = mesh.total_volume();
    mesh.part = part;
  }
  TetMesh mesh;
  std::shared_ptr<LonePart> part;
};

TEST(MeshPart, SharedForcesTravelWhileTheOtherElementsAreComputed) {
  BodyInOnePart body({24, 8, 8}, 0.01);
  ASSERT_FALSE(body.part->shared_vertices.empty());
  const MechanicalSystem whole(small_block({24, 8, 8}), all_materials()[1], 1000.0);
  const MechanicalSystem system(body.mesh, all_materials()[1], 1000.0);
  const Vector q = jiggled(whole.mesh().rest_positions(), 1e-3);
  double expected_energy = 0.0;
  Vector expected;
  ASSERT_TRUE(whole.elastic_energy_and_gradient(q, expected_energy, expected).ok());

  double energy = 0.0;
  // Values that are not computed yet when the exchange begins are still NaN.
  Vector gradient = Vector::Constant(q.size(), std::numeric_limits<double>::quiet_NaN());
  Index later = -1;
  body.part->on_begin = [&](const double* values) {
    later = 0;
    for (Index v = 0; v < system.vertex_count(); ++v) later += std::isnan(values[3 * v]) ? 1 : 0;
    for (const Index v : body.part->shared_vertices) {
      for (Index k = 0; k < 3; ++k) EXPECT_EQ(values[3 * v + k], expected[3 * v + k]);
    }
  };
  ASSERT_TRUE(system.elastic_energy_and_gradient(q, energy, gradient).ok());
  EXPECT_GT(later, system.vertex_count() / 2);
  EXPECT_EQ(energy, expected_energy);
  EXPECT_EQ(gradient, expected);
}

TEST(MeshPart, FailureOfOnePartReachesTheExchange) {
  for (const double shared_to : {0.01, 3.0}) {  // the failure is in inner blocks, or in outer ones
    BodyInOnePart body({24, 8, 8}, shared_to);
    const MechanicalSystem system(body.mesh, all_materials()[1], 1000.0);
    Vector q = system.mesh().rest_positions();
    const Index last = system.mesh().tetrahedron_count() - 1;
    const auto corners = system.mesh().tetrahedra[static_cast<std::size_t>(last)];
    q.segment<3>(3 * corners[0]).swap(q.segment<3>(3 * corners[1]));
    body.part->exchanges = 0;
    body.part->on_begin = [&](const double* values) {
      for (const Index v : body.part->shared_vertices) EXPECT_TRUE(std::isfinite(values[3 * v]));
    };
    double energy = 0.0;
    Vector gradient;
    EXPECT_FALSE(system.elastic_energy_and_gradient(q, energy, gradient).ok());
    EXPECT_EQ(body.part->exchanges, 1);
    EXPECT_TRUE(gradient.allFinite());
  }
}

TEST(MeshPart, ExplicitStepsHaveOneReductionAndOneExchange) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    BodyInOnePart body({4, 2, 2}, 0.6);
    const MechanicalSystem system(body.mesh, all_materials()[1], 1000.0);
    const auto stepper = make_stepper(rule, system, nullptr);
    State state = system.rest_state();
    system.set_velocity(state, jiggled(Vector::Zero(system.dof_count()), 0.1));
    Balance balance(system, state);
    State next;
    for (int step = 1; step <= 4; ++step) {
      body.part->reductions = body.part->exchanges = 0;
      const StepOutcome outcome = stepper->advance(state, next, 1e-4, step * 1e-4);
      ASSERT_TRUE(outcome.ok());
      balance.enter(next, outcome);
      std::swap(state, next);
      // The first step has to agree on more, and begins with the force at the start.
      if (step == 1) continue;
      EXPECT_EQ(body.part->reductions, 1);
      EXPECT_EQ(body.part->exchanges, 1);
    }
    const Momenta expected = momenta_of(system, state);
    EXPECT_EQ(balance.momenta().linear, expected.linear);
    EXPECT_EQ(balance.momenta().angular, expected.angular);
    EXPECT_EQ(balance.energies().kinetic(), kinetic_energy(system, state.momentum));
  }
}

}  // namespace
}  // namespace tetraction
