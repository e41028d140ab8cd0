// The material battery (material_test.cc) runs on CustomMaterial too; here is what it does in a body.
#include "tetraction/material/custom_material.h"

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/fibre_rubber.h"
#include "support/runs.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {
namespace {

using namespace testing_support;

const LameParameters kLame = lame_from_young(1e5, 0.3);

// Counts its copies: a CustomMaterial makes none when it is copied.
struct Counted : NeoHookean {
  explicit Counted(int* count) : NeoHookean(kLame.mu, kLame.lambda), copies(count) {}
  Counted(const Counted& other) : NeoHookean(other), copies(other.copies) { ++*copies; }
  Counted(Counted&& other) noexcept : NeoHookean(other), copies(other.copies) {}
  Counted& operator=(const Counted&) = delete;
  Counted& operator=(Counted&&) = delete;
  ~Counted() = default;

  int* copies;
};

TEST(CustomMaterial, CopiesShareTheUsersObject) {
  int copies = 0;
  const CustomMaterial first(Counted(&copies), "counted", kLame);
  const int at_first = copies;
  const MaterialModel model = first;
  const MaterialModel again = model;  // NOLINT(performance-unnecessary-copy-initialization)
  EXPECT_EQ(copies, at_first);
  EXPECT_EQ(material_name(again), "counted");
  EXPECT_EQ(&std::get<CustomMaterial>(again).name(), &first.name());
}

TEST(CustomMaterial, TakesNameAndParametersOfTheTypeOrThoseGiven) {
  const NeoHookean neo(2.0, 3.0);
  EXPECT_EQ(CustomMaterial(neo).name(), "neo-hookean");
  EXPECT_EQ(CustomMaterial(neo).initial_lame().lambda, 3.0);
  EXPECT_EQ(CustomMaterial(neo, "mine", {5.0, 6.0}).name(), "mine");
  EXPECT_EQ(CustomMaterial(neo, "mine", {5.0, 6.0}).initial_lame().mu, 5.0);
  EXPECT_THROW(CustomMaterial(neo, "", {5.0, 6.0}), InputError);
}

// A textbook's formula that leaves out its constants, and one that is wrong at rest.
struct WithoutConstants : NeoHookean {
  WithoutConstants() : NeoHookean(kLame.mu, kLame.lambda) {}
  double energy_density(const Matrix3& f) const {
    return NeoHookean::energy_density(f) - 1e6 * kLame.mu;
  }
};
struct Inverted : NeoHookean {
  Inverted() : NeoHookean(kLame.mu, kLame.lambda) {}
  static bool admissible(const Matrix3& f) { return jacobian(f) < 0.0; }
};

TEST(CustomMaterial, EnergyCountsFromRest) {
  const CustomMaterial material{WithoutConstants()};
  EXPECT_EQ(material.energy_density(Matrix3::Identity()), 0.0);
  const Matrix3 f = Vector3(1.2, 0.9, 1.1).asDiagonal();
  EXPECT_NEAR(material.energy_density(f), NeoHookean(kLame.mu, kLame.lambda).energy_density(f),
              1e-9 * 1e6 * kLame.mu);
}

TEST(CustomMaterial, RefusesOneThatIsNotDefinedAtRest) {
  EXPECT_THROW(CustomMaterial{Inverted()}, InputError);
}

// Nothing becomes a material by accident.
static_assert(!std::is_convertible_v<NeoHookean, CustomMaterial>);
static_assert(!std::is_constructible_v<CustomMaterial, int>);
static_assert(!std::is_constructible_v<CustomMaterial, int, std::string, LameParameters>);

TEST(CustomMaterial, DerivativesAreExactInABody) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  for (const Vector3& a : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1, -2, 0.5)}) {
    const ElasticPotential potential(rest, CustomMaterial(FibreRubber(kLame, 1e5, 2.0, a)));
    const DerivativeErrors errors =
        check_derivatives(potential, strained_state(potential, mesh.rest_positions()));
    EXPECT_GT(errors.force_norm, 0.0);
    EXPECT_LT(errors.force, 1e-7);
    EXPECT_LT(errors.stiffness, 1e-7);
  }
}

