// Stopping a load step at once.
#pragma once

#include <atomic>

namespace tetraction {

/// An additional interface of a StopRequest (simulation/stop_request.h) that has a flag which another
/// thread sets. An equilibrium may have one long load step only. Session::run() gives it up as soon
/// as the flag is true (core/interruption.h): the state is that of the last complete load step, and
/// the run ends with RunStatus::kCancelled. stop_requested() must be true from then on, too.
class StopFlag {
 public:
  virtual ~StopFlag() = default;
  /// It must live as long as the observer. Of several observers with a flag, the first one counts.
  virtual const std::atomic<bool>& stop_flag() const = 0;
};

}  // namespace tetraction
