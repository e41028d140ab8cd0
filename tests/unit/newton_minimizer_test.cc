#include "tetraction/solver/newton_minimizer.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "support/fibre_rubber.h"
#include "support/step_problems.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/solver/ceres_minimizer.h"

namespace tetraction {
namespace {

using namespace testing_support;

NewtonOptions newton(LinearSolver linear, double tolerance = 1e-8, int iterations = 100,
                     bool keep_factor = true) {
  NewtonOptions options;
  options.tolerance = tolerance;
  options.max_iterations = iterations;
  options.linear = linear;
  options.keep_factor = keep_factor;
  return options;
}

const std::vector<LinearSolver>& all_linear() {
  static const std::vector<LinearSolver> all{LinearSolver::kAuto, LinearSolver::kMatrixFree,
                                             LinearSolver::kCg, LinearSolver::kFactor};
  return all;
}

std::string test_name(LinearSolver linear) {
  std::string name = to_string(linear);
  std::erase(name, '-');
  return name;
}

double lowest_eigenvalue(const StepProblem& problem, const Vector& x) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(dense_hessian(problem, x), Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

double phi_of(const StepProblem& problem, const Vector& x) {
  double phi = 0.0;
  EXPECT_TRUE(problem.value(x, phi).ok());
  return phi;
}

// The report tells the truth about x and hangs together.
void expect_true_report(const StepProblem& problem, const Vector& x, const MinimizerReport& report,
                        LinearSolver linear, double tolerance) {
  ASSERT_TRUE(report.converged()) << report.message << ": " << report.residual << " > "
                                  << report.residual_limit;
  const auto [phi, gradient] = value_and_gradient_of(problem, x);
  EXPECT_NEAR(gradient.norm(), report.residual, 1e-9 * report.residual_limit);
  EXPECT_LE(gradient.norm(), report.residual_limit * (1.0 + 1e-9));
  EXPECT_LE(report.residual_limit, 1.1 * problem.residual_limit(x, tolerance));
  EXPECT_FALSE(report.message.empty());
  if (linear != LinearSolver::kAuto) {
    EXPECT_EQ(report.linear, to_string(linear));
  }
  if (report.linear == "factor") {
    EXPECT_LE(report.factorizations, 2 * report.iterations);
  } else {
    EXPECT_EQ(report.factorizations, 0);
    EXPECT_GE(report.cg_iterations, report.iterations);
  }
}

// Expects that the bending step of the system has the solution that Ceres finds.
MinimizerReport expect_solution_of_ceres(const MechanicalSystem& system, LinearSolver linear) {
  StepProblem problem(system);
  const State state = bending_state(system);
  begin(problem, state);
  Vector x = state.position;
  const MinimizerReport report =
      make_newton_minimizer(system, newton(linear, 1e-11))->minimize(problem, x);
  expect_true_report(problem, x, report, linear, 1e-11);
  Vector expected = state.position;
  EXPECT_TRUE(make_ceres_minimizer(system, {1e-11, 200})->minimize(problem, expected).converged());
  EXPECT_LT((x - expected).norm(), 1e-8 * (expected - state.position).norm());
  return report;
}

class NewtonStep : public testing::TestWithParam<LinearSolver> {
 protected:
  std::unique_ptr<Minimizer> make(double tolerance = 1e-8, int iterations = 100,
                                  bool keep_factor = true) const {
    return make_newton_minimizer(system_, newton(GetParam(), tolerance, iterations, keep_factor));
  }

  BendingBlock block_;
  MechanicalSystem& system_ = block_.system;
  const State& state_ = block_.state;
  StepProblem& problem_ = block_.problem;
};

TEST_P(NewtonStep, AgreesWithADenseNewtonSolve) {
  Vector x = state_.position;
  const MinimizerReport report = make(1e-11)->minimize(problem_, x);
  expect_true_report(problem_, x, report, GetParam(), 1e-11);
  const Vector reference = dense_newton(problem_, state_.position);
  const double moved = (reference - state_.position).norm();
  ASSERT_GT(moved, 0.01);
  EXPECT_LT((x - reference).norm(), 1e-8 * moved);
}

TEST_P(NewtonStep, IterationsAreNewtonIterations) {
  // The residual after each iteration, from solves that are cut off one iteration later each time.
  const double scale = problem_.residual_limit(state_.position, 0.5) / 0.5;
  std::vector<double> residuals;
  for (int iterations = 1; iterations <= 12; ++iterations) {
    Vector x = state_.position;
    const MinimizerReport report = make(1e-13, iterations)->minimize(problem_, x);
    residuals.push_back(report.residual);
    if (report.converged()) break;
    EXPECT_EQ(report.iterations, iterations);
  }
  EXPECT_LT(residuals.back(), 1e-11 * scale);
  // Superlinear: the forcing terms fall with the residual.
  for (std::size_t i = 0; i + 1 < residuals.size(); ++i) {
    EXPECT_LT(residuals[i + 1], residuals[i]);
    if (residuals[i] < 1e-3 * scale && residuals[i + 1] > 1e-11 * scale) {
      EXPECT_LT(residuals[i + 1], 0.05 * residuals[i]);
    }
  }
}

TEST_P(NewtonStep, RecoversFromAnInvertedFirstGuess) {
  const auto minimizer = make(1e-10);
  Vector good = state_.position;
  ASSERT_TRUE(minimizer->minimize(problem_, good).converged());
  Vector mirrored = state_.position;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (system_.coordinates().is_free(v)) mirrored[3 * v] *= -1.0;  // J < 0
  }
  Vector wild = state_.position;
  const Vector moves = jiggled(Vector::Zero(wild.size()), 2.0);
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (system_.coordinates().is_free(v)) wild.segment<3>(3 * v) += moves.segment<3>(3 * v);
  }
  problem_.set_origin(problem_.base());
  for (const Vector& x : {mirrored, wild}) {
    Vector u = x - problem_.base();
    double phi = 0.0;
    ASSERT_FALSE(problem_.value(u, phi).ok());
    const MinimizerReport report = minimizer->minimize(problem_, u);
    ASSERT_TRUE(report.converged()) << report.message;
    EXPECT_LT((problem_.base() + u - good).norm(), 1e-8 * (good - state_.position).norm());
  }
}

TEST_P(NewtonStep, AgreesWithCeresFromStrainedStarts) {
  for (const MaterialModel& material : all_materials()) {
    MechanicalSystem system(small_block(), material, 1000.0);
    clamp_under_gravity(system);
    StepProblem problem(system);
    begin(problem, bending_state(system));
    const auto ours = make_newton_minimizer(system, newton(GetParam(), 1e-11));
    const auto theirs = make_ceres_minimizer(system, {1e-11, 200});
    const Vector start = system.rest_state().position;
    Vector expected = start;
    ASSERT_TRUE(theirs->minimize(problem, expected).converged());
    for (unsigned seed = 1; seed <= 6; ++seed) {
      Vector x = start;
      const Vector moves = jiggled(Vector::Zero(x.size()), seed < 4 ? 0.05 : 0.12, seed);
      for (Index v = 0; v < system.vertex_count(); ++v) {
        if (system.coordinates().is_free(v)) x.segment<3>(3 * v) += moves.segment<3>(3 * v);
      }
      const MinimizerReport report = ours->minimize(problem, x);
      expect_true_report(problem, x, report, GetParam(), 1e-11);
      EXPECT_LT((x - expected).norm(), 1e-8 * (expected - start).norm())
          << material_name(material) << " " << seed;
    }
  }
}

TEST_P(NewtonStep, LeavesFixedVerticesBitwiseAlone) {
  Vector x = state_.position;
  ASSERT_TRUE(make()->minimize(problem_, x).converged());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (!system_.coordinates().is_fully_prescribed(v)) continue;
    EXPECT_EQ(x.segment<3>(3 * v), state_.position.segment<3>(3 * v));
  }
}

