#include "mesh_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/decompositions.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Pairs that only keep sharp features apart have this part of the area of a vertex.
constexpr double kSmallShare = 0.05;
constexpr Index kPairGrain = 64;

std::size_t slot(Index i) {
  return static_cast<std::size_t>(i);
}

bool same_numbers(const Vector& a, const Vector& b) {
  return a.size() == b.size() && (a.array() == b.array()).all();
}

}  // namespace

MeshContact::MeshContact(TriangleMesh mesh, ContactSurface surface, const Barrier& barrier)
    : mesh_(std::move(mesh)), surface_(std::move(surface)), barrier_(barrier) {
  const double total = std::accumulate(surface_.areas.begin(), surface_.areas.end(), 0.0);
  mean_area_ = total / static_cast<double>(std::max<std::size_t>(1, surface_.areas.size()));
}

PairPoints MeshContact::MovingPair::points(const Vector& x) const {
  PairPoints p = rest_of_it;
  for (int k = 0; k < count; ++k) {
    p.col(first + k) = vertex_block(x, vertices[static_cast<std::size_t>(k)]);
  }
  return p;
}

MeshContact::MovingPair MeshContact::vertex_face(Index vertex, Index triangle) const {
  MovingPair moving;
  moving.pair.kind = PairKind::kPointTriangle;
  moving.count = 3;
  moving.first = 1;
  moving.mesh_item = vertex;
  moving.vertices = surface_.triangles[slot(triangle)];
  moving.rest_of_it.col(0) = mesh_.points()[slot(vertex)];
  double area = 0.0;
  for (const Index i : moving.vertices) area += surface_.areas[slot(i)] / 3.0;
  moving.pair.weight = kSmallShare * (area > 0.0 ? area : mean_area_);
  return moving;
}

MeshContact::MovingPair MeshContact::edge_edge(Index edge, Index other) const {
  MovingPair moving;
  moving.pair.kind = PairKind::kEdgeEdge;
  moving.count = 2;
  moving.first = 0;
  moving.mesh_item = other;
  const auto& [i, j] = surface_.edges[slot(edge)];
  const auto& [k, l] = mesh_.edges()[slot(other)];
  moving.vertices = {i, j, 0};
  moving.rest_of_it.col(2) = mesh_.points()[slot(k)];
  moving.rest_of_it.col(3) = mesh_.points()[slot(l)];
  const double area = 0.5 * (surface_.areas[slot(i)] + surface_.areas[slot(j)]);
  moving.pair.weight = kSmallShare * (area > 0.0 ? area : mean_area_);
  moving.pair.parallel =
      parallel_limit(vertex_block(surface_.rest, j) - vertex_block(surface_.rest, i),
                     moving.rest_of_it.col(3) - moving.rest_of_it.col(2));
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
  std::vector<MovingPair> pairs(faces.size() + edges.size());
  std::vector<char> close(pairs.size());
  parallel_for(static_cast<Index>(pairs.size()), kPairGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      MovingPair& moving = pairs[slot(k)];
      if (slot(k) < faces.size()) {
        moving = vertex_face(faces[slot(k)][0], faces[slot(k)][1]);
      } else {
        const auto& [e, other] = edges[slot(k) - faces.size()];
        moving = edge_edge(e, other);
      }
      const double limit = barrier_.thickness * barrier_.thickness;
      close[slot(k)] = pair_distance(moving.pair.kind, moving.points(from)).squared < limit ||
                       pair_distance(moving.pair.kind, moving.points(to)).squared < limit;
    }
  });
  way.pairs.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (close[k] != 0) way.pairs.push_back(pairs[k]);
  }
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
                 point.energy(now.near.triangles_of(slot(k)), vertex_block(x, i));
        }
        return sum;
      });
  return vertices + parallel_sum(static_cast<Index>(now.pairs.size()), [&](Index begin, Index end) {
           double sum = 0.0;
           for (Index k = begin; k < end; ++k) {
             const MovingPair& moving = now.pairs[slot(k)];
             sum += pair_energy(barrier_, moving.pair, moving.points(x));
           }
           return sum;
         });
}

