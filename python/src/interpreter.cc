#include "interpreter.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tetraction/core/interruption.h"

namespace py = pybind11;

namespace tetraction::python {
namespace {

// Never destroyed, because threads may outlive the static objects of the program.
struct Gate {
  std::mutex mutex;
  std::condition_variable left;
  int inside = 0;  // threads that have released the lock, or wait for it
  std::atomic<bool> ends{false};
  std::thread::id ending;  // the thread that ends the interpreter, which may go on
};

Gate& gate() {
  static Gate* const gate = new Gate;
  return *gate;
}

// With the gate's mutex.
bool is_closed() {
  return gate().ends && gate().ending != std::this_thread::get_id();
}

// Lets the computations of other threads stop, and those go on that wait for the lock.
void close_gate() {
  // Code in Python that is called within a step may not return.
  constexpr std::chrono::seconds kLongest{5};
  Gate& g = gate();
  std::unique_lock lock(g.mutex);
  g.ending = std::this_thread::get_id();
  g.ends = true;
  PyThreadState* const state = PyEval_SaveThread();
  g.left.wait_for(lock, kLongest, [&] { return g.inside == 0; });
  lock.unlock();
  PyEval_RestoreThread(state);
}

}  // namespace

Released::Released() : state_(PyEval_SaveThread()) {
  const std::lock_guard lock(gate().mutex);
  ++gate().inside;
}

Released::~Released() {
  Gate& g = gate();
  {
    std::unique_lock lock(g.mutex);
    if (is_closed()) {
      --g.inside;
      g.left.notify_all();
      lock.unlock();
      for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    }
  }
  PyEval_RestoreThread(state_);
  const std::lock_guard lock(g.mutex);
  --g.inside;
  g.left.notify_all();
}

Acquired::Acquired() {
  {
    const std::lock_guard lock(gate().mutex);
    if (is_closed()) throw Interrupted();
  }
  state_ = PyGILState_Ensure();
}

Acquired::~Acquired() {
  PyGILState_Release(state_);
}

const std::atomic<bool>& interpreter_end_flag() {
  static const std::atomic<bool> never{false};
  const std::lock_guard lock(gate().mutex);
  return gate().ends && !is_closed() ? never : gate().ends;
}

void watch_interpreter_end() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&close_gate));
}

}  // namespace tetraction::python
