#include "solver/linear/single_precision_factor.h"

#include <cholmod.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "solver/linear/sparse_cholesky.h"
#include "support/bodies.h"
#include "support/instruction_sets.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// The stiffness of a block of 2n × n × n cells held at one end.
class Stiffness {
 public:
  explicit Stiffness(int n)
      : mesh_(small_block({2 * n, n, n})),
        rest_(mesh_),
        coordinates_(hold(mesh_, SelectPlane{0, 0.0, {}}).coordinates()),
        pattern_(rest_, coordinates_),
        values_(static_cast<std::size_t>(pattern_.nonzeros()), 0.0) {
    const ElasticPotential elastic(rest_, all_materials()[1]);
    const Vector q = strained_state(elastic, mesh_.rest_positions(), 0.02);
    EXPECT_TRUE(elastic.add_hessian(q, pattern_, values_.data()).ok());
  }

  const SparsityPattern& pattern() const { return pattern_; }
  const std::vector<double>& values() const { return values_; }
  Index size() const { return pattern_.size(); }
  // D A D.
  std::vector<double> scaled(const Vector& d) const {
    std::vector<double> result = values_;
    for (Index j = 0; j < size(); ++j) {
      for (int k = pattern_.column_begin()[static_cast<std::size_t>(j)];
           k < pattern_.column_begin()[static_cast<std::size_t>(j) + 1]; ++k) {
        const auto at = static_cast<std::size_t>(k);
        result[at] = result[at] * d[j] * d[pattern_.rows()[at]];
      }
    }
    return result;
  }
  Vector right() const { return jiggled(Vector::Zero(size()), 1.0); }

 private:
  TetMesh mesh_;
  RestState rest_;
  FreeCoordinates coordinates_;
  SparsityPattern pattern_;
  std::vector<double> values_;
};

double relative_error(const Vector& x, const Vector& exact) {
  return (x - exact).norm() / exact.norm();
}

// Small systems take CHOLMOD's simplicial method, large ones the supernodal one, and with more than
// 9000 unknowns another ordering.
class SinglePrecisionFactorOf : public testing::TestWithParam<int> {
 protected:
  // Single precision's round-off times the condition, which grows with the mesh.
  static constexpr double kTolerance = 2e-5;

  const Stiffness matrix_{GetParam()};
  SparseCholesky cholesky_{matrix_.pattern()};
  SinglePrecisionFactor single_;
};

TEST_P(SinglePrecisionFactorOf, SolvesAsTheFactorInDouble) {
  const Vector b = matrix_.right();
  for (const std::int64_t set : instruction_sets()) {
    SCOPED_TRACE(instruction_set_name(set));
    const UseInstructionSet use(set);
    for (const double scale : {1.0, 1e-6, 1e9}) {  // factorised again and again
      ASSERT_TRUE(
          cholesky_.factorize(matrix_.scaled(Vector::Constant(matrix_.size(), std::sqrt(scale)))));
      cholesky_.copy_to(single_);
      const Vector exact = cholesky_.solve(b);
      Vector x(b.size());
      single_.solve(b, x);
      EXPECT_LT(relative_error(x, exact), kTolerance);
      x = b;
      single_.solve(x, x);
      EXPECT_LT(relative_error(x, exact), kTolerance) << "in place";
      const Eigen::VectorXf right = b.cast<float>();
      Eigen::VectorXf y(b.size());
      single_.solve(right, y);
      EXPECT_LT(relative_error(y.cast<double>(), exact), kTolerance) << "float";
    }
  }
}

TEST_P(SinglePrecisionFactorOf, OutlivesTheFactor) {
  EXPECT_THROW(cholesky_.copy_to(single_), Error);
  ASSERT_TRUE(cholesky_.factorize(matrix_.values()));
  const Vector b = matrix_.right();
  const Vector exact = cholesky_.solve(b);
  cholesky_.copy_to(single_);
  cholesky_.release_factor();
  Vector x(b.size());
  single_.solve(b, x);
  EXPECT_LT(relative_error(x, exact), kTolerance);
  // And the next factorisation is as the first.
  ASSERT_TRUE(cholesky_.factorize(matrix_.values()));
  EXPECT_EQ(cholesky_.solve(b), exact);
}

// Units of the unknowns far beyond the range of float, and right-hand sides, too.
TEST_P(SinglePrecisionFactorOf, BearsBadScaling) {
  for (const double decades : {10.0, 70.0}) {
    Vector d(matrix_.size());
    for (Index i = 0; i < d.size(); ++i)
      d[i] = std::pow(10.0, decades * std::sin(0.7 * static_cast<double>(i)));
    ASSERT_TRUE(cholesky_.factorize(matrix_.scaled(d)));
    cholesky_.copy_to(single_);
    for (const double size : {1.0, 1e-80, 1e80}) {
      const Vector b = size * d.cwiseProduct(matrix_.right());
      const Vector exact = d.cwiseProduct(cholesky_.solve(b));
      Vector x(b.size());
      single_.solve(b, x);
      EXPECT_LT(relative_error(d.cwiseProduct(x), exact), kTolerance) << decades << " " << size;
    }
  }
  Vector x = Vector::Ones(matrix_.size());
  single_.solve(Vector::Zero(matrix_.size()), x);
  EXPECT_EQ(x.squaredNorm(), 0.0);
}

