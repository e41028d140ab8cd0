#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/dynamics/body_sums.h"

#include "support/force_terms.h"
#include "support/step_problems.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/problems/derivative_check.h"
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
  const std::vector<Index> vertices{3, 0, 1};
  const std::vector<Vector3> vectors{{1.0, 2.0, -1.0}, {0.5, 0.0, 1.0}, {-2.0, 1.0, 0.3}};
  blocks.add_outer(-0.7, vertices, vectors);
  Vector b = Vector::Zero(12);
  for (std::size_t i = 0; i < 3; ++i) vertex_block(b, vertices[i]) = vectors[i];
  dense -= 0.7 * b * b.transpose();
  const HessianBlocks same = blocks;
  blocks.add(same, 0.5);
  blocks.scale(2.0);
  dense *= 3.0;
  Matrix sum = Matrix::Zero(12, 12);
  const Matrix diagonal = blocks.whole_diagonal();
  for (Index v = 0; v < 4; ++v) sum.block<3, 3>(3 * v, 3 * v) = diagonal.middleCols<3>(3 * v);
  blocks.for_each_pair([&](Index i, Index j, const Matrix3& block) {
    sum.block<3, 3>(3 * i, 3 * j) += block;
    sum.block<3, 3>(3 * j, 3 * i) += block.transpose();
  });
  EXPECT_LT((sum - dense).norm(), 1e-13);
  const Vector u = Vector::Random(12);
  Vector product = Vector::Ones(12);
  blocks.add_product(u, product);
  EXPECT_LT((product - Vector::Ones(12) - dense * u).norm(), 1e-13);
  blocks.reset(2);
  EXPECT_TRUE(blocks.pairs().empty());
  EXPECT_TRUE(blocks.outers().empty());
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
  const ForceTerm* first = system.force_terms().back();
  const std::size_t count = system.force_terms().size();
  system.set_force_term(std::make_shared<Named>("floor_2"));
  EXPECT_EQ(system.force_terms().size(), count);
  EXPECT_NE(system.force_terms().back(), first);
  EXPECT_THROW(system.set_force_term(nullptr), InputError);
  EXPECT_EQ(system.force_terms().back()->name(), "floor_2");
}

// Positions and velocities at which every term below has a force.
class TermDerivatives : public testing::Test {
 protected:
  TermDerivatives()
      : system_(small_block(), all_materials()[1], 1000.0),
        position_(jiggled(system_.mesh().rest_positions(), 0.01, 5)),
        velocity_(jiggled(Vector::Zero(system_.dof_count()), 3.0, 7)) {}

  ForceTermErrors errors_of(const ForceTerm& term, double time = 0.3) const {
    return check_derivatives(term, system_.force_point(position_, time), velocity_, 1e-7);
  }
  static PairSprings springs(const MechanicalSystem& system, double length) {
    return {{{0, system.vertex_count() - 1}, {system.vertex_count() - 3, 7}}, 3e4, length};
  }
  static void expect_right(const TermDerivativeErrors& errors, const std::string& name) {
    EXPECT_GT(errors.gradient_norm, 0.0) << name;
    EXPECT_LT(errors.gradient, 1e-7) << name;
    EXPECT_LT(errors.hessian, 1e-7) << name;
    EXPECT_GT(errors.least_eigenvalue, -1e-14) << name;
  }

  MechanicalSystem system_;
  Vector position_;
  Vector velocity_;
};

TEST_F(TermDerivatives, OfAllTermsFitTheirEnergies) {
  const PairSprings pulled = springs(system_, 0.1);
  const FloorBarrier floor(-0.04, 2e5, 0.05);
  const SwingingField swing(3.0, 2.0);
  for (const ForceTerm* term :
       {static_cast<const ForceTerm*>(&pulled), static_cast<const ForceTerm*>(&floor),
        static_cast<const ForceTerm*>(&swing)}) {
    expect_right(errors_of(*term).potential, term->name());
    EXPECT_EQ(errors_of(*term).dissipation.gradient_norm, 0.0) << term->name();
  }
  const QuadraticDrag drag(2.0);
  const LayeredDrag layered(2.0, 0.5);
  for (const ForceTerm* term :
       {static_cast<const ForceTerm*>(&drag), static_cast<const ForceTerm*>(&layered)}) {
    expect_right(errors_of(*term).dissipation, term->name());
    EXPECT_EQ(errors_of(*term).potential.gradient_norm, 0.0) << term->name();
  }
}