TEST_P(NewtonStep, SaysWhenTheIterationLimitIsReached) {
  Vector x = state_.position;
  const MinimizerReport report = make(1e-12, 1)->minimize(problem_, x);
  EXPECT_EQ(report.termination, Termination::kIterationLimit);
  EXPECT_FALSE(report.converged());
  EXPECT_GT(report.residual, report.residual_limit);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_NE(report.message.find("limit"), std::string::npos);
  double phi = 0.0;
  EXPECT_TRUE(problem_.value(x, phi).ok());
}

TEST_P(NewtonStep, HonoursTheResidualLimit) {
  int before = 0;
  for (const double tolerance : {1e-2, 1e-4, 1e-8, 1e-12}) {
    Vector x = state_.position;
    const MinimizerReport report = make(tolerance)->minimize(problem_, x);
    expect_true_report(problem_, x, report, GetParam(), tolerance);
    EXPECT_GE(report.iterations, before);
    before = report.iterations;
  }
  // At the solution there is nothing to do.
  Vector x = state_.position;
  const auto minimizer = make();
  ASSERT_TRUE(minimizer->minimize(problem_, x).converged());
  const Vector solution = x;
  const MinimizerReport again = minimizer->minimize(problem_, x);
  EXPECT_TRUE(again.converged());
  EXPECT_EQ(again.iterations, 0);
  EXPECT_EQ(x, solution);
}

