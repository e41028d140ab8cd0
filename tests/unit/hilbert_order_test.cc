#include "mesh/hilbert_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace tetraction {
namespace {

using Points = Eigen::Matrix<float, 3, Eigen::Dynamic>;

bool is_permutation_of_all(std::vector<Index> order, Index count) {
  std::sort(order.begin(), order.end());
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return order == all;
}

// Points in the middles of an n × n × n grid's cells, in a random order. The two corners of the cube
// come last: they pin the bounding box to the grid.
Points grid(int n, unsigned seed) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < n * n * n; ++i) {
    points.push_back(Eigen::Vector3f(static_cast<float>(i % n), static_cast<float>(i / n % n),
                                     static_cast<float>(i / n / n)) +
                     Eigen::Vector3f::Constant(0.5F));
  }
  std::shuffle(points.begin(), points.end(), std::mt19937(seed));
  points.push_back(Eigen::Vector3f::Zero());
  points.push_back(Eigen::Vector3f::Constant(static_cast<float>(n)));
  Points result(3, static_cast<Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) result.col(static_cast<Index>(i)) = points[i];
  return result;
}

TEST(HilbertOrder, GoesFromCellToNeighbourOnAFullGrid) {
  for (const int n : {2, 4, 8, 16}) {
    const Points points = grid(n, 3);
    std::vector<Index> order = hilbert_order(points);
    ASSERT_TRUE(is_permutation_of_all(order, points.cols()));
    std::erase_if(order, [&](Index i) { return i >= points.cols() - 2; });
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
      EXPECT_EQ((points.col(order[i + 1]) - points.col(order[i])).norm(), 1.0F) << n << " " << i;
    }
  }
}

TEST(HilbertOrder, KeepsNeighboursTogetherInARandomCloud) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-3.0F, 5.0F);
  Points points(3, 4096);
  for (Index i = 0; i < points.size(); ++i) points(i % 3, i / 3) = place(random);
  const std::vector<Index> order = hilbert_order(points);
  ASSERT_TRUE(is_permutation_of_all(order, points.cols()));
  float sum = 0.0F;
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    sum += (points.col(order[i + 1]) - points.col(order[i])).norm();
  }
  // Cells with one point on average have an edge of 8/16.
  EXPECT_LT(sum / 4095.0F, 1.5F * 0.5F);
}

TEST(HilbertOrder, DoesNotDependOnTheNumberingBesideTies) {
  const Points points = grid(8, 1);
  const std::vector<Index> order = hilbert_order(points);
  Points reversed = points.rowwise().reverse();
  const std::vector<Index> other = hilbert_order(reversed);
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(points.col(order[i]), reversed.col(other[i]));
  }
}

TEST(HilbertOrder, TiesAreInTheOrderOfTheirNumbers) {
  const Points points = Points::Constant(3, 1000, 0.7F);
  const std::vector<Index> order = hilbert_order(points);
  ASSERT_EQ(order.size(), 1000U);
  EXPECT_TRUE(is_permutation_of_all(order, 1000));
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(HilbertOrder, DegenerateClouds) {
  EXPECT_TRUE(hilbert_order(Points(3, 0)).empty());
  EXPECT_EQ(hilbert_order(Points::Constant(3, 1, -2.0F)), std::vector<Index>{0});

  // Flat: still every step is to a neighbour.
  constexpr int kSide = 16;
  for (int normal = 0; normal < 3; ++normal) {
    Points flat(3, kSide * kSide + 2);
    for (Index i = 0; i < kSide * kSide; ++i) {
      flat.col(i).setZero();
      flat((normal + 1) % 3, i) = static_cast<float>(i % kSide) + 0.5F;
      flat((normal + 2) % 3, i) = static_cast<float>(i / kSide) + 0.5F;
    }
    flat.col(kSide * kSide).setZero();
    flat.col(kSide * kSide + 1).setConstant(static_cast<float>(kSide));
    flat(normal, kSide * kSide + 1) = 0.0F;
    std::vector<Index> order = hilbert_order(flat);
    ASSERT_TRUE(is_permutation_of_all(order, flat.cols()));
    std::erase_if(order, [](Index i) { return i >= kSide * kSide; });
    float sum = 0.0F;
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
      sum += (flat.col(order[i + 1]) - flat.col(order[i])).norm();
    }
    EXPECT_LT(sum / static_cast<float>(kSide * kSide), 2.0F);
  }

  // On a line every half is finished before the next, and so on with its halves.
  Points line = Points::Zero(3, 64);
  for (Index i = 0; i < 64; ++i) line(1, i) = static_cast<float>(63 - i);
  const std::vector<Index> order = hilbert_order(line);
  ASSERT_TRUE(is_permutation_of_all(order, 64));
  for (const Index part : {32, 16, 8}) {
    int changes = 0;
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
      changes += order[i] / part != order[i + 1] / part ? 1 : 0;
    }
    EXPECT_EQ(changes, 64 / part - 1);
  }
}

TEST(HilbertOrder, ExtremeSizes) {
  for (const float size : {1e-30F, 1e30F}) {
    Points points(3, 50);
    for (Index i = 0; i < 50; ++i) {
      points.col(i) = size * Eigen::Vector3f(static_cast<float>(i) - 25.0F, 0.3F, -1.0F);
    }
    EXPECT_TRUE(is_permutation_of_all(hilbert_order(points), 50));
  }
  Points far = Points::Constant(3, 10, 1e7F);
  far(0, 3) += 1.0F;
  EXPECT_TRUE(is_permutation_of_all(hilbert_order(far), 10));
}

}  // namespace
}  // namespace tetraction
