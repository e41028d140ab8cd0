#include "self_contact.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/contact/pairs/surface_loops.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Pairs of edges have these parts of the area of a vertex: any, and two sharp ones.
constexpr double kEdgeShare = 0.01;
constexpr double kSharpEdgeShare = 0.5;
// The mollifier of sharp ones begins at sin² = 0.1 of the angle between them: where edges of such a share become parallel,
// the closest points move far in a step.
constexpr double kSharpParallel = 100.0;
// The cosine of the angle between the normals of two triangles from which on their edge is sharp.
constexpr double kSharp = 0.8;

std::size_t place(Index i) {
  return static_cast<std::size_t>(i);
}

// The vertices of the second side that are closest to the first one, as bits of the columns 1 to 3.
int closest_feature(const PairDistance& distance) {
  int bits = 0;
  for (int k = 1; k < 4; ++k) bits |= distance.weights[k] != 0.0 ? 1 << k : 0;
  return bits;
}

}  // namespace

SelfContact::SelfContact(ContactSurface surface, std::vector<Index> body_of, bool within_bodies,
                         const Barrier& barrier)
    : surface_(std::move(surface)),
      body_of_(std::move(body_of)),
      within_bodies_(within_bodies),
      barrier_(barrier) {
  const auto boxes = [&](const auto& items) {
    std::vector<Box> all(items.size());
    for (std::size_t k = 0; k < items.size(); ++k) {
      for (const Index i : items[k]) all[k].add(vertex_block(surface_.rest, i));
    }
    return all;
  };
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
    const auto& [a, b, c] = surface_.triangles[t];
    const auto face = static_cast<Index>(t);
    for (const Index i : {a, b, c}) {
      face_of_.push_back({{i, i}, face});
    }
    for (const auto& [i, j] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      face_of_.push_back({{std::min(i, j), std::max(i, j)}, face});
    }
  }
  std::sort(face_of_.begin(), face_of_.end());
  find_sharp_edges();
  triangles_ = BoxTree(boxes(surface_.triangles));
  edges_ = BoxTree(boxes(surface_.edges));
}

// An edge of a single triangle is no sharp one: it ends the part of the surface that may touch.
void SelfContact::find_sharp_edges() {
  const auto normal = [&](Index t) {
    const auto& [a, b, c] = surface_.triangles[place(t)];
    const Vector3 origin = vertex_block(surface_.rest, a);
    const Vector3 area = (vertex_block(surface_.rest, b) - origin)
                             .cross(Vector3(vertex_block(surface_.rest, c) - origin));
    return Vector3(area.normalized());
  };
  is_sharp_.assign(surface_.edges.size(), false);
  for (std::size_t e = 0; e < surface_.edges.size(); ++e) {
    const auto [first, last] = std::ranges::equal_range(
        face_of_, surface_.edges[e], {}, [](const auto& each) { return each.first; });
    if (last - first == 2) {
      is_sharp_[e] = normal(first->second).dot(normal((first + 1)->second)) < kSharp;
    }
  }
}

bool SelfContact::may_touch(Index a, Index b) const {
  return within_bodies_ || body_of_[place(a)] != body_of_[place(b)];
}

void SelfContact::refit(const Vector& from, const Vector& to) const {
  const auto boxes = [&](const auto& items) {
    std::vector<Box> all(items.size());
    parallel_for(static_cast<Index>(items.size()), kItemsOfPiece, [&](Index begin, Index end) {
      for (std::size_t k = place(begin); k < place(end); ++k) {
        all[k] = box_of_ways(items[k], from, to);
      }
    });
    return all;
  };
  triangles_.refit(boxes(surface_.triangles));
  edges_.refit(boxes(surface_.edges));
}