TEST_P(NewtonStep, ConvergesForTinyMotionsOfAStiffBody) {
  const StiffBlock stiff;
  Vector x = stiff.system.rest_state().position;
  const MinimizerReport report =
      make_newton_minimizer(stiff.system, newton(GetParam()))->minimize(stiff.problem, x);
  EXPECT_TRUE(report.converged()) << report.message << " " << report.residual << " > "
                                  << report.residual_limit;
}

TEST_P(NewtonStep, ConvergesForStiffBodiesAndLongSteps) {
  for (const double poisson : {0.3, 0.49}) {
    for (const double h : {0.1, 10.0}) {
      const LameParameters lame = lame_from_young(1e9, poisson);
      MechanicalSystem stiff(generate_box({4, 0.5, 0.5}, {16, 2, 2}),
                             NeoHookean(lame.mu, lame.lambda), 1000.0);
      clamp_under_gravity(stiff);
      StepProblem problem(stiff);
      begin(problem, stiff.rest_state(), h);
      Vector x = stiff.rest_state().position;
      const MinimizerReport report =
          make_newton_minimizer(stiff, newton(GetParam(), 1e-10))->minimize(problem, x);
      expect_true_report(problem, x, report, GetParam(), 1e-10);
      EXPECT_LE(report.iterations, 20) << poisson << " " << h;
      Vector expected = stiff.rest_state().position;
      ASSERT_TRUE(
          make_ceres_minimizer(stiff, {1e-10, 200})->minimize(problem, expected).converged());
      EXPECT_LT((x - expected).norm(), 1e-6 * (expected - stiff.rest_state().position).norm());
    }
  }
}

TEST_P(NewtonStep, ForcesThatOverflowAreNotTakenForConverged) {
  system_.set_environment(Environment::uniform({0.0, -1e300, 0.0}));
  begin(problem_, state_);
  Vector x = state_.position;
  EXPECT_EQ(make()->minimize(problem_, x).termination, Termination::kInadmissible);
}

TEST_P(NewtonStep, KeepingTheFactorOrNotEndsInTheSamePlace) {
  // Through a number of steps, with one object each.
  const auto kept = make(1e-12, 100, true);
  const auto renewed = make(1e-12, 100, false);
  const auto run = [&](Minimizer& minimizer, int& factorizations, int& iterations) {
    State state = state_;
    StepProblem problem(system_);
    for (int step = 1; step <= 12; ++step) {
      problem.begin(state, kStep, step * kStep, 1.0, {});
      measure_from_zero(problem);
      Vector x = state.position;
      const MinimizerReport report = minimizer.minimize(problem, x);
      EXPECT_TRUE(report.converged()) << report.message;
      factorizations += report.factorizations;
      iterations += report.iterations;
      state.momentum = system_.momentum_of((x - state.position) / kStep);
      state.position = x;
    }
    return state.position;
  };
  int kept_factorizations = 0;
  int renewed_factorizations = 0;
  int kept_iterations = 0;
  int renewed_iterations = 0;
  const Vector a = run(*kept, kept_factorizations, kept_iterations);
  const Vector b = run(*renewed, renewed_factorizations, renewed_iterations);
  EXPECT_LT((a - b).norm(), 1e-9 * (a - state_.position).norm());
  if (GetParam() == LinearSolver::kFactor) {
    EXPECT_GE(renewed_factorizations, renewed_iterations);
    EXPECT_LT(kept_factorizations, kept_iterations);
    EXPECT_GE(kept_factorizations, 1);
  }
}