// A floor that only pushes, without a barrier: its Hessian jumps at the floor.
class PushingFloor : public VertexPotential {
 public:
  explicit PushingFloor(double height, double stiffness, double factor = 1.0)
      : height_(height), stiffness_(stiffness), factor_(factor) {}
  std::string name() const override { return "pushing_floor"; }
  double value(double, const Vector3& x) const override {
    return 0.5 * stiffness_ * std::pow(std::fmin(x.y() - height_, 0.0), 2);
  }
  Vector3 gradient(double, const Vector3& x) const override {
    return {0.0, stiffness_ * std::fmin(x.y() - height_, 0.0), 0.0};
  }
  Matrix3 hessian(double, const Vector3& x) const override {
    Matrix3 hessian = Matrix3::Zero();
    if (x.y() < height_) hessian(1, 1) = factor_ * stiffness_;
    return hessian;
  }

 private:
  double height_, stiffness_, factor_;
};

TEST_F(TermDerivatives, MayJump) {
  // Vertices below, at and above the floor.
  Vector position = system_.mesh().rest_positions();
  Index at_the_floor = 0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (position[3 * v + 1] == 0.5) ++at_the_floor;
  }
  ASSERT_GT(at_the_floor, 0);
  const auto errors_of = [&](double factor) {
    return check_derivatives(PushingFloor(0.5, 2e5, factor), system_.force_point(position, 0.0),
                             velocity_, 1e-7)
        .potential;
  };
  EXPECT_LT(errors_of(1.0).hessian, 1e-7);
  EXPECT_LT(errors_of(1.0).gradient, 1e-7);
  EXPECT_EQ(errors_of(1.0).jumps, at_the_floor);
  EXPECT_GT(errors_of(1.01).hessian, 1e-3);
}

TEST_F(TermDerivatives, OfTheTermsOfTheLibraryFitTheirEnergies) {
  system_.set_environment(Environment::attraction(40.0, 0.2));
  system_.set_damping({2.0, 0.5, 0.0});
  system_.set_pull(VertexPull({1, 4, 9}, system_.mass(), {0.3, 0.2, -0.1}, 500.0, 20.0));
  int potentials = 0;
  int dissipations = 0;
  for (const ForceTerm* term : system_.force_terms()) {
    const ForceTermErrors errors = errors_of(*term);
    if (errors.potential.gradient_norm > 0.0) {
      expect_right(errors.potential, term->name());
      ++potentials;
    }
    if (errors.dissipation.gradient_norm > 0.0) {
      expect_right(errors.dissipation, term->name());
      ++dissipations;
    }
  }
  EXPECT_EQ(potentials, 2);
  EXPECT_EQ(dissipations, 2);
}

TEST(VertexPull, AcceleratesItsVerticesAlike) {
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  const std::vector<Index> vertices{1, 4, 9};
  const VertexPull pull(vertices, system.mass(), {0.3, 0.2, -0.1}, 500.0, 20.0);
  const Vector position = system.mesh().rest_positions();
  Vector force = Vector::Zero(system.dof_count());
  pull.add_gradient(system.force_point(position, 0.0), force);
  Vector3 mean = Vector3::Zero();
  double mass = 0.0;
  for (const Index v : vertices) {
    mean += system.mass()[v] * vertex_block(position, v);
    mass += system.mass()[v];
  }
  const Vector3 acceleration = 500.0 * (mean / mass - Vector3(0.3, 0.2, -0.1)) / mass;
  for (const Index v : vertices) {
    EXPECT_LT((vertex_block(force, v) / system.mass()[v] - acceleration).norm(),
              1e-12 * acceleration.norm());
    vertex_block(force, v).setZero();
  }
  EXPECT_TRUE(force.isZero(0.0));
}

