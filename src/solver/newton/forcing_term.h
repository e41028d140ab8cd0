// How exactly the linear systems of an inexact Newton method are solved.
#pragma once

#include <algorithm>

#include "tetraction/dynamics/problems/minimizer.h"

namespace tetraction {

/// The forcing term of an inexact Newton method: the relative residual to which the next linear
/// system is solved. It is 0.5 times the square of the reduction of the residual by the last
/// iteration (Eisenstat & Walker 1996, choice 2). The first one of a step comes from the first
/// reduction in the last step.
class ForcingTerm {
 public:
  static constexpr double kFirst = 0.01;  ///< of the first step

  explicit ForcingTerm(double first) : value_(first) {}

  /// The term for the next system. It is at most 0.1, unless the end of the step needs fewer digits.
  double next(const MinimizerReport& report) const {
    return std::max(enough(report), std::min(value_, kLoosest));
  }
  /// The same for an iteration with the matrix of an earlier one. It reduces the residual about as much as the last
  /// iteration did, so that a direction of many more digits is of no use.
  double next_with_earlier_matrix(const MinimizerReport& report) const {
    return std::max(enough(report), first_of_next_step());
  }
  /// Enters the ratio of the residuals after and before an iteration.
  void enter(double ratio) {
    ratio_ = ratio;
    value_ = kGamma * ratio * ratio;
  }
  /// To be called after the first iteration of a step.
  double first_of_next_step() const { return std::clamp(kGamma * ratio_, kTightest, kLoosest); }

 private:
  static double enough(const MinimizerReport& report) {
    return 0.3 * report.residual_limit / report.residual;
  }

  static constexpr double kLoosest = 0.1;
  static constexpr double kTightest = 1e-4;
  static constexpr double kGamma = 0.5;

  double value_;
  double ratio_ = 1.0;
};

}  // namespace tetraction
