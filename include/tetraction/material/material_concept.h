// The concept of a hyperelastic material. A material has an energy density Ψ(F), a first
// Piola–Kirchhoff stress P = ∂Ψ/∂F and a stiffness ∂P/∂F, all in closed form. F is the deformation
// gradient (3 × 3), and J = det F.
//
// ∂P/∂F is the 9×9 matrix A of dvec(P) = A dvec(F) with vec() column by column (core/types.h):
//
//          F00 F10 F20 F01 F11 F21 F02 F12 F22
//     P00 [                                     ]
//     P10 [            symmetric                ]
//     ...
//
// A material is objective, Ψ(RF) = Ψ(F) for every rotation R.
#pragma once

#include <concepts>
#include <span>

#include "tetraction/core/types.h"

namespace tetraction {

/// J = det F.
inline double jacobian(const Matrix3& f) {
  return f(0, 0) * (f(1, 1) * f(2, 2) - f(2, 1) * f(1, 2)) -
         f(0, 1) * (f(1, 0) * f(2, 2) - f(2, 0) * f(1, 2)) +
         f(0, 2) * (f(1, 0) * f(2, 1) - f(2, 0) * f(1, 1));
}

/// The functions of a hyperelastic material that the element loop calls, from several threads at
/// the same time.
///
/// admissible(F) returns whether Ψ is defined at F (for example J > 0 if the law contains ln J). The
/// other three functions are called only where Ψ is defined. Ψ is in J/m³, P and ∂P/∂F
/// are in Pa.
template <class M>
concept Material = requires(const M& m, const Matrix3& f) {
  { m.admissible(f) } -> std::convertible_to<bool>;
  { m.energy_density(f) } -> std::convertible_to<double>;
  { m.first_piola(f) } -> std::convertible_to<Matrix3>;
  { m.stiffness(f) } -> std::convertible_to<Matrix9>;
};

/// Where in a body a material is evaluated.
struct MaterialPlace {
  Index element = 0;  ///< number of the tetrahedron in the body's mesh, from 0
  /// Rest position, m: the centroid of a linear tetrahedron, or one of the four quadrature points of a
  /// quadratic one.
  Vector3 position = Vector3::Zero();
};

/// A material that is not the same everywhere, such as one with fibres. at(place) returns the law there,
/// which is a Material. It is called for each evaluation, from several threads at the same time, and should
/// therefore cost little.
template <class M>
concept PlacedMaterial = requires(const M& m, const MaterialPlace& place) {
  { m.at(place) } -> Material;
};

/// Deformation gradients, and what a material computes of them: one entry for each F in every list that is
/// asked for. Lists that are not asked for are empty.
struct MaterialValues {
  std::span<const Matrix3> f;
  std::span<char> admissible;    ///< 1 where Ψ is defined, otherwise 0; always asked for
  std::span<double> energy;      ///< Ψ, J/m³
  std::span<Matrix3> stress;     ///< P, Pa
  std::span<Matrix9> stiffness;  ///< ∂P/∂F, Pa
  std::span<const MaterialPlace> places = {};  ///< only for a PlacedMaterial
};

/// A material that can evaluate many F in one call, for instance one in an interpreted language, whose
/// calls cost more than their arithmetic. Entries where Ψ is not defined are not looked at.
template <class M>
concept BatchMaterial = (Material<M> || PlacedMaterial<M>)&&requires(const M& m,
                                                                     const MaterialValues& values) {
  m.evaluate(values);
};

/// Small-strain Lamé parameters, Pa.
struct LameParameters {
  double mu = 0.0;      ///< shear modulus
  double lambda = 0.0;  ///< first Lamé parameter
};

}  // namespace tetraction
