// Deformation gradient and stress at any place of a quadratic element.
#pragma once

#include <array>

#include "mesh/quadratic_rules.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

class QuadraticElement {
 public:
  /// It refers to the system and to q, which must live longer.
  QuadraticElement(const MechanicalSystem& system, Index e, const Vector& q);

  /// det(∂X/∂ξ), m³.
  double rest_determinant(const VolumeCoordinates& l) const;
  /// F = (∂x/∂ξ)(∂X/∂ξ)⁻¹. Away from the four points of quadrature ∂X/∂ξ may be singular (at a corner with
  /// edge vertices in the quarters of its edges), and the element may be turned inside out, where the
  /// material has no energy. There F is that of the nearest of the four points.
  Matrix3 deformation_gradient(const VolumeCoordinates& l) const;
  Matrix3 first_piola(const Matrix3& f) const;

 private:
  using Nodes = std::array<Vector3, QuadraticPoints::kNodes>;
  static Matrix3 edges(const Nodes& nodes, const VolumeCoordinates& l);
  bool is_defined(const Matrix3& f) const;

  MaterialModel material_;
  Nodes rest_;  // relative to the first node
  Nodes present_;
  double least_determinant_ = 0.0;
};

/// Whether a quadratic element has curved edges, or an edge vertex that is not in the middle.
bool is_curved(const RestState& rest, Index e);

/// σ = P Fᵀ/J, Pa.
Matrix3 cauchy_of(const Matrix3& first_piola, const Matrix3& f);

}  // namespace tetraction
