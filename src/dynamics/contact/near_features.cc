#include "near_features.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "dynamics/contact/pairs/surface_loops.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kBoxGrain = 256;

std::size_t box_at(Index i) {
  return static_cast<std::size_t>(i);
}

bool contains(const Box& outer, const Box& inner) {
  return (outer.lower.array() <= inner.lower.array()).all() &&
         (inner.upper.array() <= outer.upper.array()).all();
}

Box box_of(std::span<const Index> vertices, const std::vector<Box>& of_vertices) {
  Box box;
  for (const Index i : vertices) box.add(of_vertices[box_at(i)]);
  return box;
}

// The boxes of edges or triangles.
template <class Items>
std::vector<Box> boxes_of(const Items& items, const std::vector<Box>& of_vertices) {
  std::vector<Box> all(items.size());
  parallel_for(static_cast<Index>(items.size()), kBoxGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) all[box_at(k)] = box_of(items[box_at(k)], of_vertices);
  });
  return all;
}

std::vector<Box> widened(std::vector<Box> boxes, double by) {
  for (Box& box : boxes) box = box.widened(by);
  return boxes;
}

// Those of the pairs whose boxes overlap.
NearFeatures::Pairs overlapping(const NearFeatures::Pairs& pairs, const std::vector<Box>& first,
                                const std::vector<Box>& second) {
  std::vector<char> is_kept(pairs.size());
  parallel_for(static_cast<Index>(pairs.size()), kBoxGrain, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const auto& [i, j] = pairs[box_at(k)];
      is_kept[box_at(k)] = first[box_at(i)].overlaps(second[box_at(j)]) ? 1 : 0;
    }
  });
  NearFeatures::Pairs kept;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (is_kept[k] != 0) kept.push_back(pairs[k]);
  }
  return kept;
}

}  // namespace

NearFeatures::NearFeatures(ContactSurface surface, std::vector<Index> body_of, bool within_bodies,
                           double margin)
    : surface_(std::move(surface)),
      body_of_(std::move(body_of)),
      within_bodies_(within_bodies),
      margin_(margin) {}

bool NearFeatures::may_touch(Index a, Index b) const {
  return within_bodies_ || body_of_[box_at(a)] != body_of_[box_at(b)];
}

std::vector<Box> NearFeatures::boxes_of_ways(const Vector& from, const Vector& to) const {
  // The round-off of places far from the origin.
  constexpr double kRoundOff = 4.0 * std::numeric_limits<double>::epsilon();
  const Vector3 start = mean_of_vertices(from);
  const Vector3 end = mean_of_vertices(to);
  const Vector3 error = kRoundOff * (start.cwiseAbs() + end.cwiseAbs());
  if (!from.allFinite() || !to.allFinite() || !error.allFinite()) return {};
  std::vector<Box> boxes(surface_.vertices.size());
  parallel_for(static_cast<Index>(boxes.size()), kBoxGrain, [&](Index first, Index last) {
    for (Index i = first; i < last; ++i) {
      Box& box = boxes[box_at(i)];
      box.add(Vector3(vertex_block(from, i) - start));
      box.add(Vector3(vertex_block(to, i) - end));
      box.lower -= error;
      box.upper += error;
    }
  });
  return boxes;
}

// A step moves the vertices by about as much as the last one, so that there is room for another way as long.
NearFeatures::Kept NearFeatures::search(const std::vector<Box>& boxes, double reach) const {
  constexpr double kMostRoom = 4.0;  // margins
  Kept found;
  found.reach = reach;
  found.boxes = boxes;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    double room = (boxes[i].upper - boxes[i].lower).maxCoeff();
    if (!last_ways_.empty()) room = std::max(room, last_ways_[i]);
    found.boxes[i] = boxes[i].widened(margin_ + std::min(room, kMostRoom * margin_));
  }
  const std::vector<Box> of_triangles = boxes_of(surface_.triangles, found.boxes);
  const std::vector<Box> of_edges = boxes_of(surface_.edges, found.boxes);
  const BoxTree triangles(of_triangles);
  const BoxTree edges(of_edges);
  found.near.vertex_faces =
      gather_pairs(static_cast<Index>(found.boxes.size()), [&](Index i, std::vector<Index>& near) {
        triangles.query(found.boxes[box_at(i)].widened(reach), near);
        std::erase_if(near, [&](Index t) {
          const auto& corners = surface_.triangles[box_at(t)];
          return !may_touch(i, corners[0]) || std::ranges::count(corners, i) > 0;
        });
      });
  found.near.edge_edges =
      gather_pairs(static_cast<Index>(of_edges.size()), [&](Index e, std::vector<Index>& near) {
        const auto& [i, j] = surface_.edges[box_at(e)];
        edges.query(of_edges[box_at(e)].widened(reach), near);
        std::erase_if(near, [&](Index f) {
          const auto& [k, l] = surface_.edges[box_at(f)];
          return f <= e || !may_touch(i, k) || i == k || i == l || j == k || j == l;
        });
      });
  found.edge_faces =
      gather_pairs(static_cast<Index>(of_edges.size()), [&](Index e, std::vector<Index>& near) {
        const auto& [i, j] = surface_.edges[box_at(e)];
        triangles.query(of_edges[box_at(e)], near);
        std::erase_if(near, [&](Index t) {
          const auto& corners = surface_.triangles[box_at(t)];
          return !may_touch(i, corners[0]) || std::ranges::count(corners, i) > 0 ||
                 std::ranges::count(corners, j) > 0;
        });
      });
  return found;
}

const NearFeatures::Kept& NearFeatures::kept_for(const std::vector<Box>& boxes,
                                                 double reach) const {
  Kept& kept = reach <= margin_ ? kept_ : far_;
  bool holds = kept.boxes.size() == boxes.size() && reach <= kept.reach;
  for (std::size_t i = 0; holds && i < boxes.size(); ++i) {
    holds = contains(kept.boxes[i], boxes[i]);
  }
  if (!holds) kept = search(boxes, std::max(reach, margin_));
  return kept;
}

NearFeatures::Found NearFeatures::on_way(const Vector& from, const Vector& to, double reach) const {
  const std::vector<Box> boxes = boxes_of_ways(from, to);
  if (boxes.empty()) return {};
  if (&from != &to) {
    last_ways_.resize(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      last_ways_[i] = (boxes[i].upper - boxes[i].lower).maxCoeff();
    }
  }
  const Kept& kept = kept_for(boxes, reach);
  const std::vector<Box> edges = boxes_of(surface_.edges, boxes);
  const std::vector<Box> triangles = boxes_of(surface_.triangles, boxes);
  return {overlapping(kept.near.vertex_faces, widened(boxes, reach), triangles),
          overlapping(kept.near.edge_edges, widened(edges, reach), edges)};
}

NearFeatures::Pairs NearFeatures::edge_faces(const Vector& x) const {
  const std::vector<Box> boxes = boxes_of_ways(x, x);
  if (boxes.empty()) return {};
  return overlapping(kept_for(boxes, 0.0).edge_faces, widened(boxes_of(surface_.edges, boxes), 0.0),
                     boxes_of(surface_.triangles, boxes));
}

}  // namespace tetraction
