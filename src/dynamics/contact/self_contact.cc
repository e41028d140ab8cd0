#include "self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Pairs of edges have this part of the area of a vertex.
constexpr double kEdgeShare = 0.01;
constexpr Index kSelfGrain = 64;

std::size_t place(Index i) {
  return static_cast<std::size_t>(i);
}

// The vertices of the second side that are closest to the first one, as bits of the columns 1 to 3.
int closest_feature(const PairDistance& distance) {
  int bits = 0;
  for (int k = 1; k < 4; ++k) bits |= distance.weights[k] != 0.0 ? 1 << k : 0;
  return bits;
}

bool is_same(const Vector& a, const Vector& b) {
  return a.size() == b.size() && (a.array() == b.array()).all();
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
  triangles_ = BoxTree(boxes(surface_.triangles));
  edges_ = BoxTree(boxes(surface_.edges));
}

PairPoints SelfContact::Pair::points(const Vector& x) const {
  PairPoints p = PairPoints::Zero();
  for (int k = 0; k < size(); ++k)
    p.col(k) = vertex_block(x, vertices[static_cast<std::size_t>(k)]);
  return p;
}

bool SelfContact::may_touch(Index a, Index b) const {
  return within_bodies_ || body_of_[place(a)] != body_of_[place(b)];
}

void SelfContact::refit(const Vector& from, const Vector& to) const {
  const auto boxes = [&](const auto& items) {
    std::vector<Box> all(items.size());
    parallel_for(static_cast<Index>(items.size()), 256, [&](Index begin, Index end) {
      for (std::size_t k = place(begin); k < place(end); ++k) {
        for (const Index i : items[k]) {
          all[k].add(vertex_block(from, i));
          all[k].add(vertex_block(to, i));
        }
      }
    });
    return all;
  };
  triangles_.refit(boxes(surface_.triangles));
  edges_.refit(boxes(surface_.edges));
}