void MeshContact::add_gradient(const Vector& x, Vector& gradient) const {
  const Way& now = state(x);
  parallel_for(static_cast<Index>(now.near.vertices.size()), kPairGrain,
               [&](Index begin, Index end) {
                 PointOnMesh point(mesh_, barrier_);
                 for (Index k = begin; k < end; ++k) {
                   const Index i = now.near.vertices[slot(k)];
                   vertex_block(gradient, i) +=
                       surface_.areas[slot(i)] *
                       point.gradient(now.near.triangles_of(slot(k)), vertex_block(x, i));
                 }
               });
  std::vector<PairVector> parts(now.pairs.size());
  parallel_for(static_cast<Index>(parts.size()), kPairGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const MovingPair& moving = now.pairs[slot(k)];
      parts[slot(k)] = pair_gradient(barrier_, moving.pair, moving.points(x));
    }
  });
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const MovingPair& moving = now.pairs[k];
    for (int a = 0; a < moving.count; ++a) {
      vertex_block(gradient, moving.vertices[static_cast<std::size_t>(a)]) +=
          parts[k].segment<3>(3 * (moving.first + a));
    }
  }
}

void MeshContact::add_discrete_gradient(const Vector& from, const Vector& to,
                                        Vector& gradient) const {
  const Way& now = way(from, to);
  parallel_for(static_cast<Index>(now.near.vertices.size()), kPairGrain,
               [&](Index begin, Index end) {
                 PointOnMesh point(mesh_, barrier_);
                 for (Index k = begin; k < end; ++k) {
                   const Index i = now.near.vertices[slot(k)];
                   vertex_block(gradient, i) +=
                       surface_.areas[slot(i)] * point.mean_gradient(now.near.triangles_of(slot(k)),
                                                                     vertex_block(from, i),
                                                                     vertex_block(to, i));
                 }
               });
  std::vector<PairVector> parts(now.pairs.size());
  parallel_for(static_cast<Index>(parts.size()), kPairGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const MovingPair& moving = now.pairs[slot(k)];
      parts[slot(k)] =
          mean_pair(barrier_, moving.pair, moving.points(from), moving.points(to)).gradient;
    }
  });
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const MovingPair& moving = now.pairs[k];
    for (int a = 0; a < moving.count; ++a) {
      vertex_block(gradient, moving.vertices[static_cast<std::size_t>(a)]) +=
          parts[k].segment<3>(3 * (moving.first + a));
    }
  }
}

// Adds the blocks of vertices and pairs; with `convex` each of them made semidefinite.
void MeshContact::add_blocks(const Way& way, bool convex, const std::vector<Matrix3>& own,
                             std::vector<PairMatrix>& coupled, SurfaceBlocks& blocks) const {
  if (convex) {
    parallel_for(static_cast<Index>(coupled.size()), kPairGrain, [&](Index begin, Index end) {
      for (Index k = begin; k < end; ++k) {
        const MovingPair& moving = way.pairs[slot(k)];
        const int first = 3 * moving.first;
        const int size = 3 * moving.count;
        Matrix part = coupled[slot(k)].block(first, first, size, size);
        make_semidefinite(part);
        coupled[slot(k)].block(first, first, size, size) = part;
      }
    });
  }
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (!convex) {
      blocks.add(way.near.vertices[k], own[k]);
      continue;
    }
    const SymmetricEigen3 eigen = symmetric_eigen(own[k]);
    blocks.add(way.near.vertices[k],
               eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose());
  }
  for (std::size_t k = 0; k < coupled.size(); ++k) {
    const MovingPair& moving = way.pairs[k];
    for (int a = 0; a < moving.count; ++a) {
      for (int b = a; b < moving.count; ++b) {
        const Matrix3 block =
            coupled[k].block<3, 3>(3 * (moving.first + a), 3 * (moving.first + b));
        const Index i = moving.vertices[static_cast<std::size_t>(a)];
        const Index j = moving.vertices[static_cast<std::size_t>(b)];
        if (a == b) {
          blocks.add(i, block);
        } else {
          blocks.add_pair(i, j, block);
        }
      }
    }
  }
}

