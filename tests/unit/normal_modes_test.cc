// Normal modes against all eigenvalues of dense matrices.
#include "tetraction/solver/normal_modes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "support/bodies.h"
#include "support/scene_parts.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kDensity = 1000.0;

std::unique_ptr<MechanicalSystem> make_body(TetMesh mesh, double youngs_modulus = 1e6) {
  const LameParameters lame = lame_from_young(youngs_modulus, 0.3);
  return std::make_unique<MechanicalSystem>(std::move(mesh), NeoHookean(lame.mu, lame.lambda),
                                            kDensity);
}

// Blocks of one mesh beside each other, which do not touch.
TetMesh separate_blocks(int count, const Vector3& size, const std::array<int, 3>& cells) {
  const TetMesh block = generate_box(size, cells);
  RawMesh raw;
  raw.source = "separate blocks";
  for (int k = 0; k < count; ++k) append_body(raw, block, Vector3(0.0, 2.0 * size.y() * k, 0.0));
  return build_mesh(std::move(raw));
}

// All ω² of the problem from dense matrices, ascending. K is computed by products of the elastic
// potential and the terms, T column by column, and motions that the equations do not allow are taken
// out by a basis of the others.
Vector dense_frequencies_squared(const MechanicalSystem& system, const Vector& q,
                                 const Vector& multipliers = {}) {
  const FreeCoordinates& coordinates = system.coordinates();
  const Index n = coordinates.count();
  HessianBlocks terms;
  terms.reset(system.vertex_count());
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) {
      term->add_hessian(system.force_point(q, 0.0), HessianForm::kExact, terms);
    }
  }
  Matrix k(n, n);
  Matrix m(n, n);
  for (Index j = 0; j < n; ++j) {
    const Vector u = coordinates.extend(Vector::Unit(n, j));
    Vector product;
    system.elastic().product(q, u, product);
    terms.add_product(u, product);
    k.col(j) = coordinates.restrict(product);
    m.col(j) = coordinates.restrict(system.momentum_of(u));
  }
  const Constraints& constraints = system.constraints();
  if (constraints.has_equations()) {
    if (multipliers.size() > 0) {
      k += constraints.selector() * constraints.curvature(multipliers) *
           constraints.selector().transpose();
    }
    const Matrix gradients =
        constraints.selector() * constraints.gradients(constraints.configuration(q));
    const Eigen::ColPivHouseholderQR<Matrix> qr(gradients);
    const Matrix basis = qr.householderQ();
    const Matrix allowed = basis.rightCols(n - qr.rank());
    k = allowed.transpose() * k * allowed;
    m = allowed.transpose() * m * allowed;
  }
  k = 0.5 * (k + Matrix(k.transpose()));
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix>(k, m, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

// Compares the lowest `count` modes with the dense ones. Zero eigenvalues of the dense problem have
// round-off; those of rigid modes must be exactly zero. Also checks that shapes are mass-normalised
// and orthogonal.
void expect_dense_modes(const MechanicalSystem& system, const Vector& q, Index count,
                        const Vector& multipliers = {}) {
  const Vector expected = dense_frequencies_squared(system, q, multipliers);
  NormalModeOptions options;
  options.count = count;
  options.multipliers = multipliers;
  const NormalModes found = normal_modes(system, q, options);
  ASSERT_EQ(found.total, expected.size());
  ASSERT_EQ(static_cast<Index>(found.modes.size()), std::min(count, expected.size()));
  const double largest = expected.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < found.modes.size(); ++i) {
    const NormalMode& mode = found.modes[i];
    const double value = expected[static_cast<Index>(i)];
    if (mode.kind == ModeKind::kRigid) {
      EXPECT_EQ(mode.omega_squared, 0.0);
      EXPECT_LT(std::abs(value), 1e-12 * largest) << "mode " << i;
    } else {
      EXPECT_NEAR(mode.omega_squared, value, 1e-10 * std::abs(value)) << "mode " << i;
      EXPECT_EQ(mode.kind, value > 0.0 ? ModeKind::kElastic : ModeKind::kUnstable);
    }
    const Vector momentum = system.momentum_of(mode.shape);
    for (std::size_t j = 0; j <= i; ++j) {
      EXPECT_NEAR(momentum.dot(found.modes[j].shape), i == j ? 1.0 : 0.0, 1e-9) << i << ' ' << j;
    }
  }
}

