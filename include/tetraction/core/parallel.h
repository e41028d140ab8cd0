// Loops over many items on all threads, with results that do not depend on the number of threads.
#pragma once

#include <functional>

#include "tetraction/core/types.h"

namespace tetraction {

/// Limits the number of threads of all parallel loops from now on; 0 means one per core.
void set_thread_count(int threads);

/// Number of threads that the loops use. Within run_jobs() that of the loops of one job.
int thread_count();

/// Calls job(i) for all i in [0, count), of which up to `jobs` run at the same time, each in a thread of
/// its own. They begin in ascending order. The parallel loops of a job have as many threads as the loops of
/// the caller, so that their results are the same bits. With at most one job at a time everything runs in
/// the calling thread.
///
/// If a job throws an exception, no further one begins, and the exception is rethrown when those that run
/// have ended. Jobs must not call run_jobs() or set_thread_count(). At most one thread of the program may
/// call this function at a time.
void run_jobs(Index count, int jobs, const std::function<void(Index)>& job);

/// Calls body(begin, end) on disjoint ranges that cover [0, count), on several threads at the same
/// time. `grain` is the smallest number of items for which a task of its own is worthwhile. Ranges
/// begin at multiples of it, so that a vectorised body with a grain that is a multiple of its lanes
/// treats every item in the same way, whatever the number of threads. The body must only write to
/// its own items. Exceptions of the body are rethrown in the calling thread.
void parallel_for(Index count, Index grain, const std::function<void(Index, Index)>& body);
/// The grain of loops over vertices that do little for each.
inline constexpr Index kVertexGrain = 2048;

/// Cuts [0, count) into ranges and returns the sum of partial(begin, end) over them. The ranges have
/// a fixed length and are added in ascending order, so that the sum is bitwise the same for any
/// number of threads.
double parallel_sum(Index count, const std::function<double(Index, Index)>& partial);

}  // namespace tetraction
