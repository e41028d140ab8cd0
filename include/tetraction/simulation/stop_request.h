// Stopping a run in the middle of a step.
#pragma once

namespace tetraction {

/// An additional interface of an observer of a run (simulation/session.h) that can tell at any time
/// whether the run shall stop. Session::run() asks such observers between the parts of a step that
/// is divided (time.retry) and between the attempts at a step (time.adapt, step = "auto"), of which
/// there may be many. The step is then given up: the state is that of the last complete step, and
/// the run ends with RunStatus::kCancelled.
class StopRequest {
 public:
  virtual ~StopRequest() = default;
  /// Whether the run shall stop. It is called by the thread that runs it.
  virtual bool stop_requested() const = 0;
};

}  // namespace tetraction
