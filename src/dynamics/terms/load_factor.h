// The factor of a load where a force term is evaluated.
#pragma once

#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

/// The mean of a LoadHistory or an Amplitude over the step of `at`, or its value at the instant
/// `at.time` if there is no step.
template <class Factor>
double factor_at(const Factor& factor, const ForcePoint& at) {
  return at.step ? factor.mean(*at.step) : factor.value(at.time);
}

}  // namespace tetraction
