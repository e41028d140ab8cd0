#include "solver/linear/coarse_matrix.h"

#include <Eigen/Cholesky>
#include <barrier>
#include <functional>
#include <thread>

#include "support/bodies.h"
#include "support/lone_part.h"

namespace tetraction {
namespace {

using namespace testing_support;
using Block = CoarseMatrix::Block;
using Motion = CoarseMatrix::Motion;

constexpr Index kGroups = 12;
constexpr double kShift = 1e-9;

// A chain of groups, each coupled with the next two, as elements that each touch three groups make it. Element e
// has the groups e, e + 1, e + 2.
Matrix element_matrix(Index e) {
  const Vector random = jiggled(Vector::Zero(18 * 18), 1.0);
  const Matrix m = Eigen::Map<const Matrix>(random.data(), 18, 18);
  return static_cast<double>(e + 1) * m * m.transpose() + Matrix::Identity(18, 18);
}

Matrix sum_of_elements() {
  Matrix a = Matrix::Zero(6 * kGroups, 6 * kGroups);
  for (Index e = 0; e + 2 < kGroups; ++e) a.block<18, 18>(6 * e, 6 * e) += element_matrix(e);
  return a;
}

// The share of one part in the chain.
struct Share {
  std::vector<Index> groups;  // in the part's order: own ones first
  Index own = 0;
  std::vector<std::int32_t> interface_numbers;
  std::vector<Index> elements;
};

// Some processes that are threads of the test.
class ThreadParts {
 public:
  explicit ThreadParts(int count) : barrier_(count), data_(static_cast<std::size_t>(count)) {}

  class Part : public LonePart {
   public:
    Part(ThreadParts& all, int rank) : LonePart(0), all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int count() const override { return static_cast<int>(all_.data_.size()); }
    void sum(double* values, Index count) const override {
      combine(values, count, [](double a, double b) { return a + b; });
    }
    void largest(double* values, Index count) const override {
      combine(values, count, [](double a, double b) { return std::max(a, b); });
    }
    void gather(const double* own, const std::vector<Index>& counts, double* all) const override {
      exchange(own, [&] {
        for (std::size_t p = 0; p < counts.size(); ++p) {
          all = std::copy_n(all_.data_[p], counts[p], all);
        }
      });
    }

   private:
    void exchange(const double* own, const std::function<void()>& read) const {
      all_.data_[static_cast<std::size_t>(rank_)] = own;
      all_.barrier_.arrive_and_wait();
      read();
      all_.barrier_.arrive_and_wait();
    }
    template <class Operation>
    void combine(double* values, Index count, const Operation& operation) const {
      std::vector<double> result;
      exchange(values, [&] {
        result.assign(all_.data_[0], all_.data_[0] + count);
        for (std::size_t p = 1; p < all_.data_.size(); ++p) {
          for (Index i = 0; i < count; ++i) {
            result[static_cast<std::size_t>(i)] =
                operation(result[static_cast<std::size_t>(i)], all_.data_[p][i]);
          }
        }
      });
      std::copy(result.begin(), result.end(), values);
    }
    ThreadParts& all_;
    int rank_;
  };

