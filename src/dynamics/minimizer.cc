#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

bool make_admissible(const StepProblem& problem, Vector& u) {
  const ElasticPotential& elastic = problem.system().elastic();
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    if (elastic.admissible(Positions(problem.origin(), u)).ok()) return true;
    u *= 0.5;
  }
  u.setZero();
  return elastic.admissible(problem.origin()).ok();
}

}  // namespace tetraction