SelfContact::Near SelfContact::find_near(const Vector& from, const Vector& to, double reach) const {
  refit(from, to);
  const auto gather = [&](Index count, const auto& find) {
    constexpr Index kPiece = 256;
    const Index pieces = (count + kPiece - 1) / kPiece;
    std::vector<Candidates> parts(place(pieces));
    parallel_for(pieces, 1, [&](Index begin, Index end) {
      std::vector<Index> found;
      for (Index piece = begin; piece < end; ++piece) {
        const Index last = std::min(count, (piece + 1) * kPiece);
        for (Index i = piece * kPiece; i < last; ++i) {
          found.clear();
          find(i, found);
          for (const Index j : found) parts[place(piece)].push_back({i, j});
        }
      }
    });
    Candidates all;
    for (const Candidates& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  };
  const auto box_of = [&](const auto& corners) {
    Box box;
    for (const Index i : corners) {
      box.add(vertex_block(from, i));
      box.add(vertex_block(to, i));
    }
    return box.widened(reach);
  };
  Near near;
  near.vertex_faces = gather(from.size() / 3, [&](Index i, std::vector<Index>& found) {
    triangles_.query(box_of(std::array<Index, 1>{i}), found);
    std::erase_if(found, [&](Index t) {
      const auto& corners = surface_.triangles[place(t)];
      return !may_touch(i, corners[0]) || std::ranges::count(corners, i) > 0;
    });
  });
  near.edge_edges =
      gather(static_cast<Index>(surface_.edges.size()), [&](Index e, std::vector<Index>& found) {
        const auto& [i, j] = surface_.edges[place(e)];
        edges_.query(box_of(surface_.edges[place(e)]), found);
        std::erase_if(found, [&](Index f) {
          const auto& [k, l] = surface_.edges[place(f)];
          return f <= e || !may_touch(i, k) || i == k || i == l || j == k || j == l;
        });
      });
  return near;
}

SelfContact::Pair SelfContact::vertex_face(Index vertex, Index triangle) const {
  const auto& [a, b, c] = surface_.triangles[place(triangle)];
  return {{PairKind::kPointTriangle, 0.5 * surface_.areas[place(vertex)], 0.0}, {vertex, a, b, c}};
}

SelfContact::Pair SelfContact::edge_edge(Index edge, Index other) const {
  const auto& [i, j] = surface_.edges[place(edge)];
  const auto& [k, l] = surface_.edges[place(other)];
  Pair pair;
  pair.pair.kind = PairKind::kEdgeEdge;
  pair.vertices = {i, j, k, l};
  double area = 0.0;
  for (const Index v : pair.vertices) area += 0.25 * surface_.areas[place(v)];
  pair.pair.weight = kEdgeShare * area;
  const Vector& rest = surface_.rest;
  pair.pair.parallel = parallel_limit(vertex_block(rest, j) - vertex_block(rest, i),
                                      vertex_block(rest, l) - vertex_block(rest, k));
  return pair;
}

// The pairs of a vertex with triangles, and with their edges and vertices. Those whose closest feature is the same at
// both ends of the way are one pair with this feature.
void SelfContact::add_pairs_of(Index vertex, const std::array<Index, 2>* faces, std::size_t count,
                               const Vector& from, const Vector& to,
                               std::vector<Pair>& pairs) const {
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
  for (std::size_t k = 0; k < count; ++k) add(surface_.triangles[place(faces[k][1])], 1.0);
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
    Pair pair;
    pair.pair.kind = unused == 0   ? PairKind::kPointTriangle
                     : unused == 1 ? PairKind::kPointEdge
                                   : PairKind::kPointPoint;
    pair.pair.weight = 0.5 * surface_.areas[place(vertex)] * coefficient;
    pair.vertices[0] = vertex;
    for (std::size_t k = 0; k + static_cast<std::size_t>(unused) < 3; ++k) {
      pair.vertices[k + 1] = corners[k + static_cast<std::size_t>(unused)];
    }
    return pair;
  };
  for (const Feature& feature : features) {
    if (feature.coefficient == 0.0) continue;
    const Pair pair = pair_of(feature.vertices, 1.0);
    const PairDistance d0 = pair_distance(pair.pair.kind, pair.points(from));
    const PairDistance d1 = pair_distance(pair.pair.kind, pair.points(to));
    if (!(d0.squared < limit) && !(d1.squared < limit)) continue;
    Close item{feature.vertices, feature.vertices, feature.coefficient};
    const int bits = closest_feature(d0);
    if (bits == closest_feature(d1)) {
      item.key = {-1, -1, -1};
      std::size_t next = 3;
      for (int k = 3; k > 0; --k) {
        if ((bits & (1 << k)) != 0) item.key[--next] = pair.vertices[static_cast<std::size_t>(k)];
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
  std::vector<std::size_t> starts;  // of the vertices
  for (std::size_t k = 0; k < near.vertex_faces.size(); ++k) {
    if (k == 0 || near.vertex_faces[k][0] != near.vertex_faces[k - 1][0]) starts.push_back(k);
  }
  starts.push_back(near.vertex_faces.size());
  std::vector<std::vector<Pair>> of_vertices(starts.size() - 1);
  parallel_for(static_cast<Index>(of_vertices.size()), kSelfGrain, [&](Index begin, Index end) {
    for (std::size_t k = place(begin); k < place(end); ++k) {
      const std::array<Index, 2>* faces = near.vertex_faces.data() + starts[k];
      add_pairs_of((*faces)[0], faces, starts[k + 1] - starts[k], from, to, of_vertices[k]);
    }
  });
  for (const std::vector<Pair>& pairs : of_vertices) {
    way.pairs.insert(way.pairs.end(), pairs.begin(), pairs.end());
  }
  std::vector<Pair> edges(near.edge_edges.size());
  std::vector<char> is_close(edges.size());
  const double limit = barrier_.thickness * barrier_.thickness;
  parallel_for(static_cast<Index>(edges.size()), kSelfGrain, [&](Index begin, Index end) {
    for (std::size_t k = place(begin); k < place(end); ++k) {
      const Pair pair = edge_edge(near.edge_edges[k][0], near.edge_edges[k][1]);
      edges[k] = pair;
      is_close[k] = pair_distance(pair.pair.kind, pair.points(from)).squared < limit ||
                    pair_distance(pair.pair.kind, pair.points(to)).squared < limit;
    }
  });
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (is_close[k] != 0) way.pairs.push_back(edges[k]);
  }
}

const SelfContact::Way& SelfContact::state(const Vector& x) const {
  if (!is_same(state_.from, x)) prepare(state_, x, x);
  return state_;
}

const SelfContact::Way& SelfContact::way(const Vector& from, const Vector& to) const {
  if (!is_same(way_.from, from) || !is_same(way_.to, to)) prepare(way_, from, to);
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
  const Way& now = state(x);
  return parallel_sum(static_cast<Index>(now.pairs.size()), [&](Index begin, Index end) {
    double sum = 0.0;
    for (std::size_t k = place(begin); k < place(end); ++k) {
      sum += pair_energy(barrier_, now.pairs[k].pair, now.pairs[k].points(x));
    }
    return sum;
  });
}

namespace {

// part[k] = of(k) for all pairs, on all threads.
template <class Part, class Of>
std::vector<Part> all_parts(std::size_t count, const Of& of) {
  std::vector<Part> parts(count);
  parallel_for(static_cast<Index>(count), kSelfGrain, [&](Index begin, Index end) {
    for (std::size_t k = place(begin); k < place(end); ++k) parts[k] = of(k);
  });
  return parts;
}

}  // namespace

void SelfContact::add_gradient(const Vector& x, Vector& gradient) const {
  const Way& now = state(x);
  const auto parts = all_parts<PairVector>(now.pairs.size(), [&](std::size_t k) {
    return pair_gradient(barrier_, now.pairs[k].pair, now.pairs[k].points(x));
  });
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (int a = 0; a < now.pairs[k].size(); ++a) {
      vertex_block(gradient, now.pairs[k].vertices[static_cast<std::size_t>(a)]) +=
          parts[k].segment<3>(3 * a);
    }
  }
}

void SelfContact::add_discrete_gradient(const Vector& from, const Vector& to,
                                        Vector& gradient) const {
  const Way& now = way(from, to);
  const auto parts = all_parts<PairVector>(now.pairs.size(), [&](std::size_t k) {
    const Pair& pair = now.pairs[k];
    return mean_pair(barrier_, pair.pair, pair.points(from), pair.points(to)).gradient;
  });
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (int a = 0; a < now.pairs[k].size(); ++a) {
      vertex_block(gradient, now.pairs[k].vertices[static_cast<std::size_t>(a)]) +=
          parts[k].segment<3>(3 * a);
    }
  }
}