// A floor with a mistake in one of its derivatives.
class WrongFloor : public FloorBarrier {
 public:
  enum class Mistake { kGradient, kHessian, kConvex };
  explicit WrongFloor(Mistake mistake) : FloorBarrier(-0.04, 2e5, 0.05), mistake_(mistake) {}
  Vector3 gradient(double mass, const Vector3& x) const override {
    return (mistake_ == Mistake::kGradient ? 1.001 : 1.0) * FloorBarrier::gradient(mass, x);
  }
  Matrix3 hessian(double mass, const Vector3& x) const override {
    Matrix3 hessian = FloorBarrier::hessian(mass, x);
    if (mistake_ == Mistake::kHessian) hessian(0, 1) += 1e-3 * hessian(1, 1);
    return hessian;
  }
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override {
    FloorBarrier::add_hessian(at, form, hessian);
    if (mistake_ == Mistake::kConvex && form == HessianForm::kConvex) hessian.scale(-1.0);
  }

 private:
  Mistake mistake_;
};

TEST_F(TermDerivatives, ThatAreWrongAreFound) {
  const TermDerivativeErrors gradient =
      errors_of(WrongFloor(WrongFloor::Mistake::kGradient)).potential;
  EXPECT_NEAR(gradient.gradient, 1e-3, 1e-5);
  EXPECT_NEAR(gradient.hessian, 1e-3, 1e-5);
  const TermDerivativeErrors hessian =
      errors_of(WrongFloor(WrongFloor::Mistake::kHessian)).potential;
  EXPECT_LT(hessian.gradient, 1e-7);
  EXPECT_NEAR(hessian.hessian, 1e-3, 1e-5);
  const TermDerivativeErrors convex = errors_of(WrongFloor(WrongFloor::Mistake::kConvex)).potential;
  EXPECT_LT(convex.hessian, 1e-7);
  EXPECT_EQ(convex.least_eigenvalue, -1.0);
  // Compressed springs that push have a negative curvature across, which the convex form must drop.
  class PushingSprings : public PairSprings {
   public:
    using PairSprings::PairSprings;
    void add_hessian(const ForcePoint& at, HessianForm, HessianBlocks& blocks) const override {
      PairSprings::add_hessian(at, HessianForm::kExact, blocks);
      blocks.add_pair(0, 1, 1e5 * Matrix3::Identity());
    }
  };
  const PushingSprings pushing(std::vector<std::pair<Index, Index>>{{0, 1}}, 3e4, 0.01);
  EXPECT_LT(errors_of(pushing).potential.least_eigenvalue, -0.1);
}

TEST_F(TermDerivatives, AreNotCheckedWhereThePotentialIsNotDefined) {
  const FloorBarrier floor(0.02, 2e5, 0.05);  // some vertices are below it
  EXPECT_THROW(errors_of(floor), InputError);
  const ForcePoint at = system_.force_point(position_, 0.0);
  const QuadraticDrag drag(2.0);
  EXPECT_THROW(check_derivatives(drag, at, Vector::Zero(3), 1e-7), InputError);
  EXPECT_THROW(check_derivatives(drag, at, velocity_, 0.0), InputError);
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
  const auto [phi, gradient] = value_and_gradient_of(problem_, u);
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
  ASSERT_TRUE(evaluate_energies(system, state, energies).ok());
  EXPECT_GT(energies.of("floor"), 0.0);
  EXPECT_EQ(energies.of("kinetic"), 0.0);
  EXPECT_EQ(energies.total(), energies.elastic() + energies.of("floor"));
  EXPECT_THROW(static_cast<void>(energies.of("roof")), InputError);
  ASSERT_EQ(energies.extra_count(), 1U);
  EXPECT_EQ(energies.extra(0).name, "floor");
}

}  // namespace
}  // namespace tetraction
