#include "tetraction/dynamics/force_term.h"

#include "support/bodies.h"
#include "support/force_terms.h"
#include "support/step_problems.h"
#include "tetraction/core/error.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(HessianBlocks, MultiplyAsTheMatrixThatTheyAre) {
  HessianBlocks blocks;
  blocks.reset(4);
  Matrix dense = Matrix::Zero(12, 12);
  const Matrix3 a = Matrix3::Random();
  const Matrix3 symmetric = a + a.transpose();
  blocks.add(2, symmetric);
  dense.block<3, 3>(6, 6) += symmetric;
  blocks.add_pair(3, 1, a);
  dense.block<3, 3>(9, 3) += a;
  dense.block<3, 3>(3, 9) += a.transpose();
  blocks.scale(2.0);
  dense *= 2.0;
  const Vector u = Vector::Random(12);
  Vector product = Vector::Ones(12);
  blocks.add_product(u, product);
  EXPECT_LT((product - Vector::Ones(12) - dense * u).norm(), 1e-13);
  blocks.reset(2);
  EXPECT_TRUE(blocks.pairs().empty());
  EXPECT_EQ(blocks.diagonal(), Matrix::Zero(3, 6));
}

TEST(PositiveSemidefinitePart, KeepsWhatIsPositiveAndDropsTheRest) {
  const Matrix3 a = Vector3(2.0, 0.5, 1.0).asDiagonal();
  EXPECT_EQ(positive_semidefinite_part(a), a);
  const Matrix3 b = Vector3(2.0, -0.5, 1.0).asDiagonal();
  EXPECT_LT((positive_semidefinite_part(b) - Matrix3(Vector3(2.0, 0.0, 1.0).asDiagonal())).norm(),
            1e-15);
}

TEST(ForceTerms, AreRefusedWithNamesThatCannotBeColumns) {
  class Named : public FloorBarrier {
   public:
    explicit Named(std::string name) : FloorBarrier(-9.0, 1.0, 1.0), name_(std::move(name)) {}
    std::string name() const override { return name_; }

   private:
    std::string name_;
  };
  class WithoutAccount : public FloorBarrier {
   public:
    WithoutAccount() : FloorBarrier(-9.0, 1.0, 1.0) {}
    EnergyAccount account() const override { return EnergyAccount::kNone; }
  };
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  for (const char* name : {"", "Floor", "two words", "comma,", "environment", "kinetic", "total",
                           "elastic", "penalty_springs"}) {
    EXPECT_THROW(system.add_force_term(std::make_shared<Named>(name)), InputError) << name;
  }
  EXPECT_THROW(system.add_force_term(nullptr), InputError);
  EXPECT_THROW(system.add_force_term(std::make_shared<WithoutAccount>()), InputError);
  system.add_force_term(std::make_shared<Named>("floor_2"));
  EXPECT_THROW(system.add_force_term(std::make_shared<Named>("floor_2")), InputError);
  EXPECT_EQ(system.force_terms().back()->name(), "floor_2");
}

// A block near the floor with springs between far vertices and drag, in an implicit step.
class StepWithTerms : public testing::TestWithParam<double> {
 protected:
  StepWithTerms() : system_(small_block(), all_materials()[1], 1000.0), problem_(system_) {
    system_.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
    system_.set_constraints(hold(system_.mesh(), SelectPlane{0, 0.0, {}}));
    system_.add_force_term(std::make_shared<FloorBarrier>(-0.04, 2e5, 0.05));
    system_.add_force_term(std::make_shared<PairSprings>(
        std::vector<std::pair<Index, Index>>{{0, system_.vertex_count() - 1},
                                             {system_.vertex_count() - 3, 7},
                                             {10, system_.vertex_count() - 1}},
        3e4, 0.4));
    system_.add_force_term(std::make_shared<QuadraticDrag>(2.0));
    state_ = system_.rest_state();
    state_.momentum = system_.momentum_of(jiggled(Vector::Zero(system_.dof_count()), 3.0, 3));
    project_momenta();
    problem_.begin(state_, kStep, kStep, GetParam(), {});
  }
  void project_momenta() {
    system_.coordinates().project_momentum(system_.mass(), state_.momentum);
  }
  // A displacement that the barrier allows.
  Vector displacement() const {
    return system_.coordinates().extend(
        system_.coordinates().restrict(jiggled(Vector::Zero(system_.dof_count()), 0.01, 5)));
  }

