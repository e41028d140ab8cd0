// The discrete gradient of the elastic energy: energy, momenta, derivative, small steps.
#include "fem/discrete_gradient.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "support/bodies.h"
#include "support/fibre_rubber.h"
#include "support/instruction_sets.h"

namespace tetraction {
namespace {

using namespace testing_support;

const LameParameters kStiffRubber = lame_from_young(1e6, 0.4);

struct Case {
  std::string name;
  MaterialModel material;
};

std::vector<Case> cases() {
  std::vector<Case> all{
      {"stvk", StVenantKirchhoff(kStiffRubber.mu, kStiffRubber.lambda)},
      {"neo_hookean", NeoHookean(kStiffRubber.mu, kStiffRubber.lambda)},
      {"neo_hookean_quadratic",
       NeoHookean(kStiffRubber.mu, kStiffRubber.lambda, VolumetricPart::kQuadratic)},
      {"mooney_rivlin", mooney_rivlin_from_young(1e6, 0.4, 0.5)},
      {"yeoh", Yeoh(2e5, 3e4, 5e3, 1e6)},
      {"custom_neo_hookean", CustomMaterial(NeoHookean(kStiffRubber.mu, kStiffRubber.lambda))},
      {"custom_stvk", CustomMaterial(StVenantKirchhoff(kStiffRubber.mu, kStiffRubber.lambda))},
      {"fibres", CustomMaterial(FibreRubber(kStiffRubber, 1e5, 0.5, {1.0, 1.0, 0.0}))},
      {"winding_fibres", CustomMaterial(WindingFibres(kStiffRubber))},
      {"winding_fibres_in_batches",
       CustomMaterial(InBatches<WindingFibres>(WindingFibres(kStiffRubber)))}};
  for (const MaterialModel& model : materials_like(kStiffRubber)) {
    std::string name = "like_" + material_name(model);
    std::replace(name.begin(), name.end(), '-', '_');
    all.push_back({name, model});
  }
  return all;
}

// A step of a block from one deformed and turned shape to another one.
struct BlockStep {
  BlockStep(const MaterialModel& material, double size, double turn)
      : mesh(small_block()), rest(mesh), elastic(rest, material), gradient(elastic) {
    from = jiggled(mesh.rest_positions(), 0.05);
    const Matrix3 rotation =
        Eigen::AngleAxisd(turn, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
    to = jiggled(from, 0.07 * size, 11);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = vertex_block(std::as_const(to), v);
      vertex_block(to, v) = rotation * (x + size * Vector3(0.1 * x.x(), 0.05 * x.x() * x.y(), 0.0));
    }
    set_middle(0.5 * (from + to));
  }
  void set_middle(const Vector& x) {
    middle = x;
    way = x - from;
  }
  Vector discrete_gradient(double viscous = 0.0) {
    Vector result = Vector::Zero(from.size());
    EXPECT_TRUE(gradient.add({middle, way, viscous}, result).ok());
    return result;
  }
  double energy(const Vector& q) {
    double result = 0.0;
    EXPECT_TRUE(elastic.value(q, result).ok());
    return result;
  }

