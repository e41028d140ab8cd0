// Contact of surfaces that both deform, through the interface of obstacles.
#include "dynamics/contact/self_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/decompositions.h"
#include "support/contact_surfaces.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Barrier kLayer{0.1, 1e5};

Triangles joined(const Triangles& a, const Triangles& b) {
  Triangles both = a;
  const auto first = static_cast<Index>(a.points.size());
  both.points.insert(both.points.end(), b.points.begin(), b.points.end());
  for (const auto& [i, j, k] : b.triangles) {
    both.triangles.push_back({first + i, first + j, first + k});
  }
  return both;
}

// Two surfaces of different bodies.
struct TwoBodies {
  TwoBodies(const Triangles& lower, const Triangles& upper, const Barrier& layer = kLayer)
      : surface(contact_surface(joined(lower, upper))),
        first(static_cast<Index>(lower.points.size())),
        contact(surface, bodies(), false, layer) {}
  std::vector<Index> bodies() const {
    std::vector<Index> body(surface.vertices.size(), 0);
    std::fill(body.begin() + first, body.end(), 1);
    return body;
  }
  Vector with_upper_moved(const Vector3& by) const {
    Vector x = surface.rest;
    for (Index i = first; i < x.size() / 3; ++i) vertex_block(x, i) += by;
    return x;
  }
  Vector gradient(const Vector& x) const {
    Vector sum = Vector::Zero(x.size());
    contact.add_gradient(x, sum);
    return sum;
  }
  Vector mean_gradient(const Vector& from, const Vector& to) const {
    Vector sum = Vector::Zero(from.size());
    contact.add_discrete_gradient(from, to, sum);
    return sum;
  }

  ContactSurface surface;
  Index first;
  SelfContact contact;
};

void turn_and_move(Triangles& t, const Vector3& axis, double angle, const Vector3& by) {
  const Matrix3 turn = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  for (Vector3& p : t.points) p = turn * p + by;
}

// A cube above a larger one, with a corner and edges in the layer.
TwoBodies tilted_cubes(double unit = 1.0) {
  Triangles lower = cube_surface(3, 1.0);
  Triangles upper = cube_surface(2, 0.6);
  turn_and_move(upper, Vector3(1.0, 0.4, 0.2), 0.13, Vector3(0.21, 0.17, 1.02));
  double lowest = 1e9;
  for (const Vector3& p : upper.points) lowest = std::min(lowest, p.z());
  for (Vector3& p : upper.points) p.z() += 1.03 - lowest;
  for (Triangles* t : {&lower, &upper}) {
    for (Vector3& p : t->points) p *= unit;
  }
  return TwoBodies(lower, upper, {kLayer.thickness * unit, kLayer.stiffness});
}

// A smaller face on a larger one, whose meshes do not match: every vertex of either inner part is at the distance d
// from the other face.
TEST(SelfContact, FlatFacesTransmitThePressure) {
  Triangles lower = flat_grid(9, 3.0);
  Triangles upper = flat_grid(5, 3.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.1, 0.1);
  const auto inside = [](const Vector3& p) {
    return p.x() > 0.1 && p.x() < 2.9 && p.y() > 0.1 && p.y() < 2.9;
  };
  for (Triangles* t : {&lower, &upper}) {
    for (Vector3& p : t->points) {
      if (inside(p)) p += Vector3(uniform(random), uniform(random), 0.0);
    }
  }
  for (auto& [a, b, c] : upper.triangles) std::swap(b, c);  // looks down
  for (const double d : {0.01, 0.05, 0.09}) {
    Triangles above = upper;
    for (Vector3& p : above.points) p.z() += d;
    const TwoBodies two(lower, above);
    const Vector gradient = two.gradient(two.surface.rest);
    double force = 0.0;
    double least = 0.0;
    for (Index i = two.first; i < gradient.size() / 3; ++i) {
      force -= gradient[3 * i + 2];
      least = std::min(least, -gradient[3 * i + 2]);
    }
    EXPECT_GE(least, -1e-9);
    // The pairs of edges have a share of their own, which is small and pushes apart, too.
    const double pressure = -kLayer.slope(d);
    EXPECT_GT(force, pressure * 9.0 * (1.0 - 1e-12)) << d;
    EXPECT_LT(force, pressure * 9.0 * 1.12) << d;
    double edges = 0.0;
    {
      // Without them the force is exact.
      const TwoBodies no_edges = [&] {
        TwoBodies copy(lower, above);
        copy.surface.edges.clear();
        copy.contact = SelfContact(copy.surface, copy.bodies(), false, kLayer);
        return copy;
      }();
      const Vector exact = no_edges.gradient(no_edges.surface.rest);
      for (Index i = two.first; i < exact.size() / 3; ++i) edges -= exact[3 * i + 2];
      EXPECT_NEAR(edges, pressure * 9.0, 1e-9 * pressure * 9.0) << d;
    }
    EXPECT_NEAR(two.contact.smallest_gap(two.surface.rest), d, 1e-14);
  }
}