void SelfContact::add_blocks(const Way& way, bool convex, std::vector<PairMatrix>& parts,
                             SurfaceBlocks& blocks) const {
  if (convex) {
    parallel_for(static_cast<Index>(parts.size()), kSelfGrain, [&](Index begin, Index end) {
      for (std::size_t k = place(begin); k < place(end); ++k) {
        const int size = 3 * way.pairs[k].size();
        Matrix part = parts[k].topLeftCorner(size, size);
        make_semidefinite(part);
        parts[k].topLeftCorner(size, size) = part;
      }
    });
  }
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Pair& pair = way.pairs[k];
    for (int a = 0; a < pair.size(); ++a) {
      const Index i = pair.vertices[static_cast<std::size_t>(a)];
      blocks.add(i, parts[k].block<3, 3>(3 * a, 3 * a));
      for (int b = a + 1; b < pair.size(); ++b) {
        blocks.add_pair(i, pair.vertices[static_cast<std::size_t>(b)],
                        parts[k].block<3, 3>(3 * a, 3 * b));
      }
    }
  }
}

void SelfContact::add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const {
  const Way& now = state(x);
  auto parts = all_parts<PairMatrix>(now.pairs.size(), [&](std::size_t k) {
    return pair_hessian(barrier_, now.pairs[k].pair, now.pairs[k].points(x));
  });
  add_blocks(now, convex, parts, blocks);
}

