// Shape functions of the ten-node tetrahedron at any point of it. The nodes have the order of
// TetMesh::edge_vertices. quadratic_points.h has the formulas, and the fixed points of the quadrature.
#pragma once

#include <array>

#include "mesh/quadratic_points.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// L_0 … L_3, whose sum is 1.
using VolumeCoordinates = std::array<double, 4>;

/// N_a: L_i (2 L_i − 1) at the corners, 4 L_i L_j at the middles of the edges.
inline std::array<double, QuadraticPoints::kNodes> quadratic_shapes(const VolumeCoordinates& l) {
  std::array<double, QuadraticPoints::kNodes> n{};
  for (int i = 0; i < 4; ++i) {
    const double own = l[static_cast<std::size_t>(i)];
    n[static_cast<std::size_t>(i)] = own * (2.0 * own - 1.0);
    for (int j = 0; j < i; ++j) {
      n[static_cast<std::size_t>(QuadraticPoints::middle(i, j))] =
          4.0 * own * l[static_cast<std::size_t>(j)];
    }
  }
  return n;
}

/// The columns ∂x/∂ξ_k = ∂x/∂L_k − ∂x/∂L_0, k = 1 … 3, of x = Σ_a N_a x_a. `node(a)` is x_a for
/// a = 0 … 9; a constant offset of all nodes changes the result by round-off alone.
template <class Node>
Matrix3 quadratic_edges(const VolumeCoordinates& l, const Node& node) {
  std::array<Vector3, 4> d;  // ∂x/∂L_j
  for (int j = 0; j < 4; ++j) {
    Vector3 sum = (4.0 * l[static_cast<std::size_t>(j)] - 1.0) * node(j);
    for (int i = 0; i < 4; ++i) {
      if (i != j) {
        sum += 4.0 * l[static_cast<std::size_t>(i)] * node(QuadraticPoints::middle(i, j));
      }
    }
    d[static_cast<std::size_t>(j)] = sum;
  }
  Matrix3 edges;
  edges << d[1] - d[0], d[2] - d[0], d[3] - d[0];
  return edges;
}

}  // namespace tetraction
