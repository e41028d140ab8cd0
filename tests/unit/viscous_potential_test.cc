#include "tetraction/fem/viscous_potential.h"

#include <Eigen/Geometry>

#include "support/assembled.h"
#include "support/bodies.h"
#include "support/instruction_sets.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

class Viscosity : public testing::TestWithParam<std::int64_t> {
 protected:
  const UseInstructionSet use_{GetParam()};
  const TetMesh mesh_ = small_block({2, 2, 1});
  const RestState rest_{mesh_};
  const ElasticPotential elastic_{rest_, all_materials()[1]};
  const Vector start_ = strained_state(elastic_, mesh_.rest_positions(), 0.2);
  const Vector x_ = jiggled(start_, 0.02);
  ViscousPotential viscous_{elastic_};

  double value(const Vector& x) const {
    double energy = 0.0;
    viscous_.add_value(x - start_, energy);
    return energy;
  }
  Vector gradient(const Vector& x) const {
    double energy = 0.0;
    Vector result = Vector::Zero(x.size());
    viscous_.add_value_and_gradient(x - start_, energy, result);
    EXPECT_EQ(energy, value(x));
    return result;
  }
  Vector3 torque(const Vector& x, const Vector& force) const {
    Vector3 sum = Vector3::Zero();
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      sum += x.segment<3>(3 * v).cross(force.segment<3>(3 * v));
    }
    return sum;
  }
};

TEST_P(Viscosity, GradientAndHessianAreDerivatives) {
  viscous_.begin(start_, 700.0);
  viscous_.set_estimate(jiggled(Vector::Zero(x_.size()), 0.05, 3));
  const Vector direction = jiggled(Vector::Zero(x_.size()), 1.0, 5);
  const double h = 1e-6;
  const Vector g = gradient(x_);
  ASSERT_GT(g.norm(), 1.0);
  EXPECT_NEAR(g.dot(direction), (value(x_ + h * direction) - value(x_ - h * direction)) / (2.0 * h),
              1e-7 * g.norm());
  const Vector bend = (gradient(x_ + h * direction) - gradient(x_ - h * direction)) / (2.0 * h);
  const SparsityPattern pattern(rest_, FreeCoordinates(mesh_.vertex_count()));
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  viscous_.add_hessian(x_ - start_, pattern, values.data());
  Vector product = sparse_product(pattern, values, direction);
  EXPECT_LT((product - bend).norm(), 1e-6 * bend.norm());

  // Element by element the same.
  Vector sum = Vector::Zero(x_.size());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    terms.gradient.setZero(3, 4);
    viscous_.add_element_terms(e, x_, false, terms);
    for (int a = 0; a < 4; ++a) {
      sum.segment<3>(3 * rest_.nodes(e)[static_cast<std::size_t>(a)]) += terms.gradient.col(a);
    }
  }
  EXPECT_LT((sum - g).norm(), 1e-12 * g.norm());
}

TEST_P(Viscosity, ForceIsThatOfTheStress) {
  const Vector velocity = jiggled(Vector::Zero(x_.size()), 1.0, 9);
  Vector force = Vector::Ones(x_.size());
  viscous_.add_force(50.0, x_, velocity, force);
  Vector expected = Vector::Ones(x_.size());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    const auto element = rest_.point(e);
    const Matrix3 f = deformation_gradient(element, 0, rest_.gather(x_, e));
    const Matrix3 rate =
        f.transpose() * deformation_gradient(element, 0, rest_.gather(velocity, e));
    const Matrix3 stress = 50.0 * (rate + rate.transpose());
    const RestState::Shape::NodeMatrix local =
        -element.weights[0] * f * stress * element.gradients[0];
    for (int a = 0; a < 4; ++a) {
      expected.segment<3>(3 * rest_.nodes(e)[static_cast<std::size_t>(a)]) += local.col(a);
    }
  }
  EXPECT_LT((force - expected).norm(), 1e-13 * expected.norm());
}

TEST_P(Viscosity, TakesNoMomentumAndOnlyEnergy) {
  const Vector velocity = jiggled(Vector::Zero(x_.size()), 1.0, 9);
  Vector force = Vector::Zero(x_.size());
  viscous_.add_force(50.0, x_, velocity, force);
  ASSERT_GT(force.norm(), 1.0);
  Vector3 sum = Vector3::Zero();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) sum += force.segment<3>(3 * v);
  EXPECT_LT(sum.norm(), 1e-12 * force.norm());
  EXPECT_LT(torque(x_, force).norm(), 1e-12 * force.norm());
  EXPECT_LT(force.dot(velocity), 0.0);

  viscous_.begin(start_, 700.0);
  const Vector g = gradient(x_);
  EXPECT_LT(torque(x_, g).norm(), 1e-12 * g.norm());
}

TEST_P(Viscosity, DoesNotResistRigidMotion) {
  const Vector3 w(0.3, -1.0, 0.7);
  Vector velocity(x_.size());
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    velocity.segment<3>(3 * v) = Vector3(1, 2, 3) + w.cross(x_.segment<3>(3 * v));
  }
  Vector force = Vector::Zero(x_.size());
  viscous_.add_force(50.0, x_, velocity, force);
  EXPECT_LT(force.norm(), 1e-11);

  // Backward Euler: x is q_k turned by any angle. Midpoint: x is half way to the turned q_{k+1}, and
  // Ė = sym(Fᵀ(F − F_k))/s is zero for a rotation by any angle, since |F + ΔF| = |F − ΔF|.
  const auto turned = [&](double angle) {
    const Matrix3 r = Eigen::AngleAxisd(angle, w.normalized()).toRotationMatrix();
    Vector q(start_.size());
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      q.segment<3>(3 * v) = r * start_.segment<3>(3 * v);
    }
    return q;
  };
  viscous_.begin(start_, 700.0);
  EXPECT_LT(gradient(turned(1.0)).norm(), 1e-9);
  const Vector middle = 0.5 * (start_ + turned(1.0));
  viscous_.set_estimate(middle - start_);
  EXPECT_LT(gradient(middle).norm(), 1e-9);
}

// With the estimate at x itself the stress is that of Ė = sym(Fᵀ(F − F_k))/s, and the force does work
// against the displacement, however large it is.
TEST_P(Viscosity, RateOfTheMotionAtTheMidpoint) {
  const Vector far = jiggled(x_, 0.5, 11);
  viscous_.begin(start_, 700.0);
  viscous_.set_estimate(far - start_);
  Vector expected = Vector::Zero(x_.size());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    const auto element = rest_.point(e);
    const Matrix3 f = deformation_gradient(element, 0, rest_.gather(far, e));
    const Matrix3 change = f - deformation_gradient(element, 0, rest_.gather(start_, e));
    const Matrix3 rate = f.transpose() * change;
    const RestState::Shape::NodeMatrix local =
        element.weights[0] * f * 700.0 * (rate + rate.transpose()) * element.gradients[0];
    for (int a = 0; a < 4; ++a) {
      expected.segment<3>(3 * rest_.nodes(e)[static_cast<std::size_t>(a)]) += local.col(a);
    }
  }
  const Vector g = gradient(far);
  ASSERT_GT(g.norm(), 1.0);
  EXPECT_LT((g - expected).norm(), 1e-12 * expected.norm());
  EXPECT_NEAR(g.dot(far - start_), 2.0 * value(far), 1e-12 * value(far));
}

INSTANTIATE_TEST_SUITE_P(All, Viscosity, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return instruction_set_name(test.param); });

}  // namespace
}  // namespace tetraction
