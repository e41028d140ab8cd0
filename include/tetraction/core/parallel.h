// Loops over many items on all threads, with results that do not depend on the number of threads.
#pragma once

#include <functional>

#include "tetraction/core/types.h"

namespace tetraction {

/// Limits the number of threads of all parallel loops from now on; 0 means one per core.
void set_thread_count(int threads);

/// Number of threads that the loops use.
int thread_count();

/// Calls body(begin, end) on disjoint ranges that cover [0, count), on several threads at the same
/// time. `grain` is the smallest number of items for which a task of its own is worthwhile. Ranges
/// begin at multiples of it, so that a vectorised body with a grain that is a multiple of its lanes
/// treats every item in the same way, whatever the number of threads. The body must only write to
/// its own items. Exceptions of the body are rethrown in the calling thread.
void parallel_for(Index count, Index grain, const std::function<void(Index, Index)>& body);

/// Cuts [0, count) into ranges and returns the sum of partial(begin, end) over them. The ranges have
/// a fixed length and are added in ascending order, so that the sum is bitwise the same for any
/// number of threads.
double parallel_sum(Index count, const std::function<double(Index, Index)>& partial);

}  // namespace tetraction
