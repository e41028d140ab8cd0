// The message of a minimiser at its end.
#pragma once

#include <string>

#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

/// One line for MinimizerReport::message.
inline std::string termination_message(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged: the force residual is below its limit";
    case Termination::kIterationLimit:
      return "the iteration limit was reached";
    case Termination::kNoProgress:
      return "no step lowers the potential any further";
    case Termination::kInadmissible:
      break;
  }
  return "the elastic energy is not defined at the end of the minimisation";
}

}  // namespace tetraction
