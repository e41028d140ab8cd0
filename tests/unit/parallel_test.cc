#include "tetraction/core/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace tetraction {
namespace {

class Parallel : public testing::Test {
 protected:
  ~Parallel() override { set_thread_count(0); }
};

TEST_F(Parallel, CoversEveryItemOnce) {
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    EXPECT_EQ(thread_count(), threads);
    std::vector<int> visits(10007, 0);
    parallel_for(10007, 10, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
    });
    for (const int v : visits) ASSERT_EQ(v, 1);
  }
}

// A vectorised body treats the items at the end of a range in another way than those within.
TEST_F(Parallel, RangesBeginAtMultiplesOfTheGrain) {
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    std::vector<Index> begins(10007, -1);
    parallel_for(10007, 16, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) begins[static_cast<std::size_t>(i)] = begin;
    });
    for (const Index begin : begins) ASSERT_EQ(begin % 16, 0);
  }
}

TEST_F(Parallel, SumsAreBitwiseTheSameForAnyNumberOfThreads) {
  constexpr Index kCount = 123457;
  const auto partial = [](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i)
      sum += std::sin(static_cast<double>(i)) / (1.0 + static_cast<double>(i % 17));
    return sum;
  };
  set_thread_count(1);
  const double one = parallel_sum(kCount, partial);
  for (const int threads : {2, 3, 8}) {
    set_thread_count(threads);
    EXPECT_EQ(parallel_sum(kCount, partial), one);
  }
  EXPECT_EQ(parallel_sum(0, partial), 0.0);
}

TEST_F(Parallel, ExceptionsReachTheCaller) {
  set_thread_count(2);
  EXPECT_THROW(
      parallel_for(1000, 1, [](Index, Index) { throw std::runtime_error("from the body"); }),
      std::runtime_error);
}

}  // namespace
}  // namespace tetraction
