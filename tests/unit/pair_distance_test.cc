// Distances of contact pairs: the conditions of a minimum, and derivatives against differences.
#include "dynamics/contact/pairs/pair_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace tetraction {
namespace {

constexpr PairKind kAllPairKinds[] = {PairKind::kPointPoint, PairKind::kPointEdge,
                                      PairKind::kPointTriangle, PairKind::kEdgeEdge};

PairPoints random_pair_points(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return PairPoints::NullaryExpr([&] { return uniform(random); });
}

// The closest points lie in their sides, v joins them, and no point of either side is nearer: for a convex
// problem these conditions are sufficient.
void expect_minimum(PairKind kind, const PairPoints& p, double tolerance) {
  const PairDistance d = pair_distance(kind, p);
  const int first = first_side_size(kind);
  const double size = p.leftCols(pair_size(kind)).cwiseAbs().maxCoeff();
  Vector3 closest[2] = {Vector3::Zero(), Vector3::Zero()};
  double sums[2] = {0.0, 0.0};
  for (int i = 0; i < pair_size(kind); ++i) {
    const int side = i < first ? 0 : 1;
    const double w = side == 0 ? d.weights[i] : -d.weights[i];
    ASSERT_GE(w, 0.0);
    sums[side] += w;
    closest[side] += w * p.col(i);
  }
  for (int i = pair_size(kind); i < 4; ++i) ASSERT_EQ(d.weights[i], 0.0);
  EXPECT_NEAR(sums[0], 1.0, 1e-14);
  EXPECT_NEAR(sums[1], 1.0, 1e-14);
  EXPECT_LE((closest[0] - closest[1] - d.difference).norm(), tolerance * size);
  EXPECT_NEAR(d.squared, d.difference.squaredNorm(), 1e-15 * d.squared);
  const double length = std::sqrt(d.squared);
  for (int i = 0; i < pair_size(kind); ++i) {
    const int side = i < first ? 0 : 1;
    const double towards = d.difference.dot(p.col(i) - closest[side]);
    EXPECT_GE(side == 0 ? towards : -towards, -tolerance * size * length);
  }
}

TEST(PairDistance, IsTheMinimumForRandomPairs) {
  std::mt19937 random(1);
  for (const double size : {1e-3, 1.0, 1e3}) {
    for (int trial = 0; trial < 3000; ++trial) {
      const PairPoints p = random_pair_points(random, size);
      for (const PairKind kind : kAllPairKinds) expect_minimum(kind, p, 1e-11);
    }
  }
}

TEST(PairDistance, IsTheMinimumForNeedlesAndSides) {
  std::mt19937 random(2);
  for (const double height : {1e-2, 1e-4, 1e-8, 0.0}) {
    for (int trial = 0; trial < 1000; ++trial) {
      // A triangle whose third corner is nearly on the first edge, and nearly parallel edges.
      PairPoints p = random_pair_points(random, 1.0);
      std::uniform_real_distribution<double> uniform(-0.5, 1.5);
      const double t = uniform(random);
      const Vector3 off = random_pair_points(random, height).col(0);
      p.col(3) = p.col(1) + t * (p.col(2) - p.col(1)) + off;
      expect_minimum(PairKind::kPointTriangle, p, 1e-7);
      PairPoints q = p;
      q.col(3) = q.col(2) + t * (q.col(1) - q.col(0)) + off;
      expect_minimum(PairKind::kEdgeEdge, q, 1e-7);
    }
  }
}

TEST(PairDistance, KnowsTheClosestFeaturesOfATriangle) {
  PairPoints p;
  p.col(1) = Vector3(0, 0, 0);
  p.col(2) = Vector3(1, 0, 0);
  p.col(3) = Vector3(0, 1, 0);
  const auto at = [&](double x, double y) {
    p.col(0) = Vector3(x, y, 2.0);
    return pair_distance(PairKind::kPointTriangle, p);
  };
  EXPECT_DOUBLE_EQ(at(0.25, 0.25).squared, 4.0);
  EXPECT_TRUE(at(0.25, 0.25).weights.isApprox(PairWeights(1, -0.5, -0.25, -0.25)));
  EXPECT_DOUBLE_EQ(at(0.5, -1).squared, 5.0);
  EXPECT_TRUE(at(0.5, -1).weights.isApprox(PairWeights(1, -0.5, -0.5, 0)));
  EXPECT_DOUBLE_EQ(at(1, 1).squared, 4.5);
  EXPECT_TRUE(at(1, 1).weights.isApprox(PairWeights(1, 0, -0.5, -0.5)));
  EXPECT_DOUBLE_EQ(at(-1, -1).squared, 6.0);
  EXPECT_TRUE(at(-1, -1).weights.isApprox(PairWeights(1, -1, 0, 0)));
  EXPECT_DOUBLE_EQ(at(3, 0).squared, 8.0);
  EXPECT_DOUBLE_EQ(at(0, 3).squared, 8.0);
}

TEST(PairDistance, ParallelAndCrossingEdges) {
  PairPoints p;
  p.col(0) = Vector3(0, 0, 0);
  p.col(1) = Vector3(1, 0, 0);
  p.col(2) = Vector3(0.5, 0.1, 0);
  p.col(3) = Vector3(2.5, 0.1, 0);
  EXPECT_NEAR(pair_distance(PairKind::kEdgeEdge, p).squared, 0.01, 1e-16);
  p.col(3) = Vector3(0.7, -0.4, 0);
  EXPECT_NEAR(pair_distance(PairKind::kEdgeEdge, p).squared, 0.0, 1e-30);
  p.col(2) = p.col(3);
  EXPECT_NEAR(pair_distance(PairKind::kEdgeEdge, p).squared, 0.16, 1e-15);
}

TEST(PairDistance, DerivativesAgreeWithDifferences) {
  std::mt19937 random(3);
  for (const double size : {1e-3, 1.0, 1e3}) {
    int compared = 0;
    for (int trial = 0; trial < 300; ++trial) {
      const PairPoints p = random_pair_points(random, size);
      for (const PairKind kind : kAllPairKinds) {
        const PairDistance d = pair_distance(kind, p);
        const PairVector gradient = squared_distance_gradient(d);
        const PairMatrix hessian = squared_distance_hessian(kind, p, d);
        EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-12 * hessian.norm());
        const double h = 1e-5 * size;
        PairVector slope = PairVector::Zero();
        PairMatrix bend = PairMatrix::Zero();
        bool same = true;
        for (int k = 0; k < 3 * pair_size(kind) && same; ++k) {
          PairDistance ends[2];
          for (const int side : {0, 1}) {
            PairPoints q = p;
            q(k % 3, k / 3) += side == 0 ? -h : h;
            ends[side] = pair_distance(kind, q);
            for (int i = 0; i < 4; ++i) {
              same = same && (ends[side].weights[i] == 0.0) == (d.weights[i] == 0.0);
            }
          }
          slope[k] = (ends[1].squared - ends[0].squared) / (2.0 * h);
          bend.col(k) =
              (squared_distance_gradient(ends[1]) - squared_distance_gradient(ends[0])) / (2.0 * h);
        }
        if (!same) continue;
        // Where edges or a triangle are nearly degenerate, the third derivatives are large.
        const Vector3 a = p.col(1) - p.col(0);
        const Vector3 b = p.col(3) - p.col(2);
        if (kind == PairKind::kEdgeEdge && a.cross(b).norm() < 0.2 * a.norm() * b.norm()) continue;
        const Vector3 c = p.col(2) - p.col(1);
        if (kind == PairKind::kPointTriangle && c.cross(b).norm() < 0.2 * c.norm() * b.norm()) {
          continue;
        }
        ++compared;
        EXPECT_LT((slope - gradient).norm(), 1e-7 * (gradient.norm() + size));
        EXPECT_LT((bend - hessian).norm(), 1e-5 * hessian.norm()) << static_cast<int>(kind);
      }
    }
    EXPECT_GT(compared, 600);
  }
}

}  // namespace
}  // namespace tetraction
