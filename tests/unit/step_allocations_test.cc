// The allocations of a step, and how often it evaluates: work vectors are kept, and what the
// minimiser evaluated last is not evaluated again.

#include <atomic>
#include <string>

#include "support/allocations.h"
#include "support/rules.h"
#include "support/step_problems.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {
namespace {

using namespace testing_support;

std::unique_ptr<Stepper> make(Integrator integrator, const MechanicalSystem& system) {
  NewtonOptions options;
  options.linear = LinearSolver::kMatrixFree;
  switch (integrator) {
    case Integrator::kExplicit:
      return make_explicit_stepper(system);
    case Integrator::kVerlet:
      return make_verlet_stepper(system);
    case Integrator::kMidpoint:
      return make_midpoint_stepper(system, make_newton_minimizer(system, options));
    case Integrator::kBackwardEuler:
    case Integrator::kEnergyMomentum:  // not among the parameters
      break;
  }
  return make_backward_euler_stepper(system, make_newton_minimizer(system, options));
}

class StepAllocations : public testing::TestWithParam<Integrator> {
 protected:
  void SetUp() override {
    if (!can_count_allocations()) GTEST_SKIP() << "the address sanitizer has malloc";
  }

  // Allocations of a byte or more for each vertex in ten steps, after ten to warm up: within these
  // matrix-free Newton decides on a coarse space.
  std::int64_t in_ten_steps() {
    const bool implicit =
        GetParam() == Integrator::kMidpoint || GetParam() == Integrator::kBackwardEuler;
    const double h = implicit ? 5e-3 : 1e-4;
    const auto stepper = make(GetParam(), system_);
    State state = bending_state(system_);
    Balance balance(system_, state);
    const auto step = [&] {
      const StepOutcome outcome = stepper->step(state, h);
      EXPECT_TRUE(outcome.ok()) << outcome.message;
      balance.enter(state, outcome);
    };
    for (int k = 0; k < 10; ++k) step();
    const AllocationCounter counter(static_cast<std::size_t>(system_.vertex_count()));
    for (int k = 0; k < 10; ++k) step();
    return counter.count();
  }

  // So large that what a vertex loop's tasks take is less than a byte a vertex.
  MechanicalSystem system_{small_block({24, 12, 12}), all_materials()[1], 1000.0};
};

TEST_P(StepAllocations, NoneWithoutLoads) {
  EXPECT_EQ(in_ten_steps(), 0);
}

TEST_P(StepAllocations, NoneWithGravityAndAClamp) {
  clamp_under_gravity(system_);
  EXPECT_EQ(in_ten_steps(), 0);
}

TEST_P(StepAllocations, NoneWithEverythingThatNeedsNoMultipliers) {
  PrescribedVertices clamp = prescribe_at_rest(
      system_.mesh(), select_vertices(system_.mesh(), SelectPlane{0, 0.0, {}}), "clamp");
  clamp.motion.velocity = Vector3(0.0, 0.1, 0.0);
  PrescribedVertices spring = prescribe_at_rest(
      system_.mesh(), select_vertices(system_.mesh(), SelectPlane{0, 2.0, {}}), "spring");
  spring.penalty = 10.0;
  system_.set_constraints(
      Constraints({{clamp, spring}, {}, {}, {}}, system_.mesh(), system_.mass()));
  system_.set_environment(Environment::attraction(1e-3, 0.1));
  system_.set_damping({0.1, 0.2, 10.0});
  system_.add_force({{5, 6}, {1.0, 0.0, 0.0}});
  EXPECT_EQ(in_ten_steps(), 0);
}

TEST_P(StepAllocations, ACounterThatCounts) {
  const AllocationCounter counter(static_cast<std::size_t>(system_.vertex_count()));
  const State state = system_.rest_state();
  EXPECT_EQ(counter.count(), 3) << "position, momentum and velocity of " << state.position.size();
}

INSTANTIATE_TEST_SUITE_P(All, StepAllocations,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet,
                                         Integrator::kMidpoint, Integrator::kBackwardEuler),
                         name_of_rule);

// A neo-Hookean material that counts how often its energy is evaluated.
class CountingMaterial {
 public:
  explicit CountingMaterial(std::atomic<Index>& count) : count_(&count) {}
  bool admissible(const Matrix3& f) const { return material_.admissible(f); }
  double energy_density(const Matrix3& f) const {
    ++*count_;
    return material_.energy_density(f);
  }
  Matrix3 first_piola(const Matrix3& f) const { return material_.first_piola(f); }
  Matrix9 stiffness(const Matrix3& f) const { return material_.stiffness(f); }

 private:
  std::atomic<Index>* count_;
  NeoHookean material_{lame_from_young(1e6, 0.4).mu, lame_from_young(1e6, 0.4).lambda};
};

TEST(StepEvaluations, NothingIsEvaluatedTwice) {
  std::atomic<Index> count{0};
  const MaterialModel material =
      CustomMaterial(CountingMaterial(count), "counting", lame_from_young(1e6, 0.4));
  MechanicalSystem system(small_block(), material, 1000.0);
  clamp_under_gravity(system);
  NewtonOptions options;
  options.linear = LinearSolver::kCg;
  for (const bool midpoint : {true, false}) {
    const auto stepper =
        midpoint ? make_midpoint_stepper(system, make_newton_minimizer(system, options))
                 : make_backward_euler_stepper(system, make_newton_minimizer(system, options));
    State state = bending_state(system);
    for (int k = 0; k < 10; ++k) {
      count = 0;
      const StepOutcome outcome = stepper->step(state, 2e-3);
      ASSERT_TRUE(outcome.ok()) << outcome.message;
      if (k < 5) continue;  // until the best of four guesses is the same every time
      // The guesses but the present place, whose energy is known; Newton's Hessians and the points
      // they lead to; the end of the step.
      EXPECT_EQ(count, system.rest().element_count() * (5 + 2 * outcome.minimizer.iterations));
    }
  }
}

TEST(StepEvaluations, TheElasticPartIsThatOfThePoint) {
  BendingBlock block;
  const Vector here = jiggled(block.state.position, 1e-3, 1);
  const Vector there = jiggled(block.state.position, 1e-3, 2);
  double phi = 0.0;
  Vector full;
  ASSERT_TRUE(block.problem.value_and_full_gradient(here, phi, full).ok());
  for (const Vector& x : {here, there, here}) {
    double energy = 0.0;
    Vector gradient;
    ASSERT_TRUE(block.system.elastic().value_and_gradient(x, energy, gradient).ok());
    double found = 0.0;
    ASSERT_TRUE(block.problem.elastic_energy(x, found).ok());
    EXPECT_NEAR(found, energy, 1e-12 * energy);
    const Vector* kept = nullptr;
    ASSERT_TRUE(block.problem.elastic_gradient(x, kept).ok());
    EXPECT_EQ(*kept, gradient);
  }
  // A change of the system counts from the next step on.
  ASSERT_TRUE(block.problem.value_and_full_gradient(here, phi, full).ok());
  block.system.set_material(0, all_materials()[0]);
  begin(block.problem, block.state);
  const Vector* kept = nullptr;
  ASSERT_TRUE(block.problem.elastic_gradient(here, kept).ok());
  double energy = 0.0;
  Vector gradient;
  ASSERT_TRUE(block.system.elastic().value_and_gradient(here, energy, gradient).ok());
  EXPECT_EQ(*kept, gradient);
}

}  // namespace
}  // namespace tetraction
