// How signals end a run.
#pragma once

#include <array>
#include <csignal>

#include "tetraction/simulation/session.h"
#include "tetraction/simulation/stop_request.h"

namespace tetraction {

/// While an object of this class lives, SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGQUIT end a run
/// properly: the present step is finished, unless it is divided or repeated (StopRequest), and all
/// files are written. A second signal ends the program at once, wherever it is, and the files are
/// then as after a kill. Some programs send one signal twice (timeout, for instance, to the program
/// and to its group), so a signal within 0.3 s after the first one does not count.
///
/// A signal that was ignored when the program began stays ignored: nohup ignores SIGHUP.
class InterruptGuard : public Observer, public StopRequest {
 public:
  InterruptGuard();
  ~InterruptGuard() override;
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  bool on_step(const Session&) override { return !interrupted(); }
  bool stop_requested() const override { return interrupted(); }
  static bool interrupted();
  /// 128 plus the number of the first signal, as shells have it: 130 for SIGINT, 143 for SIGTERM,
  /// 129 for SIGHUP, 131 for SIGQUIT. 130 if there was none.
  static int exit_code();

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT};
  std::array<struct sigaction, kSignals.size()> previous_{};
};

}  // namespace tetraction