Index rigid_count(const NormalModes& modes) {
  return std::count_if(modes.modes.begin(), modes.modes.end(),
                       [](const NormalMode& mode) { return mode.kind == ModeKind::kRigid; });
}

PrescribedVertices hold_where(const TetMesh& mesh, const Selection& selection) {
  return prescribe_at_rest(mesh, select_vertices(mesh, selection), "hold");
}

// 45 vertices are solved with dense matrices, 140 vertices by Lanczos iterations.
class Meshes : public testing::TestWithParam<std::array<int, 3>> {
 protected:
  TetMesh mesh() const {
    TetMesh mesh = generate_box({2, 1, 0.8}, GetParam());
    const Vector moved = jiggled(mesh.rest_positions(), 0.02);
    RawMesh raw;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      raw.vertices.push_back(moved.segment<3>(3 * v));
      raw.vertex_ids.push_back(v);
    }
    for (const auto t : mesh.tetrahedra) {
      RawCell cell;
      cell.type = CellType::kTetrahedron;
      cell.id = static_cast<std::int64_t>(raw.cells.size());
      cell.vertices = {t[0], t[1], t[2], t[3]};
      raw.cells.push_back(cell);
    }
    return build_mesh(std::move(raw));
  }
};

INSTANTIATE_TEST_SUITE_P(NormalModes, Meshes,
                         testing::Values(std::array<int, 3>{4, 2, 2}, std::array<int, 3>{6, 4, 3}));

TEST_P(Meshes, FreeBody) {
  const auto system = make_body(mesh());
  expect_dense_modes(*system, system->rest_state().position, 20);
  NormalModeOptions options;
  options.count = 20;
  const NormalModes modes = normal_modes(*system, system->rest_state().position, options);
  EXPECT_EQ(rigid_count(modes), 6);
  // The translations along x, y and z come first.
  for (int d = 0; d < 3; ++d) {
    const Vector3 mass = modes.modes[static_cast<std::size_t>(d)].effective_mass;
    EXPECT_NEAR(mass[d], system->total_mass(), 1e-12 * system->total_mass());
  }
}

TEST_P(Meshes, ClampedBody) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  const Selection end = SelectBox{{-0.1, -1, -1}, {0.1, 2, 2}};
  system->set_constraints(Constraints({{hold_where(box, end)}, {}, {}, {}}, box, system->mass()));
  expect_dense_modes(*system, system->rest_state().position, 20);
  // A strained state is as good as any other positions.
  expect_dense_modes(*system, 1.05 * system->rest_state().position, 20);
}

TEST_P(Meshes, GuidedBody) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  const auto guided = [&](const Selection& selection, const Matrix& directions) {
    GuidedVertices guide;
    guide.vertices = select_vertices(box, selection);
    guide.directions = directions;
    guide.points = Matrix(3, static_cast<Index>(guide.vertices.size()));
    for (Index i = 0; i < guide.points.cols(); ++i) {
      guide.points.col(i) =
          box.vertices[static_cast<std::size_t>(guide.vertices[static_cast<std::size_t>(i)])];
    }
    guide.name = "guide";
    return guide;
  };
  Matrix plane(3, 2);
  plane.col(0) = Vector3(1, 1, 0).normalized();
  plane.col(1) = Vector3(0, 0, 1);
  const Selection low = SelectBox{{-0.1, -1, -1}, {0.1, 2, 2}};
  const Selection high = SelectBox{{1.9, -1, -1}, {2.1, 2, 2}};
  system->set_constraints(Constraints({{}, {guided(low, plane)}, {}, {}}, box, system->mass()));
  expect_dense_modes(*system, system->rest_state().position, 15);
  EXPECT_EQ(rigid_count(normal_modes(*system, system->rest_state().position)), 3);

  const Matrix line = Vector3(0, 0, 1);
  system->set_constraints(
      Constraints({{}, {guided(low, plane), guided(high, line)}, {}, {}}, box, system->mass()));
  expect_dense_modes(*system, system->rest_state().position, 15);
  EXPECT_EQ(rigid_count(normal_modes(*system, system->rest_state().position)), 1);
}

TEST_P(Meshes, SpringsHoldTheBody) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  PrescribedVertices springs = hold_where(box, SelectAll{});
  springs.penalty = 3000.0;
  system->set_constraints(Constraints({{springs}, {}, {}, {}}, box, system->mass()));
  expect_dense_modes(*system, system->rest_state().position, 15);
  EXPECT_EQ(rigid_count(normal_modes(*system, system->rest_state().position)), 0);
}