SelfContact::Near SelfContact::find_near(const Vector& from, const Vector& to, double reach) const {
  refit(from, to);
  const auto box_of = [&](std::span<const Index> corners) {
    return box_of_ways(corners, from, to).widened(reach);
  };
  Near near;
  near.vertex_faces = gather_pairs(from.size() / 3, [&](Index i, std::vector<Index>& found) {
    triangles_.query(box_of({&i, 1}), found);
    std::erase_if(found, [&](Index t) {
      const auto& corners = surface_.triangles[place(t)];
      return !may_touch(i, corners[0]) || std::ranges::count(corners, i) > 0;
    });
  });
  near.edge_edges = gather_pairs(
      static_cast<Index>(surface_.edges.size()), [&](Index e, std::vector<Index>& found) {
        const auto& [i, j] = surface_.edges[place(e)];
        edges_.query(box_of(surface_.edges[place(e)]), found);
        std::erase_if(found, [&](Index f) {
          const auto& [k, l] = surface_.edges[place(f)];
          return f <= e || !may_touch(i, k) || i == k || i == l || j == k || j == l;
        });
      });
  return near;
}

MovingPair SelfContact::vertex_face(Index vertex, Index triangle) const {
  const auto& [a, b, c] = surface_.triangles[place(triangle)];
  MovingPair moving;
  moving.pair = {PairKind::kPointTriangle, 0.5 * surface_.areas[place(vertex)], 0.0};
  moving.vertices = {vertex, a, b, c};
  moving.count = 4;
  return moving;
}

MovingPair SelfContact::edge_edge(Index edge, Index other) const {
  const auto& [i, j] = surface_.edges[place(edge)];
  const auto& [k, l] = surface_.edges[place(other)];
  MovingPair moving;
  moving.pair.kind = PairKind::kEdgeEdge;
  moving.vertices = {i, j, k, l};
  moving.count = 4;
  double area = 0.0;
  for (const Index v : moving.own()) area += 0.25 * surface_.areas[place(v)];
  const bool are_sharp = is_sharp_[place(edge)] && is_sharp_[place(other)];
  moving.pair.weight = (are_sharp ? kSharpEdgeShare : kEdgeShare) * area;
  const Vector& rest = surface_.rest;
  moving.pair.parallel = (are_sharp ? kSharpParallel : 1.0) *
                         parallel_limit(vertex_block(rest, j) - vertex_block(rest, i),
                                        vertex_block(rest, l) - vertex_block(rest, k));
  return moving;
}

std::vector<MovingPair> SelfContact::pairs_of(const Near& near) const {
  std::vector<MovingPair> pairs;
  pairs.reserve(near.vertex_faces.size() + near.edge_edges.size());
  for (const auto& [i, t] : near.vertex_faces) pairs.push_back(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) pairs.push_back(edge_edge(e, f));
  return pairs;
}

