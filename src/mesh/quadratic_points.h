// The quadrature points of the ten-node tetrahedron, seen as linear tetrahedra.
//
// With the volume coordinates L_0 … L_3 the shape functions are N_i = L_i (2 L_i − 1) at the corners
// and N_ij = 4 L_i L_j at the middles of the edges (Zienkiewicz, Taylor & Zhu 2013, section 6.3). With
// the reference coordinates ξ_k = L_k, k = 1 … 3, the columns of ∂x/∂ξ at a point are
//
//     ∂x/∂ξ_k = D_k − D_0,   D_j = Σ_a x_a ∂N_a/∂L_j = (4 L_j − 1) x_j + 4 Σ_{i≠j} L_i x_ij
//
// The rule with four points has L_p = a at point p and L_i = b for i ≠ p, and the weights 1/24. It is
// exact for polynomials of degree 2 (Hammer, Marlowe & Stroud 1956).
//
// F = (∂x/∂ξ)(∂X/∂ξ)⁻¹ is therefore that of a linear tetrahedron with the edges e_k = s ∂x/∂ξ_k at x
// and s ∂X/∂ξ_k at rest. With s = (1/4)^(1/3) its rest volume det(s ∂X/∂ξ)/6 is the weight
// det(∂X/∂ξ)/24 of the point. So everything that is computed for linear tetrahedra serves the points
// of quadratic ones, if the edges are formed from the nodes before and forces on edges are handed to
// the nodes afterwards.
#pragma once

#include <array>

#include "tetraction/core/types.h"

namespace tetraction {

struct QuadraticPoints {
  static constexpr int kNodes = 10;
  static constexpr int kPoints = 4;
  static constexpr int kEdges = 3 * kPoints;
  static constexpr double kNear = 0.58541019662496845446;   ///< a = (5 + 3 √5)/20
  static constexpr double kFar = 0.13819660112501051518;    ///< b = (5 − √5)/20
  static constexpr double kScale = 0.62996052494743658238;  ///< s

  /// The node in the middle of the edge between corners i and j ≠ i.
  static constexpr int middle(int i, int j) {
    constexpr int kMiddle[4][4] = {{-1, 4, 6, 7}, {4, -1, 5, 8}, {6, 5, -1, 9}, {7, 8, 9, -1}};
    return kMiddle[i][j];
  }

  /// edges[3 p + k − 1] = s ∂x/∂ξ_k at point p of the element with these nodes. T is a vector.
  template <class T>
  static void edges_of(const std::array<T, kNodes>& x, std::array<T, kEdges>& edges) {
    using Scalar = typename T::Scalar;
    constexpr auto kOwn = static_cast<Scalar>(kScale * (4.0 * kFar - 1.0));
    constexpr auto kSum = static_cast<Scalar>(kScale * 4.0 * kFar);
    constexpr auto kMore = static_cast<Scalar>(kScale * 4.0 * (kNear - kFar));
    // s D_j is `base` and a term of the node that is next to the point.
    std::array<T, 4> base;
    for (int j = 0; j < 4; ++j) {
      const T others = x[at(middle(j, (j + 1) % 4))] + x[at(middle(j, (j + 2) % 4))] +
                       x[at(middle(j, (j + 3) % 4))];
      base[at(j)] = kOwn * x[at(j)] + kSum * others;
    }
    for (int p = 0; p < kPoints; ++p) {
      const T first = base[0] + kMore * x[at(p == 0 ? 0 : middle(p, 0))];
      for (int k = 1; k < 4; ++k) {
        edges[at(3 * p + k - 1)] = base[at(k)] + kMore * x[at(p == k ? k : middle(p, k))] - first;
      }
    }
  }

  /// The number with which node a enters edge k = 0 … 2 of point p: e_k = Σ_a x_a coefficient(p, k, a).
  static constexpr double coefficient(int p, int k, int a) {
    return derivative(p, k + 1, a) - derivative(p, 0, a);
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
  // s ∂N_a/∂L_j at point p.
  static constexpr double derivative(int p, int j, int a) {
    const auto level = [p](int i) { return p == i ? kNear : kFar; };  // L_i
    if (a == j) return kScale * (4.0 * level(j) - 1.0);
    for (int i = 0; i < 4; ++i) {
      if (i != j && a == middle(i, j)) return kScale * 4.0 * level(i);
    }
    return 0.0;
  }
};

}  // namespace tetraction
