#include "interruptible.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "interpreter.h"

namespace py = pybind11;

namespace tetraction::python {

void CallingThread::call(const std::function<void()>& function) {
  std::packaged_task<void()> task([&function] {
    const Acquired python;
    function();
  });
  std::future<void> done = task.get_future();
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return asked_ == nullptr; });
    if (stops_) return;
    asked_ = &task;
    changed_.notify_all();
  }
  done.get();
}

void compute_interruptibly(const std::function<void(CallingThread&)>& compute) {
  constexpr std::chrono::milliseconds kPause{50};
  CallingThread caller;
  std::exception_ptr failure;
  std::exception_ptr signal;
  const Released released;
  std::thread worker([&] {
    try {
      compute(caller);
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(caller.mutex_);
    caller.has_ended_ = true;
    caller.changed_.notify_all();
  });
  std::unique_lock lock(caller.mutex_);
  while (!caller.has_ended_) {
    caller.changed_.wait_for(lock, kPause,
                             [&] { return caller.has_ended_ || caller.asked_ != nullptr; });
    std::packaged_task<void()> task;
    if (caller.asked_ != nullptr) task = std::move(*std::exchange(caller.asked_, nullptr));
    lock.unlock();
    caller.changed_.notify_all();
    if (task.valid()) task();
    if (!signal) {
      try {
        const Acquired python;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      } catch (...) {  // also at the end of the interpreter
        signal = std::current_exception();
      }
    }
    lock.lock();
    if (signal) caller.stops_ = true;
  }
  lock.unlock();
  worker.join();
  if (signal) std::rethrow_exception(signal);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tetraction::python