void MeshContact::add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const {
  const Way& now = state(x);
  std::vector<Matrix3> own(now.near.vertices.size());
  parallel_for(static_cast<Index>(own.size()), kPairGrain, [&](Index begin, Index end) {
    PointOnMesh point(mesh_, barrier_);
    for (Index k = begin; k < end; ++k) {
      const Index i = now.near.vertices[slot(k)];
      own[slot(k)] = surface_.areas[slot(i)] *
                     point.hessian(now.near.triangles_of(slot(k)), vertex_block(x, i));
    }
  });
  std::vector<PairMatrix> coupled(now.pairs.size());
  parallel_for(static_cast<Index>(coupled.size()), kPairGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const MovingPair& moving = now.pairs[slot(k)];
      coupled[slot(k)] = pair_hessian(barrier_, moving.pair, moving.points(x));
    }
  });
  add_blocks(now, convex, own, coupled, blocks);
}

void MeshContact::add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                       SurfaceBlocks& blocks) const {
  const Way& now = way(from, to);
  std::vector<Matrix3> own(now.near.vertices.size());
  parallel_for(static_cast<Index>(own.size()), kPairGrain, [&](Index begin, Index end) {
    PointOnMesh point(mesh_, barrier_);
    for (Index k = begin; k < end; ++k) {
      const Index i = now.near.vertices[slot(k)];
      own[slot(k)] =
          surface_.areas[slot(i)] * point.mean_hessian(now.near.triangles_of(slot(k)),
                                                       vertex_block(from, i), vertex_block(to, i));
    }
  });
  std::vector<PairMatrix> coupled(now.pairs.size());
  parallel_for(static_cast<Index>(coupled.size()), kPairGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const MovingPair& moving = now.pairs[slot(k)];
      coupled[slot(k)] =
          mean_pair_hessian(barrier_, moving.pair, moving.points(from), moving.points(to));
    }
  });
  add_blocks(now, convex, own, coupled, blocks);
}

double MeshContact::smallest_gap(const Vector& x) const {
  const Way& now = state(x);
  Vector gaps;
  vertex_gaps(x, gaps);
  double smallest = gaps.size() > 0 ? gaps.minCoeff() : std::numeric_limits<double>::infinity();
  for (const MovingPair& moving : now.pairs) {
    smallest =
        std::min(smallest, std::sqrt(pair_distance(moving.pair.kind, moving.points(x)).squared));
  }
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
  const auto add = [&](Index i, double weight, const PairDistance& distance) {
    const double d = std::sqrt(distance.squared);
    if (d > reach) return;
    const double closing = -distance.difference.dot(vertex_block(v, i));
    found.push_back({i, weight, d, d > 0.0 ? closing / d : 0.0});
  };
  PairPoints points = PairPoints::Zero();
  for (std::size_t k = 0; k < near.vertices.size(); ++k) {
    const Index i = near.vertices[k];
    points.col(0) = vertex_block(x, i);
    for (const Index t : near.triangles_of(k)) {
      for (Index c = 0; c < 3; ++c) {
        points.col(c + 1) = mesh_.points()[slot(mesh_.triangles()[slot(t)][slot(c)])];
      }
      add(i, surface_.areas[slot(i)], pair_distance(PairKind::kPointTriangle, points));
    }
  }
  const auto add_moving = [&](const MovingPair& moving) {
    PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
    // The difference goes from the second side to the first one.
    if (moving.first > 0) distance.difference = -distance.difference;
    for (int a = 0; a < moving.count; ++a) {
      add(moving.vertices[static_cast<std::size_t>(a)], moving.pair.weight, distance);
    }
  };
  for (const auto& [vertex, triangle] : near.vertex_faces)
    add_moving(vertex_face(vertex, triangle));
  for (const auto& [edge, other] : near.edge_edges) add_moving(edge_edge(edge, other));
}

}  // namespace tetraction
