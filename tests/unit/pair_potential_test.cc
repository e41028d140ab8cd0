// The potential of contact pairs: derivatives, and the identities of the discrete gradient.
#include "dynamics/contact/pairs/pair_potential.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

namespace tetraction {
namespace {

constexpr PairKind kPotentialKinds[] = {PairKind::kPointPoint, PairKind::kPointEdge,
                                        PairKind::kPointTriangle, PairKind::kEdgeEdge};

// Two sides at a distance within the layer, d̂ = size/2; sometimes nearly parallel edges.
PairPoints close_pair(PairKind kind, std::mt19937& random, double size, bool parallel) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (;;) {
    PairPoints p = size * PairPoints::NullaryExpr([&] { return uniform(random); });
    if (parallel) {
      p.col(3) = p.col(2) + uniform(random) * (p.col(1) - p.col(0)) +
                 0.01 * size * Vector3(uniform(random), uniform(random), uniform(random));
    }
    const PairDistance d = pair_distance(kind, p);
    const double length = std::sqrt(d.squared);
    if (length < 1e-3 * size) continue;
    // Move the first side to the wanted distance.
    const double wanted = size * 0.5 * std::pow(10.0, -1.5 + 1.7 * std::abs(uniform(random)));
    for (int i = 0; i < first_side_size(kind); ++i) {
      p.col(i) += (wanted / length - 1.0) * d.difference;
    }
    return p;
  }
}

ContactPair pair_of(PairKind kind, const PairPoints& p, double size) {
  ContactPair pair;
  pair.kind = kind;
  pair.weight = 0.3 * size * size;
  if (kind == PairKind::kEdgeEdge) {
    pair.parallel = parallel_limit(p.col(1) - p.col(0), p.col(3) - p.col(2));
  }
  return pair;
}

PairPoints moved(const PairPoints& p, std::mt19937& random, double by) {
  std::uniform_real_distribution<double> uniform(-by, by);
  return p + PairPoints::NullaryExpr([&] { return uniform(random); });
}

TEST(PairPotential, DerivativesAgreeWithDifferences) {
  std::mt19937 random(4);
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Barrier barrier{0.5 * size, 2e5};
    int compared = 0;
    for (int trial = 0; trial < 400; ++trial) {
      for (const PairKind kind : kPotentialKinds) {
        const bool parallel = kind == PairKind::kEdgeEdge && trial % 2 == 0;
        const PairPoints p = close_pair(kind, random, size, parallel);
        const ContactPair pair = pair_of(kind, p, size);
        const PairVector gradient = pair_gradient(barrier, pair, p);
        const PairMatrix hessian = pair_hessian(barrier, pair, p);
        const PairDistance d = pair_distance(kind, p);
        const double h = 1e-6 * size;
        PairVector slope = PairVector::Zero();
        PairMatrix bend = PairMatrix::Zero();
        bool same = std::sqrt(d.squared) > 0.1 * barrier.thickness;
        for (int k = 0; k < 3 * pair_size(kind) && same; ++k) {
          PairPoints q[2] = {p, p};
          for (const int side : {0, 1}) {
            q[side](k % 3, k / 3) += side == 0 ? -h : h;
            const PairDistance other = pair_distance(kind, q[side]);
            for (int i = 0; i < 4; ++i) {
              same = same && (other.weights[i] == 0.0) == (d.weights[i] == 0.0);
            }
          }
          slope[k] =
              (pair_energy(barrier, pair, q[1]) - pair_energy(barrier, pair, q[0])) / (2.0 * h);
          bend.col(k) =
              (pair_gradient(barrier, pair, q[1]) - pair_gradient(barrier, pair, q[0])) / (2.0 * h);
        }
        const double force = barrier.stiffness * pair.weight;
        if (!same) continue;
        if (kind == PairKind::kPointTriangle) {
          const Vector3 u = p.col(2) - p.col(1);
          const Vector3 v = p.col(3) - p.col(1);
          if (u.cross(v).norm() < 0.1 * u.norm() * v.norm()) continue;
        }
        ++compared;
        EXPECT_LT((slope - gradient).norm(), 1e-5 * (gradient.norm() + 1e-2 * force));
        const Vector3 a = p.col(1) - p.col(0);
        const Vector3 b = p.col(3) - p.col(2);
        // Interior closest points of nearly parallel edges move fast.
        const bool sharp = kind == PairKind::kEdgeEdge && d.weights.minCoeff() < 0.0 &&
                           a.cross(b).norm() < 0.1 * a.norm() * b.norm();
        if (!sharp) {
          EXPECT_LT((bend - hessian).norm(), 1e-4 * (hessian.norm() + 1e-2 * force / size))
              << static_cast<int>(kind) << " " << trial;
        }
      }
    }
    EXPECT_GT(compared, 500);
  }
}

