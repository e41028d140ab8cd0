#include "progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "console.h"

namespace tetraction {
namespace {

std::string duration(double seconds) {
  const auto whole = std::lround(seconds);
  if (whole >= 3600)
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

bool ProgressBar::possible() {
  const char* term = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && (term == nullptr || std::strcmp(term, "dumb") != 0);
}

void ProgressBar::on_start(const Session&) {
  start_ = drawn_ = Clock::now();
}

bool ProgressBar::on_step(const Session& session) {
  constexpr auto kRedraw = std::chrono::milliseconds(100);
  constexpr int kWidth = 30;
  const auto now = Clock::now();
  if (now - drawn_ < kRedraw) return true;
  drawn_ = now;
  // The number of adaptive steps is not known before.
  const TimeSettings& time = session.time_settings();
  const bool adapts = time.adapt != StepAdaptation::kNone && std::isfinite(time.end);
  const double done = adapts ? session.time() / time.end
                             : static_cast<double>(session.step_number()) /
                                   static_cast<double>(session.step_count());
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const auto filled = static_cast<std::size_t>(done * kWidth);
  print_progress(fmt::format("\r\033[K{} [{}{}] {:3.0f} %  step {}/{}  {} left", label_,
                             std::string(filled, '='), std::string(kWidth - filled, ' '),
                             100.0 * done, session.step_number(), session.step_count(),
                             duration(elapsed * (1.0 - done) / done)));
  return true;
}

void ProgressBar::on_finish(const Session&) {
  print_progress("\r\033[K");
}

}  // namespace tetraction
