// Continuous collision detection: the way that it allows is free, and little of the free way is lost.
#include "dynamics/contact/pairs/additive_ccd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetraction {
namespace {

double smallest_distance(PairKind kind, const PairPoints& p, const PairPoints& m, double from,
                         double to) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= 400; ++k) {
    const double t = from + (to - from) * k / 400.0;
    smallest = std::min(smallest, pair_distance(kind, p + t * m).squared);
  }
  return std::sqrt(smallest);
}

// Triangles and edges of all shapes, and needles; moves that are far longer than the distance.
TEST(AdditiveCcd, TheWayIsFreeAndNotMuchShorterThanItCouldBe) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int stopped = 0;
  for (const double size : {1e-3, 1.0, 1e3}) {
    for (int trial = 0; trial < 1500; ++trial) {
      PairPoints p = size * PairPoints::NullaryExpr([&] { return uniform(random); });
      PairPoints m = size * PairPoints::NullaryExpr([&] { return uniform(random); });
      m *= std::pow(10.0, trial % 4 - 2);
      if (trial % 3 == 0) {
        p.col(3) = p.col(2) + 1e-5 * (p.col(3) - p.col(2));
        m.col(3) = m.col(2);
      }
      for (const PairKind kind : {PairKind::kPointPoint, PairKind::kPointEdge,
                                  PairKind::kPointTriangle, PairKind::kEdgeEdge}) {
        const double start = std::sqrt(pair_distance(kind, p).squared);
        if (start < 1e-9 * size) continue;
        const double cap = trial % 2 == 0 ? 0.01 * size : size;
        const double reference = std::min(start, cap);
        const double t = first_touch(kind, p, m, cap);
        ASSERT_GE(t, 0.0);
        ASSERT_LE(t, 1.0);
        EXPECT_GT(t, 0.0);
        EXPECT_GE(smallest_distance(kind, p, m, 0.0, t), 0.0099 * reference);
        if (t < 1.0) {
          ++stopped;
          EXPECT_LT(std::sqrt(pair_distance(kind, p + t * m).squared), 0.1001 * reference)
              << static_cast<int>(kind) << " " << trial;
        }
      }
    }
  }
  EXPECT_GT(stopped, 100);
}

// A point through the inside of a triangle; the step must end on the first side of it.
TEST(AdditiveCcd, PointsDoNotPassTriangles) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 3000; ++trial) {
    PairPoints p = PairPoints::NullaryExpr([&] { return uniform(random); });
    const double a = 0.3 + 0.05 * uniform(random);
    const Vector3 target = a * p.col(1) + a * p.col(2) + (1.0 - 2.0 * a) * p.col(3);
    p.col(0) =
        target + std::pow(10.0, -(trial % 10)) * Vector3(uniform(random), uniform(random), 1);
    PairPoints m = PairPoints::Zero();
    m.col(0) = 2.0 * (target - p.col(0));
    if (!(pair_distance(PairKind::kPointTriangle, p).squared > 0.0)) continue;
    const double t = first_touch(PairKind::kPointTriangle, p, m, 1.0);
    EXPECT_LT(t, 0.5);
    const double start = std::sqrt(pair_distance(PairKind::kPointTriangle, p).squared);
    const double end = std::sqrt(pair_distance(PairKind::kPointTriangle, p + t * m).squared);
    EXPECT_LT(end, 0.1001 * start) << trial;
    EXPECT_GT(end, 0.0099 * std::min(start, 1.0)) << trial;
  }
}

TEST(AdditiveCcd, SlidingAndPartingPairsGoAllTheWay) {
  PairPoints p;
  p.col(0) = Vector3(0.1, 0.1, 1e-6);
  p.col(1) = Vector3(0, 0, 0);
  p.col(2) = Vector3(10, 0, 0);
  p.col(3) = Vector3(0, 10, 0);
  PairPoints m = PairPoints::Zero();
  m.col(0) = Vector3(5, 2, 0);
  EXPECT_EQ(first_touch(PairKind::kPointTriangle, p, m, 1.0), 1.0);
  m.col(0) = Vector3(5, 2, 3);
  EXPECT_EQ(first_touch(PairKind::kPointTriangle, p, m, 1.0), 1.0);
  // From far away nearly to the surface, which only matters below a tenth of the cap.
  p.col(0) = Vector3(1, 1, 10);
  m.col(0) = Vector3(0, 0, -9.99);
  EXPECT_EQ(first_touch(PairKind::kPointTriangle, p, m, 0.01), 1.0);
  EXPECT_LT(first_touch(PairKind::kPointTriangle, p, m, 1.0), 1.0);
  p.col(0) = Vector3(1, 1, 0);
  EXPECT_EQ(first_touch(PairKind::kPointTriangle, p, m, 1.0), 0.0);
}

}  // namespace
}  // namespace tetraction
