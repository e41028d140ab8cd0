// Ending a computation from another thread.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>

namespace tetraction {

/// Ends a computation that was asked to stop. It is no Error: nothing went wrong.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "the computation was interrupted"; }
};

/// While an object of this class lives, computations of the thread that made it end with the
/// exception Interrupted soon after the flag has become true: at the next loop over the elements or
/// vertices, of which an iteration of any solver has several. A factorisation of a matrix is not
/// interrupted. Session::step() leaves the state as it was before the step. Objects in one thread must
/// not overlap.
///
/// `lock` lets another thread read what the computation does not change before it succeeds. It must be
/// locked. It is unlocked as long as the object lives, and locked again before Interrupted is thrown:
/// while another thread has the mutex, an interrupted computation waits and changes nothing.
class Interruptible {
 public:
  explicit Interruptible(const std::atomic<bool>& flag,
                         std::unique_lock<std::mutex>* lock = nullptr);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

 private:
  friend void throw_if_interrupted();
  const std::atomic<bool>& flag_;
  std::unique_lock<std::mutex>* lock_;
};

/// Throws Interrupted if the thread has an Interruptible whose flag is true.
void throw_if_interrupted();

}  // namespace tetraction
