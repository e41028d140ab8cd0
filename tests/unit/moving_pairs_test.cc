// Hessians of pairs that are made positive semidefinite, against the decomposition of the whole matrix.
#include "dynamics/contact/pairs/moving_pairs.h"

#include <gtest/gtest.h>

#include <random>

#include "core/decompositions.h"

namespace tetraction {
namespace {

// Blocks as one dense matrix.
class DenseBlocks : public SurfaceBlocks {
 public:
  explicit DenseBlocks(Index vertices) : matrix(Matrix::Zero(3 * vertices, 3 * vertices)) {}
  void add(Index i, const Matrix3& block) override { matrix.block<3, 3>(3 * i, 3 * i) += block; }
  void add_pair(Index i, Index j, const Matrix3& block) override {
    matrix.block<3, 3>(3 * i, 3 * j) += block;
    matrix.block<3, 3>(3 * j, 3 * i) += block.transpose();
  }
  Matrix matrix;
};

Matrix hessian_of(const MovingPair& pair, const Barrier& barrier, const Vector& x, bool convex) {
  DenseBlocks blocks(4);
  add_hessian_of({&pair, 1}, barrier, x, convex, blocks);
  return blocks.matrix;
}

TEST(MovingPairs, ConvexHessiansAreTheNearestSemidefiniteOnes) {
  const Barrier barrier{2.0, 1e5};
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int indefinite = 0;
  for (int trial = 0; trial < 400; ++trial) {
    for (const PairKind kind : {PairKind::kPointPoint, PairKind::kPointEdge,
                                PairKind::kPointTriangle, PairKind::kEdgeEdge}) {
      MovingPair pair;
      pair.pair = {kind, 0.7, 0.0};
      pair.count = pair_size(kind);
      pair.vertices = {0, 1, 2, 3};
      Vector x = Vector::NullaryExpr(12, [&] { return uniform(random); });
      if (trial % 3 == 1) {  // only the first side moves
        pair.count = first_side_size(kind);
        pair.at_rest = x.reshaped(3, 4);
      } else if (trial % 3 == 2) {  // only the second one
        pair.first = first_side_size(kind);
        pair.count = pair_size(kind) - pair.first;
        pair.at_rest = x.reshaped(3, 4);
        pair.vertices = {pair.first, pair.first + 1, pair.first + 2, -1};
      }
      if (kind == PairKind::kEdgeEdge && trial % 2 == 0) {
        pair.pair.parallel = 10.0 * parallel_measure(pair.points(x)) * (1.0 + uniform(random));
      }
      const Matrix exact = hessian_of(pair, barrier, x, false);
      const SymmetricEigen eigen = symmetric_eigen(exact);
      const Matrix expected =
          eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
      const Matrix convex = hessian_of(pair, barrier, x, true);
      EXPECT_LE((convex - expected).norm(), 1e-12 * exact.norm())
          << static_cast<int>(kind) << " " << trial;
      indefinite += eigen.values[0] < -1e-6 * exact.norm() ? 1 : 0;
    }
  }
  EXPECT_GT(indefinite, 400);
}

}  // namespace
}  // namespace tetraction
