#include "tetraction/dynamics/steppers/stability.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "core/decompositions.h"
#include "support/step_problems.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Largest eigenvalue of M⁻¹K over the free DOFs by the dense generalised eigenproblem.
double dense_omega_max(const MechanicalSystem& system, const Vector& q) {
  const SparsityPattern pattern(system.rest(), system.coordinates());
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  EXPECT_TRUE(system.elastic().add_hessian(q, pattern, values.data()).ok());
  const Matrix k = dense_matrix(pattern, values);
  const Matrix m = system.coordinates().reduced_mass(system.mass()).asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> solver(k, m, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

TEST(StabilityLimit, AgreesWithTheDenseEigenproblem) {
  for (const MaterialModel& material : all_materials()) {
    for (const auto& cells : {std::array{1, 1, 1}, std::array{6, 4, 3}}) {
      MechanicalSystem system(small_block(cells), material, 1000.0);
      system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
      for (const Vector& q :
           {system.rest_state().position,
            strained_state(system.elastic(), system.rest_state().position, 0.2)}) {
        const StabilityLimit limit = stability_limit(system, q);
        const double exact = dense_omega_max(system, q);
        EXPECT_NEAR(limit.omega_max, exact, 1e-3 * exact) << material_name(material);
        EXPECT_NEAR(limit.critical_step, 2.0 / exact, 2e-3 / exact);
        EXPECT_GE(limit.element, 0);
      }
    }
  }
}

// The same in the space that the equations of constraints allow.
double dense_omega_max_on_constraints(const MechanicalSystem& system, const Vector& q) {
  const SparsityPattern pattern(system.rest(), system.coordinates());
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  EXPECT_TRUE(system.elastic().add_hessian(q, pattern, values.data()).ok());
  const Vector root = system.coordinates().reduced_mass(system.mass()).cwiseSqrt().cwiseInverse();
  const Matrix k = root.asDiagonal() * dense_matrix(pattern, values) * root.asDiagonal();
  const Constraints& constraints = system.constraints();
  const Matrix across = root.asDiagonal() * (constraints.selector() *
                                             constraints.gradients(constraints.configuration(q)));
  const Eigen::ColPivHouseholderQR<Matrix> qr(across);
  const Matrix basis = qr.householderQ();
  const Matrix allowed = basis.rightCols(basis.cols() - qr.rank());
  return std::sqrt(symmetric_eigen(Matrix(allowed.transpose() * k * allowed)).values.maxCoeff());
}

TEST(StabilityLimit, FreeHandlesAndDistancesRestrictTheMotions) {
  for (const auto& cells : {std::array{2, 1, 1}, std::array{6, 4, 3}}) {
    const TetMesh mesh = small_block(cells);
    MechanicalSystem system(mesh, NeoHookean(4e5, 1e6), 1000.0);
    const double free_omega = stability_limit(system, system.rest_state().position).omega_max;
    const auto constrain = [&](const Selection& part, std::vector<FixedDistance> distances) {
      RigidHandle handle{select_vertices(mesh, part), {}, "handle"};
      handle.shape.resize(3, static_cast<Index>(handle.vertices.size()));
      for (std::size_t i = 0; i < handle.vertices.size(); ++i) {
        handle.shape.col(static_cast<Index>(i)) =
            mesh.vertices[static_cast<std::size_t>(handle.vertices[i])];
      }
      system.set_constraints(
          Constraints({{}, {}, std::move(distances), {handle}}, mesh, system.mass()));
    };
    constrain(SelectPlane{0, 0.0, {}}, {FixedDistance{mesh.vertex_count() - 1, 1, 0.5, "rod"}});
    const Vector q = system.rest_state().position;
    const double exact = dense_omega_max_on_constraints(system, q);
    EXPECT_NEAR(stability_limit(system, q).omega_max, exact, 1e-3 * exact);
    EXPECT_NEAR(stability_limit(system, q, Integrator::kVerlet).critical_step, 2.0 / exact,
                2e-3 / exact);
    // A body that is one handle has nothing that could vibrate.
    constrain(SelectAll{}, {});
    EXPECT_LT(stability_limit(system, q).omega_max, 1e-3 * free_omega);
  }
}

// Stiffness and damping of everything that acts, as dense matrices divided by the mass, in coordinates in which they are
// symmetric.
struct DenseMatrices {
  Matrix stiffness;
  Matrix damping;
};
DenseMatrices dense_matrices(const MechanicalSystem& system, const Vector& q) {
  const Index n = system.dof_count();
  const ForcePoint at = system.force_point(q, 0.0);
  const Vector rest = Vector::Zero(n);
  HessianBlocks springs;
  HessianBlocks dampers;
  springs.reset(system.vertex_count());
  dampers.reset(system.vertex_count());
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) term->add_hessian(at, HessianForm::kExact, springs);
    if (term->has_dissipation()) {
      term->add_dissipation_hessian(at, rest, HessianForm::kExact, dampers);
    }
  }
  DenseMatrices result{Matrix(n, n), Matrix::Zero(n, n)};
  Vector root(n);
  for (Index i = 0; i < n; ++i) root[i] = 1.0 / std::sqrt(system.mass()[i / 3]);
  for (Index j = 0; j < n; ++j) {
    Vector column;
    system.elastic().product(q, Vector::Unit(n, j), column);
    springs.add_product(Vector::Unit(n, j), column);
    result.stiffness.col(j) = column;
    Vector damped = Vector::Zero(n);
    dampers.add_product(Vector::Unit(n, j), damped);
    result.damping.col(j) = damped;
  }
  result.stiffness = root.asDiagonal() * result.stiffness * root.asDiagonal();
  result.damping = root.asDiagonal() * result.damping * root.asDiagonal();
  return result;
}

