// Mass, damping and stiffness of small bodies as dense matrices, and the motions that they give.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <complex>
#include <iterator>
#include <vector>

#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction::testing_support {

/// M, C and K over the free coordinates.
struct DenseMatrices {
  Matrix mass, damping, stiffness;
};

/// The matrices at the positions q, with the potentials and the loads that depend on positions.
inline DenseMatrices dense_matrices(const MechanicalSystem& system, const Vector& q) {
  const FreeCoordinates& coordinates = system.coordinates();
  const Index n = coordinates.count();
  const ForcePoint at = system.force_point(q, 0.0);
  HessianBlocks terms;
  terms.reset(system.vertex_count());
  LoadStiffness loads;
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) term->add_hessian(at, HessianForm::kExact, terms);
    if (term->has_load()) term->add_load_stiffness(at, loads);
  }
  DenseMatrices all{Matrix(n, n), Matrix(n, n), Matrix(n, n)};
  for (Index j = 0; j < n; ++j) {
    const Vector u = coordinates.extend(Vector::Unit(n, j));
    Vector product;
    system.elastic().product(q, u, product);
    terms.add_product(u, product);
    loads.add_product(u, product);
    all.stiffness.col(j) = coordinates.restrict(product);
    const Vector momentum =
        system.rest().is_quadratic() ? consistent_momentum(system, u) : system.momentum_of(u);
    all.mass.col(j) = coordinates.restrict(momentum);
    Vector viscous = Vector::Zero(u.size());
    system.add_viscous_force(q, u, viscous);
    all.damping.col(j) = coordinates.restrict(system.damping().mass_damping * momentum - viscous);
  }
  return all;
}

/// The λ of λ² M y + λ C y + K y = 0 that `counts` takes, in the order of |λ|.
template <class Counts>
std::vector<std::complex<double>> rates_of(const DenseMatrices& all, const Counts& counts) {
  const Index n = all.mass.rows();
  const Eigen::PartialPivLU<Matrix> lu(all.mass);
  Matrix companion = Matrix::Zero(2 * n, 2 * n);
  companion.topRightCorner(n, n).setIdentity();
  companion.bottomLeftCorner(n, n) = -lu.solve(all.stiffness);
  companion.bottomRightCorner(n, n) = -lu.solve(all.damping);
  const Eigen::VectorXcd values = Eigen::EigenSolver<Matrix>(companion, false).eigenvalues();
  std::vector<std::complex<double>> rates;
  std::copy_if(values.begin(), values.end(), std::back_inserter(rates), counts);
  std::sort(rates.begin(), rates.end(),
            [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); });
  return rates;
}

}  // namespace tetraction::testing_support
