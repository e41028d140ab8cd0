// A material whose evaluation can be held up: a step that lasts as long as a test wants.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "tetraction/material/material.h"

namespace tetraction::testing_support {

/// Holds up one thread, the first one that comes after close(), until open(). Others pass.
class Gate {
 public:
  void pass() {
    std::unique_lock lock(mutex_);
    if (!closed_ || occupied_) return;
    occupied_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !closed_; });
    occupied_ = false;
  }
  void close() { set(true); }
  void open() { set(false); }
  /// Waits until a thread is held up, for a minute at most.
  bool wait_for_thread() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::minutes(1), [this] { return occupied_; });
  }

 private:
  void set(bool closed) {
    const std::scoped_lock lock(mutex_);
    closed_ = closed;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool closed_ = false;
  bool occupied_ = false;
};

/// Neo-Hookean rubber behind a gate, where the derivatives are computed.
class GatedRubber {
 public:
  static constexpr const char* kName = "gated-rubber";
  GatedRubber(const LameParameters& lame, std::shared_ptr<Gate> gate)
      : rubber_(lame.mu, lame.lambda), gate_(std::move(gate)) {}

  bool admissible(const Matrix3& f) const { return rubber_.admissible(f); }
  double energy_density(const Matrix3& f) const { return rubber_.energy_density(f); }
  Matrix3 first_piola(const Matrix3& f) const {
    gate_->pass();
    return rubber_.first_piola(f);
  }
  Matrix9 stiffness(const Matrix3& f) const {
    gate_->pass();
    return rubber_.stiffness(f);
  }
  LameParameters initial_lame() const { return rubber_.initial_lame(); }

 private:
  NeoHookean rubber_;
  std::shared_ptr<Gate> gate_;
};

}  // namespace tetraction::testing_support
