// The volumetric energy with averages at the vertices: derivatives, conservation, solvers, refusals.
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

#include <Eigen/Geometry>
#include <cmath>

#include "fem/tangent_operator.h"
#include "solver/linear/matrix_free_cg.h"
#include "support/fibre_rubber.h"
#include "support/runs.h"
#include "support/step_problems.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

const LameParameters kNearlyIncompressible = lame_from_young(1e6, 0.49);

struct BodyCase {
  std::string name;
  std::vector<MaterialField> materials;
};

// The moduli of a neo-Hookean material that varies.
MaterialField varying(Index count) {
  std::vector<IsotropicModel> elements;
  for (Index e = 0; e < count; ++e) {
    elements.emplace_back(
        NeoHookean(kNearlyIncompressible.mu,
                   kNearlyIncompressible.lambda * (1.0 + 0.3 * std::sin(double(e)))));
  }
  return MaterialField(elements);
}

std::vector<BodyCase> cases() {
  const NeoHookean neo(kNearlyIncompressible.mu, kNearlyIncompressible.lambda);
  const Yeoh yeoh(2e5, 3e4, 5e3, 1e7);
  return {{"neo_hookean", {neo}},
          {"neo_hookean_quadratic",
           {NeoHookean(kNearlyIncompressible.mu, kNearlyIncompressible.lambda,
                       VolumetricPart::kQuadratic)}},
          {"mooney_rivlin", {mooney_rivlin_from_young(1e6, 0.49, 0.5)}},
          {"yeoh", {yeoh}},
          {"two_materials", {neo, yeoh}},
          {"varying", {varying(small_block().tetrahedron_count())}}};
}

std::unique_ptr<MechanicalSystem> block_of(const std::vector<MaterialField>& materials,
                                           VolumeRule rule) {
  TetMesh mesh = small_block();
  std::vector<int> region(mesh.tetrahedra.size(), 0);
  if (materials.size() > 1) {
    for (std::size_t e = 0; e < region.size(); ++e) region[e] = e % 3 == 0 ? 1 : 0;
  }
  std::vector<BodyRegion> regions;
  for (const MaterialField& material : materials) regions.push_back({material, 1000.0});
  return std::make_unique<MechanicalSystem>(std::move(mesh), regions, region, rule);
}

class NodalVolumeOf : public testing::TestWithParam<BodyCase> {
 protected:
  std::unique_ptr<MechanicalSystem> system_ = block_of(GetParam().materials, VolumeRule::kNodal);
  const NodalVolume& volume() const { return *system_->nodal_volume(); }
  Vector strained(double amount = 0.05) const {
    return jiggled(system_->mesh().rest_positions(), amount);
  }
};

TEST_P(NodalVolumeOf, IsExactlyZeroAtRest) {
  const Vector rest = system_->mesh().rest_positions();
  Vector gradient = Vector::Zero(rest.size());
  EXPECT_EQ(volume().add_gradient(rest, gradient), 0.0);
  EXPECT_EQ(gradient, Vector::Zero(rest.size()));
  EXPECT_EQ(volume().ratios(rest), Vector::Ones(system_->vertex_count()));
}

