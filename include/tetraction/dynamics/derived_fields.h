// Fields for display that are computed from a state: strain, stress, deformation without rigid
// motion.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The components XX YY ZZ XY YZ XZ of a symmetric tensor.
Vector6 six_components(const Matrix3& s);
// The fields of an element are means over its rest volume. With straight edges they are those of its
// points of quadrature, which are exact for the strains of quadratic elements. Curved ones have a rule
// of degree 5, by which means of F are exact, too.

/// σ = P Fᵀ/J of one element, Pa: the mean. W must be defined at q.
Matrix3 cauchy_stress(const MechanicalSystem& system, Index e, const Vector& q);
/// J of one element: the ratio of its volumes at q and at rest, exact also with curved edges.
double volume_ratio(const MechanicalSystem& system, Index e, const Vector& q);
/// The least J at the quadrature points of one element.
double least_jacobian(const MechanicalSystem& system, Index e, const Vector& q);
/// √(3/2 s:s) of the deviator s of a stress, Pa; also of its six components.
double von_mises(const Matrix3& stress);
double von_mises(const Vector6& stress);

/// Fields with one column per element. Symmetric tensors have six rows in the order XX YY ZZ XY YZ
/// XZ.
struct ElementFields {
  Matrix cauchy_stress;   ///< σ = P Fᵀ/J, Pa (6 × elements)
  Matrix green_strain;    ///< E = ½(FᵀF − I) (6 × elements)
  Matrix von_mises;       ///< √(3/2 s:s) of the deviator s of the mean stress, Pa (1 × elements)
  Matrix jacobian;        ///< J (1 × elements)
  Matrix energy_density;  ///< Ψ, J/m³ (1 × elements)
};

/// Computes all fields. W must be defined at q. The energy density is the energy of the element, which is
/// that of its points of quadrature, divided by their volume.
ElementFields element_fields(const MechanicalSystem& system, const Vector& q);

/// Compute one of the fields only. For stress and energy W must be defined at q.
Matrix cauchy_stresses(const MechanicalSystem& system, const Vector& q);
Matrix green_strains(const MechanicalSystem& system, const Vector& q);
Matrix energy_densities(const MechanicalSystem& system, const Vector& q);
Vector volume_ratios(const MechanicalSystem& system, const Vector& q);

/// Compute two of the fields in one loop over the elements, with the same bits.
void stresses_and_energies(const MechanicalSystem& system, const Vector& q, Matrix& cauchy_stress,
                           Matrix& energy_density);
void strains_and_ratios(const MechanicalSystem& system, const Vector& q, Matrix& green_strain,
                        Matrix& jacobian);

/// The first Piola–Kirchhoff stress P of all elements, Pa, with the nine rows XX XY XZ YX YY YZ ZX ZY
/// ZZ (force along the first, on an area of the rest shape that is normal to the second). W must be
/// defined at q.
Matrix first_piola_stress(const MechanicalSystem& system, const Vector& q);
/// The eigenvalues of stresses that are given as columns of six components, the largest first, Pa
/// (3 × columns).
Matrix principal_stresses(const Matrix& cauchy_stress);
/// √(3/2 s:s) of the deviators s of stresses that are given as columns of six components, Pa (1 × columns).
Matrix von_mises_stresses(const Matrix& cauchy_stress);
/// −tr σ/3 of stresses that are given as columns of six components, Pa (1 × columns).
Matrix pressures(const Matrix& cauchy_stress);
/// The means Σ V_e s_e / Σ V_e of a field of elements over the elements at each vertex, with their
/// rest volumes (rows × vertices).
Matrix nodal_average(const MechanicalSystem& system, const Matrix& element_field);

/// The displacement less the best-fit rigid motion, 3 × vertices: q − (R (X − X̄) + q̄). The
/// centres X̄ and q̄ are mass-weighted. R is the rotation that brings the rest shape nearest to q.
/// It comes from the polar decomposition of Σ m (q − q̄)(X − X̄)ᵀ (shape matching, Müller et al.
/// 2005). R is a proper rotation even for flat or mirrored shapes.
Matrix deformation_field(const MechanicalSystem& system, const Vector& q);

/// The largest displacement from rest.
struct Displacement {
  double length = 0.0;  ///< m
  Index vertex = 0;
};
Displacement largest_displacement(const MechanicalSystem& system, const Vector& q);

/// The sum of the forces of all vertices (3 per vertex, N).
Vector3 resultant(const Vector& force);

}  // namespace tetraction
