#include "pair_distance.h"

#include <Eigen/Geometry>

#include <array>

namespace tetraction {
namespace {

// Edges whose squared sine of the angle between them is below this are closest at one of their ends.
constexpr double kParallelEdges = 1e-20;
// The free parameters of two features are dependent below this squared sine.
constexpr double kDependentTangents = 1e-22;

// The distance of points i and j; i is of the first side.
PairDistance distance_of_points(const PairPoints& p, int i, int j) {
  PairDistance result;
  result.weights[i] = 1.0;
  result.weights[j] = -1.0;
  result.difference = p.col(i) - p.col(j);
  result.squared = result.difference.squaredNorm();
  return result;
}

// The distance of point i and the edge of a and b. `sign` is 1 if i is of the first side, else −1.
PairDistance distance_to_edge(const PairPoints& p, int i, int a, int b, double sign) {
  const Vector3 edge = p.col(b) - p.col(a);
  const Vector3 r = p.col(i) - p.col(a);
  const double length = edge.squaredNorm();
  const double along = r.dot(edge);
  PairDistance result;
  result.weights[i] = sign;
  if (!(along > 0.0) || length == 0.0) {
    result.weights[a] = -sign;
    result.difference = sign * r;
  } else if (along >= length) {
    result.weights[b] = -sign;
    result.difference = sign * (p.col(i) - p.col(b));
  } else {
    const double t = along / length;
    result.weights[a] = -sign * (1.0 - t);
    result.weights[b] = -sign * t;
    // From the nearer end, so that an error of t does not matter.
    const Vector3 difference =
        t < 0.5 ? Vector3(r - t * edge) : Vector3(p.col(i) - p.col(b) + (1.0 - t) * edge);
    result.difference = sign * difference;
  }
  result.squared = result.difference.squaredNorm();
  return result;
}

void take_smaller(PairDistance& best, const PairDistance& other) {
  if (other.squared < best.squared) best = other;
}

PairDistance point_triangle(const PairPoints& p) {
  const Vector3 u = p.col(2) - p.col(1);
  const Vector3 v = p.col(3) - p.col(1);
  const Vector3 r = p.col(0) - p.col(1);
  const Vector3 normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (squared > 0.0) {
    const double b = normal.dot(r.cross(v)) / squared;
    const double c = normal.dot(u.cross(r)) / squared;
    const double a = 1.0 - b - c;
    if (a > 0.0 && b > 0.0 && c > 0.0) {
      PairDistance result;
      result.weights << 1.0, -a, -b, -c;
      result.difference = (normal.dot(r) / squared) * normal;
      result.squared = result.difference.squaredNorm();
      return result;
    }
  }
  PairDistance best = distance_to_edge(p, 0, 1, 2, 1.0);
  take_smaller(best, distance_to_edge(p, 0, 2, 3, 1.0));
  take_smaller(best, distance_to_edge(p, 0, 3, 1, 1.0));
  return best;
}

PairDistance edge_edge(const PairPoints& p) {
  const Vector3 a = p.col(1) - p.col(0);
  const Vector3 b = p.col(3) - p.col(2);
  const Vector3 r = p.col(2) - p.col(0);
  const Vector3 normal = a.cross(b);
  const double squared = normal.squaredNorm();
  PairDistance best = distance_to_edge(p, 0, 2, 3, 1.0);
  take_smaller(best, distance_to_edge(p, 1, 2, 3, 1.0));
  take_smaller(best, distance_to_edge(p, 2, 0, 1, -1.0));
  take_smaller(best, distance_to_edge(p, 3, 0, 1, -1.0));
  const double aa = a.squaredNorm();
  const double bb = b.squaredNorm();
  if (squared <= kParallelEdges * aa * bb) return best;
  // Each parameter once more from the other one, which is more exact.
  const double first = r.cross(b).dot(normal) / squared;
  const double t = (first * a - r).dot(b) / bb;
  const double s = (r + t * b).dot(a) / aa;
  if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
    PairDistance inside;
    inside.weights << 1.0 - s, s, -(1.0 - t), -t;
    inside.difference = s * a - r - t * b;
    inside.squared = inside.difference.squaredNorm();
    take_smaller(best, inside);
  }
  return best;
}

}  // namespace

int pair_size(PairKind kind) {
  switch (kind) {
    case PairKind::kPointPoint:
      return 2;
    case PairKind::kPointEdge:
      return 3;
    default:
      return 4;
  }
}

int first_side_size(PairKind kind) {
  return kind == PairKind::kEdgeEdge ? 2 : 1;
}

PairDistance pair_distance(PairKind kind, const PairPoints& points) {
  switch (kind) {
    case PairKind::kPointPoint:
      return distance_of_points(points, 0, 1);
    case PairKind::kPointEdge:
      return distance_to_edge(points, 0, 1, 2, 1.0);
    case PairKind::kPointTriangle:
      return point_triangle(points);
    default:
      return edge_edge(points);
  }
}

PairVector squared_distance_gradient(const PairDistance& distance) {
  PairVector gradient;
  for (int i = 0; i < 4; ++i) {
    gradient.segment<3>(3 * i) = 2.0 * distance.weights[i] * distance.difference;
  }
  return gradient;
}

PairMatrix squared_distance_hessian(PairKind kind, const PairPoints& points,
                                    const PairDistance& distance) {
  const PairWeights& w = distance.weights;
  PairMatrix hessian;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      hessian.block<3, 3>(3 * i, 3 * j) = (2.0 * w[i] * w[j]) * Matrix3::Identity();
    }
  }
  // The tangents of both features: from the first point of each to its other ones.
  std::array<PairWeights, 2> rates;
  std::array<Vector3, 2> tangents;
  std::size_t count = 0;
  const auto add_side = [&](int begin, int end, double sign) {
    int origin = -1;
    for (int i = begin; i < end; ++i) {
      if (w[i] == 0.0) continue;
      if (origin < 0) {
        origin = i;
        continue;
      }
      rates[count].setZero();
      rates[count][origin] = -sign;
      rates[count][i] = sign;
      tangents[count] = sign * (points.col(i) - points.col(origin));
      ++count;
    }
  };
  const int first = first_side_size(kind);
  add_side(0, first, 1.0);
  add_side(first, pair_size(kind), -1.0);
  // ∂(v·e)/∂p = T v + e w for each, made orthogonal as the tangents are.
  const auto mixed = [&](std::size_t k) {
    PairVector m;
    for (int i = 0; i < 4; ++i) {
      m.segment<3>(3 * i) = rates[k][i] * distance.difference + w[i] * tangents[k];
    }
    return m;
  };
  if (count == 0) return hessian;
  const double length = tangents[0].squaredNorm();
  const PairVector m0 = mixed(0);
  if (length > 0.0) hessian.noalias() -= (2.0 / length) * m0 * m0.transpose();
  if (count == 1) return hessian;
  if (tangents[0].cross(tangents[1]).squaredNorm() <=
      kDependentTangents * length * tangents[1].squaredNorm()) {
    return hessian;
  }
  const double share = tangents[0].dot(tangents[1]) / length;
  const Vector3 second = tangents[1] - share * tangents[0];
  const PairVector m1 = mixed(1) - share * m0;
  hessian.noalias() -= (2.0 / second.squaredNorm()) * m1 * m1.transpose();
  return hessian;
}

}  // namespace tetraction