// One loop over the elements gives what two give: that of the kernels, and that of single elements,
// which slender tetrahedra need.
TEST_P(NodalVolumeOf, TheElasticEnergyIsTheSumOfBothParts) {
  const Vector q = strained();
  const Vector origin = jiggled(q, 0.1, 3);
  const Vector flat = Vector3(1.0, 1.0, 0.01).replicate(q.size() / 3, 1);
  const auto expect_sum = [](const MechanicalSystem& system, const Positions& x) {
    Vector gradient;
    double energy = 0.0;
    ASSERT_TRUE(system.elastic_energy_and_gradient(x, energy, gradient).ok());
    Vector expected;
    double sum = 0.0;
    ASSERT_TRUE(system.elastic().value_and_gradient(x, sum, expected).ok());
    sum += system.nodal_volume()->add_gradient(x, expected);
    EXPECT_NEAR(energy, sum, 1e-14 * sum);
    EXPECT_LT((gradient - expected).norm(), 1e-12 * expected.norm());
    double alone = 0.0;
    ASSERT_TRUE(system.elastic_energy(x, alone).ok());
    EXPECT_NEAR(alone, sum, 1e-12 * sum);
  };
  expect_sum(*system_, Positions(q));
  const Vector u = q - origin;
  expect_sum(*system_, Positions(origin, u));
  TetMesh thin = system_->mesh();
  for (Vector3& vertex : thin.vertices.own()) vertex.z() *= 0.01;
  const MechanicalSystem plate(thin, {{GetParam().materials[0]}}, {}, VolumeRule::kNodal);
  const Vector bent = q.cwiseProduct(flat);
  const Vector start = origin.cwiseProduct(flat);
  const Vector way = bent - start;
  expect_sum(plate, Positions(start, way));
}

TEST_P(NodalVolumeOf, GradientAndHessianAreDerivatives) {
  const Vector q = strained();
  const Vector origin = jiggled(q, 0.1, 3);
  const Vector u = q - origin;
  Vector gradient = Vector::Zero(q.size());
  const double energy = volume().add_gradient(q, gradient);
  EXPECT_GT(energy, 0.0);
  EXPECT_NEAR(volume().energy(Positions(origin, u)), energy, 1e-12 * energy);
  const Vector d = jiggled(Vector::Zero(q.size()), 1.0, 5);
  constexpr double kStep = 1e-6;
  const Vector ahead = q + kStep * d;
  const Vector behind = q - kStep * d;
  EXPECT_NEAR((volume().energy(ahead) - volume().energy(behind)) / (2.0 * kStep), gradient.dot(d),
              1e-7 * gradient.norm() * d.norm());
  Vector product = Vector::Zero(q.size());
  volume().add_product(Positions(origin, u), d, product);
  Vector forward = Vector::Zero(q.size());
  Vector backward = Vector::Zero(q.size());
  volume().add_gradient(ahead, forward);
  volume().add_gradient(behind, backward);
  const Vector bend = (forward - backward) / (2.0 * kStep);
  EXPECT_LT((product - bend).norm(), 1e-7 * bend.norm());
  // The convex form has no negative eigenvalue.
  HessianBlocks convex;
  convex.reset(system_->vertex_count());
  volume().add_outer_products(q, HessianForm::kConvex, convex);
  EXPECT_TRUE(convex.pairs().empty());
  for (const HessianBlocks::Outer& outer : convex.outers()) EXPECT_GE(outer.factor, 0.0);
}