TEST(SelfContact, HasTheDerivativesOfItsEnergy) {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    const TwoBodies two = tilted_cubes(unit);
    const Vector x = two.surface.rest;
    ASSERT_GT(two.contact.energy(x), 0.0);
    const Vector gradient = two.gradient(x);
    DenseBlocks blocks(x.size() / 3);
    two.contact.add_hessian(x, false, blocks);
    const double h = 1e-6 * unit;
    Vector differences = Vector::Zero(x.size());
    Matrix second = Matrix::Zero(x.size(), x.size());
    for (Index k = 0; k < x.size(); ++k) {
      Vector a = x;
      Vector b = x;
      a[k] -= h;
      b[k] += h;
      differences[k] = (two.contact.energy(b) - two.contact.energy(a)) / (2.0 * h);
      second.col(k) = (two.gradient(b) - two.gradient(a)) / (2.0 * h);
    }
    EXPECT_LT((differences - gradient).norm(), 1e-6 * gradient.norm());
    EXPECT_LT((second - blocks.matrix).norm(), 1e-5 * second.norm());
    DenseBlocks convex(x.size() / 3);
    two.contact.add_hessian(x, true, convex);
    EXPECT_GT(symmetric_eigen(convex.matrix).values[0], -1e-10 * convex.matrix.norm());
  }
}

// However large the step: the energy is that of the ends, and neither a resultant nor a moment remains.
TEST(SelfContact, DiscreteGradientKeepsEnergyAndMomenta) {
  const TwoBodies two = tilted_cubes();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Vector from = two.surface.rest;
  for (const double size : {1e-9, 1e-3, 0.02, 0.3}) {
    Vector to = from;
    for (Index i = two.first; i < to.size() / 3; ++i) {
      vertex_block(to, i) += size * Vector3(0.3, -0.2, 1.0);
    }
    for (Index k = 0; k < to.size(); ++k) to[k] += 0.1 * size * uniform(random);
    ASSERT_LT(two.contact.penetrating_vertex(to), 0);
    const Vector mean = two.mean_gradient(from, to);
    const double change = two.contact.energy(to) - two.contact.energy(from);
    const double scale = two.contact.energy(to) + two.contact.energy(from);
    EXPECT_NEAR(mean.dot(to - from), change, 1e-13 * scale) << size;
    Vector3 force = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    const Vector middle = 0.5 * (from + to);
    for (Index i = 0; i < mean.size() / 3; ++i) {
      force += vertex_block(mean, i);
      moment += vertex_block(middle, i).cross(vertex_block(mean, i));
    }
    EXPECT_LT(force.norm(), 1e-12 * mean.norm());
    EXPECT_LT(moment.norm(), 1e-12 * mean.norm());
    if (size > 1e-6) continue;
    EXPECT_LT((mean - two.gradient(0.5 * (from + to))).norm(), 1e-6 * mean.norm());
  }
}

