// Analytic forces and stiffness against finite differences, on a user's own mesh and state.
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

/// Compares element by element at q, with central differences of 1e-5 of the element's shortest
/// edge. W must be defined at q.
DerivativeErrors check_derivatives(const ElasticPotential& potential, const Vector& q);

/// q with a smooth bending and twisting displacement of about `strain` strain and small random
/// moves of single vertices (fixed seed) added, halved until W is defined there: a state in which
/// every element is strained.
Vector strained_state(const ElasticPotential& potential, const Vector& q, double strain = 0.1);

}  // namespace tetraction