// The stiffness of the elements with tensions, and outer products.
TEST_P(NodalVolumeOf, TangentsWithTensionsAndOuterProductsAreTheWholeHessian) {
  const Vector q = strained();
  const Vector d = jiggled(Vector::Zero(q.size()), 1.0, 5);
  constexpr double kStep = 1e-6;
  const auto gradient_at = [&](const Vector& x) {
    double energy = 0.0;
    Vector gradient;
    EXPECT_TRUE(system_->elastic_energy_and_gradient(x, energy, gradient).ok());
    return gradient;
  };
  const Vector bend = (gradient_at(q + kStep * d) - gradient_at(q - kStep * d)) / (2.0 * kStep);
  HessianBlocks outers;
  outers.reset(system_->vertex_count());
  volume().add_outer_products(q, HessianForm::kExact, outers);
  EXPECT_TRUE(outers.pairs().empty());
  Vector outer_product = Vector::Zero(q.size());
  outers.add_product(d, outer_product);
  const ViscousPotential no_viscosity(system_->elastic());
  const auto tangent_product = [&]<class T>(TangentOperator<T> tangent) {
    tangent.set(q, no_viscosity, q, volume().tensions(q).data());
    AlignedVector<T> records(static_cast<std::size_t>(4 * system_->vertex_count()), T(0));
    for (Index i = 0; i < d.size(); ++i) {
      records[static_cast<std::size_t>(4 * (i / 3) + i % 3)] = static_cast<T>(d[i]);
    }
    tangent.multiply(records.data());
    Vector product(d.size());
    for (Index v = 0; v < system_->vertex_count(); ++v) {
      vertex_block(product, v) = tangent.record_sum(v).template head<3>().template cast<double>();
    }
    return product;
  };
  const Vector product = tangent_product(TangentOperator<double>(system_->elastic()));
  EXPECT_LT((product + outer_product - bend).norm(), 1e-7 * bend.norm());
  const Vector single = tangent_product(TangentOperator<float>(system_->elastic()));
  EXPECT_LT((single - product).norm(), 1e-5 * product.norm());
  // Assembled, also where vertices may move on planes only.
  const TetMesh& mesh = system_->mesh();
  Matrix plane(3, 2);
  plane.col(0) = Vector3(1.0, 1.0, 0.0).normalized();
  plane.col(1) = Vector3(0.0, 0.0, 1.0);
  const std::vector<Index> guided = select_vertices(mesh, SelectPlane{0, 0.0, {}});
  const Constraints constraints(
      {{}, {{guided, plane, prescribe_at_rest(mesh, guided).start, "guide"}}, {}, {}}, mesh,
      Vector::Ones(mesh.vertex_count()));
  for (const FreeCoordinates& coordinates :
       {FreeCoordinates(mesh.vertex_count()), constraints.coordinates()}) {
    const SparsityPattern pattern(system_->rest(), coordinates);
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    ASSERT_TRUE(BlockAccess::add_hessian(system_->elastic(), q, volume().tensions(q).data(),
                                         pattern, values.data())
                    .ok());
    const Vector y = jiggled(Vector::Zero(coordinates.count()), 1.0, 9);
    Vector expected = Vector::Zero(q.size());
    volume().add_product(q, coordinates.extend(y), expected);
    outers.scale(-1.0);
    outers.add_product(coordinates.extend(y), expected);
    outers.scale(-1.0);
    Vector elements;
    system_->elastic().product(q, coordinates.extend(y), elements);
    const Vector reduced = coordinates.restrict(expected + elements);
    EXPECT_LT((dense_matrix(pattern, values) * y - reduced).norm(), 1e-11 * reduced.norm());
  }
}

// Where the Hessian is made convex, the elements have no tension, and U'' is not negative.
TEST_P(NodalVolumeOf, TheConvexFormLeavesTensionsOut) {
  clamp_under_gravity(*system_);
  StepProblem problem(*system_);
  begin(problem, bending_state(*system_));
  const Vector u = jiggled(problem.base(), 0.05) - problem.origin();
  const Vector q = problem.origin() + u;
  MatrixFreeCg<double> cg(*system_);
  cg.set(problem, u);
  const Vector d =
      system_->coordinates().extend(jiggled(Vector::Zero(system_->coordinates().count()), 1.0, 5));
  const double exact = cg.curvature(d);
  const auto quadratic_form = [&](bool convex) {
    TangentOperator<double> tangent(system_->elastic());
    const ViscousPotential no_viscosity(system_->elastic());
    tangent.set(q, no_viscosity, q, convex ? nullptr : volume().tensions(q).data());
    if (convex) tangent.convexify();
    AlignedVector<double> records(static_cast<std::size_t>(4 * system_->vertex_count()), 0.0);
    for (Index i = 0; i < d.size(); ++i) {
      records[static_cast<std::size_t>(4 * (i / 3) + i % 3)] = d[i];
    }
    tangent.multiply(records.data());
    Vector product(d.size());
    for (Index v = 0; v < system_->vertex_count(); ++v) {
      vertex_block(product, v) = tangent.record_sum(v).head<3>();
    }
    HessianBlocks outers;
    outers.reset(system_->vertex_count());
    volume().add_outer_products(q, convex ? HessianForm::kConvex : HessianForm::kExact, outers);
    outers.add_product(d, product);
    return d.dot(product) + d.dot(problem.coefficient().cwiseProduct(d));
  };
  EXPECT_NEAR(exact, quadratic_form(false), 1e-10 * std::abs(exact));
  cg.convexify();
  const double convex = cg.curvature(d);
  EXPECT_NEAR(convex, quadratic_form(true), 1e-10 * convex);
  EXPECT_GT(std::abs(convex - exact), 1e-6 * convex);
}