void SelfContact::add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                       SurfaceBlocks& blocks) const {
  const Way& now = way(from, to);
  auto parts = all_parts<PairMatrix>(now.pairs.size(), [&](std::size_t k) {
    const Pair& pair = now.pairs[k];
    return mean_pair_hessian(barrier_, pair.pair, pair.points(from), pair.points(to));
  });
  add_blocks(now, convex, parts, blocks);
}

double SelfContact::smallest_gap(const Vector& x) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Pair& pair : state(x).pairs) {
    smallest = std::min(smallest, std::sqrt(pair_distance(pair.pair.kind, pair.points(x)).squared));
  }
  return smallest;
}

void SelfContact::vertex_gaps(const Vector& x, Vector& gaps) const {
  gaps.setConstant(x.size() / 3, std::numeric_limits<double>::infinity());
  for (const Pair& pair : state(x).pairs) {
    const double d = std::sqrt(pair_distance(pair.pair.kind, pair.points(x)).squared);
    if (!(d < barrier_.thickness)) continue;
    for (int k = 0; k < pair.size(); ++k) {
      double& gap = gaps[pair.vertices[static_cast<std::size_t>(k)]];
      gap = std::min(gap, d);
    }
  }
}

void SelfContact::add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const {
  constexpr double kFarthest = 10.0;  // times the thickness
  const double farthest = std::min(reach, kFarthest * barrier_.thickness);
  const double stiffness = barrier_.stiffness / barrier_.thickness;
  const auto add = [&](const Pair& pair) {
    const PairDistance distance = pair_distance(pair.pair.kind, pair.points(x));
    if (!(distance.squared < farthest * farthest)) return;
    const Vector3 n = distance.difference.normalized();
    const Matrix3 block = pair.pair.weight * stiffness * n * n.transpose();
    for (int a = 0; a < pair.size(); ++a) {
      const Index i = pair.vertices[static_cast<std::size_t>(a)];
      blocks.add(i, distance.weights[a] * distance.weights[a] * block);
      for (int b = a + 1; b < pair.size(); ++b) {
        blocks.add_pair(i, pair.vertices[static_cast<std::size_t>(b)],
                        distance.weights[a] * distance.weights[b] * block);
      }
    }
  };
  const Near near = find_near(x, x, farthest);
  for (const auto& [i, t] : near.vertex_faces) add(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) add(edge_edge(e, f));
}

// The sides of a pair come nearer with the rate of their distance. Both may move, which doubles the stiffness that
// a vertex feels.
void SelfContact::approaching(const Vector& x, const Vector& v, double reach,
                              std::vector<Approach>& found) const {
  const Near near = find_near(x, x, reach);
  const auto add = [&](const Pair& pair) {
    const PairDistance distance = pair_distance(pair.pair.kind, pair.points(x));
    const double d = std::sqrt(distance.squared);
    if (d > reach) return;
    const Vector3 rate = pair.points(v) * distance.weights;
    const double speed = d > 0.0 ? -distance.difference.dot(rate) / d : 0.0;
    for (int k = 0; k < pair.size(); ++k) {
      const Index i = pair.vertices[static_cast<std::size_t>(k)];
      found.push_back({i, 2.0 * surface_.areas[place(i)], d, speed});
    }
  };
  for (const auto& [i, t] : near.vertex_faces) add(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) add(edge_edge(e, f));
}

// Friction between bodies is not there.
void SelfContact::contact_points(const Vector&, std::vector<ContactPoint>&) const {}
void SelfContact::mean_contact_points(const Vector&, const Vector&,
                                      std::vector<ContactPoint>&) const {}

}  // namespace tetraction
