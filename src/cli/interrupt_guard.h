// How signals end the program.
#pragma once

#include "tetraction/simulation/session.h"
#include "tetraction/simulation/stop_flag.h"
#include "tetraction/simulation/stop_request.h"

namespace tetraction {

/// To be called at the start of the program. From then on SIGINT (Ctrl-C), SIGTERM, SIGHUP and
/// SIGQUIT come to a thread of their own, and are blocked in all others. METIS, which orders large
/// matrices, has a handler of its own for SIGTERM, which would end its work as if memory were
/// short, or crash in another thread than its own. A SIGHUP that is ignored (nohup) stays so.
///
/// Without an InterruptGuard a signal does what it does by default: it ends the program.
void watch_signals();

/// Unblocks these signals, for a child process. It may be called after a fork.
void unblock_signals();

/// While an object of this class lives, a signal ends a run properly: the present step is finished,
/// unless it is divided or repeated, or a load step (StopRequest, StopFlag), and all files are written. A second signal ends
/// the program at once, wherever it is, and the files are then as after a kill. Some programs send one
/// signal twice (timeout, for instance, to the program and to its group), so a signal within 0.3 s
/// after the first one does not count.
class InterruptGuard : public Observer, public StopRequest, public StopFlag {
 public:
  InterruptGuard();
  ~InterruptGuard() override;
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  bool on_step(const Session&) override { return !interrupted(); }
  bool stop_requested() const override { return interrupted(); }
  const std::atomic<bool>& stop_flag() const override;
  static bool interrupted();
  /// 128 plus the number of the first signal, as shells have it: 130 for SIGINT, 143 for SIGTERM,
  /// 129 for SIGHUP, 131 for SIGQUIT. 130 if there was none.
  static int exit_code();
};

}  // namespace tetraction
