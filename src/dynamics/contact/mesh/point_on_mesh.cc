#include "point_on_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/contact/pairs/squared_barrier.h"

namespace tetraction {
namespace {

void sort_once(std::vector<Index>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

void PointOnMesh::collect_features(std::span<const Index> triangles) {
  edges_.clear();
  vertices_.clear();
  for (const Index t : triangles) {
    for (const Index edge : mesh_.triangle_edges()[static_cast<std::size_t>(t)]) {
      if (mesh_.coefficient(mesh_.first_edge() + edge) != 0.0) edges_.push_back(edge);
    }
    for (const Index i : mesh_.triangles()[static_cast<std::size_t>(t)]) {
      const Index feature = mesh_.first_vertex() + i;
      if (mesh_.coefficient(feature) != 0.0) vertices_.push_back(feature);
    }
  }
  sort_once(edges_);
  sort_once(vertices_);
}

// The closest features with the sums of their coefficients, in ascending order, without zeros.
void PointOnMesh::find_shares(std::span<const Index> triangles, const Vector3& x) {
  shares_.clear();
  for (const Index t : triangles) shares_.push_back({mesh_.closest_feature_of_triangle(t, x), 1.0});
  for (const Index e : edges_) {
    shares_.push_back(
        {mesh_.closest_feature_of_edge(e, x), mesh_.coefficient(mesh_.first_edge() + e)});
  }
  for (const Index v : vertices_) shares_.push_back({v, mesh_.coefficient(v)});
  std::sort(shares_.begin(), shares_.end(),
            [](const Share& a, const Share& b) { return a.feature < b.feature; });
  std::size_t count = 0;
  for (std::size_t k = 0; k < shares_.size();) {
    Share sum = shares_[k++];
    // Whole numbers, so that the order does not matter.
    while (k < shares_.size() && shares_[k].feature == sum.feature) {
      sum.coefficient += shares_[k++].coefficient;
    }
    if (sum.coefficient != 0.0) shares_[count++] = sum;
  }
  shares_.resize(count);
}

double PointOnMesh::distance(std::span<const Index> triangles, const Vector3& x) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Index t : triangles) {
    smallest =
        std::min(smallest, mesh_.offset(mesh_.closest_feature_of_triangle(t, x), x).squaredNorm());
  }
  return std::sqrt(smallest);
}

void PointOnMesh::find_shares_at(std::span<const Index> triangles, const Vector3& x) {
  collect_features(triangles);
  find_shares(triangles, x);
}

double PointOnMesh::energy(std::span<const Index> triangles, const Vector3& x) {
  find_shares_at(triangles, x);
  double sum = 0.0;
  for (const Share& share : shares_) {
    const double d = mesh_.offset(share.feature, x).norm();
    if (!(d > 0.0)) return std::numeric_limits<double>::infinity();
    sum += share.coefficient * barrier_.value(d);
  }
  return sum;
}

Vector3 PointOnMesh::gradient(std::span<const Index> triangles, const Vector3& x) {
  find_shares_at(triangles, x);
  Vector3 sum = Vector3::Zero();
  for (const Share& share : shares_) {
    const Vector3 m = mesh_.offset(share.feature, x);
    const double d = m.norm();
    if (d < barrier_.thickness) sum += (share.coefficient * barrier_.slope(d) / d) * m;
  }
  return sum;
}

Matrix3 PointOnMesh::hessian(std::span<const Index> triangles, const Vector3& x) {
  find_shares_at(triangles, x);
  Matrix3 sum = Matrix3::Zero();
  for (const Share& share : shares_) {
    const Vector3 m = mesh_.offset(share.feature, x);
    const double d = m.norm();
    if (d >= barrier_.thickness) continue;
    const double turn = barrier_.slope(d) / d;
    sum += share.coefficient * turn * mesh_.projector(share.feature);
    sum += (share.coefficient * (barrier_.curvature(d) - turn) / (d * d)) * (m * m.transpose());
  }
  return sum;
}

void PointOnMesh::forces(std::span<const Index> triangles, const Vector3& x,
                         std::vector<FeatureForce>& forces) {
  find_shares_at(triangles, x);
  for (const Share& share : shares_) {
    const Vector3 m = mesh_.offset(share.feature, x);
    const double d = m.norm();
    if (d >= barrier_.thickness) continue;
    forces.push_back({share.feature, m / d, -share.coefficient * barrier_.slope(d),
                      share.coefficient * barrier_.curvature(d)});
  }
}

// Calls function(first crossing or null, second crossing or null, share, m at the start, m at the end) for each
// part of the way and each share whose distance is below the thickness at one end at least.
template <class Function>
void PointOnMesh::for_each_part(std::span<const Index> triangles, const Vector3& from,
                                const Vector3& to, const Function& function) {
  const Vector3 move = to - from;
  collect_features(triangles);
  crossings_.clear();
  crossings_.push_back({0.0, Vector3::Zero()});
  for (const Index t : triangles) mesh_.add_crossings(t, from, move, crossings_);
  for (const Index e : edges_) mesh_.add_edge_crossings(e, from, move, crossings_);
  std::stable_sort(crossings_.begin(), crossings_.end(),
                   [](const auto& a, const auto& b) { return a.t < b.t; });
  crossings_.push_back({1.0, Vector3::Zero()});
  for (std::size_t k = 0; k + 1 < crossings_.size(); ++k) {
    const auto& a = crossings_[k];
    const auto& b = crossings_[k + 1];
    if (!(b.t > a.t)) continue;
    find_shares(triangles, from + 0.5 * (a.t + b.t) * move);
    const Vector3 start = from + a.t * move;
    const Vector3 end = b.t == 1.0 ? to : Vector3(from + b.t * move);
    for (const Share& share : shares_) {
      const Vector3 ma = mesh_.offset(share.feature, start);
      const Vector3 mb = mesh_.offset(share.feature, end);
      if (ma.norm() >= barrier_.thickness && mb.norm() >= barrier_.thickness) continue;
      function(a, b, share, ma, mb);
    }
  }
}

Vector3 PointOnMesh::mean_gradient(std::span<const Index> triangles, const Vector3& from,
                                   const Vector3& to) {
  Vector3 sum = Vector3::Zero();
  for_each_part(
      triangles, from, to,
      [&](const auto& a, const auto& b, const Share& share, const Vector3& ma, const Vector3& mb) {
        const double s = mean_slope_of_square(barrier_, ma.norm(), mb.norm());
        sum += ((b.t - a.t) * share.coefficient * s) * (ma + mb);
      });
  return sum;
}

Matrix3 PointOnMesh::mean_hessian(std::span<const Index> triangles, const Vector3& from,
                                  const Vector3& to) {
  const Vector3 move = to - from;
  Matrix3 sum = Matrix3::Zero();
  for_each_part(
      triangles, from, to,
      [&](const auto& a, const auto& b, const Share& share, const Vector3& ma, const Vector3& mb) {
        const double da = ma.norm();
        const double db = mb.norm();
        const double s = mean_slope_of_square(barrier_, da, db);
        const Vector3 m = ma + mb;
        const Matrix3 direct = s * mesh_.projector(share.feature);
        const Matrix3 by_start =
            direct + (2.0 * mean_slope_rate_of_square(barrier_, db, da)) * m * ma.transpose();
        const Matrix3 by_end =
            direct + (2.0 * mean_slope_rate_of_square(barrier_, da, db)) * m * mb.transpose();
        // The ends of the part move with `to`, and with the crossings.
        const Matrix3 one = Matrix3::Identity();
        const Matrix3 start = a.t * one + move * a.rate.transpose();
        const Matrix3 end = b.t * one + move * b.rate.transpose();
        sum += share.coefficient * ((b.t - a.t) * (by_start * start + by_end * end) +
                                    s * m * (b.rate - a.rate).transpose());
      });
  return 0.5 * (sum + sum.transpose());
}

void PointOnMesh::mean_forces(std::span<const Index> triangles, const Vector3& from,
                              const Vector3& to, std::vector<FeatureForce>& forces) {
  for_each_part(
      triangles, from, to,
      [&](const auto& a, const auto& b, const Share& share, const Vector3& ma, const Vector3& mb) {
        const double da = ma.norm();
        const double db = mb.norm();
        const Vector3 m = ma + mb;
        const double length = m.norm();
        if (!(length > 0.0)) return;
        const double part = (b.t - a.t) * share.coefficient;
        forces.push_back({share.feature, m / length,
                          -part * mean_slope_of_square(barrier_, da, db) * length,
                          part * barrier_.mean_slope_rate(da, db)});
      });
}

}  // namespace tetraction