TEST_P(Meshes, AttractionIsPartOfTheStiffness) {
  const auto system = make_body(mesh());
  system->set_environment(Environment::attraction(5e5, 0.5));
  expect_dense_modes(*system, system->rest_state().position, 15);
}

TEST_P(Meshes, HandlesAndDistances) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  const Vector q = system->rest_state().position;
  RigidHandle handle;
  handle.vertices = select_vertices(box, SelectBox{{1.9, -1, -1}, {2.1, 2, 2}});
  handle.shape = Matrix(3, static_cast<Index>(handle.vertices.size()));
  for (Index i = 0; i < handle.shape.cols(); ++i) {
    handle.shape.col(i) = q.segment<3>(3 * handle.vertices[static_cast<std::size_t>(i)]);
  }
  handle.name = "handle";
  const auto distance = [&](Index a, Index b) {
    return FixedDistance{a, b, (q.segment<3>(3 * a) - q.segment<3>(3 * b)).norm(), "distance"};
  };
  // One distance is given twice.
  const ConstraintList list{{}, {}, {distance(0, 20), distance(3, 30), distance(0, 20)}, {handle}};
  system->set_constraints(Constraints(list, box, system->mass()));
  expect_dense_modes(*system, q, 20);
  EXPECT_EQ(rigid_count(normal_modes(*system, q)), 6);
  // With tensions, which turn against the body.
  const Vector tensions = 2e4 * jiggled(Vector::Zero(system->constraints().equation_count()), 1.0);
  expect_dense_modes(*system, q, 20, tensions);
}

TEST_P(Meshes, UnstableState) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  Vector q = system->rest_state().position;
  for (Index v = 0; v < box.vertex_count(); ++v) q[3 * v] *= 0.6;
  const NormalModes modes = normal_modes(*system, q);
  EXPECT_EQ(modes.modes.front().kind, ModeKind::kUnstable);
  EXPECT_GT(modes.modes.front().frequency(), 0.0);
  expect_dense_modes(*system, q, 15);
}

TEST_P(Meshes, EffectiveMassesOfAllModesAddUp) {
  const TetMesh box = mesh();
  const auto system = make_body(box);
  const Selection end = SelectBox{{-0.1, -1, -1}, {0.1, 2, 2}};
  system->set_constraints(Constraints({{hold_where(box, end)}, {}, {}, {}}, box, system->mass()));
  NormalModeOptions options;
  options.count = 100000;  // more than there are
  const NormalModes modes = normal_modes(*system, system->rest_state().position, options);
  ASSERT_EQ(static_cast<Index>(modes.modes.size()), system->coordinates().count());
  Vector3 sum = Vector3::Zero();
  for (const NormalMode& mode : modes.modes) sum += mode.effective_mass;
  double free = 0.0;
  for (Index v = 0; v < box.vertex_count(); ++v) {
    if (system->coordinates().is_free(v)) free += system->mass()[v];
  }
  for (int d = 0; d < 3; ++d) {
    EXPECT_NEAR(modes.moved_mass[d], free, 1e-12 * free);
    EXPECT_NEAR(sum[d], free, 1e-10 * free);
  }
}

// Three equal bodies have every frequency three times.
TEST(NormalModes, MultipleEigenvaluesAreFoundInFull) {
  const TetMesh mesh = separate_blocks(3, {1, 0.2, 0.2}, {10, 2, 2});
  const auto system = make_body(mesh);
  system->set_constraints(
      Constraints({{hold_where(mesh, SelectPlane{0, 0.0, {}})}, {}, {}, {}}, mesh, system->mass()));
  NormalModeOptions options;
  options.count = 15;
  const NormalModes modes = normal_modes(*system, system->rest_state().position, options);
  const Vector expected = dense_frequencies_squared(*system, system->rest_state().position);
  for (Index i = 0; i < options.count; ++i) {
    const double value = modes.modes[static_cast<std::size_t>(i)].omega_squared;
    EXPECT_NEAR(value, expected[i], 1e-10 * expected[i]);
    EXPECT_NEAR(value, modes.modes[static_cast<std::size_t>(3 * (i / 3))].omega_squared,
                1e-10 * value);
  }
}