TEST(CustomMaterial, AStiffnessThatJumpsIsComparedWithTheSideThatItBelongsTo) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  // Stretched across the fibres, all of them are at the jump.
  Vector across = mesh.rest_positions();
  for (Index v = 0; v < mesh.vertex_count(); ++v) across[3 * v + 1] *= 1.1;
  const auto errors_of = [&](double factor, const Vector& q) {
    const ElasticPotential potential(
        rest, CustomMaterial(TensionFibres(kLame, 1e5, Vector3::UnitX(), factor)));
    return check_derivatives(potential, q);
  };
  const DerivativeErrors right = errors_of(1.0, across);
  EXPECT_GT(right.force_norm, 0.0);
  EXPECT_LT(right.force, 1e-7);
  EXPECT_LT(right.stiffness,
            2e-5);  // differences to one side are of the first order in the step, 1e-5
  EXPECT_GT(right.jumps, mesh.tetrahedron_count());
  EXPECT_LT(errors_of(1.0, mesh.rest_positions()).stiffness, 2e-5);
  // A wrong formula is still found, at the jump and elsewhere.
  EXPECT_GT(errors_of(1.01, across).stiffness, 1e-4);
  EXPECT_GT(errors_of(1.01, 1.05 * across).stiffness, 1e-4);
  EXPECT_EQ(errors_of(1.0, 1.05 * across).jumps, 0);
}

// A law whose shear modulus depends on the place.
struct Graded {
  double (*shear_modulus)(const MaterialPlace&);
  StVenantKirchhoff at(const MaterialPlace& place) const { return {shear_modulus(place), 0.0}; }
};

// Under the same F everywhere the energy is μ E:E integrated over the body. The rules are exact for
// polynomials of degree 1 (linear elements) and 2 (quadratic ones).
TEST(PlacedMaterial, GetsTheRestPositionsOfTheQuadraturePoints) {
  const Matrix3 f = (Matrix3() << 1.1, 0.1, 0.0, 0.05, 0.9, 0.0, 0.0, -0.1, 1.05).finished();
  const Matrix3 e = 0.5 * (f.transpose() * f - Matrix3::Identity());
  const auto energy_of = [&](const TetMesh& mesh, double (*modulus)(const MaterialPlace&)) {
    const RestState rest(mesh);
    const ElasticPotential potential(rest, CustomMaterial(Graded{modulus}, "graded", {1.0, 0.0}));
    Vector q = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      vertex_block(q, v) = f * vertex_block(std::as_const(q), v);
    }
    double energy = 0.0;
    EXPECT_TRUE(potential.value(q, energy).ok());
    return energy / e.squaredNorm();
  };
  const auto linear = [](const MaterialPlace& at) { return 1.0 + at.position.x(); };
  const auto quadratic = [](const MaterialPlace& at) {
    return 1.0 + at.position.x() + at.position.y() * at.position.z();
  };
  EXPECT_NEAR(energy_of(small_block(), linear), 4.0, 1e-12);  // over 2 × 1 × 1 m
  EXPECT_NEAR(energy_of(with_edge_vertices(small_block()), quadratic), 4.5, 1e-12);
}

// A law by the number of the element.
struct ByElement {
  std::vector<NeoHookean> laws;
  const NeoHookean& at(const MaterialPlace& place) const {
    return laws[static_cast<std::size_t>(place.element)];
  }
};

TEST(PlacedMaterial, ByElementIsAFieldOfParameters) {
  for (const bool is_quadratic : {false, true}) {
    const TetMesh mesh = is_quadratic ? with_edge_vertices(small_block()) : small_block();
    const RestState rest(mesh);
    std::vector<IsotropicModel> models;
    ByElement law;
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      const double factor = 1.0 + 0.1 * static_cast<double>(e % 17);
      law.laws.emplace_back(factor * kLame.mu, factor * kLame.lambda);
      models.emplace_back(law.laws.back());
    }
    ElasticPotential field(rest, MaterialField(models));
    ElasticPotential placed(rest, CustomMaterial(law, "by element", kLame));
    const Vector q = jiggled(mesh.rest_positions(), 0.02);
    const Vector d = jiggled(Vector::Zero(q.size()), 1.0, 3);
    double expected = 0.0;
    double energy = 0.0;
    Vector expected_gradient;
    Vector gradient;
    ASSERT_TRUE(field.value_and_gradient(q, expected, expected_gradient).ok());
    ASSERT_TRUE(placed.value_and_gradient(q, energy, gradient).ok());
    EXPECT_NEAR(energy, expected, 1e-12 * expected);
    EXPECT_LT((gradient - expected_gradient).norm(), 1e-12 * expected_gradient.norm());
    Vector product;
    field.product(q, d, expected_gradient);
    placed.product(q, d, product);
    EXPECT_LT((product - expected_gradient).norm(), 1e-12 * product.norm());
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      ElasticPotential::ElementTerms terms;
      ElasticPotential::ElementTerms expected_terms;
      ASSERT_TRUE(placed.element_terms(e, q, true, terms));
      ASSERT_TRUE(field.element_terms(e, q, true, expected_terms));
      EXPECT_LT((terms.hessian - expected_terms.hessian).norm(), 1e-12 * terms.hessian.norm());
    }
    const Index last = rest.point_count() - 1;
    EXPECT_LT((placed.first_piola(last, q) - field.first_piola(last, q)).norm(), 1e-6);
  }
}

