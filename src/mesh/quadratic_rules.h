// Quadrature of polynomials over a tetrahedron, in volume coordinates, for elements with curved edges.
//
// x = Σ N_a x_a is quadratic, so that ∂x/∂ξ is linear and det ∂x/∂ξ is cubic in the volume coordinates.
// With that determinant, a constant has degree 3, a gradient of the shape functions times a volume 3
// (the cofactors of ∂X/∂ξ have degree 2), N_a degree 5 and N_a N_b degree 7. quadratic_points.h has
// the four points of the energy, whose rule is exact for degree 2: for volumes and strains of elements
// with straight edges.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "mesh/quadratic_shapes.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

struct VolumePoint {
  VolumeCoordinates l;
  double weight;  ///< of the volume of the element; all weights add up to 1
};

/// Degree 5, 14 points inside the element (N. J. Walkington, Quadrature on simplices of arbitrary
/// dimension, 2000).
constexpr std::array<VolumePoint, 14> rule_of_degree_five() {
  constexpr std::array<std::array<double, 2>, 2> kInner{
      {{0.31088591926330060980, 0.11268792571801585080},
       {0.092735250310891226402, 0.073493043116361949544}}};
  constexpr double kEdge = 0.045503704125649649492;
  constexpr double kEdgeWeight = 0.042546020777081466438;
  std::array<VolumePoint, 14> points{};
  std::size_t count = 0;
  for (const auto& [a, weight] : kInner) {
    for (std::size_t i = 0; i < 4; ++i) {
      VolumeCoordinates l{a, a, a, a};
      l[i] = 1.0 - 3.0 * a;
      points[count++] = {l, weight};
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      VolumeCoordinates l{kEdge, kEdge, kEdge, kEdge};
      l[i] = l[j] = 0.5 - kEdge;
      points[count++] = {l, kEdgeWeight};
    }
  }
  return points;
}

/// Degree 7, 35 points, some with negative weights (A. Grundmann & H. M. Möller, Invariant integration
/// formulas for the n-simplex by combinatorial methods, SIAM J. Numer. Anal. 15, 1978, with s = 3 and
/// n = 3): the points with the coordinates (2 β_k + 1)/(10 − 2 i), Σ β_k = 3 − i, i = 0 … 3.
constexpr std::array<VolumePoint, 35> rule_of_degree_seven() {
  // 3! (−1)^i 2⁻⁶ (10 − 2 i)⁷/(i! (10 − i)!)
  constexpr std::array<double, 4> kWeights{
      6.0 * 1e7 / 64.0 / 3628800.0, -6.0 * 2097152.0 / 64.0 / 362880.0,
      6.0 * 279936.0 / 64.0 / (2.0 * 40320.0), -6.0 * 16384.0 / 64.0 / (6.0 * 5040.0)};
  std::array<VolumePoint, 35> points{};
  std::size_t count = 0;
  for (int i = 0; i < 4; ++i) {
    const int sum = 3 - i;
    const auto level = [i](int beta) { return (2.0 * beta + 1.0) / (10.0 - 2.0 * i); };
    for (int a = 0; a <= sum; ++a) {
      for (int b = 0; a + b <= sum; ++b) {
        for (int c = 0; a + b + c <= sum; ++c) {
          points[count++] = {{level(a), level(b), level(c), level(sum - a - b - c)},
                             kWeights[static_cast<std::size_t>(i)]};
        }
      }
    }
  }
  return points;
}

/// The edges s ∂x/∂ξ at the four points of an element (mesh/quadratic_points.h).
using PointEdges = std::array<Matrix3, QuadraticPoints::kPoints>;

/// Those of the element with the nodes node(a), a = 0 … 9. They are formed relative to the first corner, which keeps
/// their digits.
template <class Node>
PointEdges edges_at_points(const Node& node) {
  std::array<Vector3, QuadraticPoints::kNodes> values;
  const Vector3 origin = node(0);
  for (std::size_t a = 0; a < values.size(); ++a) values[a] = node(static_cast<int>(a)) - origin;
  std::array<Vector3, QuadraticPoints::kEdges> edges;
  QuadraticPoints::edges_of(values, edges);
  PointEdges at_points;
  for (std::size_t p = 0; p < at_points.size(); ++p) {
    at_points[p] << edges[3 * p], edges[3 * p + 1], edges[3 * p + 2];
  }
  return at_points;
}

/// Those of element e of a quadratic mesh at rest.
inline PointEdges rest_edges_at_points(const TetMesh& mesh, Index e) {
  const auto i = static_cast<std::size_t>(e);
  return edges_at_points([&](int a) -> Vector3 {
    const auto node = static_cast<std::size_t>(a);
    const Index v = a < 4 ? mesh.tetrahedra[i][node] : mesh.edge_vertices[i][node - 4];
    return mesh.vertices[static_cast<std::size_t>(v)];
  });
}

/// ∫ det(∂x/∂ξ) over the element: the exact volume with curved edges, m³.
///
/// The four points leave out a part of the terms of third degree, which are the determinant of the
/// linear part of ∂x/∂ξ. That is c(d) = det(∂x/∂ξ(m + d) − ∂x/∂ξ(m)) at the distance d from the
/// centroid m, and its integral is Σ c(d_p)/360 over the corners. The points of the energy are at
/// d_p/√5. With straight edges c is zero, and the sum has the bits of that of the four points.
inline double curved_volume(const PointEdges& edges) {
  double sum = 0.0;
  Matrix3 mean = Matrix3::Zero();
  for (const Matrix3& at_point : edges) {
    sum += at_point.determinant() / 6.0;
    mean += 0.25 * at_point;
  }
  double third = 0.0;
  for (const Matrix3& at_point : edges) third += (at_point - mean).determinant();
  return sum + (std::sqrt(5.0) / 3.0 - 1.0) / 6.0 * third;
}

/// Whether all edges are straight up to round-off, with their vertices in the middle. `node(a)` is x_a.
template <class Node>
bool has_straight_edges(const Node& node) {
  constexpr double kRoundOff = 1e-12;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const Vector3 a = node(i);
      const Vector3 b = node(j);
      const Vector3 off = node(QuadraticPoints::middle(i, j)) - 0.5 * (a + b);
      if (off.squaredNorm() > kRoundOff * kRoundOff * (b - a).squaredNorm()) return false;
    }
  }
  return true;
}

}  // namespace tetraction
