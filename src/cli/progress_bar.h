// A progress bar with the time left, on a terminal only.
#pragma once

#include <chrono>
#include <string>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// Draws on stderr while a run goes on, and clears the line at the end.
class ProgressBar : public Observer {
 public:
  explicit ProgressBar(std::string label) : label_(std::move(label)) {}
  void on_start(const Session& session) override;
  bool on_step(const Session& session) override;
  void on_finish(const Session& session) override;

  /// Whether stderr is a terminal that a line can be redrawn on.
  static bool possible();

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  Clock::time_point start_;
  Clock::time_point drawn_;
};

}  // namespace tetraction
