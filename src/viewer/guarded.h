// Data that two threads share, and the mutex that protects them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace tetraction::viewer {

/// Owns a T and its mutex. The data can be accessed through the result of lock() only, which holds the
/// mutex as long as it exists. Therefore an access without the lock does not compile.
template <class T>
class Guarded {
 public:
  /// Access to the locked data. It must be used in one thread and destroyed as soon as possible.
  template <class Data>
  class Access {
   public:
    Access(Data& data, std::mutex& mutex) : data_(&data), lock_(mutex) {}
    Data* operator->() const { return data_; }
    Data& operator*() const { return *data_; }

    /// Releases the mutex until the condition is notified.
    void wait(std::condition_variable& condition) { condition.wait(lock_); }
    /// Releases the mutex until the condition is notified, but no longer than until a point in
    /// time.
    template <class Clock, class Duration>
    void wait_until(std::condition_variable& condition,
                    const std::chrono::time_point<Clock, Duration>& time) {
      condition.wait_until(lock_, time);
    }
    /// Waits until `holds(data)` is true, but no longer than a duration. Returns whether it is
    /// true.
    template <class Rep, class Period, class Predicate>
    bool wait_for(std::condition_variable& condition,
                  const std::chrono::duration<Rep, Period>& duration, const Predicate& holds) {
      return condition.wait_for(lock_, duration, [&] { return holds(*data_); });
    }

   private:
    Data* data_;
    std::unique_lock<std::mutex> lock_;
  };

  [[nodiscard]] Access<T> lock() { return {data_, mutex_}; }
  [[nodiscard]] Access<const T> lock() const { return {data_, mutex_}; }

 private:
  T data_;
  mutable std::mutex mutex_;
};

}  // namespace tetraction::viewer
