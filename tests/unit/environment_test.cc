#include "tetraction/dynamics/terms/environment.h"

#include <cmath>
#include <limits>

#include "support/bodies.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

TEST(Environment, GradientAndHessianAreDerivativesOfTheValue) {
  const Vector3 q(0.3, -0.5, 0.8);
  const double mass = 2.5;
  const double h = 1e-5;
  for (const Environment& environment :
       {Environment(), Environment::uniform({1.0, -9.81, 0.5}), Environment::attraction(3.0),
        Environment::attraction(3.0, 0.4)}) {
    for (int i = 0; i < 3; ++i) {
      const Vector3 e = h * Vector3::Unit(i);
      const double slope =
          (environment.value(mass, Vector3(q + e)) - environment.value(mass, Vector3(q - e))) /
          (2.0 * h);
      EXPECT_NEAR(environment.gradient(mass, q)[i], slope, 1e-8);
      const Vector3 bend =
          (environment.gradient(mass, q + e) - environment.gradient(mass, q - e)) / (2.0 * h);
      EXPECT_LT((environment.hessian(mass, q).col(i) - bend).norm(), 1e-8);
    }
  }
}

TEST(Environment, AttractionPullsTowardTheOriginWithTheInverseSquare) {
  const Environment attraction = Environment::attraction(4.0);
  const Vector3 q(0.0, 2.0, 0.0);
  EXPECT_LT((attraction.gradient(1.0, q) - Vector3(0.0, 1.0, 0.0)).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(attraction.value(1.0, q), -2.0);
  // The same for every mass.
  EXPECT_EQ(attraction.gradient(1.0, q), attraction.gradient(7.0, q));
}

TEST(Environment, NothingActsAtTheOriginAndNearItThereIsNoNan) {
  for (const Environment& environment :
       {Environment::attraction(4.0), Environment::attraction(4.0, 0.1)}) {
    EXPECT_EQ(environment.gradient(1.0, Vector3::Zero()), Vector3::Zero());
    EXPECT_TRUE(std::isfinite(environment.value(1.0, Vector3::Zero())));
    for (const double distance : {1e-10, 1e-100, 1e-200, 1e-308, 5e-324}) {
      const Vector3 q(distance, 0.0, 0.0);
      const Vector3 gradient = environment.gradient(1.0, q);
      for (int i = 0; i < 3; ++i) EXPECT_FALSE(std::isnan(gradient[i])) << distance;
      EXPECT_GE(gradient[0], 0.0);
    }
    EXPECT_TRUE(environment.gradient(1.0, Vector3(1e200, 1e200, 0.0)).allFinite());
  }
}

TEST(Environment, RefusesWhatIsNotFinite) {
  EXPECT_THROW(Environment::uniform({std::nan(""), 0.0, 0.0}), InputError);
  EXPECT_THROW(Environment::attraction(std::numeric_limits<double>::infinity()), InputError);
  EXPECT_THROW(Environment::attraction(1.0, -0.1), InputError);
}

}  // namespace
}  // namespace tetraction