// Needles, whose weights are ill-conditioned, make the largest errors.
// For moves of all sizes, through changes of the closest features and of the mollifier.
TEST(PairPotential, DiscreteGradientGivesTheChangeOfEnergyAndNoResultant) {
  std::mt19937 random(5);
  double worst_energy = 0.0;
  double worst_sum = 0.0;
  double worst_moment = 0.0;
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Barrier barrier{0.5 * size, 2e5};
    for (int trial = 0; trial < 2000; ++trial) {
      for (const PairKind kind : kPotentialKinds) {
        const bool parallel = kind == PairKind::kEdgeEdge && trial % 2 == 0;
        const PairPoints p = close_pair(kind, random, size, parallel);
        const PairPoints q = moved(p, random, size * std::pow(10.0, -(trial % 9)));
        const ContactPair pair = pair_of(kind, p, size);
        if (pair_distance(kind, q).squared < 1e-6 * size * size) continue;
        const MeanPair mean = mean_pair(barrier, pair, p, q);
        const double u0 = pair_energy(barrier, pair, p);
        const double u1 = pair_energy(barrier, pair, q);
        double work = 0.0;
        double scale = std::max(std::abs(u0), std::abs(u1));
        Vector3 sum = Vector3::Zero();
        Vector3 moment = Vector3::Zero();
        for (int i = 0; i < 4; ++i) {
          const Vector3 f = mean.gradient.segment<3>(3 * i);
          work += f.dot(q.col(i) - p.col(i));
          sum += f;
          moment += (0.5 * (p.col(i) + q.col(i))).cross(f);
        }
        if (scale > 0.0) worst_energy = std::max(worst_energy, std::abs(work - u1 + u0) / scale);
        const double force = mean.gradient.norm();
        if (force > 0.0) {
          worst_sum = std::max(worst_sum, sum.norm() / force);
          worst_moment = std::max(worst_moment, moment.norm() / (force * size));
        }
        EXPECT_GE(mean.force, 0.0);
      }
    }
  }
  EXPECT_LT(worst_energy, 1e-11);
  EXPECT_LT(worst_sum, 1e-14);
  EXPECT_LT(worst_moment, 1e-12);
}

TEST(PairPotential, DiscreteGradientTendsToTheGradient) {
  std::mt19937 random(6);
  const Barrier barrier{0.5, 2e5};
  for (int trial = 0; trial < 300; ++trial) {
    for (const PairKind kind : kPotentialKinds) {
      const PairPoints p = close_pair(kind, random, 1.0, false);
      const ContactPair pair = pair_of(kind, p, 1.0);
      const PairVector exact = pair_gradient(barrier, pair, p);
      EXPECT_LE((mean_pair(barrier, pair, p, p).gradient - exact).norm(), 1e-9 * exact.norm());
      if (kind == PairKind::kPointTriangle || kind == PairKind::kEdgeEdge) {
        const PairPoints q = moved(p, random, 1e-9);
        EXPECT_LT((mean_pair(barrier, pair, p, q).gradient - exact).norm(),
                  1e-4 * exact.norm() + 1e-3);
      }
      const PairMatrix half = 0.5 * pair_hessian(barrier, pair, p);
      EXPECT_LE((mean_pair_hessian(barrier, pair, p, p) - half).norm(), 1e-7 * half.norm());
    }
  }
}

// Most of the derivative of the discrete gradient: a step of moderate size.
TEST(PairPotential, DiscreteHessianIsNearTheDerivative) {
  std::mt19937 random(7);
  const Barrier barrier{0.5, 2e5};
  std::vector<double> errors;
  for (int trial = 0; trial < 400; ++trial) {
    for (const PairKind kind : {PairKind::kPointTriangle, PairKind::kEdgeEdge}) {
      const PairPoints p = close_pair(kind, random, 1.0, false);
      const ContactPair pair = pair_of(kind, p, 1.0);
      const double d = std::sqrt(pair_distance(kind, p).squared);
      if (d > 0.4 || d < 0.05) continue;
      const PairPoints q = moved(p, random, 0.1 * d);
      const PairMatrix h = mean_pair_hessian(barrier, pair, p, q);
      PairMatrix bend;
      for (int k = 0; k < 12; ++k) {
        PairPoints a = q;
        PairPoints b = q;
        a(k % 3, k / 3) -= 1e-6;
        b(k % 3, k / 3) += 1e-6;
        bend.col(k) =
            (mean_pair(barrier, pair, p, b).gradient - mean_pair(barrier, pair, p, a).gradient) /
            2e-6;
      }
      bend = (0.5 * (bend + bend.transpose())).eval();
      errors.push_back((bend - h).norm() / bend.norm());
    }
  }
  ASSERT_GT(errors.size(), 100U);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.05);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.3);
}

// However large the step, the mean is defined where the points would meet at the mean positions.
TEST(PairPotential, DiscreteGradientThroughTheOtherSide) {
  const Barrier barrier{0.1, 1e6};
  PairPoints p;
  p.col(0) = Vector3(0.2, 0.3, 0.05);
  p.col(1) = Vector3(0, 0, 0);
  p.col(2) = Vector3(1, 0, 0);
  p.col(3) = Vector3(0, 1, 0);
  PairPoints q = p;
  q(2, 0) = -0.05;
  const ContactPair pair{PairKind::kPointTriangle, 1.0, 0.0};
  EXPECT_TRUE(mean_pair(barrier, pair, p, q).gradient.allFinite());
  q(2, 0) = -0.02;
  const MeanPair mean = mean_pair(barrier, pair, p, q);
  const double work = mean.gradient[2] * (q(2, 0) - p(2, 0));
  EXPECT_NEAR(work, pair_energy(barrier, pair, q) - pair_energy(barrier, pair, p), 1e-9 * work);
}

}  // namespace
}  // namespace tetraction
