#include "tetraction/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "core/loop_order.h"

namespace tetraction {
namespace {

// Length of the ranges of parallel_sum(). It is fixed, so that the order of additions never changes.
constexpr Index kSumRange = 4096;

std::unique_ptr<tbb::global_control>& control() {
  static std::unique_ptr<tbb::global_control> instance;
  return instance;
}

}  // namespace

void set_thread_count(int threads) {
  const int wanted =
      threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  control() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(wanted));
}

int thread_count() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void parallel_for(Index count, Index grain, const std::function<void(Index, Index)>& body) {
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
