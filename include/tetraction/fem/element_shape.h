// Finite-element shapes and the functions of one element. They are templates over the numbers of
// nodes and quadrature points, so that all matrices have a fixed size.
//
// With the positions q_a of the element's nodes and the gradients g_a = ∂N_a/∂X of the shape
// functions at a quadrature point,
//
//     F = Σ_a q_a g_aᵀ                       deformation gradient
//     W = Σ_points w Ψ(F)                    energy, w = volume × quadrature weight
//     ∂W/∂q_a = Σ_points w P g_a             gradient, the internal forces with reversed sign
//     ∂²W/∂q_a∂q_b = Σ_points w Σ_JL g_a[J] A_JL g_b[L]
//
// where A_JL is the 3×3 block (J, L) of ∂P/∂F (material/material.h).
// For the linear tetrahedron F = [q1−q0, q2−q0, q3−q0] D_m⁻¹ with the rest edges
// D_m = [X1−X0, X2−X0, X3−X0] (Sumner & Popović 2004).
#pragma once

#include <array>

#include "tetraction/material/material.h"

namespace tetraction {

/// The number of nodes and quadrature points of an element, and its matrix types.
template <int Nodes, int Points>
struct ElementShape {
  static constexpr int kNodes = Nodes;
  static constexpr int kPoints = Points;
  static constexpr int kDofs = 3 * Nodes;

  using NodeMatrix = Eigen::Matrix<double, 3, Nodes>;  ///< one column per node
  using DofVector = Eigen::Matrix<double, kDofs, 1>;
  using DofMatrix = Eigen::Matrix<double, kDofs, kDofs>;
};

/// The tetrahedron with four nodes and constant strain.
using LinearTetrahedron = ElementShape<4, 1>;

/// Rest data of one element: gradients of the shape functions and weights at each point.
template <class Shape>
struct RestElement {
  std::array<typename Shape::NodeMatrix, Shape::kPoints> gradients;  ///< 1/m
  std::array<double, Shape::kPoints> weights{};                      ///< m³
};

/// F at a quadrature point.
template <class Shape>
Matrix3 deformation_gradient(const RestElement<Shape>& rest, int point,
                             const typename Shape::NodeMatrix& q) {
  return q * rest.gradients[static_cast<std::size_t>(point)].transpose();
}

/// Whether the material's energy is defined at all points of the element.
template <class Shape, Material M>
bool element_admissible(const RestElement<Shape>& rest, const M& material,
                        const typename Shape::NodeMatrix& q) {
  for (int p = 0; p < Shape::kPoints; ++p) {
    if (!material.admissible(deformation_gradient(rest, p, q))) return false;
  }
  return true;
}

/// Energy W of the element, J.
template <class Shape, Material M>
double element_energy(const RestElement<Shape>& rest, const M& material,
                      const typename Shape::NodeMatrix& q) {
  double energy = 0.0;
  for (int p = 0; p < Shape::kPoints; ++p) {
    energy += rest.weights[static_cast<std::size_t>(p)] *
              material.energy_density(deformation_gradient(rest, p, q));
  }
  return energy;
}

/// ∂W/∂q, one column per node, N.
template <class Shape, Material M>
typename Shape::NodeMatrix element_gradient(const RestElement<Shape>& rest, const M& material,
                                            const typename Shape::NodeMatrix& q) {
  typename Shape::NodeMatrix gradient = Shape::NodeMatrix::Zero();
  for (std::size_t p = 0; p < Shape::kPoints; ++p) {
    const Matrix3 stress = material.first_piola(deformation_gradient(rest, static_cast<int>(p), q));
    gradient.noalias() += rest.weights[p] * stress * rest.gradients[p];
  }
  return gradient;
}

/// ∂²W/∂q², symmetric, N/m.
template <class Shape, Material M>
typename Shape::DofMatrix element_hessian(const RestElement<Shape>& rest, const M& material,
                                          const typename Shape::NodeMatrix& q) {
  typename Shape::DofMatrix hessian = Shape::DofMatrix::Zero();
  for (std::size_t p = 0; p < Shape::kPoints; ++p) {
    const Matrix9 a =
        rest.weights[p] * material.stiffness(deformation_gradient(rest, static_cast<int>(p), q));
    const auto& g = rest.gradients[p];
    for (int n = 0; n < Shape::kNodes; ++n) {
      const Eigen::Matrix<double, 9, 3> column = a.template middleCols<3>(0) * g(0, n) +
                                                 a.template middleCols<3>(3) * g(1, n) +
                                                 a.template middleCols<3>(6) * g(2, n);
      for (int m = n; m < Shape::kNodes; ++m) {
        hessian.template block<3, 3>(3 * m, 3 * n) += g(0, m) * column.template middleRows<3>(0) +
                                                      g(1, m) * column.template middleRows<3>(3) +
                                                      g(2, m) * column.template middleRows<3>(6);
      }
    }
  }
  hessian.template triangularView<Eigen::StrictlyUpper>() = hessian.transpose();
  return hessian;
}

/// (∂²W/∂q²) δq at q = X + u without forming the matrix, one column per node, N. F = 1 + ∇u is exactly 1 at
/// rest, where a rotation must meet no stress.
template <class Shape, Material M>
typename Shape::NodeMatrix element_product(const RestElement<Shape>& rest, const M& material,
                                           const typename Shape::NodeMatrix& u,
                                           const typename Shape::NodeMatrix& dq) {
  typename Shape::NodeMatrix result = Shape::NodeMatrix::Zero();
  for (std::size_t p = 0; p < Shape::kPoints; ++p) {
    const int point = static_cast<int>(p);
    const Matrix3 f = Matrix3::Identity() + deformation_gradient(rest, point, u);
    const Matrix9 a = material.stiffness(f);
    const Vector9 stress = a * flatten(deformation_gradient(rest, point, dq));
    result.noalias() +=
        rest.weights[p] * Eigen::Map<const Matrix3>(stress.data()) * rest.gradients[p];
  }
  return result;
}

}  // namespace tetraction
