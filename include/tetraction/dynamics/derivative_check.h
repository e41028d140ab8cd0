// Comparison of analytic forces and stiffness with finite differences on a user's own mesh and
// state.
#pragma once

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// Relative errors |analytic − difference|₂/|analytic|₂ over all elements.
struct DerivativeErrors {
  double force = 0.0;      ///< ∇W against central differences of W
  double stiffness = 0.0;  ///< ∇²W against central differences of ∇W
  double force_norm =
      0.0;  ///< |∇W|₂ over all element forces, N: shows that there was something to compare
};

/// Compares element by element at q. The steps of the central differences are 1e-5 of the element's
/// shortest edge. W must be defined at q.
DerivativeErrors check_derivatives(const ElasticPotential& potential, const Vector& q);

/// Returns positions in which every element is strained. A smooth bending and twisting displacement
/// with strains of about `strain` and small random moves of single vertices (with a fixed seed) are
/// added to q. The displacement is halved until W is defined.
Vector strained_state(const ElasticPotential& potential, const Vector& q, double strain = 0.1);

}  // namespace tetraction