// The pairs of a vertex with triangles, and with their edges and vertices. Those whose closest feature is the same at
// both ends of the way are one pair with this feature.
void SelfContact::add_pairs_of(Index vertex, std::span<const std::array<Index, 2>> faces,
                               const Vector& from, const Vector& to,
                               std::vector<MovingPair>& pairs) const {
  struct Feature {
    std::array<Index, 3> vertices{-1, -1, -1};  // ascending, those that are not used first
    double coefficient = 0.0;
  };
  std::vector<Feature> features;
  const auto add = [&features](std::array<Index, 3> corners, double coefficient) {
    std::sort(corners.begin(), corners.end());
    const auto known = std::ranges::find(features, corners, &Feature::vertices);
    if (known == features.end()) {
      features.push_back({corners, coefficient});
    } else {
      known->coefficient += coefficient;
    }
  };
  // c_e = 1 − Σ 1 and c_v = 1 − Σ 1 − Σ c_e.
  for (const auto& [i, t] : faces) add(surface_.triangles[place(t)], 1.0);
  const std::size_t triangles = features.size();
  const auto add_parts = [&](std::size_t begin, std::size_t end, int removed) {
    for (std::size_t k = begin; k < end; ++k) {
      const Feature whole = features[k];
      for (std::size_t c = 0; c < 3; ++c) {
        std::array<Index, 3> part = whole.vertices;
        if (part[c] < 0) continue;
        part[c] = -1;
        if (removed == 2) {  // a vertex of a triangle
          part = {-1, -1, whole.vertices[c]};
        }
        add(part, -whole.coefficient);
      }
    }
  };
  add_parts(0, triangles, 1);
  const std::size_t edges = features.size();
  for (std::size_t k = triangles; k < edges; ++k) features[k].coefficient += 1.0;
  add_parts(0, triangles, 2);
  add_parts(triangles, edges, 1);
  for (std::size_t k = edges; k < features.size(); ++k) features[k].coefficient += 1.0;

  const double limit = barrier_.thickness * barrier_.thickness;
  struct Close {
    std::array<Index, 3> vertices;
    std::array<Index, 3> key;  // the closest feature at both ends, if it is the same
    double coefficient;
  };
  std::vector<Close> close;
  const auto pair_of = [&](const std::array<Index, 3>& corners, double coefficient) {
    const int unused = static_cast<int>(std::ranges::count(corners, Index{-1}));
    constexpr std::array kKinds{PairKind::kPointTriangle, PairKind::kPointEdge,
                                PairKind::kPointPoint};
    MovingPair moving;
    moving.pair.kind = kKinds[static_cast<std::size_t>(unused)];
    moving.pair.weight = 0.5 * surface_.areas[place(vertex)] * coefficient;
    moving.count = 4 - unused;
    moving.vertices[0] = vertex;
    std::copy(corners.begin() + unused, corners.end(), moving.vertices.begin() + 1);
    return moving;
  };
  for (const Feature& feature : features) {
    if (feature.coefficient == 0.0) continue;
    const MovingPair moving = pair_of(feature.vertices, 1.0);
    const PairDistance d0 = pair_distance(moving.pair.kind, moving.points(from));
    const PairDistance d1 = pair_distance(moving.pair.kind, moving.points(to));
    if (!(d0.squared < limit) && !(d1.squared < limit)) continue;
    Close item{feature.vertices, feature.vertices, feature.coefficient};
    const int bits = closest_feature(d0);
    if (bits == closest_feature(d1)) {
      item.key = {-1, -1, -1};
      std::size_t next = 3;
      for (int k = 3; k > 0; --k) {
        if ((bits & (1 << k)) != 0) item.key[--next] = moving.vertices[static_cast<std::size_t>(k)];
      }
    }
    const auto known = std::ranges::find(close, item.key, &Close::key);
    if (known == close.end()) {
      close.push_back(item);
    } else {
      known->coefficient += item.coefficient;
    }
  }
  for (const Close& item : close) {
    if (item.coefficient != 0.0) pairs.push_back(pair_of(item.key, item.coefficient));
  }
}

void SelfContact::prepare(Way& way, const Vector& from, const Vector& to) const {
  way.from = from;
  way.to = to;
  way.checked = false;
  way.penetrating = -1;
  way.pairs.clear();
  const Near near = find_near(from, to, barrier_.thickness);
  const auto& faces = near.vertex_faces;
  std::vector<std::size_t> starts;  // of the vertices
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if (k == 0 || faces[k][0] != faces[k - 1][0]) starts.push_back(k);
  }
  starts.push_back(faces.size());
  std::vector<std::vector<MovingPair>> of_vertices(starts.size() - 1);
  parallel_for(static_cast<Index>(of_vertices.size()), 64, [&](Index begin, Index end) {
    for (std::size_t k = place(begin); k < place(end); ++k) {
      const std::span own(faces.data() + starts[k], starts[k + 1] - starts[k]);
      add_pairs_of(own[0][0], own, from, to, of_vertices[k]);
    }
  });
  for (const std::vector<MovingPair>& pairs : of_vertices) {
    way.pairs.insert(way.pairs.end(), pairs.begin(), pairs.end());
  }
  const auto& edges = near.edge_edges;
  const std::vector<MovingPair> of_edges =
      pairs_within(barrier_.thickness, from, to, edges.size(),
                   [&](std::size_t k) { return edge_edge(edges[k][0], edges[k][1]); });
  way.pairs.insert(way.pairs.end(), of_edges.begin(), of_edges.end());
}