TEST(PlacedMaterial, DerivativesAreExactInABody) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const ElasticPotential potential(rest, CustomMaterial(WindingFibres(kLame)));
  const DerivativeErrors errors =
      check_derivatives(potential, strained_state(potential, mesh.rest_positions()));
  EXPECT_LT(errors.force, 1e-7);
  EXPECT_LT(errors.stiffness, 1e-7);
  EXPECT_EQ(errors.jumps, 0);
}

struct UndefinedInElement7 {
  NeoHookean inner{1e5, 1e5};
  const MaterialPlace place;
  bool admissible(const Matrix3& f) const { return place.element != 7 && inner.admissible(f); }
  double energy_density(const Matrix3& f) const { return 5.0 + inner.energy_density(f); }
  Matrix3 first_piola(const Matrix3& f) const { return inner.first_piola(f); }
  Matrix9 stiffness(const Matrix3& f) const { return inner.stiffness(f); }
};
struct Undefined {
  UndefinedInElement7 at(const MaterialPlace& place) const { return {.place = place}; }
};

TEST(PlacedMaterial, IsRefusedByABodyInWhichItIsNotDefined) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const CustomMaterial material(Undefined(), "undefined", kLame);
  EXPECT_TRUE(material.has_places());
  EXPECT_THROW(material.first_piola(Matrix3::Identity()), InputError);  // where?
  EXPECT_EQ(material.at({3, Vector3::Zero()}).energy_density(Matrix3::Identity()), 0.0);
  expect_part(message_of([&] { const ElasticPotential potential(rest, material); }),
              "in element 7 ");
}

// Half of a body is stiffer, by regions and by the numbers of the elements.
TEST(PlacedMaterial, MovesAsRegionsDo) {
  for (const Integrator rule :
       {Integrator::kVerlet, Integrator::kMidpoint, Integrator::kEnergyMomentum}) {
    Scene scene = spinning_block(rule, is_implicit(rule) ? 2e-3 : 5e-4, 0.1);
    const TetMesh mesh = generate_box({2, 1, 1}, {2, 1, 1});
    const LameParameters soft = lame_from_young(1e5, 0.3);
    const LameParameters stiff = lame_from_young(4e5, 0.3);
    const SelectBox half{{1.0, 0.0, 0.0}, {2.0, 1.0, 1.0}};
    ByElement law{std::vector<NeoHookean>(mesh.tetrahedra.size(), {soft.mu, soft.lambda})};
    for (const Index e : select_tetrahedra(mesh, half)) {
      law.laws[static_cast<std::size_t>(e)] = NeoHookean(stiff.mu, stiff.lambda);
    }
    scene.solver.tolerance = 1e-12;
    Scene regions = scene;
    MaterialRegionSettings region{half, scene.material, {}};
    region.material.youngs_modulus = 4e5;
    regions.material_region.push_back(region);
    scene.material.custom = CustomMaterial(law, "by element", soft);
    Session expected(regions, mesh);
    Session session(scene, mesh);
    EXPECT_EQ(expected.run(), RunStatus::kFinished);
    EXPECT_EQ(session.run(), RunStatus::kFinished);
    const Vector moved = expected.state().position - mesh.rest_positions();
    EXPECT_LT((session.state().position - expected.state().position).norm(), 1e-9 * moved.norm())
        << to_string(rule);
  }
}