TEST_P(NodalVolumeOf, AgreesWithElementsWhereTheStrainIsTheSameEverywhere) {
  if (GetParam().name == "varying") GTEST_SKIP() << "the stress is not the same everywhere";
  const auto plain = block_of(GetParam().materials, VolumeRule::kElement);
  Matrix3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.1, 0.0, -0.15, 1.05;
  Vector q = plain->mesh().rest_positions();
  for (Index v = 0; v < plain->vertex_count(); ++v) {
    vertex_block(q, v) = f * Vector3(vertex_block(std::as_const(q), v));
  }
  double expected = 0.0;
  double energy = 0.0;
  Vector expected_gradient;
  Vector gradient;
  ASSERT_TRUE(plain->elastic_energy_and_gradient(q, expected, expected_gradient).ok());
  ASSERT_TRUE(system_->elastic_energy_and_gradient(q, energy, gradient).ok());
  EXPECT_NEAR(energy, expected, 1e-12 * expected);
  if (GetParam().materials.size() == 1) {
    EXPECT_LT((gradient - expected_gradient).norm(), 1e-12 * expected_gradient.norm());
  }
  EXPECT_LT((system_->elastic_energies_by_region(q) - plain->elastic_energies_by_region(q)).norm(),
            1e-12 * expected);
  const ElementFields fields = element_fields(*system_, q);
  const ElementFields expected_fields = element_fields(*plain, q);
  if (GetParam().materials.size() == 1) {
    EXPECT_LT((fields.cauchy_stress - expected_fields.cauchy_stress).norm(),
              1e-12 * expected_fields.cauchy_stress.norm());
  }
  EXPECT_LT((fields.energy_density - expected_fields.energy_density).norm(),
            1e-12 * expected_fields.energy_density.norm());
  EXPECT_LT((volume().ratios(q).array() - f.determinant()).abs().maxCoeff(), 1e-13);
}

TEST_P(NodalVolumeOf, DensitiesAndRegionsAddUpToTheEnergy) {
  const Vector q = strained();
  double energy = 0.0;
  ASSERT_TRUE(system_->elastic_energy(q, energy).ok());
  EXPECT_NEAR(system_->elastic_energies_by_region(q).sum(), energy, 1e-12 * energy);
  Vector densities;
  system_->elastic_energy_densities(q, densities);
  double sum = 0.0;
  for (Index e = 0; e < densities.size(); ++e) sum += system_->rest().volume(e) * densities[e];
  EXPECT_NEAR(sum, energy, 1e-12 * energy);
}

TEST_P(NodalVolumeOf, StressesOfTheElementsAreTheForcesOfTheVertices) {
  const Vector q = strained();
  double energy = 0.0;
  Vector gradient;
  ASSERT_TRUE(system_->elastic_energy_and_gradient(q, energy, gradient).ok());
  Vector forces = Vector::Zero(q.size());
  for (Index e = 0; e < system_->rest().element_count(); ++e) {
    const auto element = system_->rest().point(e);
    const RestState::Shape::NodeMatrix own =
        element.weights[0] * system_->first_piola(e, q) * element.gradients[0];
    for (int a = 0; a < 4; ++a) {
      vertex_block(forces, system_->rest().nodes(e)[static_cast<std::size_t>(a)]) += own.col(a);
    }
  }
  EXPECT_LT((forces - gradient).norm(), 1e-12 * gradient.norm());
}

