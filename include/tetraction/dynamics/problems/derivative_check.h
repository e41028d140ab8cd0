// Comparison of analytic derivatives with finite differences, on a user's own mesh and state: of
// materials, and of force terms.
#pragma once

#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// Relative errors |analytic − difference|₂/|analytic|₂ over the elements that are compared.
///
/// Differences are central. Where the second derivative jumps within the step, such as that of fibres that bear
/// no compression, a right one agrees only with the difference to one side, and that one counts.
struct DerivativeErrors {
  double force = 0.0;      ///< ∇W against central differences of W
  double stiffness = 0.0;  ///< ∇²W against central differences of ∇W
  double force_norm =
      0.0;  ///< |∇W|₂ over these elements' forces, N: shows that there was something to compare
  Index jumps = 0;  ///< moves of a node of an element across which ∇²W jumps
};

/// Compares element by element at q: all of them, or of a mesh with more than 16,384 elements
/// at least 8192, evenly spread over their numbers. The steps of the central differences are 1e-5 of the element's
/// shortest edge, and shorter where the forces bend within this step, as near the limit of Gent's law. W must be
/// defined at q.
DerivativeErrors check_derivatives(const ElasticPotential& potential, const Vector& q);

/// Compares the energy of nodal volumes at q in a few fixed random directions of all vertices, with
/// steps of 1e-5 of the mesh's shortest edge.
DerivativeErrors check_derivatives(const NodalVolume& volume, const RestState& rest,
                                   const Vector& q);

/// Returns positions in which every element is strained. A smooth bending and twisting displacement
/// with strains of about `strain` and small random moves of single vertices (with a fixed seed) are
/// added to q. The displacement is halved until W is defined.
Vector strained_state(const ElasticPotential& potential, const Vector& q, double strain = 0.1);

/// How well the derivatives of one part of a force term fit: of its potential U, whose variable y
/// is the positions x, or of its dissipation potential D, whose variable y is the velocities v.
/// Errors are relative, |analytic − difference|₂/|analytic|₂; infinite if only the analytic
/// derivative is zero. All are zero if the term lacks the part.
struct TermDerivativeErrors {
  double gradient = 0.0;  ///< ∂U/∂y against central differences of the energy
  double hessian = 0.0;   ///< ∂²U/∂y² against central differences of ∂U/∂y
  /// The least eigenvalue of the Hessian in the form HessianForm::kConvex, divided by the largest
  /// magnitude of an eigenvalue. It must not be below 0 by more than round-off.
  double least_eigenvalue = 0.0;
  /// |∂U/∂y|₂, N: shows that there was something to compare.
  double gradient_norm = 0.0;
  /// Entries of y across which the Hessian jumps. It is compared with the difference to one side there.
  Index jumps = 0;
};
struct ForceTermErrors {
  TermDerivativeErrors potential;
  TermDerivativeErrors dissipation;
};

/// Compares the derivatives of a force term at `at`, and those of its dissipation potential also at
/// the velocities `v` (3 per vertex, m/s). `step` is the step of the differences in positions, m.
/// It should be about 1e-5 of the lengths over which the force changes. The step in velocities is
/// 1e-5 of the largest component of v, or 1e-5 m/s if v is zero.
///
/// The term is evaluated about 12 times for every vertex, and the eigenvalues of a dense matrix are
/// computed if it couples vertices. The check is therefore meant for meshes of at most some
/// hundred vertices. Throws InputError if U is not defined at `at` or nearer than `step`, or if
/// sizes do not fit.
ForceTermErrors check_derivatives(const ForceTerm& term, const ForcePoint& at, const Vector& v,
                                  double step);

}  // namespace tetraction
