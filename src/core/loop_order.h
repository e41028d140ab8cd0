// Tells the thread sanitizer in which order the parts of a parallel loop run.
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace tetraction {

/// The order that a parallel loop guarantees: what comes before the loop comes before each of its
/// tasks, and each task comes before what follows the loop. TBB sees to this, but it is not built
/// with the sanitizer, which would therefore report every loop. Between two tasks of a loop there is
/// no order, so that races between them are still found. Without the sanitizer nothing is done.
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

}  // namespace tetraction
