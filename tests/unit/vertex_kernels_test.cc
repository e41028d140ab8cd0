#include "dynamics/terms/vertex_kernels.h"

#include <cmath>
#include <limits>

#include "support/bodies.h"
#include "support/instruction_sets.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr Index kMost = 40;
constexpr double kRound = 4e-16;  // of single operations: a fused one may round differently

class VertexKernels : public testing::TestWithParam<std::int64_t> {
 protected:
  const UseInstructionSet use_{GetParam()};
  const Vector q_ = jiggled(Vector::Zero(3 * kMost), 2.0, 1);
  const Vector p_ = jiggled(Vector::Zero(3 * kMost), 3.0, 2);
  const Vector gradient_ = jiggled(Vector::Zero(3 * kMost), 5.0, 3);
  const Vector force_ = jiggled(Vector::Zero(3 * kMost), 4.0, 4);
  const Vector mass_ = jiggled(Vector::Constant(kMost, 2.0), 1.5, 5);
  const Vector inverse_ = mass_.cwiseInverse();

  VertexKick kick(bool with_force) const {
    return {mass_.data(),      inverse_.data(),
            gradient_.data(),  with_force ? force_.data() : nullptr,
            {0.3, -9.81, 2.0}, 0.037};
  }
  // p + dt (f + m a − ∇W) by Eigen.
  Vector kicked(const VertexKick& k) const {
    Vector result = p_;
    for (Index v = 0; v < kMost; ++v) {
      Vector3 force = mass_[v] * k.acceleration - gradient_.segment<3>(3 * v);
      if (k.force != nullptr) force += force_.segment<3>(3 * v);
      result.segment<3>(3 * v) += k.dt * force;
    }
    return result;
  }
};

// `actual` is `inside` in [3 begin, 3 end) up to round-off and bitwise `outside` elsewhere.
void expect_range(const Vector& actual, Index begin, Index end, const Vector& inside,
                  const Vector& outside) {
  for (Index i = 0; i < actual.size(); ++i) {
    if (i >= 3 * begin && i < 3 * end) {
      EXPECT_NEAR(actual[i], inside[i], kRound * 20.0) << i;
    } else {
      EXPECT_EQ(actual[i], outside[i]) << i;
    }
  }
}

TEST_P(VertexKernels, KickAndDriftAnyRange) {
  const double h = 0.11;
  for (const bool with_force : {false, true}) {
    const VertexKick k = kick(with_force);
    const Vector p = kicked(k);
    Vector velocity(p.size());
    for (Index v = 0; v < kMost; ++v) velocity.segment<3>(3 * v) = p.segment<3>(3 * v) / mass_[v];
    const Vector q = q_ + h * velocity;
    const Vector untouched = Vector::Constant(3 * kMost, -77.0);
    for (const Index begin : {0, 1, 3}) {
      for (Index end = begin; end <= kMost; ++end) {
        Vector p_out = untouched;
        Vector v_out = untouched;
        Vector q_out = untouched;
        EXPECT_TRUE(kick_and_drift(begin, end, k, h, q_.data(), p_.data(), p_out.data(),
                                   v_out.data(), q_out.data()));
        expect_range(p_out, begin, end, p, untouched);
        expect_range(v_out, begin, end, velocity, untouched);
        expect_range(q_out, begin, end, q, untouched);
      }
    }
  }
}

TEST_P(VertexKernels, KickAndDriftInPlace) {
  const VertexKick k = kick(true);
  Vector p = p_;
  Vector q = q_;
  Vector v(3 * kMost);
  Vector p_out(3 * kMost);
  Vector q_out(3 * kMost);
  Vector v_out(3 * kMost);
  kick_and_drift(0, kMost, k, 0.1, q_.data(), p_.data(), p_out.data(), v_out.data(), q_out.data());
  kick_and_drift(0, kMost, k, 0.1, q.data(), p.data(), p.data(), v.data(), q.data());
  EXPECT_EQ(p, p_out);
  EXPECT_EQ(q, q_out);
  EXPECT_EQ(v, v_out);
}

TEST_P(VertexKernels, KickOnlyAnyRange) {
  for (const bool with_force : {false, true}) {
    const VertexKick k = kick(with_force);
    const Vector expected = kicked(k);
    for (const Index begin : {0, 1, 3}) {
      for (Index end = begin; end <= kMost; ++end) {
        Vector p = p_;
        kick_only(begin, end, k, p.data());
        expect_range(p, begin, end, expected, p_);
      }
    }
  }
}

TEST_P(VertexKernels, SumsOfAnyRange) {
  for (const Index begin : {0, 1, 3}) {
    for (Index end = begin; end <= kMost; ++end) {
      VertexSums expected;
      for (Index v = begin; v < end; ++v) {
        const Vector3 q = q_.segment<3>(3 * v);
        const Vector3 p = p_.segment<3>(3 * v);
        VertexSums one;
        one.linear = p;
        one.angular = Vector3(q.y() * p.z() - q.z() * p.y(), q.z() * p.x() - q.x() * p.z(),
                              q.x() * p.y() - q.y() * p.x());
        one.linear_scale = p.norm();
        one.angular_scale = one.angular.norm();
        one.twice_kinetic = p.squaredNorm() / mass_[v];
        one.first_moment = mass_[v] * q;
        expected += one;
      }
      const VertexSums sums =
          vertex_sums(begin, end, mass_.data(), inverse_.data(), q_.data(), p_.data());
      const double scale = static_cast<double>(1 + end - begin);
      EXPECT_LT((sums.linear - expected.linear).norm(), 1e-15 * (1.0 + expected.linear_scale));
      EXPECT_LT((sums.angular - expected.angular).norm(), 1e-15 * (1.0 + expected.angular_scale));
      EXPECT_LT((sums.first_moment - expected.first_moment).norm(), 1e-14 * scale);
      EXPECT_NEAR(sums.linear_scale, expected.linear_scale, 1e-14 * scale);
      EXPECT_NEAR(sums.angular_scale, expected.angular_scale, 1e-14 * scale);
      EXPECT_NEAR(sums.twice_kinetic, expected.twice_kinetic, 1e-14 * expected.twice_kinetic);
    }
  }
}

TEST_P(VertexKernels, EveryNumberThatIsNotFiniteIsFound) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Index count : {1, 2, 7, 8, 9, 16, 23, 40}) {
    for (Index i = 0; i < 3 * count; ++i) {
      for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
        Vector p = p_;
        p[i] = bad;
        Vector p_out(3 * kMost);
        Vector v_out(3 * kMost);
        Vector q_out(3 * kMost);
        EXPECT_FALSE(kick_and_drift(0, count, kick(false), 0.1, q_.data(), p.data(), p_out.data(),
                                    v_out.data(), q_out.data()))
            << count << " " << i;
        EXPECT_FALSE(std::isfinite(q_out[i]));
        // Behind the range it does not matter.
        EXPECT_TRUE(kick_and_drift(0, i / 3, kick(false), 0.1, q_.data(), p.data(), p_out.data(),
                                   v_out.data(), q_out.data()));
      }
    }
    // Finite numbers that overflow.
    Vector p = p_;
    p[3 * count - 1] = 1e308;
    Vector out(3 * kMost);
    Vector v_out(3 * kMost);
    Vector q_out(3 * kMost);
    EXPECT_FALSE(kick_and_drift(0, count, kick(false), 1e3, q_.data(), p.data(), out.data(),
                                v_out.data(), q_out.data()));
  }
}

INSTANTIATE_TEST_SUITE_P(All, VertexKernels, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return instruction_set_name(test.param); });

}  // namespace
}  // namespace tetraction
