#include "tetraction/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "tetraction/core/blas.h"
#include "tetraction/core/interruption.h"

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace tetraction {
namespace {

// The order that a parallel loop guarantees: what comes before the loop comes before each of its
// tasks, and each task comes before what follows the loop. TBB sees to this, but it is not built
// with the sanitizer, which would therefore report every loop. Between two tasks of a loop there is
// no order, so that races between them are still found. Without the sanitizer nothing is done.
class LoopOrder {
 public:
#ifdef __SANITIZE_THREAD__
  LoopOrder() {
    __tsan_release(&begin_);
  }
  ~LoopOrder() {
    __tsan_acquire(&end_);
  }
  void begin_task() {
    __tsan_acquire(&begin_);
  }
  void end_task() {
    __tsan_release(&end_);
  }

 private:
  char begin_ = 0;
  char end_ = 0;
#else
  void begin_task() {}
  void end_task() {}
#endif
};

// Length of the ranges of parallel_sum(). It is fixed, so that the order of additions never changes.
constexpr Index kSumRange = 4096;

std::unique_ptr<tbb::global_control>& control() {
  static std::unique_ptr<tbb::global_control> instance;
  return instance;
}

// While jobs run at the same time, the threads of the loops of each of them; otherwise 0.
std::atomic<int> threads_of_job{0};

// The smallest limit of TBB holds, so that the earlier one has to go first.
void limit_threads(std::size_t threads) {
  control().reset();
  control() =
      std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, threads);
}

// As long as it lives, TBB has enough threads for jobs that run at the same time.
class ThreadsOfJobs {
 public:
  ThreadsOfJobs(int jobs, int threads) : had_limit_(control() != nullptr), threads_(threads) {
    // The thread of a job works, too.
    limit_threads(static_cast<std::size_t>(jobs * (threads - 1) + 1));
    threads_of_job = threads;
  }
  ~ThreadsOfJobs() {
    threads_of_job = 0;
    if (had_limit_) {
      limit_threads(static_cast<std::size_t>(threads_));
    } else {
      control().reset();
    }
  }
  ThreadsOfJobs(const ThreadsOfJobs&) = delete;
  ThreadsOfJobs& operator=(const ThreadsOfJobs&) = delete;

 private:
  bool had_limit_;
  int threads_;
};

}  // namespace

void set_thread_count(int threads) {
  const int wanted =
      threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  control() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(wanted));
}

void run_jobs(Index count, int jobs, const std::function<void(Index)>& job) {
  const int workers = static_cast<int>(std::min<Index>(jobs, count));
  if (workers < 2) {
    for (Index i = 0; i < count; ++i) job(i);
    return;
  }
  const int threads = thread_count();
  const ThreadsOfJobs enough_threads(workers, threads);
  // The objects of this class in the jobs then change nothing, which they may not do at the same time.
  const SerialBlas serial_blas;
  std::atomic<Index> next{0};
  std::atomic<bool> has_failed{false};
  std::exception_ptr failure;
  std::mutex failing;
  const auto work = [&] {
    tbb::task_arena arena(threads);
    arena.execute([&] {
      for (Index i = next++; i < count && !has_failed; i = next++) {
        try {
          job(i);
        } catch (...) {
          const std::lock_guard lock(failing);
          if (!failure) failure = std::current_exception();
          has_failed = true;
        }
      }
    });
  };
  {
    std::vector<std::jthread> pool;
    try {
      for (int i = 1; i < workers; ++i) pool.emplace_back(work);
    } catch (const std::system_error&) {
      // The system gives no more threads: those that there are do all jobs.
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

int thread_count() {
  if (threads_of_job > 0) return threads_of_job;
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void parallel_for(Index count, Index grain, const std::function<void(Index, Index)>& body) {
  throw_if_interrupted();
  if (count <= 0) return;
  if (count <= grain || thread_count() == 1) {
    body(0, count);
    return;
  }
  // Which pieces a thread gets depends on chance, but where they may be cut does not.
  grain = std::max<Index>(1, grain);
  const Index pieces = (count + grain - 1) / grain;
  LoopOrder order;
  tbb::parallel_for(tbb::blocked_range<Index>(0, pieces), [&](const tbb::blocked_range<Index>& r) {
    order.begin_task();
    body(r.begin() * grain, std::min(count, r.end() * grain));
    order.end_task();
  });
}

double parallel_sum(Index count, const std::function<double(Index, Index)>& partial) {
  const Index ranges = (count + kSumRange - 1) / kSumRange;
  if (ranges <= 1) return count > 0 ? partial(0, count) : 0.0;
  std::vector<double> sums(static_cast<std::size_t>(ranges));
  parallel_for(ranges, 1, [&](Index begin, Index end) {
    for (Index r = begin; r < end; ++r) {
      sums[static_cast<std::size_t>(r)] =
          partial(r * kSumRange, std::min(count, (r + 1) * kSumRange));
    }
  });
  double total = 0.0;
  for (const double s : sums) total += s;
  return total;
}

}  // namespace tetraction
