// Materials whose parameters vary from element to element.

#include <cmath>

#include "fem/tangent_operator.h"
#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A modulus between 1e4 and 1e6 Pa for every element.
NeoHookean soft_or_stiff(Index e) {
  const double mu = std::pow(10.0, 5.0 + std::sin(3.7 * static_cast<double>(e)));
  return {mu, 1.5 * mu};
}
MaterialField field_of(Index elements) {
  std::vector<IsotropicModel> models;
  for (Index e = 0; e < elements; ++e) models.emplace_back(soft_or_stiff(e));
  return MaterialField(models);
}

TEST(MaterialField, KnowsItsParameters) {
  const MaterialField uniform = NeoHookean(2.0, 3.0);
  EXPECT_FALSE(uniform.varies());
  EXPECT_EQ(initial_lame(uniform.at(17)).lambda, 3.0);
  EXPECT_EQ(uniform.lame_range().most_modulus, 7.0);
  EXPECT_EQ(uniform.lame_range().most_ratio, 0.3);

  const MaterialField field(
      std::vector<IsotropicModel>{NeoHookean(2.0, 3.0, VolumetricPart::kQuadratic),
                                  NeoHookean(4.0, -1.0, VolumetricPart::kQuadratic)});
  EXPECT_TRUE(field.varies());
  EXPECT_EQ(initial_lame(field.at(1)).mu, 4.0);
  EXPECT_EQ(std::get<NeoHookean>(field.at(1)).volumetric(), VolumetricPart::kQuadratic);
  EXPECT_EQ(initial_lame(field.model()).mu, 3.0);
  EXPECT_EQ(field.lame_range().least.mu, 2.0);
  EXPECT_EQ(field.lame_range().least.lambda, -1.0);
  EXPECT_EQ(field.lame_range().most.lambda, 3.0);
  EXPECT_EQ(field.lame_range().most_modulus, 7.0);
  EXPECT_EQ(field.lame_range().most_ratio, 0.3);
}

TEST(MaterialField, RefusesDifferentLaws) {
  EXPECT_THROW(MaterialField(std::vector<IsotropicModel>{}), InputError);
  EXPECT_THROW(
      MaterialField(std::vector<IsotropicModel>{NeoHookean(2.0, 3.0), StVenantKirchhoff(2.0, 3.0)}),
      InputError);
  EXPECT_THROW(MaterialField(std::vector<IsotropicModel>{
                   NeoHookean(2.0, 3.0), NeoHookean(2.0, 3.0, VolumetricPart::kQuadratic)}),
               InputError);
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  EXPECT_THROW(ElasticPotential(rest, field_of(rest.element_count() + 1)), InputError);
}

// A region for each element is the same body by another way.
TEST(MaterialField, IsTheSameAsARegionForEveryElement) {
  const TetMesh mesh = small_block({3, 2, 2});
  const RestState rest(mesh);
  const Index count = rest.element_count();
  std::vector<MaterialModel> models;
  std::vector<int> regions;
  for (Index e = 0; e < count; ++e) {
    models.emplace_back(soft_or_stiff(e));
    regions.push_back(static_cast<int>(e));
  }
  const ElasticPotential by_regions(rest, models, regions);
  ElasticPotential potential(rest, field_of(count));
  const Vector q = strained_state(potential, mesh.rest_positions(), 0.1);
  const auto [expected_energy, expected] = value_and_gradient_of(by_regions, q);
  const auto expect_same = [&] {
    auto [energy, gradient] = value_and_gradient_of(potential, q);
    EXPECT_NEAR(energy, expected_energy, 1e-14 * expected_energy);
    EXPECT_LT((gradient - expected).norm(), 1e-13 * expected.norm());
  };
  expect_same();

  const Vector x = jiggled(Vector::Zero(q.size()), 0.3);
  Vector product;
  Vector expected_product;
  potential.product(q, x, product);
  by_regions.product(q, x, expected_product);
  EXPECT_LT((product - expected_product).norm(), 1e-13 * expected_product.norm());

  Vector densities;
  Vector expected_densities;
  potential.energy_densities(q, densities);
  by_regions.energy_densities(q, expected_densities);
  EXPECT_LT((densities - expected_densities).norm(), 1e-14 * expected_densities.norm());
  EXPECT_EQ(potential.first_piola(5, q), by_regions.first_piola(5, q));
  EXPECT_EQ(potential.lame(5).mu, soft_or_stiff(5).mu());

  const auto sums = potential.stiffness_sums(2e4);
  const auto expected_sums = by_regions.stiffness_sums(2e4);
  EXPECT_NEAR(sums.squared, expected_sums.squared, 1e-13 * expected_sums.squared);
  EXPECT_NEAR(sums.with_edges, expected_sums.with_edges, 1e-13 * expected_sums.with_edges);

  const DerivativeErrors errors = check_derivatives(potential, q);
  EXPECT_LT(errors.force, 1e-8);
  EXPECT_LT(errors.stiffness, 1e-8);

  potential.set_material(0, NeoHookean(1e5, 1e5));
  const ElasticPotential uniform(rest, NeoHookean(1e5, 1e5));
  double energy = 0.0;
  double uniform_energy = 0.0;
  Vector gradient;
  ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());
  ASSERT_TRUE(uniform.value_and_gradient(q, uniform_energy, expected_product).ok());
  EXPECT_EQ(energy, uniform_energy);
  EXPECT_EQ(gradient, expected_product);
  potential.set_material(0, field_of(count));
  expect_same();
}

TEST(BodyRegion, DensitiesOfElementsGiveTheMass) {
  const TetMesh mesh = small_block({3, 2, 2});
  std::vector<double> densities;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    densities.push_back(500.0 + 10.0 * static_cast<double>(e));
  }
  const MechanicalSystem system(mesh, {{NeoHookean(1e5, 1e5), 1000.0, densities}}, {});
  Vector expected = Vector::Zero(mesh.vertex_count());
  double total = 0.0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const double mass = densities[static_cast<std::size_t>(e)] * system.rest().volume(e);
    total += mass;
    for (const Index v : system.rest().nodes(e)) expected[v] += 0.25 * mass;
  }
  EXPECT_LT((system.mass() - expected).norm(), 1e-14 * expected.norm());
  EXPECT_NEAR(system.total_mass(), total, 1e-13 * total);
  densities[7] = -1.0;
  EXPECT_THROW(MechanicalSystem(mesh, {{NeoHookean(1e5, 1e5), 1000.0, densities}}, {}), InputError);
  densities.pop_back();
  EXPECT_THROW(MechanicalSystem(mesh, {{NeoHookean(1e5, 1e5), 1000.0, densities}}, {}), InputError);
}

}  // namespace
}  // namespace tetraction