  TetMesh mesh;
  RestState rest;
  ElasticPotential elastic;
  DiscreteGradient gradient;
  Vector from, to, middle, way;
};

class DiscreteGradientOf : public testing::TestWithParam<Case> {};

TEST_P(DiscreteGradientOf, DoesTheWorkOfTheEnergyAndHasNoResultant) {
  for (const double size : {1.0, 0.3, 0.03, 1e-3}) {
    for (const double turn : {0.0, 0.1, 1.5}) {
      BlockStep step(GetParam().material, size, turn);
      const Vector f = step.discrete_gradient();
      const double before = step.energy(step.from);
      const double after = step.energy(step.to);
      EXPECT_NEAR(f.dot(step.to - step.from), after - before, 1e-13 * (after + before))
          << size << ", " << turn;
      Vector3 force = Vector3::Zero();
      Vector3 moment = Vector3::Zero();
      double scale = 0.0;
      for (Index v = 0; v < step.mesh.vertex_count(); ++v) {
        const Vector3 each = vertex_block(f, v);
        force += each;
        moment += Vector3(vertex_block(std::as_const(step.middle), v)).cross(each);
        scale += each.norm();
      }
      EXPECT_LT(force.norm(), 1e-14 * scale);
      EXPECT_LT(moment.norm(), 1e-14 * scale);
    }
  }
}

TEST_P(DiscreteGradientOf, IsTheGradientInTheLimitOfNoMotion) {
  BlockStep step(GetParam().material, 0.0, 0.0);
  Vector expected;
  double energy = 0.0;
  ASSERT_TRUE(step.elastic.value_and_gradient(step.from, energy, expected).ok());
  step.set_middle(step.from);
  EXPECT_LT((step.discrete_gradient() - expected).norm(), 1e-13 * expected.norm());
  for (const double size : {1e-12, 1e-9, 1e-6, 1e-4}) {
    step.set_middle(jiggled(step.from, size, 5));
    ASSERT_TRUE(step.elastic.value_and_gradient(step.middle, energy, expected).ok());
    // The difference is of the second order, but for round-off.
    EXPECT_LT((step.discrete_gradient() - expected).norm(),
              (100.0 * size * size + 2e-13) * expected.norm())
        << size;
  }
}

TEST_P(DiscreteGradientOf, HasTheDerivativeOfItsProduct) {
  for (const double viscous : {0.0, 2e5}) {
    for (const double size : {1.0, 0.1, 1e-3}) {
      BlockStep step(GetParam().material, size, 0.7);
      const Vector x = step.middle;
      const Vector d = jiggled(Vector::Zero(x.size()), 1.0, 3);
      Vector product = Vector::Zero(x.size());
      step.gradient.add_product({x, step.way, viscous}, d, product);
      const double h = size < 0.01 ? 1e-7 : 1e-5;
      step.set_middle(x + h * d);
      const Vector after = step.discrete_gradient(viscous);
      step.set_middle(x - h * d);
      const Vector before = step.discrete_gradient(viscous);
      EXPECT_LT((product - (after - before) / (2.0 * h)).norm(),
                (size < 0.01 ? 1e-6 : 1e-7) * product.norm())
          << viscous << ", " << size;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, DiscreteGradientOf, testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

TEST(DiscreteGradient, OfTheKernelsIsThatOfTheScalarLoop) {
  struct Pair {
    MaterialModel kernel;
    MaterialModel scalar;
  };
  const StVenantKirchhoff stvk(kStiffRubber.mu, kStiffRubber.lambda);
  const NeoHookean neo(kStiffRubber.mu, kStiffRubber.lambda);
  const MooneyRivlin mooney = mooney_rivlin_from_young(1e6, 0.4, 0.5);
  const Yeoh yeoh(2e5, 3e4, 5e3, 1e6);
  for (const std::int64_t set : instruction_sets()) {
    const UseInstructionSet use(set);
    std::vector<Pair> pairs;
    for_each_model([&]<class M>() {
      const M material = M::like(kStiffRubber);
      pairs.push_back({material, CustomMaterial(material)});
    });
    for (const Pair& pair :
         {Pair{stvk, CustomMaterial(stvk)}, Pair{neo, CustomMaterial(neo)},
          Pair{mooney, CustomMaterial(mooney)}, Pair{yeoh, CustomMaterial(yeoh)}}) {
      pairs.push_back(pair);
    }
    for (const Pair& pair : pairs) {
      for (const double size : {1.0, 0.1, 1e-4}) {
        BlockStep kernel(pair.kernel, size, 0.4);
        BlockStep scalar(pair.scalar, size, 0.4);
        const Vector expected = scalar.discrete_gradient(1e5);
        EXPECT_LT((kernel.discrete_gradient(1e5) - expected).norm(), 1e-13 * expected.norm());
        const Vector d = jiggled(Vector::Zero(kernel.from.size()), 1.0, 3);
        Vector product = Vector::Zero(d.size());
        Vector expected_product = Vector::Zero(d.size());
        kernel.gradient.add_product({kernel.middle, kernel.way, 1e5}, d, product);
        scalar.gradient.add_product({scalar.middle, scalar.way, 1e5}, d, expected_product);
        EXPECT_LT((product - expected_product).norm(), 1e-8 * expected_product.norm());
      }
    }
  }
}

TEST(DiscreteGradient, OfViscosityTakesTheDissipatedEnergy) {
  BlockStep step(NeoHookean(kStiffRubber.mu, kStiffRubber.lambda), 0.3, 0.8);
  const double viscous = 3e4;
  const Vector force = step.discrete_gradient(viscous) - step.discrete_gradient();
  double expected = 0.0;
  for (Index e = 0; e < step.rest.element_count(); ++e) {
    const auto element = step.rest.point(e);
    const Matrix3 f0 = deformation_gradient(element, 0, step.rest.gather(step.from, e));
    const Matrix3 f1 = deformation_gradient(element, 0, step.rest.gather(step.to, e));
    const Matrix3 change = 0.5 * (f1.transpose() * f1 - f0.transpose() * f0);
    expected += step.rest.volume(e) * viscous * change.squaredNorm();
  }
  EXPECT_NEAR(force.dot(step.to - step.from), expected, 1e-12 * expected);
}

TEST(DiscreteGradient, IsNotDefinedWhereAnElementIsInvertedAtTheEnd) {
  BlockStep step(NeoHookean(kStiffRubber.mu, kStiffRubber.lambda), 0.1, 0.0);
  step.set_middle(0.4 * step.from);  // the step ends at −0.2 times its beginning
  Vector result = Vector::Zero(step.from.size());
  const EvaluationStatus status = step.gradient.add({step.middle, step.way}, result);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.failed_element, 0);
  BlockStep stvk(StVenantKirchhoff(kStiffRubber.mu, kStiffRubber.lambda), 0.1, 0.0);
  stvk.set_middle(0.4 * stvk.from);
  EXPECT_TRUE(stvk.gradient.add({stvk.middle, stvk.way}, result).ok());
}

}  // namespace
}  // namespace tetraction
