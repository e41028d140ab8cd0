// Where a surface touches a rigid mesh on its way.
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/contact/pairs/additive_ccd.h"
#include "dynamics/contact/pairs/edge_crossing.h"
#include "dynamics/contact/pairs/surface_loops.h"
#include "dynamics/contact/pairs/way_clearing.h"
#include "mesh_contact.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kMotionGrain = 64;

std::size_t item(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

Index MeshContact::find_penetrating_vertex(const Vector& x) const {
  const Index count = x.size() / 3;
  Index first = count;
  const auto& points = mesh_.points();
  const auto pierces = [&](std::span<const Index> vertices) {
    for (const Index i : vertices) first = std::min(first, i);
  };
  // Features that touch.
  const MeshCandidates near = find_candidates(mesh_, surface_, x, x, 0.0, MeshFeatures::kAll);
  const PointOnMesh point(mesh_, barrier_);
  for (std::size_t k = 0; k < near.vertices.size(); ++k) {
    const Index i = near.vertices[k];
    if (!(point.distance(near.triangles_of(k), vertex_block(x, i)) > 0.0)) pierces({&i, 1});
  }
  for (const auto& [i, t] : near.vertex_faces) {
    const MovingPair moving = vertex_face(i, t);
    if (!(moving.distance(x) > 0.0)) pierces(moving.own());
  }
  for (const auto& [e, other] : near.edge_edges) {
    const MovingPair moving = edge_edge(e, other);
    if (!(moving.distance(x) > 0.0)) pierces(moving.own());
  }
  // Edges that cross triangles.
  const auto smallest_of = [&](Index items, const auto& vertex_of) {
    first = std::min(first, smallest_over_items(items, count, vertex_of));
  };
  smallest_of(static_cast<Index>(surface_.edges.size()), [&](Index e, std::vector<Index>& found) {
    const auto& [i, j] = surface_.edges[item(e)];
    mesh_.triangle_tree().query(box_of_ways(surface_.edges[item(e)], x, x).widened(0.0), found);
    for (const Index t : found) {
      const auto& corner = mesh_.triangles()[item(t)];
      if (edge_crosses_triangle(vertex_block(x, i), vertex_block(x, j), points[item(corner[0])],
                                points[item(corner[1])], points[item(corner[2])])) {
        return std::min(i, j);
      }
    }
    return count;
  });
  smallest_of(
      static_cast<Index>(surface_.triangles.size()), [&](Index t, std::vector<Index>& found) {
        const auto& corner = surface_.triangles[item(t)];
        mesh_.edge_tree().query(box_of_ways(corner, x, x).widened(0.0), found);
        for (const Index e : found) {
          const auto& [i, j] = mesh_.edges()[item(e)];
          if (edge_crosses_triangle(points[item(i)], points[item(j)], vertex_block(x, corner[0]),
                                    vertex_block(x, corner[1]), vertex_block(x, corner[2]))) {
            return std::min({corner[0], corner[1], corner[2]});
          }
        }
        return count;
      });
  return first == count ? -1 : first;
}

// first_touch() of all pairs on the way from x to x + d: vertices of the surface with each of their triangles,
// vertices of the mesh, and edges.
std::vector<double> MeshContact::free_parts(const MeshCandidates& near, const Vector& x,
                                            const Vector& d) const {
  const std::size_t singles = near.triangles.size();
  const std::size_t faces = near.vertex_faces.size();
  std::vector<Index> vertex_of(singles);
  for (std::size_t k = 0; k < near.vertices.size(); ++k) {
    for (std::size_t m = near.starts[k]; m < near.starts[k + 1]; ++m) {
      vertex_of[m] = near.vertices[k];
    }
  }
  std::vector<double> parts(singles + faces + near.edge_edges.size());
  const double cap = barrier_.thickness;
  parallel_for(static_cast<Index>(parts.size()), kMotionGrain, [&](Index begin, Index end) {
    for (std::size_t k = item(begin); k < item(end); ++k) {
      if (k < singles) {
        PairPoints p;
        PairPoints m = PairPoints::Zero();
        p.col(0) = vertex_block(x, vertex_of[k]);
        m.col(0) = vertex_block(d, vertex_of[k]);
        const auto& corners = mesh_.triangles()[item(near.triangles[k])];
        for (int c = 0; c < 3; ++c) {
          p.col(c + 1) = mesh_.points()[item(corners[static_cast<std::size_t>(c)])];
        }
        parts[k] = first_touch(PairKind::kPointTriangle, p, m, cap);
        continue;
      }
      const std::size_t rest = k - singles;
      const MovingPair moving =
          rest < faces
              ? vertex_face(near.vertex_faces[rest][0], near.vertex_faces[rest][1])
              : edge_edge(near.edge_edges[rest - faces][0], near.edge_edges[rest - faces][1]);
      parts[k] = first_touch(moving.pair.kind, moving.points(x), moving.moves(d), cap);
    }
  });
  return parts;
}

double MeshContact::longest_step(const Vector& x, const Vector& d) const {
  if (!x.allFinite() || !d.allFinite()) return 0.0;
  const MeshCandidates near =
      find_candidates(mesh_, surface_, x, x + d, 0.1 * barrier_.thickness, MeshFeatures::kAll);
  double longest = 1.0;
  for (const double part : free_parts(near, x, d)) longest = std::min(longest, part);
  return longest;
}

void MeshContact::clear_way(const Vector& from, Vector& x) const {
  WayClearing clearing(from, x);
  bool vertices_only = true;
  for (int round = 0; round < WayClearing::kRounds; ++round) {
    MeshCandidates near =
        find_candidates(mesh_, surface_, from, x, 0.1 * barrier_.thickness, MeshFeatures::kAll);
    // At first each vertex by itself, which often clears the way of faces and edges, too.
    if (vertices_only) {
      near.vertex_faces.clear();
      near.edge_edges.clear();
    }
    const std::vector<double> free = free_parts(near, from, x - from);
    clearing.begin_round();
    std::size_t k = 0;
    for (std::size_t v = 0; v < near.vertices.size(); ++v) {
      for (std::size_t m = near.starts[v]; m < near.starts[v + 1]; ++m) {
        clearing.limit({&near.vertices[v], 1}, free[k++]);
      }
    }
    for (const auto& pair : near.vertex_faces) {
      clearing.limit(surface_.triangles[item(pair[1])], free[k++]);
    }
    for (const auto& pair : near.edge_edges) {
      clearing.limit(surface_.edges[item(pair[0])], free[k++]);
    }
    const bool clear = clearing.is_clear();
    if (clear && !vertices_only) return;
    vertices_only = vertices_only && !clear;
    if (!clear) clearing.shorten();
  }
  // `from` is clear, so that a common part of what is left is.
  const Vector d = x - from;
  x = from + (WayClearing::kKept * longest_step(from, d)) * d;
}

// A surface of triangles may support in all directions; in its layer it supports in those of its forces.
void MeshContact::add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const {
  const double stiffness = barrier_.stiffness / barrier_.thickness;
  if (std::isfinite(reach)) {
    Vector gradient = Vector::Zero(x.size());
    if (penetrating_vertex(x) < 0) add_gradient(x, gradient);
    for (Index v = 0; 3 * v < x.size(); ++v) {
      const Vector3 n = vertex_block(gradient, v).stableNormalized();
      blocks.add(v, surface_.areas[static_cast<std::size_t>(v)] * stiffness * n * n.transpose());
    }
    return;
  }
  for (Index v = 0; 3 * v < x.size(); ++v) {
    blocks.add(v, surface_.areas[static_cast<std::size_t>(v)] * stiffness * Matrix3::Identity());
  }
}

}  // namespace tetraction