TEST(NormalModes, EveryPartHasItsRigidMotions) {
  const TetMesh mesh = separate_blocks(2, {1, 0.2, 0.2}, {6, 2, 2});
  const auto system = make_body(mesh);
  const Vector q = system->rest_state().position;
  NormalModeOptions options;
  options.count = 20;
  EXPECT_EQ(rigid_count(normal_modes(*system, q, options)), 12);
  // A rod of fixed length between the two bodies takes one motion.
  const Index b = mesh.vertex_count() / 2;
  const double length = (q.segment<3>(0) - q.segment<3>(3 * b)).norm();
  system->set_constraints(
      Constraints({{}, {}, {FixedDistance{0, b, length, "rod"}}, {}}, mesh, system->mass()));
  EXPECT_EQ(rigid_count(normal_modes(*system, q, options)), 11);
}

// A body that is held at two vertices can turn about the line through them.
TEST(NormalModes, AHingeIsARigidMode) {
  const TetMesh mesh = generate_box({1, 0.5, 0.5}, {6, 3, 3});
  const auto system = make_body(mesh);
  const Index other = select_vertices(mesh, SelectNearest{{0, 0, 0.5}}).front();
  PrescribedVertices held = prescribe_at_rest(mesh, {0, other}, "hinge");
  system->set_constraints(Constraints({{held}, {}, {}, {}}, mesh, system->mass()));
  const NormalModes modes = normal_modes(*system, system->rest_state().position);
  EXPECT_EQ(rigid_count(modes), 1);
  const Vector& shape = modes.modes.front().shape;
  for (Index v = 0; v < mesh.vertex_count(); ++v) EXPECT_NEAR(shape[3 * v + 2], 0.0, 1e-12);
}

// Frequencies of bodies of the same material are inversely proportional to the size.
TEST(NormalModes, FromNanometresToKilometres) {
  const auto frequencies = [](double scale) {
    const TetMesh mesh = generate_box(scale * Vector3(4, 1, 1), {12, 3, 3});
    const auto system = make_body(mesh, 2e11);
    std::vector<double> result;
    NormalModeOptions options;
    options.count = 16;
    const NormalModes modes = normal_modes(*system, system->rest_state().position, options);
    EXPECT_EQ(rigid_count(modes), 6);
    for (const NormalMode& mode : modes.modes) result.push_back(mode.frequency() * scale);
    return result;
  };
  const std::vector<double> metre = frequencies(1.0);
  for (const double scale : {1e-9, 1e3}) {
    const std::vector<double> other = frequencies(scale);
    for (std::size_t i = 0; i < metre.size(); ++i) EXPECT_NEAR(other[i], metre[i], 1e-9 * metre[i]);
  }
}

// A clamped beam with a rod, or with a rigid plate at its end, without and with forces in them. In the units of
// its size, modulus and density the frequencies are the same for all bodies: those of the dense problem of one
// body.
TEST(NormalModes, ConstraintsFromMicrometresToKilometres) {
  struct Case {
    bool plate;
    double force;  // in them, relative to E s²
  };
  for (const Case& c : {Case{false, 0.0}, {false, 2e-3}, {true, 0.0}, {true, 2e-3}}) {
    const auto make = [&](double scale, double youngs_modulus) {
      const TetMesh mesh = generate_box(scale * Vector3(4, 1, 1), {6, 2, 2});
      auto system = make_body(mesh, youngs_modulus);
      const Vector q = mesh.rest_positions();
      ConstraintList list;
      list.held = {hold_where(mesh, SelectPlane{0, 0.0, {}})};
      if (c.plate) {
        RigidHandle plate;
        plate.vertices = select_vertices(mesh, SelectPlane{0, 4.0 * scale, {}});
        plate.shape = Matrix(3, static_cast<Index>(plate.vertices.size()));
        for (Index i = 0; i < plate.shape.cols(); ++i) {
          plate.shape.col(i) = q.segment<3>(3 * plate.vertices[static_cast<std::size_t>(i)]);
        }
        list.handles = {plate};
      } else {
        list.distances = {FixedDistance{0, 6, 4.0 * scale, "rod"}};
      }
      system->set_constraints(Constraints(list, mesh, system->mass()));
      return system;
    };
    const auto multipliers = [&](const MechanicalSystem& system, double scale, double modulus) {
      const Index count = system.constraints().equation_count();
      const double energy = c.force * modulus * scale * scale * scale;
      return Vector(energy * jiggled(Vector::Ones(count), 0.5));
    };
    const auto metre = make(1.0, 1e6);
    const Vector expected = dense_frequencies_squared(*metre, metre->rest_state().position,
                                                      multipliers(*metre, 1.0, 1e6)) /
                            1e6;
    for (const double scale : {1e-6, 1e-4, 1.0, 1e3}) {
      for (const double modulus : {1e-10, 1e6, 2e11, 1e12}) {
        const auto system = make(scale, modulus);
        NormalModeOptions options;
        options.count = 12;
        options.multipliers = multipliers(*system, scale, modulus);
        const NormalModes found = normal_modes(*system, system->rest_state().position, options);
        for (std::size_t i = 0; i < 12; ++i) {
          const double value = found.modes[i].omega_squared * scale * scale / modulus;
          const double exact = expected[static_cast<Index>(i)];
          EXPECT_NEAR(value, exact, 1e-8 * exact) << scale << ' ' << modulus << ' ' << i;
        }
      }
    }
  }
}