  static constexpr double kStep = 0.02;
  MechanicalSystem system_;
  StepProblem problem_;
  State state_;
};

TEST_P(StepWithTerms, GradientAndHessianAreDerivatives) {
  ASSERT_TRUE(problem_.has_general_terms());
  const Vector u = displacement();
  double phi = 0.0;
  Vector gradient;
  ASSERT_TRUE(problem_.value_and_gradient(u, phi, gradient).ok());
  const SparsityPattern pattern(system_.rest(), system_.coordinates(),
                                {{0, system_.vertex_count() - 1},
                                 {system_.vertex_count() - 3, 7},
                                 {10, system_.vertex_count() - 1}});
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()));
  HessianBlocks terms;
  problem_.term_hessian(u, HessianForm::kExact, terms);
  EXPECT_FALSE(terms.pairs().empty());
  ASSERT_TRUE(problem_.hessian(u, terms, pattern, values.data()).ok());
  const Matrix hessian = dense_matrix(pattern, values);
  constexpr double kDifference = 1e-6;
  const Vector direction = jiggled(Vector::Zero(gradient.size()), 1.0, 11);
  const Vector d = kDifference * system_.coordinates().extend(direction);
  double plus = 0.0;
  double minus = 0.0;
  Vector gradient_plus;
  Vector gradient_minus;
  ASSERT_TRUE(problem_.value_and_gradient(u + d, plus, gradient_plus).ok());
  ASSERT_TRUE(problem_.value_and_gradient(u - d, minus, gradient_minus).ok());
  EXPECT_NEAR((plus - minus) / (2.0 * kDifference), gradient.dot(direction),
              1e-7 * gradient.norm() * direction.norm());
  const Vector bend = (gradient_plus - gradient_minus) / (2.0 * kDifference);
  EXPECT_LT((hessian * direction - bend).norm(), 1e-7 * bend.norm());
}

TEST_P(StepWithTerms, NewtonFindsTheSameMinimumWithEveryLinearSolver) {
  Vector reference;
  for (const LinearSolver linear :
       {LinearSolver::kFactor, LinearSolver::kCg, LinearSolver::kMatrixFree, LinearSolver::kAuto}) {
    NewtonOptions options;
    options.linear = linear;
    options.tolerance = 1e-11;
    const auto minimizer = make_newton_minimizer(system_, options);
    Vector u = Vector::Zero(system_.dof_count());
    const MinimizerReport report = minimizer->minimize(problem_, u);
    ASSERT_TRUE(report.converged()) << to_string(linear) << ": " << report.message;
    EXPECT_LE(report.iterations, 25) << to_string(linear);
    if (reference.size() == 0) reference = u;
    EXPECT_LT((u - reference).norm(), 1e-8 * reference.norm()) << to_string(linear);
  }
}

TEST_P(StepWithTerms, CeresRefusesTermsThatCoupleVertices) {
  EXPECT_THROW(make_ceres_minimizer(system_, {}), InputError);
}

INSTANTIATE_TEST_SUITE_P(Rules, StepWithTerms, testing::Values(0.5, 1.0));

TEST(Energies, AreFoundByTheirNames) {
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  system.add_force_term(std::make_shared<FloorBarrier>(-0.05, 1e3, 0.1));
  State state = system.rest_state();
  Energies energies;
  ASSERT_TRUE(system.energies(state, energies).ok());
  EXPECT_GT(energies.of("floor"), 0.0);
  EXPECT_EQ(energies.of("kinetic"), 0.0);
  EXPECT_EQ(energies.total(), energies.elastic() + energies.of("floor"));
  EXPECT_THROW(static_cast<void>(energies.of("roof")), InputError);
  ASSERT_EQ(energies.extra_count(), 1U);
  EXPECT_EQ(energies.extra(0).name, "floor");
}

}  // namespace
}  // namespace tetraction