TEST_P(NewtonStep, StepSizesMayChangeBetweenMinimisations) {
  const auto minimizer = make(1e-11);
  for (const double h : {0.02, 0.002, 0.2, 2e-5, 0.02}) {
    StepProblem problem(system_);
    begin(problem, state_, h);
    Vector x = state_.position;
    const MinimizerReport report = minimizer->minimize(problem, x);
    expect_true_report(problem, x, report, GetParam(), 1e-11);
    Vector fresh = state_.position;
    ASSERT_TRUE(make(1e-11)->minimize(problem, fresh).converged());
    EXPECT_LT((x - fresh).norm(), 1e-9 * (fresh - state_.position).norm()) << h;
  }
}

TEST_P(NewtonStep, SolvesLinearSystemsBetweenMinimisations) {
  const auto minimizer = make(1e-11);
  Vector x = state_.position;
  ASSERT_TRUE(minimizer->minimize(problem_, x).converged());
  const Matrix right = Matrix::Random(system_.coordinates().count(), 3);
  Matrix solution;
  ASSERT_TRUE(minimizer->solve_linearized(problem_, x, right, solution));
  EXPECT_LT((dense_hessian(problem_, x) * solution - right).norm(), 1e-10 * right.norm());
  // The factor that this left behind does no harm.
  StepProblem next(system_);
  begin(next, state_, 0.5 * kStep);
  Vector y = state_.position;
  ASSERT_TRUE(minimizer->minimize(next, y).converged());
  Vector fresh = state_.position;
  ASSERT_TRUE(make(1e-11)->minimize(next, fresh).converged());
  EXPECT_LT((y - fresh).norm(), 1e-9 * (fresh - state_.position).norm());
}

TEST_P(NewtonStep, StronglyCompressedStVenantKirchhoffEndsInAMinimum) {
  // Both ends held at 0.45 of their distance: beyond the limit of 1/√3, where it softens.
  MechanicalSystem system(generate_box({2, 0.5, 0.5}, {6, 2, 2}), all_materials()[0], 1000.0);
  const TetMesh& mesh = system.mesh();
  std::vector<Index> ends = select_vertices(mesh, SelectPlane{0, 0.0, {}});
  const std::vector<Index> far = select_vertices(mesh, SelectPlane{0, 2.0, {}});
  ends.insert(ends.end(), far.begin(), far.end());
  PrescribedVertices held = prescribe_at_rest(mesh, ends, "ends");
  held.start.row(0) *= 0.45;
  system.set_constraints(
      Constraints({{held}, {}, {}, {}}, mesh, Vector::Ones(mesh.vertex_count())));
  State state = system.rest_state();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    state.position[3 * v] = 0.45 * mesh.vertices[static_cast<std::size_t>(v)].x();
  }
  Vector start = jiggled(state.position, 0.02);
  for (const Index v : ends) start.segment<3>(3 * v) = state.position.segment<3>(3 * v);
  for (const double h : {0.01, 0.1, 1.0}) {
    StepProblem problem(system);
    // Loads set the force scale.
    problem.begin(state, h, h, 1.0, jiggled(Vector::Zero(system.dof_count()), 1e3, 2));
    measure_from_zero(problem);
    if (h >= 0.1) {
      ASSERT_LT(lowest_eigenvalue(problem, start), 0.0);
    }
    Vector x = start;
    const auto minimizer = make_newton_minimizer(system, newton(GetParam(), 1e-9, 300));
    if (lowest_eigenvalue(problem, start) < 0.0) {
      Matrix solution;
      EXPECT_FALSE(minimizer->solve_linearized(
          problem, start, Matrix::Ones(system.coordinates().count(), 1), solution));
    }
    const MinimizerReport report = minimizer->minimize(problem, x);
    ASSERT_TRUE(report.converged())
        << h << ": " << report.message << " " << report.residual << " > " << report.residual_limit
        << " after " << report.iterations;
    EXPECT_LT(phi_of(problem, x), phi_of(problem, start));
    EXPECT_GT(lowest_eigenvalue(problem, x), 0.0) << h;
  }
}