// A clamped block that a rod stiffens, under a large weight and a force: the multipliers balance what
// the elements and the loads leave, and the modes about this equilibrium are those of the dense
// problem with the geometric stiffness of the rod.
TEST(NormalModes, AboutAnEquilibriumWithADistance) {
  const TetMesh mesh = generate_box({2, 0.5, 0.5}, {6, 2, 2});
  const auto system = make_body(mesh);
  const Index a = select_vertices(mesh, SelectNearest{{2.0, 0.5, 0.0}}).front();
  const Index b = select_vertices(mesh, SelectNearest{{1.0, 0.5, 0.5}}).front();
  const Vector rest = mesh.rest_positions();
  const double length = (rest.segment<3>(3 * a) - rest.segment<3>(3 * b)).norm();
  system->set_constraints(Constraints(
      {{hold_where(mesh, SelectPlane{0, 0.0, {}})}, {}, {FixedDistance{a, b, length, "rod"}}, {}},
      mesh, system->mass()));
  system->set_environment(Environment::uniform({0.0, -5.0, 0.0}));
  ExternalForce pull;
  pull.vertices = {a};
  pull.vector = {0.0, 0.0, 200.0};
  system->add_force(pull);
  const Equilibrium equilibrium = find_equilibrium(*system);
  ASSERT_TRUE(equilibrium.found) << equilibrium.message;
  const Vector& q = equilibrium.position;
  const Vector multipliers = balancing_multipliers(*system, q, equilibrium.load);
  ASSERT_EQ(multipliers.size(), 1);
  EXPECT_GT(std::abs(multipliers[0]), 1.0);

  double energy = 0.0;
  Vector force;
  ASSERT_TRUE(system->elastic().value_and_gradient(q, energy, force).ok());
  for (const ForceTerm* term : system->force_terms()) {
    if (term->has_potential()) term->add_gradient(system->force_point(q, 0.0), force);
  }
  const Constraints& constraints = system->constraints();
  const Vector rod =
      constraints.selector() * (constraints.gradients(constraints.configuration(q)) * multipliers);
  const Vector others = system->coordinates().restrict(force - equilibrium.load);
  EXPECT_LT((others + rod).norm(), 1e-7 * rod.norm());

  expect_dense_modes(*system, q, 10, multipliers);
}

// For ν = 0 the damping matrix is aM + βK + drag: ζ = (a + k_D φᵀφ)/(2ω) + βω/2 for every mode.
TEST(NormalModes, DampingRatios) {
  const TetMesh mesh = generate_box({2, 0.5, 0.5}, {6, 2, 2});
  const LameParameters lame = lame_from_young(1e6, 0.0);
  MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), kDensity);
  const Vector q = mesh.rest_positions();
  for (const NormalMode& mode : normal_modes(system, q).modes) EXPECT_EQ(mode.damping_ratio, 0.0);
  system.set_damping({0.0, 0.0, 2e-3 * lame.mu});
  for (const NormalMode& mode : normal_modes(system, q).modes) {
    if (mode.kind == ModeKind::kRigid) {
      EXPECT_EQ(mode.damping_ratio, 0.0) << "viscosity does not damp rigid motions";
    }
  }
  system.set_damping({0.03, 0.7, 2e-3 * lame.mu});
  Index elastic = 0;
  for (const NormalMode& mode : normal_modes(system, q).modes) {
    if (mode.kind == ModeKind::kRigid) {
      EXPECT_EQ(mode.damping_ratio, std::numeric_limits<double>::infinity());
      continue;
    }
    ++elastic;
    const double omega = std::sqrt(mode.omega_squared);
    const double expected =
        (0.7 + 0.03 * mode.shape.squaredNorm()) / (2.0 * omega) + 2e-3 * omega / 2.0;
    EXPECT_NEAR(mode.damping_ratio, expected, 1e-9 * expected);
  }
  EXPECT_EQ(elastic, 4);
}