// A material for many F in one call. In the loops over elements its other functions are not called.
class FibresInBatches {
 public:
  static constexpr const char* kName = "in batches";
  FibresInBatches() : fibres_(kLame, 1e5, 2.0, Vector3(1, -2, 0.5)) {}

  bool admissible(const Matrix3& f) const { return single("admissible") && fibres_.admissible(f); }
  double energy_density(const Matrix3& f) const {
    single("energy");
    return fibres_.energy_density(f);
  }
  Matrix3 first_piola(const Matrix3& f) const {
    single("stress");
    return fibres_.first_piola(f);
  }
  Matrix9 stiffness(const Matrix3& f) const {
    single("stiffness");
    return fibres_.stiffness(f);
  }
  void evaluate(const MaterialValues& values) const {
    for (std::size_t k = 0; k < values.f.size(); ++k) {
      const Matrix3& f = values.f[k];
      values.admissible[k] = fibres_.admissible(f) ? 1 : 0;
      if (values.admissible[k] == 0) continue;
      if (!values.energy.empty()) values.energy[k] = fibres_.energy_density(f);
      if (!values.stress.empty()) values.stress[k] = fibres_.first_piola(f);
      if (!values.stiffness.empty()) values.stiffness[k] = fibres_.stiffness(f);
    }
  }
  LameParameters initial_lame() const { return fibres_.initial_lame(); }

  static inline bool allows_single = true;

 private:
  static bool single(const char* what) {
    EXPECT_TRUE(allows_single) << what;
    return true;
  }
  FibreRubber fibres_;
};

TEST(CustomMaterial, ABatchMaterialIsEvaluatedInBatchesOnly) {
  for (const bool is_quadratic : {false, true}) {
    const TetMesh mesh = is_quadratic ? with_edge_vertices(small_block()) : small_block();
    const RestState rest(mesh);
    ElasticPotential plain(rest, CustomMaterial(FibreRubber(kLame, 1e5, 2.0, Vector3(1, -2, 0.5))));
    FibresInBatches::allows_single = true;
    ElasticPotential batched(rest, CustomMaterial(FibresInBatches()));
    FibresInBatches::allows_single = false;
    Vector q = jiggled(mesh.rest_positions(), 0.01);
    double expected = 0.0;
    double energy = 0.0;
    Vector expected_gradient;
    Vector gradient;
    ASSERT_TRUE(plain.value_and_gradient(q, expected, expected_gradient).ok());
    ASSERT_TRUE(batched.value_and_gradient(q, energy, gradient).ok());
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(energy, expected, 1e-12 * expected);
    EXPECT_LT((gradient - expected_gradient).norm(), 1e-12 * expected_gradient.norm());
    ASSERT_TRUE(batched.value(q, energy).ok());
    EXPECT_NEAR(energy, expected, 1e-12 * expected);
    Vector product;
    plain.product(q, gradient, expected_gradient);
    batched.product(q, gradient, product);
    EXPECT_LT((product - expected_gradient).norm(), 1e-12 * product.norm());
    const FreeCoordinates all(mesh.vertex_count());
    const SparsityPattern pattern(rest, all);
    std::vector<double> expected_values(static_cast<std::size_t>(pattern.nonzeros()));
    std::vector<double> values = expected_values;
    ASSERT_TRUE(plain.add_hessian(q, pattern, expected_values.data()).ok());
    ASSERT_TRUE(batched.add_hessian(q, pattern, values.data()).ok());
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_NEAR(values[k], expected_values[k], 1e-6) << k;
    }
    // Turned inside out, an element is found, and it is the same one.
    q.segment<3>(0) = 2.0 * q.segment<3>(3) - q.segment<3>(0);
    EXPECT_FALSE(plain.admissible(q).ok());
    EXPECT_EQ(batched.admissible(q).failed_element, plain.admissible(q).failed_element);
    EXPECT_FALSE(batched.value(q, energy).ok());
    FibresInBatches::allows_single = true;
  }
}

