#include "pair_potential.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "squared_barrier.h"

namespace tetraction {
namespace {

using EdgePair = Eigen::Matrix<double, 6, 1>;

// The directions of two edges as columns, and their squares and product.
struct Directions {
  Vector3 a;
  Vector3 b;
  double aa;
  double bb;
  double ab;
};

Directions edge_directions(const PairPoints& p) {
  Directions d;
  d.a = p.col(1) - p.col(0);
  d.b = p.col(3) - p.col(2);
  d.aa = d.a.squaredNorm();
  d.bb = d.b.squaredNorm();
  d.ab = d.a.dot(d.b);
  return d;
}

// A vector of the two directions as one of the four points.
PairVector of_points(const Vector3& a, const Vector3& b) {
  PairVector result;
  result << -a, a, -b, b;
  return result;
}

// c = |a|²|b|² − (a·b)² by the points.
PairVector measure_gradient(const Directions& d) {
  return of_points(2.0 * (d.bb * d.a - d.ab * d.b), 2.0 * (d.aa * d.b - d.ab * d.a));
}

PairMatrix measure_hessian(const Directions& d) {
  const Matrix3 one = Matrix3::Identity();
  const Matrix3 a = 2.0 * (d.bb * one - d.b * d.b.transpose());
  const Matrix3 b = 2.0 * (d.aa * one - d.a * d.a.transpose());
  const Matrix3 mixed = 2.0 * (2.0 * d.a * d.b.transpose() - d.b * d.a.transpose() - d.ab * one);
  PairMatrix h;
  const auto set = [&](int i, int j, const Matrix3& block) {
    h.block<3, 3>(3 * i, 3 * j) = block;
    h.block<3, 3>(3 * j, 3 * i) = block.transpose();
  };
  set(0, 0, a);
  set(1, 1, a);
  set(0, 1, -a);
  set(2, 2, b);
  set(3, 3, b);
  set(2, 3, -b);
  set(0, 2, mixed);
  set(1, 3, mixed);
  set(0, 3, -mixed);
  set(1, 2, -mixed);
  return h;
}

double mollifier_slope(double c, double limit) {
  return c >= limit ? 0.0 : 2.0 * (1.0 - c / limit) / limit;
}

double mollifier_curvature(double c, double limit) {
  return c >= limit ? 0.0 : -2.0 / (limit * limit);
}

// (e(c1) − e(c0))/(c1 − c0).
double mollifier_mean_slope(double c0, double c1, double limit) {
  const double x = std::min(c0, c1) / limit;
  const double y = std::max(c0, c1) / limit;
  if (x >= 1.0) return 0.0;
  if (y <= 1.0) return (2.0 - x - y) / limit;
  return (1.0 - x) * (1.0 - x) / ((y - x) * limit);
}

bool has_mollifier(const ContactPair& pair) {
  return pair.kind == PairKind::kEdgeEdge && pair.parallel > 0.0;
}

// The edges from point 0; a pair of fewer points has zeros.
Matrix3 edges_from_first(PairKind kind, const PairPoints& p) {
  Matrix3 r = Matrix3::Zero();
  for (int i = 1; i < pair_size(kind); ++i) r.col(i - 1) = p.col(i) - p.col(0);
  return r;
}

// The minimiser of uᵀGu for the mean of two Gram matrices: that of points whose edges have this Gram matrix.
PairWeights mean_weights(PairKind kind, const Matrix3& edges0, const Matrix3& edges1) {
  const Matrix3 gram = 0.5 * (edges0.transpose() * edges0 + edges1.transpose() * edges1);
  const Eigen::LDLT<Matrix3> factors(gram);
  const Vector3 roots = factors.vectorD().cwiseMax(0.0).cwiseSqrt();
  // G = Pᵀ L D Lᵀ P, so that the rows of Pᵀ L √D are edges.
  Matrix3 rows = factors.matrixL();
  rows = (rows * roots.asDiagonal()).eval();
  rows = factors.transpositionsP().transpose() * rows;
  PairPoints points = PairPoints::Zero();
  points.rightCols<3>() = rows.transpose();
  return pair_distance(kind, points).weights;
}

struct MeanDistance {
  PairDistance from;
  PairDistance to;
  PairWeights weights;
  Vector3 difference;
  double d0 = 0.0;
  double d1 = 0.0;
  Matrix3 gram_gradient;  // ∇̄D
  Matrix3 edges;          // r̄
};

MeanDistance mean_distance(PairKind kind, const PairPoints& from, const PairPoints& to) {
  MeanDistance m;
  m.from = pair_distance(kind, from);
  m.to = pair_distance(kind, to);
  m.d0 = std::sqrt(m.from.squared);
  m.d1 = std::sqrt(m.to.squared);
  const Matrix3 r0 = edges_from_first(kind, from);
  const Matrix3 r1 = edges_from_first(kind, to);
  m.weights = mean_weights(kind, r0, r1);
  m.edges = 0.5 * (r0 + r1);
  const Vector3 u = m.weights.tail<3>();
  m.difference = m.edges * u;
  m.gram_gradient = u * u.transpose();
  const Matrix3 half = m.edges.transpose() * (r1 - r0);
  const Matrix3 change = half + half.transpose();
  const double squared = change.squaredNorm();
  if (!(squared > 0.0)) return m;
  // D − |v̄|² with v̄ = Σ w̄_i p_i at one end, from e = v − v̄, so that it has its own digits.
  const auto excess = [&u](const PairDistance& d, const Matrix3& r) {
    const Vector3 e = r * (d.weights.tail<3>() - u);
    return 2.0 * d.difference.dot(e) - e.squaredNorm();
  };
  m.gram_gradient += ((excess(m.to, r1) - excess(m.from, r0)) / squared) * change;
  return m;
}

}  // namespace

double parallel_limit(const Vector3& a, const Vector3& b) {
  return 1e-3 * a.squaredNorm() * b.squaredNorm();
}

double parallel_measure(const PairPoints& points) {
  const Vector3 a = points.col(1) - points.col(0);
  const Vector3 b = points.col(3) - points.col(2);
  return a.cross(b).squaredNorm();
}

double mollifier(double c, double limit) {
  const double x = c / limit;
  return x >= 1.0 ? 1.0 : (2.0 - x) * x;
}

double pair_energy(const Barrier& barrier, const ContactPair& pair, const PairPoints& points) {
  const double d = std::sqrt(pair_distance(pair.kind, points).squared);
  double energy = pair.weight * barrier.value(d);
  if (energy != 0.0 && d > 0.0 && has_mollifier(pair)) {
    energy *= mollifier(parallel_measure(points), pair.parallel);
  }
  return energy;
}

PairVector pair_gradient(const Barrier& barrier, const ContactPair& pair,
                         const PairPoints& points) {
  const PairDistance distance = pair_distance(pair.kind, points);
  const double d = std::sqrt(distance.squared);
  if (d >= barrier.thickness) return PairVector::Zero();
  const PairVector by_distance =
      (pair.weight * slope_of_square(barrier, d)) * squared_distance_gradient(distance);
  if (!has_mollifier(pair)) return by_distance;
  const double c = parallel_measure(points);
  return mollifier(c, pair.parallel) * by_distance +
         (pair.weight * barrier.value(d) * mollifier_slope(c, pair.parallel)) *
             measure_gradient(edge_directions(points));
}

PairMatrix pair_hessian(const Barrier& barrier, const ContactPair& pair, const PairPoints& points) {
  const PairDistance distance = pair_distance(pair.kind, points);
  const double d = std::sqrt(distance.squared);
  if (d >= barrier.thickness) return PairMatrix::Zero();
  const PairVector g = squared_distance_gradient(distance);
  const double slope = slope_of_square(barrier, d);
  PairMatrix h = slope * squared_distance_hessian(pair.kind, points, distance);
  h.noalias() += curvature_of_square(barrier, d) * g * g.transpose();
  if (has_mollifier(pair)) {
    const double c = parallel_measure(points);
    if (c < pair.parallel) {
      const Directions edges = edge_directions(points);
      const PairVector gc = measure_gradient(edges);
      const double rate = mollifier_slope(c, pair.parallel);
      const double value = barrier.value(d);
      h *= mollifier(c, pair.parallel);
      h += (slope * rate) * (g * gc.transpose() + gc * g.transpose());
      h += value * (rate * measure_hessian(edges) +
                    mollifier_curvature(c, pair.parallel) * gc * gc.transpose());
    }
  }
  return pair.weight * h;
}

MeanPair mean_pair(const Barrier& barrier, const ContactPair& pair, const PairPoints& from,
                   const PairPoints& to) {
  const MeanDistance mean = mean_distance(pair.kind, from, to);
  MeanPair result;
  result.weights = mean.weights;
  result.difference = mean.difference;
  if (mean.d0 >= barrier.thickness && mean.d1 >= barrier.thickness) return result;
  double c0 = 0.0;
  double c1 = 0.0;
  double factor = pair.weight;
  if (has_mollifier(pair)) {
    c0 = parallel_measure(from);
    c1 = parallel_measure(to);
    factor *= 0.5 * (mollifier(c0, pair.parallel) + mollifier(c1, pair.parallel));
  }
  const double s = mean_slope_of_square(barrier, mean.d0, mean.d1);
  const Matrix3 forces = (2.0 * factor * s) * (mean.edges * mean.gram_gradient);
  for (int i = 0; i < 3; ++i) {
    result.gradient.segment<3>(3 * (i + 1)) = forces.col(i);
    result.gradient.head<3>() -= forces.col(i);
  }
  result.force = -2.0 * factor * s * mean.difference.norm();
  result.stiffness = factor * barrier.mean_slope_rate(mean.d0, mean.d1);
  if (!has_mollifier(pair) || std::min(c0, c1) >= pair.parallel) return result;
  const Directions d0 = edge_directions(from);
  const Directions d1 = edge_directions(to);
  // The squares and the product are those of the mean Gram matrix.
  const Directions d{0.5 * (d0.a + d1.a), 0.5 * (d0.b + d1.b), 0.5 * (d0.aa + d1.aa),
                     0.5 * (d0.bb + d1.bb), 0.5 * (d0.ab + d1.ab)};
  const double value = 0.5 * (barrier.value(mean.d0) + barrier.value(mean.d1));
  result.gradient +=
      (pair.weight * value * mollifier_mean_slope(c0, c1, pair.parallel)) * measure_gradient(d);
  return result;
}

PairMatrix mean_pair_hessian(const Barrier& barrier, const ContactPair& pair,
                             const PairPoints& from, const PairPoints& to) {
  const MeanDistance mean = mean_distance(pair.kind, from, to);
  if (mean.d0 >= barrier.thickness && mean.d1 >= barrier.thickness) return PairMatrix::Zero();
  const PairPoints middle = 0.5 * (from + to);
  PairDistance distance;
  distance.weights = mean.weights;
  distance.difference = mean.difference;
  distance.squared = mean.difference.squaredNorm();
  const double s = mean_slope_of_square(barrier, mean.d0, mean.d1);
  const double rate = mean_slope_rate_of_square(barrier, mean.d0, mean.d1);
  const PairVector g = squared_distance_gradient(distance);
  const PairVector g1 = squared_distance_gradient(mean.to);
  PairMatrix h = (0.5 * s) * squared_distance_hessian(pair.kind, middle, distance);
  h += (0.5 * rate) * (g * g1.transpose() + g1 * g.transpose());
  if (has_mollifier(pair)) {
    const double limit = pair.parallel;
    const double c0 = parallel_measure(from);
    const double c1 = parallel_measure(to);
    h *= 0.5 * (mollifier(c0, limit) + mollifier(c1, limit));
    if (std::min(c0, c1) < limit) {
      const Directions edges = edge_directions(middle);
      const PairVector gc = measure_gradient(edges);
      const PairVector gc1 = measure_gradient(edge_directions(to));
      const double e_rate = mollifier_mean_slope(c0, c1, limit);
      const double value = 0.5 * (barrier.value(mean.d0) + barrier.value(mean.d1));
      // ∂ē/∂c1 = e′(c1)/2 and ∂Ū_b/∂D1 = U_b′(D1)/2; the symmetric parts of the products.
      const double first = 0.25 * s * mollifier_slope(c1, limit);
      const double second =
          mean.d1 < barrier.thickness ? 0.25 * e_rate * slope_of_square(barrier, mean.d1) : 0.0;
      h += first * (g * gc1.transpose() + gc1 * g.transpose());
      h += second * (gc * g1.transpose() + g1 * gc.transpose());
      h += (0.5 * value * e_rate) * measure_hessian(edges);
      h += (0.25 * value * mollifier_curvature(c1, limit)) *
           (gc * gc1.transpose() + gc1 * gc.transpose());
    }
  }
  return pair.weight * h;
}

}  // namespace tetraction
