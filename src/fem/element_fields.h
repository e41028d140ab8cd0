// Fields at the quadrature points of all elements (RestState).
#pragma once

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// F at point i.
Matrix3 deformation_gradient(const RestState& rest, const Positions& x, Index i);

/// E = ½(FᵀF − I) in columns of XX YY ZZ XY YZ XZ. Unless `ratios` is null, it becomes volume_ratios().
Matrix green_strains(const ElasticPotential& elastic, const Vector& q, Vector* ratios = nullptr);
/// J.
Vector volume_ratios(const ElasticPotential& elastic, const Vector& q);

}  // namespace tetraction