TEST_P(SinglePrecisionFactorOf, IsTheSameForAnyNumberOfThreads) {
  ASSERT_TRUE(cholesky_.factorize(matrix_.values()));
  const Vector b = matrix_.right();
  std::vector<Vector> results;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    cholesky_.copy_to(single_);
    for (int repetition = 0; repetition < 5; ++repetition) {
      results.emplace_back(b.size());
      single_.solve(b, results.back());
    }
  }
  set_thread_count(0);
  for (const Vector& x : results) EXPECT_EQ(x, results.front());
}

INSTANTIATE_TEST_SUITE_P(Cells, SinglePrecisionFactorOf, testing::Values(1, 3, 6, 12));

TEST(SinglePrecisionFactor, HalvesTheMemory) {
  const Stiffness matrix(12);
  SparseCholesky cholesky(matrix.pattern());
  ASSERT_TRUE(cholesky.factorize(matrix.values()));
  SinglePrecisionFactor single;
  cholesky.copy_to(single);
  EXPECT_GE(static_cast<double>(single.nonzeros()), cholesky.cost().nonzeros);
  EXPECT_LT(static_cast<double>(single.bytes()), 0.6 * 8.0 * cholesky.cost().nonzeros);
}

// A matrix without zeros is one supernode, of a size of choice: 1 × 1, with all kinds of ends of
// tiles, blocks and panels.
class DenseFactor {
 public:
  DenseFactor(int size, int supernodal)
      : matrix_(Matrix::Constant(size, size, 0.3) + Matrix::Identity(size, size)) {
    for (Index i = 0; i < size; ++i) matrix_(i, i) += 0.1 * static_cast<double>(i % 5);
    cholmod_start(&common_);
    common_.final_ll = 1;
    common_.supernodal = supernodal;
    const auto n = static_cast<std::size_t>(size);
    cholmod_dense dense{};
    dense.nrow = dense.ncol = dense.d = n;
    dense.nzmax = n * n;
    dense.x = matrix_.data();
    dense.xtype = CHOLMOD_REAL;
    cholmod_sparse* sparse = cholmod_dense_to_sparse(&dense, 1, &common_);
    sparse->stype = -1;
    factor_ = cholmod_analyze(sparse, &common_);
    EXPECT_EQ(cholmod_factorize(sparse, factor_, &common_), 1);
    cholmod_free_sparse(&sparse, &common_);
  }
  ~DenseFactor() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  DenseFactor(const DenseFactor&) = delete;
  DenseFactor& operator=(const DenseFactor&) = delete;

  const Matrix& matrix() const { return matrix_; }
  cholmod_factor& factor() { return *factor_; }
  cholmod_common& common() { return common_; }

 private:
  Matrix matrix_;
  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
};

TEST(SinglePrecisionFactor, TakesSupernodesOfAnySize) {
  SinglePrecisionFactor single;  // again and again: its memory is used anew where it fits
  for (const int supernodal : {CHOLMOD_SIMPLICIAL, CHOLMOD_SUPERNODAL}) {
    for (const int size : {1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 16, 17, 31, 63, 64, 65, 79, 130, 203}) {
      DenseFactor dense(size, supernodal);
      EXPECT_EQ(dense.factor().is_super, supernodal == CHOLMOD_SUPERNODAL ? 1 : 0);
      single.assign(dense.factor());
      EXPECT_EQ(single.size(), size);
      EXPECT_EQ(single.nonzeros(), static_cast<std::size_t>(size * (size + 1) / 2));
      const Vector b = jiggled(Vector::Zero(size), 1.0);
      const Vector exact = dense.matrix().llt().solve(b);
      for (const std::int64_t set : instruction_sets()) {
        const UseInstructionSet use(set);
        Vector x(size);
        single.solve(b, x);
        EXPECT_LT(relative_error(x, exact), 1e-5) << size << " " << instruction_set_name(set);
      }
    }
  }
}

TEST(SinglePrecisionFactor, RefusesOtherFactors) {
  DenseFactor dense(5, CHOLMOD_SIMPLICIAL);
  SinglePrecisionFactor single;
  dense.factor().minor = 3;
  EXPECT_THROW(single.assign(dense.factor()), Error) << "not positive definite";
  dense.factor().minor = 5;
  cholmod_change_factor(CHOLMOD_REAL, 0, 0, 1, 1, &dense.factor(), &dense.common());
  EXPECT_THROW(single.assign(dense.factor()), Error) << "L D Lᵀ";
  cholmod_change_factor(CHOLMOD_PATTERN, 1, 0, 1, 1, &dense.factor(), &dense.common());
  EXPECT_THROW(single.assign(dense.factor()), Error) << "without numbers";
}

}  // namespace
}  // namespace tetraction
