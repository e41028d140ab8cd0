// Energy, gradient and Hessian of an element as sums over its quadrature points.
#pragma once

#include "mesh/quadratic_points.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

using NodeGradient = decltype(ElasticPotential::ElementTerms::gradient);
using ElementMatrix = decltype(ElasticPotential::ElementTerms::hessian);

/// matrix += the matrix K of point p for the nodes of its element, Cᵀ K C. The rows of C give the nodes
/// of the point from those of the element. For a linear element C is the identity.
void add_point_matrix(int p, const LinearTetrahedron::DofMatrix& k, ElementMatrix& matrix);

/// gradient += the gradient of point p for the nodes of its element, one column per node.
void add_point_gradient(int p, const LinearTetrahedron::NodeMatrix& g, NodeGradient& gradient);

/// Sets the terms to zero, with the sizes of an element of this mesh.
void clear(const RestState& rest, bool with_hessian, ElasticPotential::ElementTerms& terms);

/// Adds the terms of point p.
template <Material M>
void add_point(int p, const RestElement<LinearTetrahedron>& point, const M& material,
               const LinearTetrahedron::NodeMatrix& local, bool with_hessian,
               ElasticPotential::ElementTerms& terms) {
  using Shape = LinearTetrahedron;
  terms.energy += element_energy<Shape>(point, material, local);
  add_point_gradient(p, element_gradient<Shape>(point, material, local), terms.gradient);
  if (with_hessian) {
    add_point_matrix(p, element_hessian<Shape>(point, material, local), terms.hessian);
  }
}

}  // namespace tetraction
