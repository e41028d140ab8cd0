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

}  // namespace

SelfContact::SelfContact(ContactSurface surface, std::vector<Index> body_of, bool within_bodies,
                         const Barrier& barrier)
    : surface_(std::move(surface)),
      barrier_(barrier),
      near_(surface_, std::move(body_of), within_bodies, barrier.thickness) {
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
  number_features();
  find_carrying_areas();
  constexpr double kLongestPart = 2.0;  // mean edges
  for (const auto& [i, j] : surface_.edges) {
    longest_part_ += kLongestPart *
                     (vertex_block(surface_.rest, i) - vertex_block(surface_.rest, j)).norm() /
                     static_cast<double>(surface_.edges.size());
  }
}

// The corners of quadratic faces have nearly no area. The middles of the edges around them stop them.
void SelfContact::find_carrying_areas() {
  constexpr double kSmall = 0.1;
  std::vector<double> largest(surface_.areas.size(), 0.0);
  for (const std::array<Index, 3>& corners : surface_.triangles) {
    for (const Index i : corners) {
      for (const Index j : corners) {
        largest[place(i)] = std::max(largest[place(i)], surface_.areas[place(j)]);
      }
    }
  }
  carrying_areas_ = surface_.areas;
  for (std::size_t i = 0; i < largest.size(); ++i) {
    if (carrying_areas_[i] < kSmall * largest[i]) carrying_areas_[i] = largest[i];
  }
}

