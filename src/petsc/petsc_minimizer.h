// Implicit steps of a body that several processes hold together.
#pragma once

#include <memory>
#include <string>

#include "mpi_part.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/minimizer.h"

namespace tetraction::petsc {

/// Newton's method with the line search of NewtonMinimizer. Its linear systems are solved by PETSc's
/// conjugate gradients. Their products come from the kernels of the elements, without a matrix. The
/// preconditioner is made of an assembled matrix with all coordinates, which is kept as long as it serves:
///
///     linear  preconditioner
///     cg      smoothed aggregation (GAMG) with the six rigid motions
///     factor  a Cholesky factor (MUMPS)
///
/// Where the matrix is not positive definite, the system is solved with one that is (TangentOperator::
/// convexify()). Unlike NewtonMinimizer it does not look for negative curvature at the end. Throws InputError
/// for materials without fast kernels. Keeps references to `system` and `part`.
std::unique_ptr<Minimizer> make_petsc_minimizer(const MechanicalSystem& system, const MpiPart& part,
                                                const MinimizerOptions& options,
                                                const std::string& linear);

}  // namespace tetraction::petsc
