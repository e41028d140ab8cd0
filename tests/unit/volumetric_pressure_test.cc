// The pressures as unknowns of their own: forces, rates and curvature against the energy.
#include "solver/newton/volumetric_pressure.h"

#include <cmath>

#include "support/assembled.h"
#include "support/bodies.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

struct Case {
  std::string name;
  bool quadratic;
  VolumeRule rule;
  VolumetricPart part;
};

const LameParameters kIncompressibleLimit = lame_from_young(1e6, 0.49);

std::unique_ptr<MechanicalSystem> body(const Case& kind, double lambda) {
  TetMesh mesh = small_block({2, 1, 2});
  if (kind.quadratic) mesh = with_edge_vertices(mesh);
  const std::vector<int> region(mesh.tetrahedra.size(), 0);
  const std::vector<BodyRegion> regions{
      {NeoHookean(kIncompressibleLimit.mu, lambda, kind.part), 1000.0}};
  return std::make_unique<MechanicalSystem>(std::move(mesh), regions, region, kind.rule);
}

Vector gradient_of(const MechanicalSystem& system, const Vector& x) {
  double energy = 0.0;
  Vector gradient;
  EXPECT_TRUE(system.elastic_energy_and_gradient(x, energy, gradient).ok());
  return gradient;
}

class VolumetricPressureOf : public testing::TestWithParam<Case> {
 protected:
  std::unique_ptr<MechanicalSystem> system_ = body(GetParam(), kIncompressibleLimit.lambda);
  VolumetricPressure volume_{*system_};
  Vector x_ = jiggled(system_->mesh().rest_positions(), 0.05);
  Vector way_ = jiggled(Vector::Zero(x_.size()), 1.0, 11);
  static constexpr double kStep = 1e-6;

  Vector pressures(const Vector& x) const {
    Vector first;
    Vector second;
    volume_.derivatives(x, first, second);
    return first;
  }
  Vector forces(const Vector& x, const Vector& p) const {
    Vector sum = Vector::Zero(x.size());
    volume_.add_forces(x, p, sum);
    return sum;
  }
};

// With p = U'(J) they are what the body has more of than one without U.
TEST_P(VolumetricPressureOf, ForcesAreThoseOfTheVolumetricEnergy) {
  const Case without{"", GetParam().quadratic, VolumeRule::kElement, GetParam().part};
  const Vector all = gradient_of(*system_, x_);
  const Vector rest = gradient_of(*body(without, 0.0), x_);
  EXPECT_LT((forces(x_, pressures(x_)) - (all - rest)).norm(), 1e-12 * all.norm());
  EXPECT_GT((all - rest).norm(), 0.5 * all.norm());
}

TEST_P(VolumetricPressureOf, RatesAreDerivatives) {
  Vector first;
  Vector second;
  volume_.derivatives(x_, first, second);
  const Vector difference =
      (pressures(x_ + kStep * way_) - pressures(x_ - kStep * way_)) / (2.0 * kStep);
  const Vector exact = second.cwiseProduct(volume_.rates(x_, way_));
  EXPECT_LT((exact - difference).norm(), 1e-7 * exact.norm());
}

TEST_P(VolumetricPressureOf, CurvatureIsTheDerivativeOfForcesAtConstantPressure) {
  const SparsityPattern pattern(system_->rest(), system_->coordinates(), {});
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  const Vector p = jiggled(Vector::Zero(pressures(x_).size()), 1e6, 5);
  volume_.add_curvature(x_, p, pattern, values.data());
  const Vector difference =
      (forces(x_ + kStep * way_, p) - forces(x_ - kStep * way_, p)) / (2.0 * kStep);
  const FreeCoordinates& free = system_->coordinates();
  const Vector exact = dense_matrix(pattern, values) * free.restrict(way_);
  EXPECT_LT((exact - free.restrict(difference)).norm(), 1e-7 * exact.norm());
}

INSTANTIATE_TEST_SUITE_P(
    All, VolumetricPressureOf,
    testing::Values(Case{"linear", false, VolumeRule::kElement, VolumetricPart::kLogarithmic},
                    Case{"nodal", false, VolumeRule::kNodal, VolumetricPart::kLogarithmic},
                    Case{"nodal_quadratic_law", false, VolumeRule::kNodal,
                         VolumetricPart::kQuadratic},
                    Case{"quadratic", true, VolumeRule::kElement, VolumetricPart::kLogarithmic}),
    [](const auto& test) { return test.param.name; });

TEST(VolumetricPressure, DominatesWhereTheRatioIsReachedSomewhere) {
  const Case kind{"", false, VolumeRule::kElement, VolumetricPart::kLogarithmic};
  EXPECT_TRUE(VolumetricPressure::dominates(*body(kind, 30.0 * kIncompressibleLimit.mu), 30.0));
  EXPECT_FALSE(VolumetricPressure::dominates(*body(kind, 29.0 * kIncompressibleLimit.mu), 30.0));
  const MechanicalSystem stvk(small_block(), StVenantKirchhoff(1.0, 1e4), 1000.0);
  EXPECT_FALSE(VolumetricPressure::dominates(stvk, 30.0));
}

}  // namespace
}  // namespace tetraction
