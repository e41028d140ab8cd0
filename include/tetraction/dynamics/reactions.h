// The forces of constraints in a step.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The mean forces that constraints exert on the body in a step.
struct Reactions {
  /// 3 per vertex, N: the impulses of the constraints divided by the length of the step, and the forces of penalty
  /// springs.
  Vector force;
  /// 3 per vertex, N s: each of these forces times the time from where it acts to the end of the step. A vertex of
  /// the mean velocity v was v τ away from its end then, which its moment needs: Σ x × f = x_end × force − v × delay.
  Vector delay;
  /// The generalised forces u on the configuration of the constraints' equations. Empty without equations or before
  /// the first step.
  Vector configuration_force;

  static Reactions zero(Index dof_count) {
    return {Vector::Zero(dof_count), Vector::Zero(dof_count), {}};
  }
  /// Adds those of a part of the step, which is the fraction `share` of it and ends `earlier` seconds before it.
  void add(const Reactions& part, double share, double earlier) {
    const auto enter = [share](Vector& sum, const Vector& value) {
      if (value.size() == 0) return;
      if (sum.size() == 0) sum.setZero(value.size());
      sum += share * value;
    };
    enter(force, part.force);
    enter(delay, part.delay);
    delay += share * earlier * part.force;
    enter(configuration_force, part.configuration_force);
  }
};

}  // namespace tetraction
