#include "mesh_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "dynamics/contact/pairs/surface_loops.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction {
namespace {

// Pairs that only keep sharp features apart have this part of the area of a vertex.
constexpr double kSmallShare = 0.05;
constexpr Index kPairGrain = 64;

std::size_t slot(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

MeshContact::MeshContact(TriangleMesh mesh, ContactSurface surface, const Barrier& barrier)
    : mesh_(std::move(mesh)), surface_(std::move(surface)), barrier_(barrier) {
  const double total = std::accumulate(surface_.areas.begin(), surface_.areas.end(), 0.0);
  mean_area_ = total / static_cast<double>(std::max<std::size_t>(1, surface_.areas.size()));
}

MovingPair MeshContact::vertex_face(Index vertex, Index triangle) const {
  MovingPair moving;
  moving.pair.kind = PairKind::kPointTriangle;
  moving.count = 3;
  moving.first = 1;
  moving.partner = vertex;
  std::ranges::copy(surface_.triangles[slot(triangle)], moving.vertices.begin());
  moving.at_rest.col(0) = mesh_.points()[slot(vertex)];
  double area = 0.0;
  for (const Index i : moving.own()) area += surface_.areas[slot(i)] / 3.0;
  moving.pair.weight = kSmallShare * (area > 0.0 ? area : mean_area_);
  return moving;
}

MovingPair MeshContact::edge_edge(Index edge, Index other) const {
  MovingPair moving;
  moving.pair.kind = PairKind::kEdgeEdge;
  moving.count = 2;
  moving.first = 0;
  moving.partner = other;
  const auto& [i, j] = surface_.edges[slot(edge)];
  const auto& [k, l] = mesh_.edges()[slot(other)];
  moving.vertices = {i, j};
  moving.at_rest.col(2) = mesh_.points()[slot(k)];
  moving.at_rest.col(3) = mesh_.points()[slot(l)];
  const double area = 0.5 * (surface_.areas[slot(i)] + surface_.areas[slot(j)]);
  moving.pair.weight = kSmallShare * (area > 0.0 ? area : mean_area_);
  moving.pair.parallel =
      parallel_limit(vertex_block(surface_.rest, j) - vertex_block(surface_.rest, i),
                     moving.at_rest.col(3) - moving.at_rest.col(2));
  return moving;
}

void MeshContact::prepare(Way& way, const Vector& from, const Vector& to) const {
  way.from = from;
  way.to = to;
  way.checked = false;
  way.penetrating = -1;
  way.near = find_candidates(mesh_, surface_, from, to, barrier_.thickness, MeshFeatures::kSharp);
  const auto& faces = way.near.vertex_faces;
  const auto& edges = way.near.edge_edges;
  way.pairs =
      pairs_within(barrier_.thickness, from, to, faces.size() + edges.size(), [&](std::size_t k) {
        if (k < faces.size()) return vertex_face(faces[k][0], faces[k][1]);
        const auto& [e, other] = edges[k - faces.size()];
        return edge_edge(e, other);
      });
}

const MeshContact::Way& MeshContact::state(const Vector& x) const {
  if (!same_numbers(state_.from, x)) prepare(state_, x, x);
  return state_;
}

const MeshContact::Way& MeshContact::way(const Vector& from, const Vector& to) const {
  if (!same_numbers(way_.from, from) || !same_numbers(way_.to, to)) prepare(way_, from, to);
  return way_;
}

Index MeshContact::penetrating_vertex(const Vector& x) const {
  for (Index i = 0; i < x.size() / 3; ++i) {
    if (!vertex_block(x, i).allFinite()) return i;
  }
  state(x);
  if (!state_.checked) {
    state_.penetrating = find_penetrating_vertex(x);
    state_.checked = true;
  }
  return state_.penetrating;
}

double MeshContact::energy(const Vector& x) const {
  if (penetrating_vertex(x) >= 0) return std::numeric_limits<double>::infinity();
  const Way& now = state(x);
  const double vertices =
      parallel_sum(static_cast<Index>(now.near.vertices.size()), [&](Index begin, Index end) {
        PointOnMesh point(mesh_, barrier_);
        double sum = 0.0;
        for (Index k = begin; k < end; ++k) {
          const Index i = now.near.vertices[slot(k)];
          sum += surface_.areas[slot(i)] *
                 point.with(layer(i)).energy(now.near.triangles_of(slot(k)), vertex_block(x, i));
        }
        return sum;
      });
  return vertices + energy_of(now.pairs, barrier_, x);
}

// Adds the area of each vertex i near the mesh times slope(triangles near it, i, point).
template <class Slope>
void MeshContact::add_vertex_gradients(const Way& way, const Slope& slope, Vector& gradient) const {
  parallel_for(static_cast<Index>(way.near.vertices.size()), kPairGrain,
               [&](Index begin, Index end) {
                 PointOnMesh point(mesh_, barrier_);
                 for (Index k = begin; k < end; ++k) {
                   const Index i = way.near.vertices[slot(k)];
                   vertex_block(gradient, i) +=
                       surface_.areas[slot(i)] *
                       slope(way.near.triangles_of(slot(k)), i, point.with(layer(i)));
                 }
               });
}

void MeshContact::add_gradient(const Vector& x, Vector& gradient) const {
  const Way& now = state(x);
  add_vertex_gradients(
      now,
      [&](std::span<const Index> triangles, Index i, PointOnMesh& point) {
        return point.gradient(triangles, vertex_block(x, i));
      },
      gradient);
  add_gradient_of(now.pairs, barrier_, x, gradient);
}

void MeshContact::add_discrete_gradient(const Vector& from, const Vector& to,
                                        Vector& gradient) const {
  const Way& now = way(from, to);
  add_vertex_gradients(
      now,
      [&](std::span<const Index> triangles, Index i, PointOnMesh& point) {
        return point.mean_gradient(triangles, vertex_block(from, i), vertex_block(to, i));
      },
      gradient);
  add_mean_gradient_of(now.pairs, barrier_, from, to, gradient);
}

// Adds the area of each vertex i near the mesh times hessian(triangles near it, i, point), with `convex` each made semidefinite.
template <class Hessian>
void MeshContact::add_vertex_blocks(const Way& way, bool convex, const Hessian& hessian,
                                    SurfaceBlocks& blocks) const {
  std::vector<Matrix3> own(way.near.vertices.size());
  parallel_for(static_cast<Index>(own.size()), kPairGrain, [&](Index begin, Index end) {
    PointOnMesh point(mesh_, barrier_);
    for (Index k = begin; k < end; ++k) {
      const Index i = way.near.vertices[slot(k)];
      own[slot(k)] = surface_.areas[slot(i)] *
                     hessian(way.near.triangles_of(slot(k)), i, point.with(layer(i)));
    }
  });
  for (std::size_t k = 0; k < own.size(); ++k) {
    blocks.add(way.near.vertices[k], convex ? positive_semidefinite_part(own[k]) : own[k]);
  }
}

void MeshContact::add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const {
  const Way& now = state(x);
  add_vertex_blocks(
      now, convex,
      [&](std::span<const Index> triangles, Index i, PointOnMesh& point) {
        return point.hessian(triangles, vertex_block(x, i));
      },
      blocks);
  add_hessian_of(now.pairs, barrier_, x, convex, blocks);
}

void MeshContact::add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                       SurfaceBlocks& blocks) const {
  const Way& now = way(from, to);
  add_vertex_blocks(
      now, convex,
      [&](std::span<const Index> triangles, Index i, PointOnMesh& point) {
        return point.mean_hessian(triangles, vertex_block(from, i), vertex_block(to, i));
      },
      blocks);
  add_mean_hessian_of(now.pairs, barrier_, from, to, convex, blocks);
}

double MeshContact::smallest_gap(const Vector& x) const {
  const Way& now = state(x);
  Vector gaps;
  vertex_gaps(x, gaps);
  double smallest = gaps.size() > 0 ? gaps.minCoeff() : std::numeric_limits<double>::infinity();
  for (const MovingPair& moving : now.pairs) smallest = std::min(smallest, moving.distance(x));
  return smallest;
}

void MeshContact::vertex_gaps(const Vector& x, Vector& gaps) const {
  const Way& now = state(x);
  gaps.setConstant(x.size() / 3, std::numeric_limits<double>::infinity());
  parallel_for(
      static_cast<Index>(now.near.vertices.size()), kPairGrain, [&](Index begin, Index end) {
        const PointOnMesh point(mesh_, barrier_);
        for (Index k = begin; k < end; ++k) {
          const Index i = now.near.vertices[slot(k)];
          const double d = point.distance(now.near.triangles_of(slot(k)), vertex_block(x, i));
          if (d < barrier_.thickness) gaps[i] = d;
        }
      });
}

void MeshContact::approaching(const Vector& x, const Vector& v, double reach,
                              std::vector<Approach>& found) const {
  const MeshCandidates near = find_candidates(mesh_, surface_, x, x, reach, MeshFeatures::kSharp);
  const auto add = [&](Index i, double weight, const PairDistance& distance, double own = 1.0) {
    const double d = std::sqrt(distance.squared);
    if (d > reach) return;
    const double closing = -distance.difference.dot(vertex_block(v, i));
    found.push_back({i, weight, d, d > 0.0 ? closing / d : 0.0, own});
  };
  PairPoints points = PairPoints::Zero();
  for (std::size_t k = 0; k < near.vertices.size(); ++k) {
    const Index i = near.vertices[k];
    points.col(0) = vertex_block(x, i);
    for (const Index t : near.triangles_of(k)) {
      for (Index c = 0; c < 3; ++c) {
        points.col(c + 1) = mesh_.points()[slot(mesh_.triangles()[slot(t)][slot(c)])];
      }
      add(i, surface_.areas[slot(i)], pair_distance(PairKind::kPointTriangle, points),
          surface_.reach(i));
    }
  }
  const auto add_moving = [&](const MovingPair& moving) {
    PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
    // The difference goes from the second side to the first one.
    if (moving.first > 0) distance.difference = -distance.difference;
    for (const Index i : moving.own()) add(i, moving.pair.weight, distance);
  };
  for (const auto& [vertex, triangle] : near.vertex_faces)
    add_moving(vertex_face(vertex, triangle));
  for (const auto& [edge, other] : near.edge_edges) add_moving(edge_edge(edge, other));
}

}  // namespace tetraction
