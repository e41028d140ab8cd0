// Loops over many items on all threads, with results that do not depend on the number of threads.
#pragma once

#include <functional>

#include "tetraction/core/types.h"

namespace tetraction {

/// Limits the number of threads of all parallel loops from now on; 0 means one per core.
void set_thread_count(int threads);

/// Number of threads the loops use.
int thread_count();

/// Calls body(begin, end) on disjoint ranges that cover [0, count), at once on several threads.
/// `grain` is the least number of items worth a task. The body must only write to its own items.
/// Exceptions of the body are rethrown in the calling thread.
void parallel_for(Index count, Index grain, const std::function<void(Index, Index)>& body);

/// Sum over [0, count) of what `partial(begin, end)` returns for fixed ranges, added in their
/// order: bitwise the same for any number of threads.
double parallel_sum(Index count, const std::function<double(Index, Index)>& partial);

}  // namespace tetraction
