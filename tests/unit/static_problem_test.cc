#include "tetraction/dynamics/problems/static_problem.h"

#include <cmath>
#include <utility>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block with an attraction, springs with targets beside their vertices, a load, and a face that is
// prescribed beside its rest position.
struct LoadedBlock {
  static const MechanicalSystem& load(MechanicalSystem& system) {
    const TetMesh& mesh = system.mesh();
    PrescribedVertices face =
        prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}));
    face.start.row(1).array() += 0.1;
    PrescribedVertices springs =
        prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 2.0, {}}));
    springs.penalty = 3000.0;
    springs.start.row(2).array() += 0.2;
    system.set_constraints(Constraints({{face, springs}, {}, {}, {}}, mesh, system.mass()));
    system.set_environment(Environment::attraction(2000.0, 0.5));
    ExternalForce force;
    force.vertices = {5, 9};
    force.vector = {100.0, -50.0, 20.0};
    system.add_force(force);
    return system;
  }
  MechanicalSystem system{small_block(), all_materials()[1], 1000.0};
  StaticProblem problem{load(system), 0.0};  // after the constraints
};

TEST(StaticProblem, DerivativesAreThoseOfItsValue) {
  LoadedBlock block;
  for (const double factor : {0.0, 0.4, 1.0}) {
    StaticProblem& problem = block.problem;
    problem.begin(block.system.mesh().rest_positions(), factor);
    const FreeCoordinates& free = problem.coordinates();
    const Vector y = jiggled(Vector::Zero(free.count()), 0.02);
    const Vector d = jiggled(Vector::Zero(free.count()), 1.0, 11);
    const auto at = [&](double t) { return free.extend(y + t * d); };
    constexpr double kStep = 1e-5;
    double before = 0.0;
    double after = 0.0;
    double here = 0.0;
    Vector gradient_before;
    Vector gradient_after;
    Vector gradient;
    ASSERT_TRUE(problem.value_and_gradient(at(-kStep), before, gradient_before).ok());
    ASSERT_TRUE(problem.value_and_gradient(at(kStep), after, gradient_after).ok());
    ASSERT_TRUE(problem.value_and_gradient(at(0.0), here, gradient).ok());
    const double slope = (after - before) / (2.0 * kStep);
    EXPECT_NEAR(gradient.dot(d), slope, 1e-6 * std::abs(slope)) << factor;
    const SparsityPattern pattern(block.system.rest(), free);
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()));
    HessianBlocks terms;
    problem.term_hessian(at(0.0), HessianForm::kExact, terms);
    ASSERT_TRUE(problem.hessian(at(0.0), terms, pattern, values.data()).ok());
    double curvature = 0.0;
    for (Index j = 0; j < pattern.size(); ++j) {
      for (int k = pattern.column_begin()[static_cast<std::size_t>(j)];
           k < pattern.column_begin()[static_cast<std::size_t>(j) + 1]; ++k) {
        const int i = pattern.rows()[static_cast<std::size_t>(k)];
        curvature += (i == j ? 1.0 : 2.0) * values[static_cast<std::size_t>(k)] * d[i] * d[j];
      }
    }
    const double difference = (gradient_after - gradient_before).dot(d) / (2.0 * kStep);
    EXPECT_NEAR(curvature, difference, 1e-6 * std::abs(difference)) << factor;
  }
}

// The value is W + φ (U − f·x) + U_c − (1 − φ) ∇U_c(X)·x, up to a constant.
TEST(StaticProblem, LoadsAreScaledAndSpringsAreNot) {
  LoadedBlock block;
  const MechanicalSystem& system = block.system;
  const Vector rest = system.mesh().rest_positions();
  const Vector zero = Vector::Zero(rest.size());
  const Vector u =
      system.coordinates().extend(jiggled(Vector::Zero(system.coordinates().count()), 0.02));
  const ForceTerm& springs = system.constraints().springs();
  for (const double factor : {0.0, 0.3, 1.0}) {
    block.problem.begin(rest, factor);
    const Vector& base = block.problem.base();
    const auto exact = [&](const Vector& x) {
      double value = 0.0;
      EXPECT_TRUE(system.elastic().value(x, value).ok());
      value += factor * system.environment().energy(system.force_point(x, 0.0));
      value -= factor * block.problem.load(x).dot(x - rest);
      value += springs.energy(system.force_point(x, 0.0));
      Vector gradient = zero;
      springs.add_gradient(system.force_point(rest, 0.0), gradient);
      return value - (1.0 - factor) * gradient.dot(x - rest);
    };
    double at_base = 0.0;
    double at_u = 0.0;
    ASSERT_TRUE(block.problem.value(zero, at_base).ok());
    ASSERT_TRUE(block.problem.value(u, at_u).ok());
    const double change = exact(base + u) - exact(base);
    EXPECT_NEAR(at_u - at_base, change, 1e-9 * std::abs(change)) << factor;
  }
}