const SelfContact::Way& SelfContact::state(const Vector& x) const {
  if (!same_numbers(state_.from, x)) prepare(state_, x, x);
  return state_;
}

const SelfContact::Way& SelfContact::way(const Vector& from, const Vector& to) const {
  if (!same_numbers(way_.from, from) || !same_numbers(way_.to, to)) prepare(way_, from, to);
  return way_;
}

Index SelfContact::penetrating_vertex(const Vector& x) const {
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

double SelfContact::energy(const Vector& x) const {
  if (penetrating_vertex(x) >= 0) return std::numeric_limits<double>::infinity();
  return energy_of(state(x).pairs, barrier_, x);
}

void SelfContact::add_gradient(const Vector& x, Vector& gradient) const {
  add_gradient_of(state(x).pairs, barrier_, x, gradient);
}

void SelfContact::add_discrete_gradient(const Vector& from, const Vector& to,
                                        Vector& gradient) const {
  add_mean_gradient_of(way(from, to).pairs, barrier_, from, to, gradient);
}

void SelfContact::add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const {
  add_hessian_of(state(x).pairs, barrier_, x, convex, blocks);
}

void SelfContact::add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                       SurfaceBlocks& blocks) const {
  add_mean_hessian_of(way(from, to).pairs, barrier_, from, to, convex, blocks);
}

double SelfContact::smallest_gap(const Vector& x) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const MovingPair& moving : state(x).pairs) smallest = std::min(smallest, moving.distance(x));
  return smallest;
}

void SelfContact::vertex_gaps(const Vector& x, Vector& gaps) const {
  gaps.setConstant(x.size() / 3, std::numeric_limits<double>::infinity());
  for (const MovingPair& moving : state(x).pairs) {
    const double d = moving.distance(x);
    if (!(d < barrier_.thickness)) continue;
    for (const Index i : moving.own()) gaps[i] = std::min(gaps[i], d);
  }
}

void SelfContact::add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const {
  constexpr double kFarthest = 10.0;  // times the thickness
  const double farthest = std::min(reach, kFarthest * barrier_.thickness);
  const double stiffness = barrier_.stiffness / barrier_.thickness;
  for (const MovingPair& moving : pairs_of(find_near(x, x, farthest))) {
    const PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
    if (!(distance.squared < farthest * farthest)) continue;
    const Vector3 n = distance.difference.normalized();
    const Matrix3 block = moving.pair.weight * stiffness * n * n.transpose();
    for (int a = 0; a < moving.count; ++a) {
      const Index i = moving.vertices[place(a)];
      blocks.add(i, distance.weights[a] * distance.weights[a] * block);
      for (int b = a + 1; b < moving.count; ++b) {
        blocks.add_pair(i, moving.vertices[place(b)],
                        distance.weights[a] * distance.weights[b] * block);
      }
    }
  }
}

// The sides of a pair come nearer with the rate of their distance. Both may move, which doubles the stiffness that
// a vertex feels, and several pairs of edges may have a vertex.
void SelfContact::approaching(const Vector& x, const Vector& v, double reach,
                              std::vector<Approach>& found) const {
  for (const MovingPair& moving : pairs_of(find_near(x, x, reach))) {
    const PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
    const double d = std::sqrt(distance.squared);
    if (d > reach) continue;
    const Vector3 rate = moving.moves(v) * distance.weights;
    const double speed = d > 0.0 ? -distance.difference.dot(rate) / d : 0.0;
    const bool is_edges = moving.pair.kind == PairKind::kEdgeEdge;
    for (const Index i : moving.own()) {
      const double area = is_edges ? 2.0 * moving.pair.weight : surface_.areas[place(i)];
      found.push_back({i, 2.0 * area, d, speed});
    }
  }
}

}  // namespace tetraction
