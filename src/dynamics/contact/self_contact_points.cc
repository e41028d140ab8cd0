// The places where a deformed surface touches itself, and where it supports itself.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "face_rotation.h"
#include "self_contact.h"

namespace tetraction {
namespace {

// The force of a pair, and where its sides are closest.
struct PairForce {
  double force = 0.0;      // N
  double stiffness = 0.0;  // N/m
  PairWeights weights = PairWeights::Zero();
  Vector3 difference = Vector3::Zero();
};

}  // namespace

// The corners of the first triangle that has the edge of two vertices, or one vertex given twice.
const std::array<Index, 3>& SelfContact::face_of(Index vertex, Index other) const {
  const std::array<Index, 2> edge{std::min(vertex, other), std::max(vertex, other)};
  const auto found =
      std::ranges::lower_bound(face_of_, edge, {}, [](const auto& each) { return each.first; });
  return surface_.triangles[static_cast<std::size_t>(found->second)];
}

// The sides turn together as the face of the second side does that the pair has, or the first face that has its edge or
// vertex.
ContactPoint SelfContact::place_of(const MovingPair& pair, const PairWeights& weights,
                                   const Vector3& difference, const Vector& x) const {
  ContactPoint place;
  place.normal = difference.normalized();
  const auto number_of = [&place](Index vertex) {
    const auto end = place.vertices.begin() + place.count;
    const auto known = std::find(place.vertices.begin(), end, vertex);
    if (known == end) place.vertices[static_cast<std::size_t>(place.count++)] = vertex;
    return static_cast<std::size_t>(known - place.vertices.begin());
  };
  const std::span<const Index> own = pair.own();
  for (std::size_t k = 0; k < own.size(); ++k) {
    const double w = weights[static_cast<int>(k)];
    if (w != 0.0) place.weights[number_of(own[k])] = w;
  }
  const auto second = own.subspan(static_cast<std::size_t>(first_side_size(pair.pair.kind)));
  const std::array<Index, 3> face = second.size() == 3
                                        ? std::array<Index, 3>{second[0], second[1], second[2]}
                                        : face_of(second.front(), second.back());
  const std::array<Matrix3, 3> rotation =
      face_rotation({vertex_block(x, face[0]), vertex_block(x, face[1]), vertex_block(x, face[2])});
  place.has_turns = true;
  for (std::size_t k = 0; k < 3; ++k) {
    place.turns[number_of(face[k])] = cross_matrix(difference) * rotation[k];
  }
  return place;
}

// Where the surface is concave, pairs with an edge or a vertex pull. What they pull is taken from the other pairs of the
// same vertex in proportion.
template <class ForceOf>
void SelfContact::append_places(const std::vector<MovingPair>& pairs, const Vector& x,
                                const ForceOf& force_of, std::vector<ContactPoint>& points) const {
  std::vector<PairForce> forces;
  for (std::size_t k = 0; k < pairs.size();) {
    const std::size_t begin = k;
    forces.clear();
    double total = 0.0;
    double positive = 0.0;
    do {
      forces.push_back(force_of(pairs[k]));
      total += forces.back().force;
      positive += std::max(0.0, forces.back().force);
      ++k;
    } while (k < pairs.size() && pairs[k].pair.kind != PairKind::kEdgeEdge &&
             pairs[k].vertices[0] == pairs[begin].vertices[0]);
    if (!(total > 0.0)) continue;
    const double scale = total / positive;
    for (std::size_t m = begin; m < k; ++m) {
      const PairForce& each = forces[m - begin];
      if (!(each.force > 0.0)) continue;
      ContactPoint place = place_of(pairs[m], each.weights, each.difference, x);
      place.force = scale * each.force;
      place.stiffness = scale * std::max(0.0, each.stiffness);
      points.push_back(place);
    }
  }
}

void SelfContact::contact_points(const Vector& x, std::vector<ContactPoint>& points) const {
  const auto force_of = [&](const MovingPair& moving) {
    const PairPoints p = moving.points(x);
    const PairDistance distance = pair_distance(moving.pair.kind, p);
    const double d = std::sqrt(distance.squared);
    if (d >= barrier_.thickness) return PairForce{};
    double weight = moving.pair.weight;
    if (moving.pair.parallel > 0.0) weight *= mollifier(parallel_measure(p), moving.pair.parallel);
    return PairForce{-weight * barrier_.slope(d), weight * barrier_.curvature(d), distance.weights,
                     distance.difference};
  };
  append_places(state(x).pairs, x, force_of, points);
}

void SelfContact::mean_contact_points(const Vector& from, const Vector& to,
                                      std::vector<ContactPoint>& points) const {
  const auto force_of = [&](const MovingPair& moving) {
    const MeanPair mean = mean_pair(barrier_, moving.pair, moving.points(from), moving.points(to));
    return PairForce{mean.force, mean.stiffness, mean.weights, mean.difference};
  };
  append_places(way(from, to).pairs, 0.5 * (from + to), force_of, points);
}

SelfContact::SideShape SelfContact::shape_of(std::span<const Index> side, const Vector& x,
                                             const Vector3& closest,
                                             const Vector3& direction) const {
  // Of directions. It leaves a lateral stiffness of its square of what is round-off in flat faces.
  constexpr double kSame = 1e-4;
  const auto is_around = [&](const std::array<Index, 3>& triangle) {
    return std::ranges::all_of(
        side, [&](Index i) { return std::ranges::find(triangle, i) != triangle.end(); });
  };
  const std::array<Index, 2> vertex{side.front(), side.front()};
  const auto around =
      std::ranges::equal_range(face_of_, vertex, {}, [](const auto& each) { return each.first; });
  SideShape shape;
  for (const auto& [key, face] : around) {
    const std::array<Index, 3>& triangle = surface_.triangles[static_cast<std::size_t>(face)];
    if (!is_around(triangle)) continue;
    const std::array<Vector3, 3> p{vertex_block(x, triangle[0]), vertex_block(x, triangle[1]),
                                   vertex_block(x, triangle[2])};
    for (const Vector3& corner : p) {
      const Vector3 along = corner - closest;
      if (along.dot(direction) > kSame * along.norm()) shape.is_nearest = false;
    }
    const Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    if ((normal - direction).norm() < kSame) shape.is_face = true;
  }
  return shape;
}

// The features next to the closest ones of a pair must not be nearer: otherwise the pair is the oblique one of two places
// that face others. What a face has before it may be a place of any shape, as it may turn, and be pressed flat.
bool SelfContact::supports(const MovingPair& moving, const PairDistance& distance,
                           const Vector& x) const {
  const std::span<const Index> own = moving.own();
  const int first_size = first_side_size(moving.pair.kind);
  const Vector3 normal = distance.difference.normalized();
  const auto shape = [&](int begin, int end, double sign) {
    std::vector<Index> side;
    Vector3 closest = Vector3::Zero();
    for (int k = begin; k < end; ++k) {
      const Index i = own[static_cast<std::size_t>(k)];
      if (distance.weights[k] == 0.0) continue;
      side.push_back(i);
      closest += sign * distance.weights[k] * vertex_block(x, i);
    }
    return shape_of(side, x, closest, -sign * normal);
  };
  const SideShape second = shape(first_size, moving.count, -1.0);
  if (!second.is_nearest) return false;
  if (moving.pair.kind != PairKind::kEdgeEdge && second.is_face) return true;
  return shape(0, first_size, 1.0).is_nearest;
}

void SelfContact::add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const {
  constexpr double kFarthest = 10.0;  // times the thickness
  const double farthest = std::min(reach, kFarthest * barrier_.thickness);
  const double stiffness = barrier_.stiffness / barrier_.thickness;
  for (const MovingPair& moving : pairs_of(near_.on_way(x, x, farthest))) {
    const PairDistance distance = pair_distance(moving.pair.kind, moving.points(x));
    if (!(distance.squared < farthest * farthest) || !(distance.squared > 0.0)) continue;
    if (!supports(moving, distance, x)) continue;
    const Vector3 n = distance.difference.normalized();
    const Matrix3 block = moving.pair.weight * stiffness * n * n.transpose();
    const std::span<const Index> own = moving.own();
    for (int a = 0; a < moving.count; ++a) {
      const Index i = own[static_cast<std::size_t>(a)];
      blocks.add(i, distance.weights[a] * distance.weights[a] * block);
      for (int b = a + 1; b < moving.count; ++b) {
        blocks.add_pair(i, own[static_cast<std::size_t>(b)],
                        distance.weights[a] * distance.weights[b] * block);
      }
    }
  }
}

}  // namespace tetraction
