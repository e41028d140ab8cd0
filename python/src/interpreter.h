// The lock of the Python interpreter, also while the interpreter ends.
//
// A daemon thread may be within a step when the interpreter ends. If it then asks for the lock, Python ends
// the thread in the middle of C++ code, which aborts the program. Therefore all waits for the lock go through
// this header: from the end on a computation stops, and its thread sleeps.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>

namespace tetraction::python {

/// Releases the interpreter's lock as long as it lives. When the interpreter ends meanwhile, the destructor
/// of another thread than the one that ends it does not return.
class Released {
 public:
  Released();
  ~Released();
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* state_;
};

/// Has the interpreter's lock as long as it lives. Throws Interrupted if the interpreter ends.
class Acquired {
 public:
  Acquired();
  ~Acquired();
  Acquired(const Acquired&) = delete;
  Acquired& operator=(const Acquired&) = delete;

 private:
  PyGILState_STATE state_;
};

/// True from the end of the interpreter on, but for the thread that ends it: an Interruptible of it ends
/// computations.
const std::atomic<bool>& interpreter_end_flag();

/// To be called once, with the interpreter's lock.
void watch_interpreter_end();

}  // namespace tetraction::python