// A common motion of both bodies is no slip, and friction of any size has neither a resultant nor a moment.
TEST(SelfContact, SlipDoesNotKnowARigidMotion) {
  const TwoBodies two = tilted_cubes();
  const Vector from = two.surface.rest;
  Vector to = two.with_upper_moved({0.01, -0.02, 0.004});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (Index k = 0; k < to.size(); ++k) to[k] += 1e-3 * uniform(random);
  const Vector3 axis(0.3, -1.2, 0.7);
  const Vector3 drift(2.0, 1.0, -0.5);
  const Vector3 pull(0.4, 0.8, -0.3);
  for (const bool is_mean : {false, true}) {
    const Vector x = is_mean ? Vector(0.5 * (from + to)) : from;
    std::vector<ContactPoint> places;
    if (is_mean) {
      two.contact.mean_contact_points(from, to, places);
    } else {
      two.contact.contact_points(x, places);
    }
    ASSERT_GT(places.size(), 2U);
    const auto at = [&](Index i) { return Vector3(vertex_block(x, i)); };
    Vector forces = Vector::Zero(x.size());
    for (const ContactPoint& place : places) {
      EXPECT_NEAR(place.normal.norm(), 1.0, 1e-14);
      EXPECT_GT(place.force, 0.0);
      const Vector3 rigid = place.slip([&](Index i) { return Vector3(axis.cross(at(i)) + drift); });
      EXPECT_LT(rigid.norm(), 1e-13);
      // The upper body alone: its whole velocity, towards the side that it is on.
      const Vector3 seen =
          place.slip([&](Index i) { return i >= two.first ? drift : Vector3(Vector3::Zero()); });
      EXPECT_NEAR(std::min((seen - drift).norm(), (seen + drift).norm()), 0.0, 1e-13);
      Vector3 force = Vector3::Zero();
      Vector3 moment = Vector3::Zero();
      for (std::size_t k = 0; k < static_cast<std::size_t>(place.count); ++k) {
        const Vector3 part = place.part(k, pull);
        force += part;
        moment += at(place.vertices[k]).cross(part);
        vertex_block(forces, place.vertices[k]) += place.weights[k] * place.force * place.normal;
        for (std::size_t j = 0; j < static_cast<std::size_t>(place.count); ++j) {
          Matrix3 expected;
          for (int c = 0; c < 3; ++c) {
            expected.col(c) = place.part(j, place.slip([&](Index i) {
              return i == place.vertices[k] ? Vector3(Vector3::Unit(c)) : Vector3(Vector3::Zero());
            }));
          }
          EXPECT_LT((place.block(j, k, Matrix3::Identity()) - expected).norm(), 1e-13);
        }
      }
      EXPECT_LT(force.norm(), 1e-13);
      EXPECT_LT(moment.norm(), 1e-13);
    }
    // All pairs push here, so that the places have all of the forces.
    const Vector normal = is_mean ? two.mean_gradient(from, to) : two.gradient(x);
    EXPECT_LT((forces + normal).norm(), (is_mean ? 0.02 : 1e-12) * normal.norm());
  }
}

// Where a vertex is in a corner between two faces, a pair with their edge pulls. The places push with the same force.
TEST(SelfContact, PlacesInAReentrantCornerPush) {
  Triangles corner;
  corner.points = {{0, 0, 0}, {0, 0, 3}, {3, 0, 0}, {3, 0, 3}, {0, 3, 0}, {0, 3, 3}};
  corner.triangles = {{0, 1, 3}, {0, 3, 2}, {0, 4, 5}, {0, 5, 1}};
  Triangles tip;
  tip.points = {{0.05, 0.06, 1.0}, {2, 1, 0.5}, {2, 1.5, 1.5}, {1, 2, 1.1}};
  tip.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  const TwoBodies two(corner, tip);
  const Vector& x = two.surface.rest;
  ASSERT_LT(two.contact.penetrating_vertex(x), 0);
  std::vector<ContactPoint> places;
  two.contact.contact_points(x, places);
  ASSERT_FALSE(places.empty());
  double sum = 0.0;
  for (const ContactPoint& place : places) {
    EXPECT_GT(place.force, 0.0);
    // Pairs of edges have forces of their own.
    if (place.vertices[0] == two.first && place.weights[0] == 1.0) sum += place.force;
  }
  const double area = two.surface.areas[static_cast<std::size_t>(two.first)];
  const auto pressure = [](double d) { return -kLayer.slope(d); };
  const double pairs =
      0.5 * area * (pressure(0.05) + pressure(0.06) - pressure(std::hypot(0.05, 0.06)));
  EXPECT_NEAR(sum, pairs, 1e-9 * pairs);
}

// Two cubes that stand on an edge, one upon the other: nothing but the pair of these edges holds them.
TEST(SelfContact, SharpEdgesHoldWhatMeetsThem) {
  Triangles lower = cube_surface(1, 1.0);
  Triangles upper = cube_surface(1, 1.0);
  const double quarter = std::atan(1.0);
  for (Triangles* t : {&lower, &upper}) {
    for (Vector3& p : t->points) p -= Vector3::Constant(0.5);
  }
  turn_and_move(lower, Vector3::UnitX(), quarter, Vector3::Zero());
  turn_and_move(upper, Vector3::UnitY(), quarter, Vector3(0.0, 0.0, std::sqrt(2.0) + 0.03));
  const TwoBodies two(lower, upper);
  const Vector& x = two.surface.rest;
  ASSERT_LT(two.contact.penetrating_vertex(x), 0);
  EXPECT_NEAR(two.contact.smallest_gap(x), 0.03, 1e-14);
  double area = 0.0;
  int count = 0;
  for (Index i = 0; i < x.size() / 3; ++i) {
    const double z = x[3 * i + 2];
    if (std::abs(z - std::sqrt(0.5)) > 0.05) continue;
    area += two.surface.areas[static_cast<std::size_t>(i)];
    ++count;
  }
  ASSERT_EQ(count, 4);
  EXPECT_NEAR(two.contact.energy(x), 0.5 * area / 4.0 * kLayer.value(0.03),
              1e-12 * two.contact.energy(x));
}

