#include "tetraction/dynamics/problems/minimizer.h"

namespace tetraction {

bool make_admissible(const NonlinearProblem& problem, Vector& u) {
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    if (problem.is_defined(u)) return true;
    u *= 0.5;
  }
  u.setZero();
  return problem.is_defined(u);
}

}  // namespace tetraction