TEST_P(NodalVolumeOf, DiscreteGradientDoesTheWorkAndHasNoMoment) {
  const Vector from = strained();
  for (const double size : {1.0, 0.1, 1e-3, 1e-8, 0.0}) {
    for (const double turn : {0.0, 1.2}) {
      Vector to = jiggled(from, 0.05 * size, 11);
      const Matrix3 rotation =
          Eigen::AngleAxisd(turn, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
      for (Index v = 0; v < system_->vertex_count(); ++v) {
        vertex_block(to, v) = rotation * Vector3(vertex_block(std::as_const(to), v));
      }
      const Vector middle = 0.5 * (from + to);
      const Vector way = middle - from;
      Vector f = Vector::Zero(from.size());
      volume().add_discrete_gradient(middle, way, f);
      const double before = volume().energy(from);
      const double after = volume().energy(to);
      EXPECT_NEAR(2.0 * f.dot(way), after - before, 1e-12 * (before + after)) << size << turn;
      Vector3 force = Vector3::Zero();
      Vector3 moment = Vector3::Zero();
      for (Index v = 0; v < system_->vertex_count(); ++v) {
        const Vector3 own = vertex_block(std::as_const(f), v);
        force += own;
        moment += Vector3(vertex_block(middle, v)).cross(own);
      }
      EXPECT_LT(force.norm() + moment.norm(), 1e-12 * f.lpNorm<1>());
      if (size == 0.0 && turn == 0.0) {
        Vector gradient = Vector::Zero(from.size());
        volume().add_gradient(from, gradient);
        EXPECT_LT((f - gradient).norm(), 1e-12 * gradient.norm());
      }
    }
  }
}

TEST_P(NodalVolumeOf, DiscreteGradientHasTheDerivativeOfItsProduct) {
  const Vector from = strained();
  const Vector d = jiggled(Vector::Zero(from.size()), 1.0, 5);
  constexpr double kStep = 1e-6;
  // The derivative of the secant is exact up to terms of the second order in the change of J.
  for (const auto& [size, tolerance] : {std::pair{1e-3, 2e-6}, std::pair{0.2, 2e-3}}) {
    const Vector middle = jiggled(from, 0.05 * size, 11);
    const auto gradient_at = [&](const Vector& x) {
      Vector f = Vector::Zero(from.size());
      volume().add_discrete_gradient(x, x - from, f);
      return f;
    };
    const Vector bend =
        (gradient_at(middle + kStep * d) - gradient_at(middle - kStep * d)) / (2.0 * kStep);
    Vector product = Vector::Zero(from.size());
    volume().add_discrete_gradient_product(middle, middle - from, d, product);
    EXPECT_LT((product - bend).norm(), tolerance * bend.norm()) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, NodalVolumeOf, testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

TEST(NodalVolume, RefusesMaterialsWithoutAVolumetricPart) {
  const std::vector<MaterialModel> refused{
      StVenantKirchhoff(kNearlyIncompressible.mu, kNearlyIncompressible.lambda),
      CustomMaterial(FibreRubber(kNearlyIncompressible, 1e5, 0.5, {1.0, 1.0, 0.0}))};
  for (const MaterialModel& material : refused) {
    EXPECT_THROW(block_of({MaterialField(material)}, VolumeRule::kNodal), InputError);
    const auto system = block_of(
        {NeoHookean(kNearlyIncompressible.mu, kNearlyIncompressible.lambda)}, VolumeRule::kNodal);
    const Vector q = jiggled(system->mesh().rest_positions(), 0.05);
    double before = 0.0;
    double after = 0.0;
    ASSERT_TRUE(system->elastic_energy(q, before).ok());
    EXPECT_THROW(system->set_material(0, MaterialField(material)), InputError);
    ASSERT_TRUE(system->elastic_energy(q, after).ok());
    EXPECT_EQ(after, before);
  }
}

TEST(NodalVolume, TakesANewMaterial) {
  const auto system = block_of({NeoHookean(kNearlyIncompressible.mu, kNearlyIncompressible.lambda)},
                               VolumeRule::kNodal);
  const auto expected = block_of({Yeoh(2e5, 3e4, 5e3, 1e7)}, VolumeRule::kNodal);
  const Vector q = jiggled(system->mesh().rest_positions(), 0.05);
  double energy = 0.0;
  double expected_energy = 0.0;
  ASSERT_TRUE(system->elastic_energy(q, energy).ok());  // nothing of it is kept
  system->set_material(0, Yeoh(2e5, 3e4, 5e3, 1e7));
  EXPECT_EQ(system->lame(3).lambda, expected->lame(3).lambda);
  ASSERT_TRUE(system->elastic_energy(q, energy).ok());
  ASSERT_TRUE(expected->elastic_energy(q, expected_energy).ok());
  EXPECT_EQ(energy, expected_energy);
}

TEST(NodalVolume, AllLinearSolversFindTheSameStep) {
  for (const double ratio : {0.4, 0.499, 0.4999}) {
    const LameParameters lame = lame_from_young(1e6, ratio);
    const auto system = block_of({NeoHookean(lame.mu, lame.lambda)}, VolumeRule::kNodal);
    clamp_under_gravity(*system);
    StepProblem problem(*system);
    Vector reference;
    for (const LinearSolver linear : {LinearSolver::kFactor, LinearSolver::kCg,
                                      LinearSolver::kMatrixFree, LinearSolver::kAuto}) {
      begin(problem, bending_state(*system));
      NewtonOptions options;
      options.tolerance = 1e-9;
      options.linear = linear;
      Vector x = problem.base();
      const MinimizerReport report = make_newton_minimizer(*system, options)->minimize(problem, x);
      EXPECT_TRUE(report.converged()) << ratio << ", " << static_cast<int>(linear);
      EXPECT_LE(report.iterations, 40);
      if (reference.size() == 0) reference = x;
      EXPECT_LT((x - reference).norm(), 1e-7) << ratio << ", " << static_cast<int>(linear);
    }
  }
}

TEST(NodalVolume, CeresRefusesIt) {
  const auto system = block_of({NeoHookean(kNearlyIncompressible.mu, kNearlyIncompressible.lambda)},
                               VolumeRule::kNodal);
  EXPECT_THROW(make_ceres_minimizer(*system, {}), InputError);
}

TEST(NodalVolume, ModesAreTheEigenvaluesOfTheWholeStiffness) {
  const auto system = block_of({NeoHookean(kNearlyIncompressible.mu, kNearlyIncompressible.lambda)},
                               VolumeRule::kNodal);
  const Vector rest = system->mesh().rest_positions();
  const NormalModes modes = normal_modes(*system, rest, {.count = 12});
  ASSERT_EQ(modes.modes.size(), 12U);
  int rigid = 0;
  for (const NormalMode& mode : modes.modes) {
    rigid += mode.kind == ModeKind::kRigid ? 1 : 0;
    if (mode.kind == ModeKind::kRigid) continue;
    // K φ = ω² M φ, with K φ from a difference of forces.
    constexpr double kStep = 1e-6;
    double energy = 0.0;
    Vector ahead;
    Vector behind;
    const Vector d = mode.shape / mode.shape.lpNorm<Eigen::Infinity>();
    ASSERT_TRUE(system->elastic_energy_and_gradient(Vector(rest + kStep * d), energy, ahead).ok());
    ASSERT_TRUE(system->elastic_energy_and_gradient(Vector(rest - kStep * d), energy, behind).ok());
    const Vector force = (ahead - behind) / (2.0 * kStep);
    const Vector inertia = mode.omega_squared * system->momentum_of(d);
    EXPECT_LT((force - inertia).norm(), 1e-5 * inertia.norm());
  }
  EXPECT_EQ(rigid, 6);
}

}  // namespace
}  // namespace tetraction
