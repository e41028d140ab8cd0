#include "solver/linear/sparse_cholesky.h"

#include "support/assembled.h"
#include "support/bodies.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Small systems take CHOLMOD's simplicial method, large ones the supernodal one, and with more than
// 9000 unknowns another ordering.
class SparseCholeskyOf : public testing::TestWithParam<int> {
 protected:
  const TetMesh mesh_ = small_block({2 * GetParam(), GetParam(), GetParam()});
  const RestState rest_{mesh_};
  const ElasticPotential elastic_{rest_, all_materials()[1]};
  const FreeCoordinates coordinates_ = hold(mesh_, SelectPlane{0, 0.0, {}}).coordinates();
  const SparsityPattern pattern_{rest_, coordinates_};

  std::vector<double> stiffness() const {
    std::vector<double> values(static_cast<std::size_t>(pattern_.nonzeros()), 0.0);
    const Vector q = strained_state(elastic_, mesh_.rest_positions(), 0.02);
    EXPECT_TRUE(elastic_.add_hessian(q, pattern_, values.data()).ok());
    return values;
  }
  double& diagonal(std::vector<double>& values, Index j) const {
    return values[static_cast<std::size_t>(pattern_.column_begin()[static_cast<std::size_t>(j)])];
  }
  Vector multiply(const std::vector<double>& values, const Vector& x) const {
    return sparse_product(pattern_, values, x);
  }
};

TEST_P(SparseCholeskyOf, Solves) {
  SparseCholesky cholesky(pattern_);
  std::vector<double> values = stiffness();
  const Vector x = jiggled(Vector::Zero(pattern_.size()), 1.0);
  for (const double scale : {1.0, 1e-6, 1e9}) {  // the same analysis again and again
    std::vector<double> scaled = values;
    for (double& v : scaled) v *= scale;
    ASSERT_TRUE(cholesky.factorize(scaled));
    EXPECT_LT((cholesky.solve(multiply(scaled, x)) - x).norm(), 1e-9 * x.norm());
  }
  EXPECT_GT(cholesky.cost().flops, 0.0);
  EXPECT_GE(cholesky.cost().nonzeros, static_cast<double>(pattern_.nonzeros()));
}

TEST_P(SparseCholeskyOf, SolvesWithItsRoot) {
  SparseCholesky cholesky(pattern_);
  const std::vector<double> values = stiffness();
  ASSERT_TRUE(cholesky.factorize(values));
  const Vector x = jiggled(Vector::Zero(pattern_.size()), 1.0);
  const Vector b = multiply(values, x);
  const Vector y = cholesky.solve_transposed_root(b);  // R x
  EXPECT_NEAR(y.squaredNorm(), x.dot(b), 1e-9 * y.squaredNorm());
  EXPECT_LT((cholesky.solve_root(y) - x).norm(), 1e-9 * x.norm());
}

TEST_P(SparseCholeskyOf, SolvesManyColumnsWithItsRoot) {
  SparseCholesky cholesky(pattern_);
  ASSERT_TRUE(cholesky.factorize(stiffness()));
  Matrix columns(pattern_.size(), 5);
  for (Index j = 0; j < columns.cols(); ++j) {
    columns.col(j) = jiggled(Vector::Zero(pattern_.size()), 1.0 + static_cast<double>(j));
  }
  const Matrix found = cholesky.solve_transposed_root(columns);
  ASSERT_EQ(found.cols(), columns.cols());
  for (Index j = 0; j < columns.cols(); ++j) {
    const Vector expected = cholesky.solve_transposed_root(Vector(columns.col(j)));
    EXPECT_LT((found.col(j) - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST_P(SparseCholeskyOf, RefusesWhatIsNotPositiveDefinite) {
  SparseCholesky cholesky(pattern_);
  const std::vector<double> good = stiffness();
  const Vector x = jiggled(Vector::Zero(pattern_.size()), 1.0);
  for (const Index j : {Index(0), pattern_.size() / 2, pattern_.size() - 1}) {
    std::vector<double> bad = good;
    diagonal(bad, j) *= -1.0;
    EXPECT_FALSE(cholesky.factorize(bad)) << j;
    // And takes the next one that is.
    ASSERT_TRUE(cholesky.factorize(good));
    EXPECT_LT((cholesky.solve(multiply(good, x)) - x).norm(), 1e-9 * x.norm());
  }
  // All of it.
  std::vector<double> negative = good;
  for (double& v : negative) v = -v;
  EXPECT_FALSE(cholesky.factorize(negative));
}

INSTANTIATE_TEST_SUITE_P(Cells, SparseCholeskyOf, testing::Values(1, 3, 12));

}  // namespace
}  // namespace tetraction