// Modes with the stiffness of the forces on the free rim of a pressure against all eigenvalues of the dense
// matrix, which is not symmetric. A strong pressure on the tip lets pairs of modes flutter.
TEST(NormalModes, UnderAPressureWithAFreeRim) {
  const TetMesh mesh = generate_box({4, 1, 0.5}, {8, 2, 1});
  Index fluttering = 0;
  for (const double pressure : {-3e3, 1e4, 1e5}) {
    const auto system = make_body(mesh);
    system->set_constraints(hold(mesh, SelectPlane{0, 0.0, {}}));
    system->set_pressures({{select_triangles(mesh, SelectPlane{0, 4.0, {}}), pressure, {}}});
    Vector q = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) q[3 * v] *= 1.0 - pressure / 1e6;
    const FreeCoordinates& coordinates = system->coordinates();
    const Index n = coordinates.count();
    HessianBlocks terms;
    terms.reset(system->vertex_count());
    for (const ForceTerm* term : system->force_terms()) {
      if (!term->has_potential()) continue;
      term->add_hessian(system->force_point(q, 0.0), HessianForm::kExact, terms);
    }
    Matrix matrix(n, n);
    for (Index j = 0; j < n; ++j) {
      const Vector u = coordinates.extend(Vector::Unit(n, j));
      Vector product;
      system->elastic().product(q, u, product);
      terms.add_product(u, product);
      const Vector ahead = q + 0.5 * u;
      const Vector behind = q - 0.5 * u;
      Vector forward;
      Vector backward;
      system->external_force(system->force_point(ahead, 0.0), forward);
      system->external_force(system->force_point(behind, 0.0), backward);
      matrix.col(j) = coordinates.restrict(product - (forward - backward));
    }
    const Vector mass = coordinates.reduced_mass(system->mass());
    Eigen::VectorXcd expected =
        Eigen::EigenSolver<Matrix>(mass.cwiseInverse().asDiagonal() * matrix, false).eigenvalues();
    std::sort(expected.begin(), expected.end(),
              [](const auto& a, const auto& b) { return a.real() < b.real(); });
    NormalModeOptions options;
    options.count = 8;
    options.with_loads = true;
    const NormalModes found = normal_modes(*system, q, options);
    ASSERT_GE(found.modes.size(), 8U);
    for (std::size_t i = 0; i < 8; ++i) {
      const NormalMode& mode = found.modes[i];
      const std::complex<double> value = expected[static_cast<Index>(i)];
      EXPECT_NEAR(system->momentum_of(mode.shape).dot(mode.shape), 1.0, 1e-9);
      if (mode.kind == ModeKind::kFlutter) {
        ++fluttering;
        const std::complex<double> omega = std::sqrt(value);
        EXPECT_NEAR(mode.omega_squared, omega.real() * omega.real(), 1e-6 * std::abs(value));
        EXPECT_NEAR(mode.growth_rate, std::abs(omega.imag()), 1e-6 * std::abs(omega)) << i;
      } else {
        EXPECT_LT(std::abs(value.imag()), 1e-6 * std::abs(value)) << i << ' ' << pressure;
        EXPECT_NEAR(mode.omega_squared, value.real(), 1e-6 * std::abs(value))
            << i << ' ' << pressure;
      }
    }
  }
  EXPECT_GE(fluttering, 2);
}

// A wire or sheet of quadratic elements of 1 m length that is clamped at x = 0, or free.
struct SlenderBody {
  TetMesh mesh;
  MechanicalSystem system;

