#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

bool make_admissible(const StepProblem& problem, Vector& x) {
  const ElasticPotential& elastic = problem.system().elastic();
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    if (elastic.admissible(x).ok()) return true;
    x = 0.5 * (x + problem.base());
  }
  x = problem.base();
  return elastic.admissible(x).ok();
}

}  // namespace tetraction
