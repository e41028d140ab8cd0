// Distances of points, edges and triangles, with derivatives.
#pragma once

#include <cstdint>

#include "tetraction/core/types.h"

namespace tetraction {

/// The two sides of a contact pair. Each side is the convex hull of its points.
enum class PairKind : std::uint8_t {
  kPointPoint,     ///< point 0 and point 1
  kPointEdge,      ///< point 0 and the edge of points 1, 2
  kPointTriangle,  ///< point 0 and the triangle of points 1, 2, 3
  kEdgeEdge,       ///< the edge of points 0, 1 and that of points 2, 3
};
/// Number of points of both sides.
int pair_size(PairKind kind);
/// Number of points of the first side.
int first_side_size(PairKind kind);

/// The points of a pair, one per column, m. Columns from pair_size() on are not used.
using PairPoints = Eigen::Matrix<double, 3, 4>;
/// Three numbers for each point; zero for points that are not used.
using PairVector = Eigen::Matrix<double, 12, 1>;
using PairMatrix = Eigen::Matrix<double, 12, 12>;
/// One number for each point.
using PairWeights = Eigen::Vector4d;

/// Where two sides are closest. The closest points are the sums of w_i p_i over the first side and of −w_i p_i
/// over the second one.
struct PairDistance {
  double squared = 0.0;  ///< D = |v|², m²
  PairWeights weights =
      PairWeights::Zero();  ///< w_i: ≥ 0 on the first side, ≤ 0 on the second one, sum 0
  Vector3 difference =
      Vector3::Zero();  ///< v = Σ w_i p_i, from the second side to the first one, m
};

/// The squared distance of the two sides of a pair: the minimum of |Σ w_i p_i|² over convex weights on each
/// side. Weights are zero at all points that the closest features do not have, so that the ones that are not
/// zero tell these features. Parallel edges and sides of length or area zero are allowed.
PairDistance pair_distance(PairKind kind, const PairPoints& points);

/// ∂D/∂p_i = 2 w_i v.
PairVector squared_distance_gradient(const PairDistance& distance);
/// ∂²D/∂p², with the weights moving within the closest features:
///
///     2 w_i w_j I − 2 (T_i v + e w_i)(EᵀE)⁻¹(T_j v + e w_j)ᵀ,   e = Σ T_i p_i the columns of E,
///
/// where T are the derivatives of the weights by the free parameters of the features. It is indefinite.
PairMatrix squared_distance_hessian(PairKind kind, const PairPoints& points,
                                    const PairDistance& distance);

}  // namespace tetraction