TEST(StaticProblem, PrescribedComponentsMoveInProportion) {
  LoadedBlock block;
  Vector x = jiggled(block.system.mesh().rest_positions(), 0.1);
  const Vector rest = block.system.mesh().rest_positions();
  for (const double factor : {0.0, 0.25, 1.0}) {
    block.problem.prescribe(factor, x);
    for (const Index v : select_vertices(block.system.mesh(), SelectPlane{0, 0.0, {}})) {
      const Vector3 moved = x.segment<3>(3 * v) - rest.segment<3>(3 * v);
      EXPECT_LT((moved - Vector3(0, 0.1 * factor, 0)).norm(), 1e-15);
    }
    EXPECT_LT(block.problem.constraint_error(factor, x), 1e-15);
    EXPECT_NEAR(block.problem.constraint_error(1.0, x), 0.1 * (1.0 - factor), 1e-15);
  }
}

// A distance goes from its length in the undeformed body to its given one.
TEST(StaticProblem, LengthsChangeInProportion) {
  const TetMesh mesh = small_block();
  MechanicalSystem system(mesh, NeoHookean(1e5, 1e5), 1000.0);
  const Vector rest = mesh.rest_positions();
  const double length = (rest.segment<3>(0) - rest.segment<3>(3 * 5)).norm();
  PrescribedVertices face = prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 2.0, {}}));
  FixedDistance distance;
  distance.a = 0;
  distance.b = 5;
  distance.length = 0.8 * length;
  system.set_constraints(Constraints({{face}, {}, {distance}, {}}, mesh, system.mass()));
  StaticProblem problem(system, 0.0);
  for (const double factor : {0.0, 0.25, 1.0}) {
    problem.begin(rest, factor);
    EXPECT_NEAR(problem.constraints().list().distances[0].length, (1.0 - 0.2 * factor) * length,
                1e-15);
    if (factor == 0.0) {
      EXPECT_LT(problem.constraint_error(factor, rest), 1e-14);
    } else {
      EXPECT_GT(problem.constraint_error(factor, rest), 0.1 * factor * length);
    }
  }
}

// Ceres needs shares of elements that add up to the value and stay positive.
TEST(StaticProblem, SharesOfElementsAddUp) {
  LoadedBlock block;
  StaticProblem& problem = block.problem;
  problem.begin(block.system.mesh().rest_positions(), 0.6);
  const Vector u = block.system.coordinates().extend(
      jiggled(Vector::Zero(block.system.coordinates().count()), 0.02));
  MinimizationProblem::TermShares shares;
  ASSERT_TRUE(problem.term_shares(u, false, shares));
  double sum = 0.0;
  Vector gradient = Vector::Zero(u.size());
  for (Index e = 0; e < block.system.rest().element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    ASSERT_TRUE(problem.element_terms(e, u, &shares, false, terms));
    sum += terms.energy;
    for (int a = 0; a < 4; ++a) {
      gradient.segment<3>(3 * block.system.rest().nodes(e)[static_cast<std::size_t>(a)]) +=
          terms.gradient.col(a);
    }
  }
  double value = 0.0;
  Vector exact;
  ASSERT_TRUE(problem.value_and_full_gradient(u, value, exact).ok());
  EXPECT_NEAR(sum, value + problem.square_value(), 1e-9 * problem.square_value());
  EXPECT_LT((gradient - exact).norm(), 1e-10 * exact.norm());
}

TEST(FindEquilibrium, BeginsAtRestAndGoesOnToRoundOff) {
  LoadedBlock block;
  const Equilibrium one = find_equilibrium(block.system);
  ASSERT_TRUE(one.found) << one.message;
  EXPECT_EQ(one.message, "");
  EXPECT_EQ(one.path.factor, 1.0);
  EXPECT_EQ(one.path.steps, 1);
  const Equilibrium many = find_equilibrium(block.system, {}, 0.0, 0.1);
  ASSERT_TRUE(many.found) << many.message;
  EXPECT_EQ(many.path.steps, 10);
  EXPECT_LT((many.position - one.position).cwiseAbs().maxCoeff(), 1e-12);
  // Elastic forces, potentials, loads and reactions are in balance at every vertex.
  double energy = 0.0;
  Vector force;
  ASSERT_TRUE(block.system.elastic().value_and_gradient(one.position, energy, force).ok());
  block.system.environment().add_gradient(block.system.force_point(one.position, 0.0), force);
  force -= one.load + one.reaction;
  EXPECT_LT(force.norm(), 1e-11 * one.reaction.norm());
  EXPECT_THROW(find_equilibrium(block.system, {}, 0.0, 0.0), InputError);
  EXPECT_THROW(find_equilibrium(block.system, {}, 0.0, 1.5), InputError);
}

}  // namespace
}  // namespace tetraction