TEST(SelfContact, SeesWhatPenetrates) {
  const TwoBodies two = tilted_cubes();
  EXPECT_LT(two.contact.penetrating_vertex(two.surface.rest), 0);
  EXPECT_GE(two.contact.penetrating_vertex(two.with_upper_moved({0.0, 0.0, -0.1})), 0);
  EXPECT_TRUE(std::isinf(two.contact.energy(two.with_upper_moved({0.0, 0.0, -0.1}))));
  // Beyond it, or inside without a crossing, nothing crosses.
  EXPECT_LT(two.contact.penetrating_vertex(two.with_upper_moved({0.0, 0.0, -5.0})), 0);
  // Two edges that cross in the air, without a vertex beyond a face.
  Triangles a;
  a.points = {{-1, 0, 0}, {1, 0, 0}, {0, 0, -1}};
  a.triangles = {{0, 1, 2}};
  Triangles b;
  b.points = {{0, -1, -0.1}, {0, 1, -0.1}, {0, 0, 1}};
  b.triangles = {{0, 1, 2}};
  EXPECT_GE(TwoBodies(a, b).contact.penetrating_vertex(TwoBodies(a, b).surface.rest), 0);
  Vector broken = two.surface.rest;
  broken[7] = std::nan("");
  EXPECT_EQ(two.contact.penetrating_vertex(broken), 2);
}

TEST(SelfContact, StepsEndBeforeTheFirstTouch) {
  const TwoBodies two = tilted_cubes();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Vector x = two.surface.rest;
  EXPECT_EQ(two.contact.longest_step(x, Vector::Zero(x.size())), 1.0);
  EXPECT_EQ(two.contact.longest_step(x, two.with_upper_moved({0.1, 0.2, 3.0}) - x), 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    // The whole upper body through the lower one, far beyond it, and turned.
    Vector d = two.with_upper_moved(Vector3(uniform(random), uniform(random), -5.0)) - x;
    for (Index k = 0; k < d.size(); ++k) d[k] += 0.3 * uniform(random);
    const double t = two.contact.longest_step(x, d);
    EXPECT_GT(t, 0.0);
    EXPECT_LT(t, 0.1);
    for (const double part : {0.5, 1.0}) {
      const Vector y = x + part * t * d;
      EXPECT_LT(two.contact.penetrating_vertex(y), 0);
      EXPECT_GT(two.contact.smallest_gap(y), 0.0);
    }
    Vector y = x + d;
    two.contact.clear_way(x, y);
    EXPECT_EQ(two.contact.longest_step(x, y - x), 1.0);
    EXPECT_LT(two.contact.penetrating_vertex(y), 0);
  }
}

// A body touches itself: the ends of a strip that is bent to a ring.
TEST(SelfContact, WithinABodyNeighboursAreNoPairs) {
  Triangles ring;
  constexpr int kCells = 24;
  for (int i = 0; i <= kCells; ++i) {
    const double angle = 6.2 * i / kCells;
    for (const double z : {0.0, 0.3}) ring.points.emplace_back(std::cos(angle), std::sin(angle), z);
  }
  for (Index i = 0; i < kCells; ++i) {
    ring.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    ring.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  const ContactSurface surface = contact_surface(ring);
  const std::vector<Index> one(surface.vertices.size(), 0);
  const SelfContact within(surface, one, true, kLayer);
  const SelfContact between(surface, one, false, kLayer);
  EXPECT_EQ(between.energy(surface.rest), 0.0);
  EXPECT_GT(within.energy(surface.rest), 0.0);
  Vector gradient = Vector::Zero(surface.rest.size());
  within.add_gradient(surface.rest, gradient);
  for (Index i = 0; i < gradient.size() / 3; ++i) {
    const bool at_the_ends = i < 2 || i >= 2 * kCells;
    EXPECT_EQ(vertex_block(gradient, i).norm() > 0.0, at_the_ends) << i;
  }
}

TEST(SelfContact, HasTheSameBitsOnAnyNumberOfThreads) {
  const TwoBodies two = tilted_cubes();
  const Vector x = two.surface.rest;
  const Vector y = two.with_upper_moved({0.01, 0.02, -0.01});
  std::vector<Vector> results;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    const TwoBodies fresh = tilted_cubes();
    Vector all(2 * x.size() + 2);
    all << fresh.gradient(x), fresh.mean_gradient(x, y), fresh.contact.energy(x),
        fresh.contact.longest_step(x, 3.0 * (y - x));
    results.push_back(all);
  }
  set_thread_count(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

}  // namespace
}  // namespace tetraction