// The damping matrix of a pull has rank 3 and one eigenvalue beside 0. Lanczos iterations that go on where
// products leave no new direction return numbers of any size for it.
TEST(StabilityLimit, OfAPullOfAnyVerticesIsThatOfTheDenseMatrices) {
  const LameParameters lame = lame_from_young(1e5, 0.3);
  std::mt19937 random(7);
  const auto largest = [](const Matrix& a) { return symmetric_eigen(a).values.maxCoeff(); };
  for (int set = 0; set < 6; ++set) {
    MechanicalSystem system(small_block({2, 2, 2}), NeoHookean(lame.mu, lame.lambda), 1000.0);
    std::vector<Index> vertices(static_cast<std::size_t>(system.vertex_count()));
    std::iota(vertices.begin(), vertices.end(), Index{0});
    std::shuffle(vertices.begin(), vertices.end(), random);
    vertices.resize(set == 0 ? vertices.size() : 2 + random() % 6);
    const Vector q = system.rest_state().position;
    const double mass = system.total_mass();
    const double omega = stability_limit(system, q).omega_max;
    for (const double stiffness : {0.0, 0.04, 100.0}) {
      for (const double damping : {0.003, 0.3, 30.0}) {
        system.set_pull(VertexPull(vertices, system.mass(), {0.1, 0.2, 0.3},
                                   stiffness * mass * omega * omega, damping * mass * omega));
        const DenseMatrices dense = dense_matrices(system, q);
        const double k = largest(dense.stiffness);
        const double c = largest(dense.damping);
        SCOPED_TRACE(::testing::Message() << vertices.size() << " vertices, stiffness " << stiffness
                                          << ", damping " << damping);
        CriticalModes modes;
        const StabilityLimit verlet = stability_limit(system, q, Integrator::kVerlet, &modes);
        EXPECT_NEAR(verlet.omega_max, std::sqrt(k), 1e-3 * std::sqrt(k));
        EXPECT_NEAR(verlet.damping_rate, c, 1e-3 * c);
        const double of_both = verlet_critical_step(std::sqrt(k), c);
        EXPECT_NEAR(verlet.critical_step, of_both, 2e-3 * of_both);
        StabilityTracker tracker(system);
        EXPECT_NEAR(tracker.critical_step(q, Integrator::kVerlet, modes), of_both, 0.03 * of_both);

        // The least h for which h²K + 2hC − 4M is singular.
        double low = 0.0;
        double high = 2.0 / std::sqrt(k);
        for (int i = 0; i < 20; ++i) {
          const double h = 0.5 * (low + high);
          const Matrix left = 4.0 * Matrix::Identity(dense.damping.rows(), dense.damping.cols()) -
                              h * h * dense.stiffness - 2.0 * h * dense.damping;
          (Eigen::LLT<Matrix>(left).info() == Eigen::Success ? low : high) = h;
        }
        EXPECT_NEAR(stability_limit(system, q, Integrator::kExplicit, &modes).critical_step, low,
                    2e-3 * low);
        EXPECT_NEAR(tracker.critical_step(q, Integrator::kExplicit, modes), low, 0.03 * low);
      }
    }
  }
}

// In the units of size, modulus and density the limit is the same for all bodies.
TEST(StabilityLimit, FromMicrometresToKilometres) {
  const auto limit_of = [](double size, double modulus) {
    TetMesh mesh = small_block({6, 4, 3});
    for (Vector3& x : mesh.vertices.own()) x *= size;
    const LameParameters lame = lame_from_young(modulus, 0.3);
    MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
    system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
    return stability_limit(system, system.rest_state().position).omega_max * size /
           std::sqrt(modulus / 1000.0);
  };
  const double expected = limit_of(1.0, 1e6);
  for (const double size : {1e-6, 1e3}) {
    for (const double modulus : {1e-10, 1e12}) {
      EXPECT_NEAR(limit_of(size, modulus), expected, 1e-3 * expected) << size << ' ' << modulus;
    }
  }
}

