// The place of a session's state in memory.
#pragma once

#include <atomic>
#include <mutex>

#include "tetraction/dynamics/state.h"

namespace tetraction {

/// Two objects, of which one is the present state. A step writes its result to the other one, which
/// then becomes the present one, so that nothing is copied and a failed step has changed nothing.
/// Those outside look at one of the two objects only, the home, whose vectors keep their addresses.
/// The state is copied there when they ask for it.
class StateBuffers {
 public:
  const State& present() const { return *present_.load(std::memory_order_acquire); }
  /// The object that is not the present state. Its vectors have the size of the body. They must be
  /// written in place, not exchanged for others.
  State& other() { return present_ == &home_ ? other_ : home_; }
  /// Makes the other object the present state.
  void switch_to_other() { present_ = &other(); }
  /// Copies `state` and makes it the present state.
  void set(const State& state) {
    home_ = state;
    present_ = &home_;
  }
  /// The present state in its home. Several threads may call this at once.
  const State& at_home() const {
    if (present_.load(std::memory_order_acquire) != &home_) {
      const std::scoped_lock lock(moving_);
      if (present_ != &home_) {
        home_ = other_;
        present_ = &home_;
      }
    }
    return home_;
  }

 private:
  mutable State home_;
  State other_;
  mutable std::atomic<const State*> present_{&home_};
  mutable std::mutex moving_;
};

}  // namespace tetraction