TEST_P(NewtonStep, VerticesOnPlanesAndLines) {
  MechanicalSystem system(small_block(), all_materials()[2], 1000.0);
  const TetMesh& mesh = system.mesh();
  const auto guide = [&](std::vector<Index> vertices, const Matrix& directions,
                         const std::string& name) {
    Matrix points = prescribe_at_rest(mesh, vertices).start;
    return GuidedVertices{std::move(vertices), directions, points, name};
  };
  const Vector3 normal = Vector3(1.0, 0.3, -0.2).normalized();
  Matrix plane(3, 2);
  const Vector3 along = normal.unitOrthogonal();
  plane.col(0) = along;
  plane.col(1) = normal.cross(along);
  const std::vector<Index> left = select_vertices(mesh, SelectPlane{0, 0.0, {}});
  const std::vector<Index> right = select_vertices(mesh, SelectPlane{0, 2.0, {}});
  PrescribedVertices roller = prescribe_at_rest(mesh, {right[3]}, "roller");
  roller.components = {false, true, false};
  const std::vector<Index> line_vertices{right[0], right[1]};
  const Matrix line = Vector3(1.0, 2.0, 2.0) / 3.0;
  system.set_constraints(Constraints(
      {{roller}, {guide(left, plane, "plane"), guide(line_vertices, line, "line")}, {}, {}}, mesh,
      Vector::Ones(mesh.vertex_count())));
  system.set_environment(Environment::uniform({1.0, -9.81, 3.0}));
  StepProblem problem(system);
  const State state = bending_state(system);
  begin(problem, state);
  Vector x = state.position;
  const MinimizerReport report =
      make_newton_minimizer(system, newton(GetParam(), 1e-11))->minimize(problem, x);
  expect_true_report(problem, x, report, GetParam(), 1e-11);
  EXPECT_LT(system.constraints().error(x, kStep), 1e-12);
  Vector expected = state.position;
  ASSERT_TRUE(make_ceres_minimizer(system, {1e-11, 200})->minimize(problem, expected).converged());
  ASSERT_GT((expected - state.position).norm(), 0.01);
  EXPECT_LT((x - expected).norm(), 1e-8 * (expected - state.position).norm());
}

TEST_P(NewtonStep, FreeRigidHandles) {
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  const TetMesh& mesh = system.mesh();
  const std::vector<Index> right = select_vertices(mesh, SelectPlane{0, 2.0, {}});
  system.set_constraints(Constraints({{prescribe_at_rest(mesh, {0, 5, 10}, "hold")},
                                      {},
                                      {},
                                      {{right, prescribe_at_rest(mesh, right).start, "grip"}}},
                                     mesh, system.mass()));
  ASSERT_FALSE(system.coordinates().sets().empty());
  system.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
  if (GetParam() == LinearSolver::kMatrixFree) {
    expect_error([&] { make_newton_minimizer(system, newton(GetParam())); },
                 {"matrix-free", "rigid handles", "auto", "cg", "factor"});
    return;
  }
  const MinimizerReport report = expect_solution_of_ceres(system, GetParam());
  if (GetParam() == LinearSolver::kAuto) {
    EXPECT_EQ(report.linear, "factor");
  }
}

TEST_P(NewtonStep, CustomMaterials) {
  const LameParameters lame = lame_from_young(1e6, 0.4);
  MechanicalSystem system(small_block(),
                          CustomMaterial(FibreRubber(lame, 1e5, 1.0, Vector3::UnitX())), 1000.0);
  clamp_under_gravity(system);
  if (GetParam() == LinearSolver::kMatrixFree) {
    EXPECT_THROW(make_newton_minimizer(system, newton(GetParam())), InputError);
    return;
  }
  expect_solution_of_ceres(system, GetParam());
}

TEST_P(NewtonStep, AttractionWithAnIndefiniteHessian) {
  // Vertices near the origin feel a potential that is concave in most directions: with a step this
  // long, inertia does not make up for it.
  TetMesh mesh = small_block();
  for (Vector3& x : mesh.vertices.own()) x += Vector3(0.3, 0.2, 0.1);
  MechanicalSystem system(mesh, all_materials()[1], 100.0);
  system.set_environment(Environment::attraction(2e3, 0.3));
  const State state = bending_state(system);
  for (const double h : {0.01, 0.05, 0.2}) {
    StepProblem problem(system);
    begin(problem, state, h);
    if (h > 0.1) {
      ASSERT_LT(lowest_eigenvalue(problem, state.position), 0.0);
    }
    Vector x = state.position;
    const MinimizerReport report =
        make_newton_minimizer(system, newton(GetParam(), 1e-9, 300))->minimize(problem, x);
    ASSERT_TRUE(report.converged())
        << h << ": " << report.message << " " << report.residual << " > " << report.residual_limit
        << " after " << report.iterations;
    EXPECT_GT(lowest_eigenvalue(problem, x), 0.0) << h;
    EXPECT_LT(phi_of(problem, x), phi_of(problem, state.position));
  }
}

