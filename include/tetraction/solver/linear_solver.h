// The ways in which Newton's method solves its linear systems.
#pragma once

namespace tetraction {

/// How Newton's linear systems are solved.
enum class LinearSolver {
  kAuto,  ///< the first of the others that the measured rule (docs/performance.md) finds cheapest
  kMatrixFree,  ///< two-level conjugate gradients on the exact stiffness, without a matrix
  kCg,          ///< conjugate gradients on the assembled matrix
  kFactor       ///< the same, preconditioned by CHOLMOD's factor of an older matrix
};

}  // namespace tetraction
