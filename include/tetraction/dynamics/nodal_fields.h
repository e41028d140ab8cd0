// Strain and stress at places of elements and at vertices.
#pragma once

#include <array>

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The values of an element at a place.
struct PlaceValues {
  Matrix3 cauchy_stress;   ///< σ = P Fᵀ/J, Pa
  Matrix3 green_strain;    ///< E = ½(FᵀF − I)
  double von_mises = 0.0;  ///< of σ, Pa
  double jacobian = 0.0;   ///< J = det F
};
/// The values of element e at the place with the volume coordinates L_0 … L_3, which add up to 1. In a
/// linear element they are the same everywhere. W must be defined at q: away from the points of
/// quadrature of a quadratic element it need not be, and the values are then those of the nearest of them.
PlaceValues values_at(const MechanicalSystem& system, Index e, const std::array<double, 4>& l,
                      const Vector& q);

/// Fields with one column per vertex, with rows as in ElementFields (dynamics/derived_fields.h).
struct NodalFields {
  Matrix cauchy_stress;
  Matrix green_strain;
  Matrix von_mises;  ///< the mean of the von Mises stresses, not that of the mean stress
  Matrix jacobian;
};
/// The means Σ V_e s_e(v)/Σ V_e over the elements at each vertex v of the values s_e(v) that they have
/// there (values_at()), with their rest volumes. Of linear elements this is nodal_average().
NodalFields nodal_fields(const MechanicalSystem& system, const Vector& q);

/// The values at the vertices of a field of linear tetrahedra, recovered by Zienkiewicz and Zhu's
/// superconvergent patches (Int. J. Numer. Meth. Eng. 33, 1992, 1331–1364): at each vertex the linear
/// polynomial in X that is nearest to the values at the centroids of its elements in the sum of
/// squares. A vertex on the surface has the mean of the polynomials of the vertices inside next to it, and one at
/// an edge those of its neighbours on the faces. Where no vertex inside is near, patches of the surface serve,
/// and nodal_average() where they would extrapolate. Fields that are linear in X are recovered exactly
/// where patches serve, and steps between materials are smoothed.
Matrix recovered_field(const MechanicalSystem& system, const Matrix& element_field);

}  // namespace tetraction