TEST(StabilityLimit, IsSetByTheSmallestElement) {
  TetMesh mesh = small_block();
  // Squeeze the last vertex into its neighbours.
  mesh.vertices.own().back() -= Vector3(0.45, 0.0, 0.0);
  const MechanicalSystem regular(small_block(), all_materials()[1], 1000.0);
  const MechanicalSystem squeezed(mesh, all_materials()[1], 1000.0);
  const StabilityLimit limit = stability_limit(squeezed, squeezed.rest_state().position);
  EXPECT_LT(limit.critical_step,
            0.7 * stability_limit(regular, regular.rest_state().position).critical_step);
  const auto& nodes = squeezed.rest().nodes(limit.element);
  EXPECT_NE(std::find(nodes.begin(), nodes.end(), squeezed.vertex_count() - 1), nodes.end());
}

TEST(StabilityLimit, NeitherUsesNorDependsOnTheProgramsRandomNumbers) {
  const MechanicalSystem system(small_block({6, 4, 3}), all_materials()[1], 1000.0);
  const Vector q = jiggled(system.rest_state().position, 0.01);
  std::srand(1);
  const int expected = std::rand();
  std::srand(1);
  const StabilityLimit first = stability_limit(system, q);
  EXPECT_EQ(std::rand(), expected);
  EXPECT_EQ(stability_limit(system, q).omega_max, first.omega_max);
}

TEST(StabilityLimit, IsNoneWhereEveryVertexIsHeld) {
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  system.set_constraints(hold(system.mesh(), SelectAll{}));
  system.set_damping({1.0, 1.0, 1.0});
  const StabilityLimit limit = stability_limit(system, system.rest_state().position);
  EXPECT_TRUE(std::isinf(limit.critical_step));
  EXPECT_EQ(limit.omega_max, 0.0);
  EXPECT_EQ(limit.element, -1);
}

// The spectral radius of a step about rest, by differences of the step itself: what really decides. In
// q and p/(mω), so that all numbers are of one size.
double spectral_radius(const MechanicalSystem& system, Integrator rule, double h, double omega) {
  const auto stepper =
      rule == Integrator::kVerlet ? make_verlet_stepper(system) : make_explicit_stepper(system);
  constexpr double kDifference = 1e-7;
  std::vector<Index> free;
  for (Index i = 0; i < system.dof_count(); ++i) {
    if (system.coordinates().is_free(i / 3)) free.push_back(i);
  }
  const auto n = static_cast<Index>(free.size());
  Matrix step(2 * n, 2 * n);
  for (Index j = 0; j < 2 * n; ++j) {
    Vector change = Vector::Zero(2 * n);
    for (const double sign : {1.0, -1.0}) {
      State state = system.rest_state();
      const Index dof = free[static_cast<std::size_t>(j % n)];
      (j < n ? state.position : state.momentum)[dof] +=
          sign * kDifference * (j < n ? 1.0 : system.mass()[dof / 3] * omega);
      stepper->reset();
      const StepOutcome outcome = stepper->step(state, h);
      // A step in which damping would give energy is refused: that is unstable, too.
      if (outcome.status == StepStatus::kOverdamped) return std::numeric_limits<double>::infinity();
      EXPECT_TRUE(outcome.ok());
      for (Index i = 0; i < n; ++i) {
        const Index k = free[static_cast<std::size_t>(i)];
        change[i] += sign * (state.position[k] - system.rest_state().position[k]);
        change[n + i] += sign * state.momentum[k] / (system.mass()[k / 3] * omega);
      }
    }
    step.col(j) = change / (2.0 * kDifference);
  }
  return step.eigenvalues().cwiseAbs().maxCoeff();
}