TEST_P(NewtonStep, ViscosityAndPenaltySprings) {
  system_.set_damping({2.0, 0.5, 2e4});
  PrescribedVertices spring = prescribe_at_rest(
      system_.mesh(), select_vertices(system_.mesh(), SelectPlane{0, 2.0, {}}), "springs");
  spring.penalty = 1e5;
  PrescribedVertices held = prescribe_at_rest(
      system_.mesh(), select_vertices(system_.mesh(), SelectPlane{0, 0.0, {}}), "hold");
  system_.set_constraints(Constraints({{held, spring}, {}, {}, {}}, system_.mesh(),
                                      Vector::Ones(system_.vertex_count())));
  for (const double alpha : {0.5, 1.0}) {
    StepProblem problem(system_);
    begin(problem, state_, kStep, alpha);
    Vector x = state_.position;
    const MinimizerReport report = make(1e-11)->minimize(problem, x);
    expect_true_report(problem, x, report, GetParam(), 1e-11);
    const Vector reference = dense_newton(problem, state_.position);
    EXPECT_LT((x - reference).norm(), 1e-8 * (reference - state_.position).norm());
  }
}

TEST_P(NewtonStep, IsBitwiseRepeatable) {
  // Large enough for several blocks and several parts of the vertex loops.
  MechanicalSystem system(small_block({14, 9, 9}), all_materials()[1], 1000.0);
  clamp_under_gravity(system);
  struct Result {
    Vector x;
    MinimizerReport report;
  };
  std::vector<Result> results;
  for (const int threads : {1, 1, 2, 4}) {
    set_thread_count(threads);
    const auto minimizer = make_newton_minimizer(system, newton(GetParam()));
    State state = bending_state(system);
    StepProblem problem(system);
    Result result;
    for (int step = 1; step <= 3; ++step) {
      problem.begin(state, kStep, step * kStep, 1.0, {});
      measure_from_zero(problem);
      result.x = state.position;
      result.report = minimizer->minimize(problem, result.x);
      EXPECT_TRUE(result.report.converged());
      state.momentum = system.momentum_of((result.x - state.position) / kStep);
      state.position = result.x;
    }
    results.push_back(result);
  }
  set_thread_count(0);
  for (const Result& r : results) {
    EXPECT_EQ(r.x, results[0].x);
    EXPECT_EQ(r.report.iterations, results[0].report.iterations);
    EXPECT_EQ(r.report.cg_iterations, results[0].report.cg_iterations);
    EXPECT_EQ(r.report.residual, results[0].report.residual);
  }
}

INSTANTIATE_TEST_SUITE_P(All, NewtonStep, testing::ValuesIn(all_linear()),
                         [](const auto& test) { return test_name(test.param); });

TEST(NewtonMinimizer, RefusesMeaninglessOptions) {
  const MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  for (const LinearSolver linear : all_linear()) {
    EXPECT_THROW(make_newton_minimizer(system, newton(linear, 0.0)), InputError);
    EXPECT_THROW(make_newton_minimizer(system, newton(linear, 1.0)), InputError);
    EXPECT_THROW(make_newton_minimizer(system, newton(linear, 1e-8, 0)), InputError);
  }
}

TEST(NewtonMinimizer, WithoutKeptFactorsItIsNewtonsMethodProper) {
  // Exact solves: the residual is squared in each iteration, up to a constant.
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  clamp_under_gravity(system);
  StepProblem problem(system);
  const State state = system.rest_state();
  begin(problem, state, 0.1);
  std::vector<double> residuals;
  for (int iterations = 1; iterations <= 8; ++iterations) {
    Vector x = state.position;
    const MinimizerReport report =
        make_newton_minimizer(system, newton(LinearSolver::kFactor, 1e-14, iterations, false))
            ->minimize(problem, x);
    residuals.push_back(report.residual);
    EXPECT_EQ(report.factorizations, report.iterations);
    EXPECT_EQ(report.cg_iterations, 0);
  }
  expect_quadratic_convergence(residuals, problem.residual_limit(state.position, 0.5) / 0.5);
}

}  // namespace
}  // namespace tetraction