  SlenderBody(const Vector3& size, const std::array<int, 3>& cells, bool clamped,
              double youngs_modulus = 1e9)
      : mesh(with_edge_vertices(generate_box(size, cells))),
        system(mesh,
               NeoHookean(lame_from_young(youngs_modulus, 0.0).mu,
                          lame_from_young(youngs_modulus, 0.0).lambda),
               kDensity) {
    if (!clamped) return;
    system.set_constraints(Constraints({{hold_where(mesh, SelectPlane{0, 0.0, {}})}, {}, {}, {}},
                                       mesh, system.mass()));
  }
  NormalModes modes(Index count) const {
    NormalModeOptions options;
    options.count = count;
    return normal_modes(system, system.rest_state().position, options);
  }
};

// The bending frequencies of a wire of 1 m with a square section, in the order of (βL)².
double wire_frequency(double thickness, double factor) {
  return factor / (2.0 * std::numbers::pi) * thickness / std::sqrt(12.0) * std::sqrt(1e9 / 1e3);
}

// The lowest frequency of a thin wire is so low that its square is below the round-off of the entries
// of the stiffness matrix. It is no rigid mode for that, and its digits are in the strains.
TEST(SlenderBodies, WiresHaveTheFrequenciesOfBeams) {
  for (const double thickness : {1e-2, 1e-3, 3e-4, 1e-4}) {
    const SlenderBody wire({1.0, thickness, thickness}, {40, 1, 1}, true);
    const NormalModes modes = wire.modes(6);
    EXPECT_EQ(rigid_count(modes), 0) << thickness;
    for (std::size_t i = 0; i < 6; ++i) {
      const double factor = std::array{3.516015, 22.03449, 61.69721}[i / 2];
      const double expected = wire_frequency(thickness, factor);
      EXPECT_EQ(modes.modes[i].kind, ModeKind::kElastic);
      EXPECT_NEAR(modes.modes[i].frequency(), expected, 3e-3 * expected) << thickness << ' ' << i;
      EXPECT_LT(modes.modes[i].round_off, 1e-3);
    }
    if (thickness > 2e-4) {
      EXPECT_EQ(round_off_warning(modes), "");
    }
  }
}

TEST(SlenderBodies, AFreeWireHasSixRigidModes) {
  for (const double thickness : {1e-2, 3e-4, 1e-4}) {
    const SlenderBody wire({1.0, thickness, thickness}, {40, 1, 1}, false);
    const NormalModes modes = wire.modes(10);
    EXPECT_EQ(rigid_count(modes), 6) << thickness;
    for (std::size_t i = 6; i < 10; ++i) {
      const double expected = wire_frequency(thickness, i < 8 ? 22.37329 : 61.67282);
      EXPECT_NEAR(modes.modes[i].frequency(), expected, 5e-3 * expected) << thickness << ' ' << i;
    }
  }
}

// A wire that is held at one vertex spins about itself in all its motions, fast beside its bending. At rest
// this must meet no stress, wherever the wire lies, not even stress of the round-off of F.
TEST(SlenderBodies, AHingedWireSpinsWithoutStress) {
  const auto frequencies = [](double thickness) {
    TetMesh mesh = generate_box({1.0, thickness, 1.3 * thickness}, {50, 1, 1});
    const Matrix3 rotation =
        Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vector3& x : mesh.vertices.own()) x = rotation * x + Vector3(3, -2, 1);
    mesh = with_edge_vertices(mesh);
    MechanicalSystem system(mesh, NeoHookean(4e8, 3e8), kDensity);
    const PrescribedVertices hinge = hold_where(mesh, SelectVertices{{0}});
    system.set_constraints(Constraints({{hinge}, {}, {}, {}}, mesh, system.mass()));
    NormalModeOptions options;
    options.count = 6;
    const NormalModes modes = normal_modes(system, system.rest_state().position, options);
    EXPECT_EQ(rigid_count(modes), 3);
    EXPECT_EQ(round_off_warning(modes), "");
    std::vector<double> result;
    for (std::size_t i = 3; i < 6; ++i) {
      EXPECT_EQ(modes.modes[i].kind, ModeKind::kElastic) << thickness;
      result.push_back(modes.modes[i].frequency() / thickness);
    }
    return result;
  };
  const std::vector<double> thick = frequencies(1e-3);
  const std::vector<double> thin = frequencies(1e-4);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(thin[i], thick[i], 1e-3 * thick[i]) << i;
}

