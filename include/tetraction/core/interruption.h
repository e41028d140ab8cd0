// Ending a computation from another thread.
#pragma once

#include <atomic>
#include <exception>

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
class Interruptible {
 public:
  explicit Interruptible(const std::atomic<bool>& flag);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
};

/// Throws Interrupted if the thread has an Interruptible whose flag is true.
void throw_if_interrupted();

}  // namespace tetraction