 private:
  std::barrier<> barrier_;
  std::vector<const double*> data_;
};

// Solves for the right-hand side (6 per group of the chain), and compares with a dense solution.
void expect_solution(const MeshPart* part, const Share& share, const Vector& right) {
  std::vector<std::int32_t> number(kGroups, -1);  // of the part, of each group of the chain
  for (std::size_t g = 0; g < share.groups.size(); ++g) {
    number[static_cast<std::size_t>(share.groups[g])] = static_cast<std::int32_t>(g);
  }
  std::vector<CoarseMatrix::GroupPair> pairs;
  for (const Index e : share.elements) {
    for (const auto& [i, j] : {std::pair(e, e + 1), {e, e + 2}, {e + 1, e + 2}}) {
      pairs.push_back(
          std::minmax(number[static_cast<std::size_t>(i)], number[static_cast<std::size_t>(j)]));
    }
  }
  CoarseMatrix matrix(part, share.own, share.interface_numbers, pairs);
  // The second time nothing is left of the first.
  for (int repetition = 0; repetition < 2; ++repetition) {
    matrix.set_zero();
    for (const Index e : share.elements) {
      const Matrix m = element_matrix(e);
      for (Index a = 0; a < 3; ++a) {
        for (Index b = 0; b <= a; ++b) {
          const Index row = number[static_cast<std::size_t>(e + a)];
          const Index column = number[static_cast<std::size_t>(e + b)];
          ASSERT_TRUE(matrix.has(row, column));
          matrix.add(row, column, m.block<6, 6>(6 * a, 6 * b));
        }
      }
    }
    ASSERT_TRUE(matrix.factorize(kShift));
  }
  Matrix dense = sum_of_elements();
  dense.diagonal() *= 1.0 + kShift;
  const Vector expected = dense.llt().solve(right);

  std::vector<Motion> motions(share.groups.size(), Motion::Constant(1e30));
  for (Index g = 0; g < share.own; ++g) {
    motions[static_cast<std::size_t>(g)] =
        right.segment<6>(6 * share.groups[static_cast<std::size_t>(g)]);
  }
  const double product = matrix.solve(motions);
  EXPECT_NEAR(product, right.dot(expected), 1e-11 * right.dot(expected));
  for (std::size_t g = 0; g < share.groups.size(); ++g) {
    EXPECT_LT((motions[g] - expected.segment<6>(6 * share.groups[g])).norm(),
              1e-10 * expected.norm())
        << "group " << share.groups[g];
  }
}

Share whole_chain() {
  Share share;
  for (Index g = 0; g < kGroups; ++g) share.groups.push_back(g);
  for (Index e = 0; e + 2 < kGroups; ++e) share.elements.push_back(e);
  share.own = kGroups;
  share.interface_numbers.assign(kGroups, -1);
  return share;
}

Vector some_right() {
  return jiggled(Vector::Zero(6 * kGroups), 1.0);
}

TEST(CoarseMatrix, SolvesInOneProcess) {
  expect_solution(nullptr, whole_chain(), some_right());
}

TEST(CoarseMatrix, SolvesWithAnyGroupsInTheInterface) {
  const LonePart part(0);
  for (const std::vector<std::size_t>& chosen :
       {std::vector<std::size_t>{}, {5}, {7, 0, 3}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}) {
    Share share = whole_chain();
    std::int32_t next = 0;
    for (const std::size_t g : chosen) share.interface_numbers[g] = next++;
    expect_solution(&part, share, some_right());
  }
}

// Three parts: the first has groups 0 to 4, the second 5 and 6, both in the interface, the third the others.
TEST(CoarseMatrix, SolvesInSeveralProcesses) {
  const std::vector<Share> shares{{{0, 1, 2, 3, 4, 5}, 5, {-1, -1, -1, 0, 1, 2}, {0, 1, 2, 3}},
                                  {{5, 6, 3, 4, 7, 8}, 2, {2, 3, 0, 1, 4, 5}, {4, 5, 6}},
                                  {{7, 8, 9, 10, 11}, 5, {4, 5, -1, -1, -1}, {7, 8, 9}}};
  // Element 3 has groups 3, 4, 5; element 4 has 4, 5, 6; element 6 has 6, 7, 8.
  ThreadParts all(static_cast<int>(shares.size()));
  std::vector<std::thread> threads;
  const Vector right = some_right();
  for (std::size_t p = 0; p < shares.size(); ++p) {
    threads.emplace_back([&, p] {
      const ThreadParts::Part part(all, static_cast<int>(p));
      expect_solution(&part, shares[p], right);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

// Interface numbers of two groups.
const std::vector<std::vector<std::int32_t>> kTwoGroups{{-1, -1}, {0, -1}, {-1, 0}, {0, 1}};

// A matrix that is indefinite in an inner group, or only because of what the inner groups leave of it.
TEST(CoarseMatrix, SaysThatItIsNotPositiveDefinite) {
  const LonePart part(0);
  for (const std::vector<std::int32_t>& numbers : kTwoGroups) {
    CoarseMatrix matrix(&part, 2, numbers, {{0, 1}});
    matrix.set_zero();
    for (const Index g : {0, 1}) matrix.add(g, g, Block::Identity());
    ASSERT_TRUE(matrix.factorize(kShift));
    matrix.set_zero();
    for (const Index g : {0, 1}) matrix.add(g, g, Block::Identity());
    matrix.add(1, 0, 2.0 * Block::Identity());
    EXPECT_FALSE(matrix.factorize(kShift));
  }
}

// A group without free vertices has a row of zeros. It stays where it is.
TEST(CoarseMatrix, TakesGroupsWithoutMotions) {
  const LonePart part(0);
  for (const std::vector<std::int32_t>& numbers : kTwoGroups) {
    CoarseMatrix matrix(&part, 2, numbers, {{0, 1}});
    matrix.set_zero();
    matrix.add(0, 0, 4.0 * Block::Identity());
    ASSERT_TRUE(matrix.factorize(kShift));
    std::vector<Motion> motions{Motion::Ones(), Motion::Zero()};
    EXPECT_NEAR(matrix.solve(motions), 1.5, 1e-6);
    EXPECT_LT((motions[0] - Motion::Constant(0.25)).norm(), 1e-6);
    EXPECT_EQ(motions[1], Motion(Motion::Zero()));
  }
}

}  // namespace
}  // namespace tetraction