TEST(CustomMaterial, FibresRaiseTheStabilityLimitsFrequency) {
  const TetMesh mesh = small_block();
  const MechanicalSystem rubber(mesh, NeoHookean(kLame.mu, kLame.lambda), 1000.0);
  const MechanicalSystem fibres(
      mesh, CustomMaterial(FibreRubber(kLame, 1e6, 1.0, Vector3::UnitX())), 1000.0);
  const Vector q = mesh.rest_positions();
  EXPECT_GT(stability_limit(fibres, q).omega_max, 2.0 * stability_limit(rubber, q).omega_max);
}

class CustomMaterialSteps : public testing::TestWithParam<Integrator> {
 protected:
  // Steps a stretched, clamped block under gravity and returns where it is then.
  static Vector end_of_run(const MaterialModel& material, double& energy_drift) {
    MechanicalSystem system(small_block({4, 1, 1}), material, 1000.0);
    system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
    system.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
    SolverSettings solver;
    solver.tolerance = 1e-12;
    const auto stepper = make_stepper(GetParam(), solver, system);
    State state = system.rest_state();
    for (Index v = 0; v < system.vertex_count(); ++v) state.position[3 * v] *= 1.1;
    Balance balance(system, state);
    for (int k = 0; k < 100; ++k) {
      const StepOutcome outcome = stepper->step(state, 2e-3);
      EXPECT_TRUE(outcome.ok()) << outcome.message;
      balance.enter(state, outcome);
    }
    energy_drift = balance.max_relative_energy_drift();
    return state.position - system.rest_state().position;
  }
};

INSTANTIATE_TEST_SUITE_P(Rules, CustomMaterialSteps,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet,
                                         Integrator::kMidpoint),
                         [](const auto& rule) { return to_string(rule.param); });

TEST_P(CustomMaterialSteps, HoldingNeoHookeanTheBodyMovesAsNeoHookean) {
  double drift = 0.0;
  const NeoHookean neo(kLame.mu, kLame.lambda);
  const Vector plain = end_of_run(neo, drift);
  const Vector custom = end_of_run(CustomMaterial(neo, "mine", kLame), drift);
  EXPECT_GT(plain.norm(), 0.1);
  EXPECT_LT((custom - plain).norm(), 1e-11 * plain.norm());
}

// Nor does the solver of the implicit rules mind the constant.
TEST_P(CustomMaterialSteps, AConstantInTheEnergyChangesNothing) {
  double drift = 0.0;
  const Vector plain = end_of_run(NeoHookean(kLame.mu, kLame.lambda), drift);
  const Vector custom = end_of_run(CustomMaterial{WithoutConstants()}, drift);
  EXPECT_LT((custom - plain).norm(), 1e-7 * plain.norm());
}

TEST_P(CustomMaterialSteps, TheBooksOfFibresClose) {
  double drift = 1.0;
  const FibreRubber fibre(kLame, 1e5, 2.0, {1.0, 0.3, 0.0});
  const Vector moved = end_of_run(CustomMaterial(fibre), drift);
  EXPECT_GT(moved.norm(), 0.1);
  EXPECT_LT(drift, order(GetParam()) == 2 ? 0.01 : 0.2);
}

TEST(CustomMaterial, StandsBesideOtherMaterialsInOneBody) {
  const TetMesh mesh = small_block();
  std::vector<int> region(mesh.tetrahedra.size(), 0);
  for (const Index e : select_tetrahedra(mesh, SelectBox{{1, 0, 0}, {2, 1, 1}})) {
    region[static_cast<std::size_t>(e)] = 1;
  }
  const NeoHookean neo(kLame.mu, kLame.lambda);
  const MechanicalSystem mixed(mesh, {{neo, 1000.0}, {CustomMaterial(neo), 1000.0}}, region);
  const MechanicalSystem plain(mesh, neo, 1000.0);
  const Vector q = strained_state(plain.elastic(), mesh.rest_positions());
  double mixed_energy = 0.0;
  double plain_energy = 0.0;
  Vector mixed_gradient;
  Vector plain_gradient;
  ASSERT_TRUE(mixed.elastic().value_and_gradient(q, mixed_energy, mixed_gradient).ok());
  ASSERT_TRUE(plain.elastic().value_and_gradient(q, plain_energy, plain_gradient).ok());
  EXPECT_NEAR(mixed_energy, plain_energy, 1e-13 * plain_energy);
  EXPECT_LT((mixed_gradient - plain_gradient).norm(), 1e-13 * plain_gradient.norm());
}

}  // namespace
}  // namespace tetraction