// From no damping to damping that has all the say: 0.98 h_crit is stable and 1.05 h_crit is not. Where
// frequency and damping rate both count, verlet's limit is up to 7 % on the safe side.
TEST(StabilityLimit, IsWhereStepsBecomeUnstableWithAnyDamping) {
  const LameParameters lame = lame_from_young(1e6, 0.4);
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    for (const Damping& damping : {Damping{0, 0, 0}, Damping{0, 0, 100}, Damping{0, 0, 1e3},
                                   Damping{0, 0, 1e4}, Damping{0, 0, 1e6}, Damping{0, 100, 0},
                                   Damping{3e3, 0, 0}, Damping{1e6, 0, 0}, Damping{1e3, 50, 2e3}}) {
      MechanicalSystem system(small_block({2, 1, 1}), NeoHookean(lame.mu, lame.lambda), 1000.0);
      system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
      system.set_damping(damping);
      const StabilityLimit limit = stability_limit(system, system.rest_state().position, rule);
      SCOPED_TRACE(::testing::Message()
                   << (rule == Integrator::kVerlet ? "verlet" : "explicit") << ", viscosity "
                   << damping.viscosity << ", drag " << damping.drag << ", mass damping "
                   << damping.mass_damping << ", h c " << limit.critical_step * limit.damping_rate);
      const auto radius = [&](double share) {
        return spectral_radius(system, rule, share * limit.critical_step, limit.omega_max);
      };
      EXPECT_LT(radius(0.98), 1.0 + 1e-6);
      const double rate = limit.critical_step * limit.damping_rate;
      const bool mixed = rule == Integrator::kVerlet && rate > 0.1 && rate < 3.0;
      EXPECT_GT(radius(mixed ? 1.12 : 1.05), 1.01);
    }
  }
}

TEST(StabilityLimit, OfOneModeIsThatOfItsPolynomial) {
  EXPECT_EQ(explicit_critical_step(10.0, 0.0), 0.2);
  EXPECT_EQ(verlet_critical_step(10.0, 0.0), 0.2);
  EXPECT_NEAR(explicit_critical_step(0.0, 10.0), 0.2, 1e-15);
  EXPECT_NEAR(verlet_critical_step(0.0, 10.0), 0.30873780253841524, 1e-12);
  EXPECT_TRUE(std::isinf(explicit_critical_step(0.0, 0.0)));
  EXPECT_TRUE(std::isinf(verlet_critical_step(0.0, 0.0)));
  for (const double rate : {1.0, 10.0, 20.0, 30.0, 100.0, 1e4}) {
    const double h = explicit_critical_step(10.0, rate);
    EXPECT_NEAR(h * h * 100.0 + 2.0 * h * rate, 4.0, 1e-12);
    EXPECT_GE(verlet_critical_step(10.0, rate), h);
  }
}

// Pressed to a fraction of its height in many small steps of the positions, from the modes of each for the
// next.
TEST(StabilityTracker, FollowsABodyThatIsCrushed) {
  const LameParameters lame = lame_from_young(1e6, 0.45);
  for (const double viscosity : {0.0, 1e3}) {
    for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
      for (const bool custom : {false, true}) {
        const NeoHookean material(lame.mu, lame.lambda);
        MechanicalSystem system(
            small_block({4, 3, 3}),
            custom ? MaterialModel(CustomMaterial(material)) : MaterialModel(material), 1000.0);
        system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
        system.set_damping({0.0, 0.0, viscosity});
        const Vector rest = system.rest_state().position;
        StabilityTracker tracker(system);
        CriticalModes modes;
        stability_limit(system, rest, rule, &modes);
        const Vector noise = jiggled(Vector::Zero(rest.size()), 0.02);
        for (int k = 1; k <= 20; ++k) {
          Vector q = rest + (0.05 * k) * noise;
          for (Index v = 0; v < system.vertex_count(); ++v) {  // more and more at the far end
            const double x = rest[3 * v];
            q[3 * v] -= 0.02 * k * x * x;
          }
          const double exact = stability_limit(system, q, rule).critical_step;
          const double followed = tracker.critical_step(q, rule, modes);
          EXPECT_LT(followed, 1.05 * exact) << k;
          EXPECT_GT(followed, 0.98 * exact) << k;
        }
      }
    }
  }
}

// A part becomes stiff where the last mode does not move.
TEST(StabilityTracker, FindsAnElementThatIsFlattenedFarAway) {
  const LameParameters lame = lame_from_young(1e6, 0.3);
  MechanicalSystem system(small_block({12, 3, 3}), NeoHookean(lame.mu, lame.lambda), 1000.0);
  Vector q = system.rest_state().position;
  q[0] += 0.12;  // a corner, against its neighbours
  StabilityTracker tracker(system);
  CriticalModes modes;
  stability_limit(system, q, Integrator::kExplicit, &modes);
  q[0] -= 0.12;
  const Index last = system.dof_count() - 3;
  q[last] -= 0.14;
  const double exact = stability_limit(system, q).critical_step;
  EXPECT_NEAR(tracker.critical_step(q, Integrator::kExplicit, modes), exact, 0.03 * exact);
  EXPECT_LT(tracker.cost(), 40.0);
}

}  // namespace
}  // namespace tetraction