// Frequencies of a sheet are proportional to its thickness.
TEST(SlenderBodies, SheetsBendAtTheFrequenciesOfThickerOnes) {
  const auto lowest = [](double thickness) {
    const SlenderBody sheet({1.0, 1.0, thickness}, {8, 8, 1}, true);
    const NormalModes modes = sheet.modes(7);
    EXPECT_EQ(rigid_count(modes), 0) << thickness;
    return modes.modes.front().frequency() / thickness;
  };
  const double expected = lowest(1e-3);
  EXPECT_NEAR(expected, 161.5, 0.01 * 161.5);
  for (const double thickness : {1e-4, 3e-5}) {
    EXPECT_NEAR(lowest(thickness), expected, 1e-3 * expected) << thickness;
  }
}

// Where round-off takes the frequency itself, it is told. The kind stays right.
TEST(SlenderBodies, RoundOffThatSpoilsFrequenciesIsTold) {
  const SlenderBody wire({1.0, 1e-7, 1e-7}, {10, 1, 1}, true);
  const NormalModes modes = wire.modes(2);
  EXPECT_EQ(rigid_count(modes), 0);
  EXPECT_GT(modes.modes.front().round_off, 1e-4);
  EXPECT_NE(round_off_warning(modes).find("round-off"), std::string::npos);
  const SlenderBody block({1.0, 0.5, 0.5}, {2, 1, 1}, true);
  EXPECT_LT(block.modes(2).modes.front().round_off, 1e-12);
}

// Springs that are weak beyond the round-off of the elements hold a body all the same. The body is
// rigid beside them, so that its modulus does not matter.
TEST(SlenderBodies, WeakSpringsLeaveNoRigidMode) {
  const TetMesh mesh = generate_box({1, 0.5, 0.5}, {6, 3, 3});
  PrescribedVertices springs = hold_where(mesh, SelectAll{});
  springs.penalty = 1e-3;
  const auto modes_with = [&](double youngs_modulus) {
    const auto system = make_body(mesh, youngs_modulus);
    system->set_constraints(Constraints({{springs}, {}, {}, {}}, mesh, system->mass()));
    return normal_modes(*system, system->rest_state().position);
  };
  const NormalModes soft = modes_with(1e5);
  const NormalModes stiff = modes_with(1e12);
  EXPECT_EQ(rigid_count(stiff), 0);
  for (std::size_t i = 0; i < 6; ++i) {
    const NormalMode& mode = stiff.modes[i];
    EXPECT_LT(mode.omega_squared, 1e-2);
    EXPECT_LT(mode.round_off, 1e-2);
    EXPECT_NEAR(mode.frequency() / soft.modes[i].frequency(), 1.0, 1e-8 + mode.round_off) << i;
  }
  EXPECT_GT(stiff.modes[6].omega_squared, 1e6);
}

// A pressure all around a body gives its rigid motions no stiffness.
TEST(NormalModes, AFreeBodyUnderAPressureAllAroundKeepsItsRigidModes) {
  const TetMesh mesh = generate_box({1, 0.5, 0.5}, {4, 2, 2});
  const auto system = make_body(mesh);
  system->set_pressures({PressureLoad{boundary_faces(mesh), 2e4, {}}});
  // A uniform pressure compresses a cube uniformly: the stretch at which both forces are in balance.
  const Vector rest = mesh.rest_positions();
  double low = 0.9;
  double high = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    double energy = 0.0;
    Vector force;
    const Vector q = middle * rest;
    system->elastic_energy_and_gradient(q, energy, force);
    for (const ForceTerm* term : system->force_terms()) {
      if (term->has_potential()) term->add_gradient(system->force_point(q, 0.0), force);
    }
    (force.dot(rest) > 0.0 ? high : low) = middle;
  }
  NormalModeOptions options;
  options.with_loads = true;
  const NormalModes modes = normal_modes(*system, 0.5 * (low + high) * rest, options);
  EXPECT_EQ(rigid_count(modes), 6);
  EXPECT_EQ(modes.modes.back().kind, ModeKind::kElastic);
}

TEST(NormalModes, RefusesWhatHasNoModes) {
  const TetMesh mesh = small_block();
  const auto system = make_body(mesh);
  const Vector q = system->rest_state().position;
  NormalModeOptions none;
  none.count = 0;
  EXPECT_THROW(normal_modes(*system, q, none), InputError);
  Vector inverted = q;
  inverted[0] += 10.0;
  EXPECT_THROW(normal_modes(*system, inverted), InputError);
  system->set_constraints(hold(mesh, SelectAll{}));
  EXPECT_THROW(normal_modes(*system, q), InputError);
}

}  // namespace
}  // namespace tetraction