void SelfContact::number_features() {
  for (const auto& [edge, face] : face_of_) {
    if (edge[0] != edge[1] && (sides_.empty() || sides_.back() != edge)) sides_.push_back(edge);
  }
  const auto first_side = static_cast<Index>(surface_.triangles.size());
  const auto side_of = [&](Index i, Index j) {
    const auto found = std::ranges::lower_bound(sides_, std::array{std::min(i, j), std::max(i, j)});
    return first_side + static_cast<Index>(found - sides_.begin());
  };
  features_of_.reserve(surface_.triangles.size());
  for (std::array<Index, 3> corners : surface_.triangles) {
    std::ranges::sort(corners);
    const auto& [a, b, c] = corners;
    features_of_.push_back({corners, {side_of(b, c), side_of(a, c), side_of(a, b)}});
  }
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

std::vector<MovingPair> SelfContact::pairs_of(const NearFeatures::Found& near) const {
  std::vector<MovingPair> pairs;
  pairs.reserve(near.vertex_faces.size() + near.edge_edges.size());
  for (const auto& [i, t] : near.vertex_faces) pairs.push_back(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) pairs.push_back(edge_edge(e, f));
  return pairs;
}

// The pair of a vertex with a feature.
MovingPair SelfContact::vertex_feature(Index vertex, Index feature, double coefficient) const {
  const auto triangles = static_cast<Index>(surface_.triangles.size());
  const Index vertices = triangles + static_cast<Index>(sides_.size());
  MovingPair moving;
  moving.pair.weight = 0.5 * surface_.areas[place(vertex)] * coefficient;
  moving.vertices[0] = vertex;
  if (feature < triangles) {
    moving.pair.kind = PairKind::kPointTriangle;
    moving.count = 4;
    std::ranges::copy(features_of_[place(feature)].corners, moving.vertices.begin() + 1);
  } else if (feature < vertices) {
    moving.pair.kind = PairKind::kPointEdge;
    moving.count = 3;
    std::ranges::copy(sides_[place(feature - triangles)], moving.vertices.begin() + 1);
  } else {
    moving.pair.kind = PairKind::kPointPoint;
    moving.count = 2;
    moving.vertices[1] = feature - vertices;
  }
  return moving;
}

// The part of a feature that is closest to a vertex.
Index SelfContact::closest_feature(Index feature, const PairDistance& distance) const {
  const auto triangles = static_cast<Index>(surface_.triangles.size());
  const Index vertices = triangles + static_cast<Index>(sides_.size());
  const auto is_used = [&](std::size_t corner) {
    return distance.weights[static_cast<int>(corner) + 1] != 0.0;
  };
  if (feature < triangles) {
    const Triangle& triangle = features_of_[place(feature)];
    const int used = is_used(0) + is_used(1) + is_used(2);
    if (used == 3) return feature;
    for (std::size_t c = 0; c < 3; ++c) {
      if (used == 2 && !is_used(c)) return triangle.sides.at(c);
      if (used == 1 && is_used(c)) return vertices + triangle.corners.at(c);
    }
  }
  if (feature < vertices && is_used(0) != is_used(1)) {
    return vertices + sides_[place(feature - triangles)].at(is_used(0) ? 0 : 1);
  }
  return feature;
}

// The pairs of a vertex with triangles, and with their edges and vertices. Those whose closest feature is the same at
// both ends of the way are one pair with this feature.
void SelfContact::add_pairs_of(Index vertex, std::span<const std::array<Index, 2>> faces,
                               const Vector& from, const Vector& to,
                               std::vector<MovingPair>& pairs) const {
  struct Feature {
    Index number;
    double coefficient;
  };
  const double limit = barrier_.thickness * barrier_.thickness;
  const auto distance_of = [&](Index feature, const Vector& x) {
    const MovingPair moving = vertex_feature(vertex, feature, 1.0);
    return pair_distance(moving.pair.kind, moving.points(x));
  };
  // No edge or vertex is nearer than the triangles that it belongs to.
  const bool is_near = std::ranges::any_of(faces, [&](const auto& pair) {
    return distance_of(pair[1], from).squared < limit ||
           (&from != &to && distance_of(pair[1], to).squared < limit);
  });
  if (!is_near) return;

  std::vector<Feature> features;
  const auto add_to = [](std::vector<Feature>& all, Index number, double coefficient) {
    const auto known = std::ranges::find(all, number, &Feature::number);
    if (known == all.end()) {
      all.push_back({number, coefficient});
    } else {
      known->coefficient += coefficient;
    }
  };
  // c_e = 1 − Σ 1 and c_v = 1 − Σ 1 − Σ c_e.
  const auto first_side = static_cast<Index>(surface_.triangles.size());
  const Index first_vertex = first_side + static_cast<Index>(sides_.size());
  for (const auto& [i, t] : faces) features.push_back({t, 1.0});
  const std::size_t triangles = features.size();
  for (std::size_t k = 0; k < triangles; ++k) {
    for (const Index side : features_of_[place(features[k].number)].sides) {
      add_to(features, side, -1.0);
    }
  }
  const std::size_t edges = features.size();
  for (std::size_t k = triangles; k < edges; ++k) features[k].coefficient += 1.0;
  for (std::size_t k = 0; k < triangles; ++k) {
    for (const Index corner : features_of_[place(features[k].number)].corners) {
      add_to(features, first_vertex + corner, -1.0);
    }
  }
  for (std::size_t k = triangles; k < edges; ++k) {
    const Feature edge = features[k];
    for (const Index end : sides_[place(edge.number - first_side)]) {
      add_to(features, first_vertex + end, -edge.coefficient);
    }
  }
  for (std::size_t k = edges; k < features.size(); ++k) features[k].coefficient += 1.0;

  std::vector<Feature> close;
  for (const Feature& feature : features) {
    if (feature.coefficient == 0.0) continue;
    const PairDistance d0 = distance_of(feature.number, from);
    const PairDistance d1 = &from == &to ? d0 : distance_of(feature.number, to);
    if (!(d0.squared < limit) && !(d1.squared < limit)) continue;
    const Index closest = closest_feature(feature.number, d0);
    const bool is_same = closest == closest_feature(feature.number, d1);
    add_to(close, is_same ? closest : feature.number, feature.coefficient);
  }
  for (const Feature& item : close) {
    if (item.coefficient != 0.0) {
      pairs.push_back(vertex_feature(vertex, item.number, item.coefficient));
    }
  }
}

void SelfContact::prepare(Way& way, const Vector& from, const Vector& to) const {
  way.from = from;
  way.to = to;
  way.checked = false;
  way.penetrating = -1;
  way.pairs.clear();
  const NearFeatures::Found near = near_.on_way(from, to, barrier_.thickness);
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

// The sides of a pair come nearer with the rate of their distance. Both may move, which doubles the stiffness that
// a vertex feels, and several pairs of edges may have a vertex. Where edges meet that are not sharp, vertices meet faces,
// too, which have nearly all of the area.
void SelfContact::approaching(const Vector& x, const Vector& v, double reach,
                              std::vector<Approach>& found) const {
  const NearFeatures::Found near = near_.on_way(x, x, reach);
  for (const auto& [i, t] : near.vertex_faces) {
    add_approach(vertex_face(i, t), false, x, v, reach, found);
  }
  for (const auto& [e, f] : near.edge_edges) {
    const bool are_sharp = is_sharp_[place(e)] && is_sharp_[place(f)];
    add_approach(edge_edge(e, f), are_sharp, x, v, reach, found);
  }
}

void SelfContact::add_approach(const MovingPair& moving, bool are_sharp_edges, const Vector& x,
                               const Vector& v, double reach, std::vector<Approach>& found) const {
  const PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
  const double d = std::sqrt(distance.squared);
  if (d > reach) return;
  const Vector3 rate = moving.moves(v) * distance.weights;
  const double speed = d > 0.0 ? -distance.difference.dot(rate) / d : 0.0;
  const bool is_edges = moving.pair.kind == PairKind::kEdgeEdge;
  const double share =
      is_edges ? mollifier(parallel_measure(moving.points(x)), moving.pair.parallel) : 1.0;
  for (const Index i : moving.own()) {
    const double area = is_edges ? 2.0 * moving.pair.weight : surface_.areas[place(i)];
    const double carrying = are_sharp_edges ? area : carrying_areas_[place(i)];
    found.push_back({i, 2.0 * share * area, d, speed, 1.0, 2.0 * carrying});
  }
}

}  // namespace tetraction
