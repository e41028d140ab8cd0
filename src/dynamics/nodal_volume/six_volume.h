// Six times the volume of a tetrahedron, a·(b × c) of its edges from the first node, and its derivatives.
#pragma once

#include <Eigen/Geometry>

#include "tetraction/fem/element_shape.h"

namespace tetraction {

using TetrahedronNodes = LinearTetrahedron::NodeMatrix;

inline double six_volume(const TetrahedronNodes& x) {
  return Vector3(x.col(1) - x.col(0))
      .dot(Vector3(x.col(2) - x.col(0)).cross(Vector3(x.col(3) - x.col(0))));
}

/// ∂(6v)/∂x of the nodes at these positions.
inline TetrahedronNodes six_volume_gradient(const TetrahedronNodes& x) {
  const Vector3 a = x.col(1) - x.col(0);
  const Vector3 b = x.col(2) - x.col(0);
  const Vector3 c = x.col(3) - x.col(0);
  TetrahedronNodes gradient;
  gradient.col(1) = b.cross(c);
  gradient.col(2) = c.cross(a);
  gradient.col(3) = a.cross(b);
  gradient.col(0) = -(gradient.col(1) + gradient.col(2) + gradient.col(3));
  return gradient;
}

/// The derivative of the gradient in the direction d.
inline TetrahedronNodes six_volume_product(const TetrahedronNodes& x, const TetrahedronNodes& d) {
  TetrahedronNodes product;
  product.col(0).setZero();
  for (int k = 0; k < 3; ++k) {
    const int i = 1 + (k + 1) % 3;
    const int j = 1 + (k + 2) % 3;
    const auto edge = [](const TetrahedronNodes& m, int node) -> Vector3 {
      return m.col(node) - m.col(0);
    };
    product.col(k + 1) = edge(d, i).cross(edge(x, j)) + edge(x, i).cross(edge(d, j));
    product.col(0) -= product.col(k + 1);
  }
  return product;
}

/// ∂²(6v)/∂x².
inline LinearTetrahedron::DofMatrix six_volume_hessian(const TetrahedronNodes& x) {
  LinearTetrahedron::DofMatrix hessian;
  for (int a = 0; a < LinearTetrahedron::kDofs; ++a) {
    TetrahedronNodes direction = TetrahedronNodes::Zero();
    direction(a % 3, a / 3) = 1.0;
    hessian.col(a) = six_volume_product(x, direction).reshaped();
  }
  return hessian;
}

}  // namespace tetraction
