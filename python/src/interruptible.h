// Long computations that Ctrl-C of Python ends.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>

namespace tetraction::python {

/// The requests of a computation in its own thread to the thread that has called it.
class CallingThread {
 public:
  /// True as soon as a signal's handler has thrown an exception: the computation shall end.
  const std::atomic<bool>& stops() const { return stops_; }
  /// Calls a function with the interpreter's lock in the calling thread, and waits for it. Programs and notebooks
  /// expect their functions to be called there. Exceptions pass through. Does nothing if the computation shall end.
  void call(const std::function<void()>& function);

 private:
  friend void compute_interruptibly(const std::function<void(CallingThread&)>& compute);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::packaged_task<void()>* asked_ = nullptr;
  bool has_ended_ = false;
  std::atomic<bool> stops_{false};
};

/// Computes in a thread of its own without the interpreter's lock. Python gives signals to the thread that has called:
/// it waits for them, sets CallingThread::stops(), and throws the exception of the signal's handler when the computation
/// has ended.
void compute_interruptibly(const std::function<void(CallingThread&)>& compute);

}  // namespace tetraction::python
