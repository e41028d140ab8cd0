// Data shared by two threads, which can only be reached while its mutex is held.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace tetraction::viewer {

/// Owns a T and the mutex that guards it. The only way to the data is lock(), whose result holds the
/// mutex as long as it lives, so that the compiler refuses an access without the lock.
template <class T>
class Guarded {
 public:
  /// The locked data. It belongs to one thread and must not outlive the block that needs it.
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
