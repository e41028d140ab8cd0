// The ways in which Newton's method solves its linear systems.
#pragma once

namespace tetraction {

/// How Newton's linear systems are solved.
enum class LinearSolver {
  kAuto,        ///< the cheapest of the others by a rule from measurements (docs/performance.md)
  kMatrixFree,  ///< two-level conjugate gradients on the exact stiffness, without a matrix
  kCg,          ///< conjugate gradients on the assembled matrix
  kFactor       ///< as kCg, preconditioned with CHOLMOD's factor of an older matrix
};

}  // namespace tetraction
