// The places where a surface touches a rigid mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "mesh_contact.h"

namespace tetraction {
namespace {

// A place and the feature of the mesh that is closest to it.
struct ContactPlace {
  ContactPoint point;
  Index feature = -1;

  auto key() const { return std::tie(point.count, point.vertices, feature); }
};

// The forces of a vertex on the mesh. Those of inner edges at reentrant corners, which are negative, are taken from
// the others in proportion.
void add_vertex_places(Index vertex, double area, const std::vector<FeatureForce>& forces,
                       std::vector<ContactPlace>& places) {
  double positive = 0.0;
  double total = 0.0;
  for (const FeatureForce& f : forces) {
    total += f.force;
    if (f.force > 0.0) positive += f.force;
  }
  if (!(total > 0.0)) return;
  const double scale = area * total / positive;
  for (const FeatureForce& f : forces) {
    if (!(f.force > 0.0)) continue;
    places.push_back(
        {place_of_vertex(vertex, f.normal, scale * f.force, scale * std::max(0.0, f.stiffness)),
         f.feature});
  }
}

// The forces are the weights of normals and places, which are equal but over a step.
void merge_places(ContactPoint& sum, const ContactPoint& other) {
  const double force = sum.force + other.force;
  const double share = force > 0.0 ? other.force / force : 0.5;
  const Vector3 normal = (1.0 - share) * sum.normal + share * other.normal;
  const double length = normal.norm();
  if (length > 0.0) sum.normal = normal / length;
  for (std::size_t k = 0; k < sum.weights.size(); ++k) {
    sum.weights[k] = (1.0 - share) * sum.weights[k] + share * other.weights[k];
  }
  sum.force = force;
  sum.stiffness += other.stiffness;
}

void append_merged(std::vector<ContactPlace>& places, std::vector<ContactPoint>& points) {
  std::stable_sort(places.begin(), places.end(),
                   [](const ContactPlace& a, const ContactPlace& b) { return a.key() < b.key(); });
  for (std::size_t k = 0; k < places.size();) {
    ContactPlace sum = places[k++];
    while (k < places.size() && places[k].key() == sum.key())
      merge_places(sum.point, places[k++].point);
    points.push_back(sum.point);
  }
}

// A pair's place, from the weights of its points.
ContactPlace place_of_pair(const TriangleMesh& mesh, const MovingPair& pair,
                           const PairWeights& weights, const Vector3& difference) {
  const bool edges = pair.pair.kind == PairKind::kEdgeEdge;
  const std::span<const Index> vertices = pair.own();
  ContactPlace place;
  // The difference goes from the second side to the first one, which is the mesh's if it has the vertex.
  const double sign = edges ? 1.0 : -1.0;
  constexpr Index kNone = std::numeric_limits<Index>::max();  // comes after all vertices
  std::array<std::pair<Index, double>, 3> own{{{kNone, 0.0}, {kNone, 0.0}, {kNone, 0.0}}};
  std::size_t count = 0;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const double w = sign * weights[pair.first + static_cast<int>(k)];
    if (w != 0.0) own[count++] = {vertices[k], w};
  }
  std::sort(own.begin(), own.end());
  place.point.count = static_cast<int>(count);
  for (std::size_t k = 0; k < count; ++k) {
    place.point.vertices[k] = own[k].first;
    place.point.weights[k] = own[k].second;
  }
  const double length = difference.norm();
  if (length > 0.0) place.point.normal = (sign / length) * difference;
  if (!edges) {
    place.feature = mesh.first_vertex() + pair.partner;
  } else if (weights[2] != 0.0 && weights[3] != 0.0) {
    place.feature = mesh.first_edge() + pair.partner;
  } else {
    const auto& edge = mesh.edges()[static_cast<std::size_t>(pair.partner)];
    place.feature = mesh.first_vertex() + (weights[2] != 0.0 ? edge[0] : edge[1]);
  }
  return place;
}

}  // namespace

void MeshContact::contact_points(const Vector& x, std::vector<ContactPoint>& points) const {
  const Way& now = state(x);
  std::vector<ContactPlace> places;
  PointOnMesh point(mesh_, barrier_);
  std::vector<FeatureForce> forces;
  for (std::size_t k = 0; k < now.near.vertices.size(); ++k) {
    const Index i = now.near.vertices[k];
    forces.clear();
    point.with(layer(i)).forces(now.near.triangles_of(k), vertex_block(x, i), forces);
    add_vertex_places(i, surface_.areas[static_cast<std::size_t>(i)], forces, places);
  }
  for (const MovingPair& moving : now.pairs) {
    const PairPoints p = moving.points(x);
    const PairDistance distance = pair_distance(moving.pair.kind, p);
    const double d = std::sqrt(distance.squared);
    double weight = moving.pair.weight;
    const bool edges = moving.pair.kind == PairKind::kEdgeEdge;
    if (edges) weight *= mollifier(parallel_measure(p), moving.pair.parallel);
    if (!(weight > 0.0) || d >= barrier_.thickness) continue;
    ContactPlace place = place_of_pair(mesh_, moving, distance.weights, distance.difference);
    place.point.force = -weight * barrier_.slope(d);
    place.point.stiffness = weight * barrier_.curvature(d);
    places.push_back(place);
  }
  append_merged(places, points);
}

void MeshContact::mean_contact_points(const Vector& from, const Vector& to,
                                      std::vector<ContactPoint>& points) const {
  const Way& now = way(from, to);
  std::vector<ContactPlace> places;
  PointOnMesh point(mesh_, barrier_);
  std::vector<FeatureForce> forces;
  for (std::size_t k = 0; k < now.near.vertices.size(); ++k) {
    const Index i = now.near.vertices[k];
    forces.clear();
    point.with(layer(i)).mean_forces(now.near.triangles_of(k), vertex_block(from, i),
                                     vertex_block(to, i), forces);
    add_vertex_places(i, surface_.areas[static_cast<std::size_t>(i)], forces, places);
  }
  for (const MovingPair& moving : now.pairs) {
    const MeanPair mean = mean_pair(barrier_, moving.pair, moving.points(from), moving.points(to));
    if (!(mean.force > 0.0)) continue;
    ContactPlace place = place_of_pair(mesh_, moving, mean.weights, mean.difference);
    place.point.force = mean.force;
    place.point.stiffness = mean.stiffness;
    places.push_back(place);
  }
  append_merged(places, points);
}

}  // namespace tetraction
