#include "step_controller.h"

#include <algorithm>
#include <cmath>

namespace tetraction {
namespace {

constexpr double kSafety = 0.9;
constexpr double kLeastFactor = 0.2;
constexpr double kMostFactor = 5.0;
// A step whose error would allow it to grow by less than this factor stays as it is.
constexpr double kHardlyLarger = 1.2;
// Shares of the integral and the proportional part (Gustafsson 1991).
constexpr double kIntegral = 0.7;
constexpr double kProportional = 0.4;
// Errors below this one make no difference to the next step but one.
constexpr double kLeastError = 1e-4;
// find_step() tries nothing above this share of a step that cannot be made.
constexpr double kBelowFailure = 0.9;
// Evaluations of find_step().
constexpr int kMostTrials = 16;

struct StepTrial {
  double square = 0.0;  // h²
  double residual = 0.0;
};

bool differ_in_sign(double a, double b) {
  return (a < 0.0) != (b < 0.0);
}

// Where the straight line through two trials vanishes.
double secant(const StepTrial& a, const StepTrial& b) {
  return (a.square * b.residual - b.square * a.residual) / (b.residual - a.residual);
}

// Evaluates the residual and remembers the best step.
class Search {
 public:
  Search(const std::function<std::optional<double>(double)>& residual, double tolerance)
      : residual_(residual), tolerance_(tolerance) {}

  std::optional<StepTrial> at(double step) {
    ++trials_;
    const std::optional<double> value = residual_(step);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    if (best_.step == 0.0 || std::abs(*value) < std::abs(best_.residual)) {
      best_ = {step, *value, std::abs(*value) <= tolerance_};
    }
    return StepTrial{step * step, *value};
  }
  bool is_over() const { return best_.found || trials_ >= kMostTrials; }
  const StepRoot& best() const { return best_; }

  // Regula falsi between two trials of different signs (Illinois).
  void narrow(StepTrial a, StepTrial b, const StepBounds& bounds) {
    int same_end = 0;  // −1: a was replaced last; 1: b
    while (!is_over()) {
      const double next =
          std::clamp(std::sqrt(std::max(0.0, secant(a, b))), bounds.least, bounds.most);
      // The solution is beyond a bound, or between two neighbouring numbers.
      if (next * next == a.square || next * next == b.square) return;
      const std::optional<StepTrial> trial = at(next);
      if (!trial) return;
      if (differ_in_sign(trial->residual, b.residual)) {
        a = *trial;
        if (same_end == -1) b.residual *= 0.5;
        same_end = -1;
      } else {
        b = *trial;
        if (same_end == 1) a.residual *= 0.5;
        same_end = 1;
      }
    }
  }

 private:
  const std::function<std::optional<double>(double)>& residual_;
  double tolerance_;
  int trials_ = 0;
  StepRoot best_;
};

}  // namespace

double StepController::after_rejection(double error) const {
  if (!std::isfinite(error)) return kLeastFactor;
  return std::clamp(kSafety * std::pow(error, -exponent_), kLeastFactor, kSafety);
}

double StepController::after_success(double error, bool was_rejected) {
  const double present = std::max(error, std::numeric_limits<double>::min());
  const double elementary = kSafety * std::pow(present, -exponent_);
  double factor = elementary;
  if (memory_.last_error > 0.0) {
    factor = kSafety * std::pow(present, -kIntegral * exponent_) *
             std::pow(memory_.last_error, kProportional * exponent_);
  }
  memory_.last_error = std::max(error, kLeastError);
  if (elementary > 1.0 && elementary < kHardlyLarger) return 1.0;
  return std::clamp(factor, kLeastFactor, was_rejected ? 1.0 : kMostFactor);
}

StepRoot find_step(const std::function<std::optional<double>(double)>& residual, double first,
                   double at_zero, const StepBounds& bounds, double tolerance) {
  Search search(residual, tolerance);
  StepBounds range = bounds;
  double step = std::clamp(first, range.least, range.most);
  std::optional<StepTrial> start = search.at(step);
  while (!start && step > range.least && !search.is_over()) {
    range.most = std::max(range.least, kBelowFailure * step);
    step = std::max(range.least, 0.5 * step);
    start = search.at(step);
  }
  if (!start || search.is_over()) return search.best();
  const StepTrial zero{0.0, at_zero};
  if (differ_in_sign(zero.residual, start->residual)) {
    search.narrow(zero, *start, range);
    return search.best();
  }
  // The residual has the same sign at the first step. It may change it farther away.
  double farther = std::sqrt(std::max(0.0, secant(zero, *start)));
  if (!(farther > step)) farther = range.most;
  double before = step;
  for (double next : {std::min(farther, range.most), range.most, range.least}) {
    if (next == before || next == step) continue;
    before = next;
    const std::optional<StepTrial> trial = search.at(next);
    if (search.is_over()) break;
    if (!trial || !differ_in_sign(trial->residual, start->residual)) continue;
    search.narrow(*start, *trial, range);
    break;
  }
  return search.best();
}

}  // namespace tetraction
