// Checkpoints of a run while it goes on.
#pragma once

#include "tetraction/simulation/checkpoint.h"

namespace tetraction {

class Session;

/// An additional interface of an observer of a run (simulation/session.h) that stores checkpoints.
/// Session::run() makes one after each so many steps, after all observers have seen the step, and one
/// more if the run is cancelled. It makes none at the end of a run.
class CheckpointObserver {
 public:
  virtual ~CheckpointObserver() = default;
  /// n: after each step whose number is a multiple of n. 0: only if the run is cancelled. Below
  /// 0: never.
  virtual Index checkpoint_every() const = 0;
  /// `is_regular`: whether it was made after such a step, before anything of the next step. A run
  /// that makes only regular checkpoints and one that goes on from one of them have the same bits.
  virtual void on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                             bool is_regular) = 0;
};

}  // namespace tetraction
