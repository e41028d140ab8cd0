#include "tetraction/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <thread>
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

// Jobs of different lengths, whose loops have the caller's number of threads.
TEST_F(Parallel, JobsRunOnceWithTheThreadsOfTheCaller) {
  for (const int threads : {1, 3}) {
    for (const int jobs : {0, 1, 2, 5}) {
      set_thread_count(threads);
      std::vector<double> sums(7, 0.0);
      std::vector<int> known(7, 0);
      run_jobs(7, jobs, [&](Index i) {
        known[static_cast<std::size_t>(i)] += thread_count();
        sums[static_cast<std::size_t>(i)] =
            parallel_sum(50000 * (i + 1), [](Index begin, Index end) {
              double sum = 0.0;
              for (Index k = begin; k < end; ++k) sum += std::sin(static_cast<double>(k));
              return sum;
            });
      });
      EXPECT_EQ(thread_count(), threads);
      for (Index i = 0; i < 7; ++i) {
        EXPECT_EQ(known[static_cast<std::size_t>(i)], threads);
        const double alone = parallel_sum(50000 * (i + 1), [](Index begin, Index end) {
          double sum = 0.0;
          for (Index k = begin; k < end; ++k) sum += std::sin(static_cast<double>(k));
          return sum;
        });
        EXPECT_EQ(sums[static_cast<std::size_t>(i)], alone);
      }
    }
  }
}

// Each waits for the other one: this ends only if both run.
TEST_F(Parallel, JobsRunAtTheSameTime) {
  set_thread_count(1);
  std::atomic<int> begun{0};
  run_jobs(2, 2, [&](Index) {
    ++begun;
    while (begun < 2) std::this_thread::yield();
  });
  EXPECT_EQ(begun, 2);
}

TEST_F(Parallel, AJobThatThrowsEndsTheOthers) {
  for (const int jobs : {1, 2}) {
    set_thread_count(2);
    std::atomic<int> begun{0};
    EXPECT_THROW(run_jobs(1000, jobs,
                          [&](Index) {
                            ++begun;
                            throw std::runtime_error("job");
                          }),
                 std::runtime_error);
    EXPECT_LE(begun, jobs);
    EXPECT_EQ(thread_count(), 2);
  }
}

}  // namespace
}  // namespace tetraction
