// Contact of a surface with a rigid mesh, through the interface of obstacles.
#include "dynamics/contact/mesh/mesh_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <iostream>
#include <random>

#include "core/decompositions.h"
#include "support/contact_surfaces.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TriangleMesh rigid_mesh(const Triangles& t) {
  return TriangleMesh(t.points, t.triangles);
}

void move(Triangles& t, const Vector3& by) {
  for (Vector3& p : t.points) p += by;
}

void roughen(Triangles& t, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  for (Vector3& p : t.points) p += Vector3(uniform(random), uniform(random), uniform(random));
}

Vector random_vector(std::mt19937& random, Index size, double by) {
  std::uniform_real_distribution<double> uniform(-by, by);
  return Vector::NullaryExpr(size, [&] { return uniform(random); });
}

// A cube whose corner and edges stand within the layer of a rough rigid cube.
struct Corner {
  explicit Corner(double unit = 1.0)
      : contact(rigid_mesh(obstacle(unit)), contact_surface(body(unit)), {0.15 * unit, 2e4}),
        x(contact_surface(body(unit)).rest) {}

  static Triangles obstacle(double unit) {
    Triangles t = cube_surface(3, 1.0);
    roughen(t, 41, 0.02);
    for (Vector3& p : t.points) p *= unit;
    return t;
  }
  static Triangles body(double unit) {
    Triangles t = cube_surface(2, 0.8);
    const Matrix3 turn =
        Eigen::AngleAxisd(0.4, Vector3(1, 0.3, -0.2).normalized()).toRotationMatrix();
    for (Vector3& p : t.points) p = turn * p;
    roughen(t, 42, 0.01);
    double lowest = kInfinite;
    for (const Vector3& p : t.points) lowest = std::min(lowest, p[2]);
    move(t, Vector3(0.35, 0.6, 1.07 - lowest));
    for (Vector3& p : t.points) p *= unit;
    return t;
  }

  MeshContact contact;
  Vector x;
};

TEST(MeshContact, FlatFloorGivesTheEnergyOfAPlane) {
  Triangles floor = flat_grid(7, 3.0);
  std::mt19937 random(43);
  std::uniform_real_distribution<double> uniform(-0.08, 0.08);
  for (Vector3& p : floor.points) p += Vector3(uniform(random), uniform(random), 0.0);
  Triangles body = cube_surface(4, 1.0);
  move(body, Vector3(1.03, 0.98, 0.0));
  const Barrier barrier{0.1, 1e5};
  const ContactSurface surface = contact_surface(body);
  const MeshContact contact(rigid_mesh(floor), surface, barrier);
  for (const double d : {1e-3, 0.02, 0.07, 0.0999}) {
    Vector x = surface.rest;
    double expected = 0.0;
    Vector force = Vector::Zero(x.size());
    for (Index i = 0; i < x.size() / 3; ++i) {
      x[3 * i + 2] += d;
      const double area = surface.areas[static_cast<std::size_t>(i)];
      expected += area * barrier.value(x[3 * i + 2]);
      force[3 * i + 2] = area * barrier.slope(x[3 * i + 2]);
    }
    EXPECT_NEAR(contact.energy(x), expected, 1e-12 * expected);
    Vector gradient = Vector::Zero(x.size());
    contact.add_gradient(x, gradient);
    EXPECT_LT((gradient - force).norm(), 1e-11 * force.norm());
    EXPECT_NEAR(contact.smallest_gap(x), d, 1e-14);
    std::vector<ContactPoint> points;
    contact.contact_points(x, points);
    double sum = 0.0;
    for (const ContactPoint& p : points) {
      EXPECT_EQ(p.count, 1);
      EXPECT_LT((p.normal - Vector3::UnitZ()).norm(), 1e-14);
      EXPECT_GE(p.force, 0.0);
      EXPECT_NEAR(p.stiffness,
                  surface.areas[static_cast<std::size_t>(p.vertices[0])] * barrier.curvature(d),
                  1e-9 * p.stiffness);
      sum += p.force;
    }
    EXPECT_NEAR(sum, -force.sum(), 1e-11 * sum);
    EXPECT_EQ(points.size(), 25U);
    // A slide over the edges of the floor, with a change of height.
    Vector y = x;
    for (Index i = 0; i < y.size() / 3; ++i) vertex_block(y, i) += Vector3(0.31, -0.27, 0.01);
    Vector mean = Vector::Zero(x.size());
    contact.add_discrete_gradient(x, y, mean);
    for (Index i = 0; i < y.size() / 3; ++i) {
      EXPECT_LT(vertex_block(mean, i).head<2>().norm(), 1e-11 * force.norm());
    }
  }
}

TEST(MeshContact, DerivativesAgreeWithDifferences) {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    const Corner c(unit);
    const Index size = c.x.size();
    const double energy = c.contact.energy(c.x);
    ASSERT_TRUE(std::isfinite(energy));
    ASSERT_GT(energy, 0.0);
    Vector gradient = Vector::Zero(size);
    c.contact.add_gradient(c.x, gradient);
    DenseBlocks exact(size / 3);
    c.contact.add_hessian(c.x, false, exact);
    DenseBlocks convex(size / 3);
    c.contact.add_hessian(c.x, true, convex);
    const double h = 1e-7 * unit;
    Vector slope(size);
    Matrix bend(size, size);
    for (Index k = 0; k < size; ++k) {
      Vector a = c.x;
      Vector b = c.x;
      a[k] -= h;
      b[k] += h;
      slope[k] = (c.contact.energy(b) - c.contact.energy(a)) / (2.0 * h);
      Vector ga = Vector::Zero(size);
      Vector gb = Vector::Zero(size);
      c.contact.add_gradient(a, ga);
      c.contact.add_gradient(b, gb);
      bend.col(k) = (gb - ga) / (2.0 * h);
    }
    EXPECT_LT((slope - gradient).norm(), 1e-6 * gradient.norm());
    EXPECT_LT((bend - exact.matrix).norm(), 1e-5 * bend.norm());
    EXPECT_GT(symmetric_eigen(convex.matrix).values[0], -1e-12 * convex.matrix.norm());
    EXPECT_LT((exact.matrix - exact.matrix.transpose()).norm(), 1e-12 * bend.norm());
  }
}

TEST(MeshContact, DiscreteGradientGivesTheChangeOfEnergy) {
  std::mt19937 random(44);
  double worst = 0.0;
  int compared = 0;
  for (const double unit : {1e-3, 1.0, 1e3}) {
    const Corner c(unit);
    for (int trial = 0; trial < 200; ++trial) {
      const Vector from = c.x + random_vector(random, c.x.size(), 0.02 * unit);
      const Vector to =
          from + random_vector(random, c.x.size(), 0.05 * unit * std::pow(10.0, -(trial % 8)));
      const double a = c.contact.energy(from);
      const double b = c.contact.energy(to);
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      Vector mean = Vector::Zero(c.x.size());
      c.contact.add_discrete_gradient(from, to, mean);
      worst = std::max(worst, std::abs(mean.dot(to - from) - (b - a)) / std::max(a, b));
      ++compared;
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_LT(worst, 1e-12);
}

TEST(MeshContact, DiscreteHessianIsNearTheDerivative) {
  const Corner c;
  std::mt19937 random(45);
  const Index size = c.x.size();
  for (int trial = 0; trial < 5; ++trial) {
    const Vector to = c.x + random_vector(random, size, 0.003);
    DenseBlocks exact(size / 3);
    c.contact.add_discrete_hessian(c.x, to, false, exact);
    DenseBlocks convex(size / 3);
    c.contact.add_discrete_hessian(c.x, to, true, convex);
    Matrix bend(size, size);
    for (Index k = 0; k < size; ++k) {
      Vector a = to;
      Vector b = to;
      a[k] -= 1e-7;
      b[k] += 1e-7;
      Vector ga = Vector::Zero(size);
      Vector gb = Vector::Zero(size);
      c.contact.add_discrete_gradient(c.x, a, ga);
      c.contact.add_discrete_gradient(c.x, b, gb);
      bend.col(k) = (gb - ga) / 2e-7;
    }
    bend = (0.5 * (bend + bend.transpose())).eval();
    EXPECT_LT((bend - exact.matrix).norm(), 0.05 * bend.norm());
    EXPECT_GT(symmetric_eigen(convex.matrix).values[0], -1e-12 * convex.matrix.norm());
  }
}

TEST(MeshContact, PenetrationOfEachKindIsFound) {
  const Triangles block = cube_surface(1, 1.0);
  const Barrier barrier{0.01, 1e5};
  // A vertex inside.
  Triangles body = cube_surface(1, 0.5);
  move(body, Vector3(0.9, 0.9, 0.9));
  ContactSurface surface = contact_surface(body);
  EXPECT_GE(MeshContact(rigid_mesh(block), surface, barrier).penetrating_vertex(surface.rest), 0);
  EXPECT_EQ(MeshContact(rigid_mesh(block), surface, barrier).energy(surface.rest), kInfinite);
  // Corners of the obstacle through a face of the body, no vertex of which is near.
  body = cube_surface(1, 10.0);
  move(body, Vector3(-5, -5, 0.99));
  surface = contact_surface(body);
  EXPECT_GE(MeshContact(rigid_mesh(block), surface, barrier).penetrating_vertex(surface.rest), 0);
  // Edges across edges: no vertex of either is inside the other.
  Triangles turned = cube_surface(1, 1.0);
  const Matrix3 turn = Eigen::AngleAxisd(0.785, Vector3::UnitZ()).toRotationMatrix();
  for (Vector3& p : turned.points) {
    p = turn * (p - Vector3::Constant(0.5)) + Vector3(0.5, 0.5, 0.5);
    p[2] = 3.0 * (p[2] - 0.5) + 0.5;
  }
  surface = contact_surface(turned);
  EXPECT_GE(MeshContact(rigid_mesh(block), surface, barrier).penetrating_vertex(surface.rest), 0);
  // A vertex on a face: it touches.
  body = cube_surface(1, 0.5);
  move(body, Vector3(0.2, 0.2, 1.0));
  surface = contact_surface(body);
  EXPECT_GE(MeshContact(rigid_mesh(block), surface, barrier).penetrating_vertex(surface.rest), 0);
  // Just above, and wholly inside a container.
  move(body, Vector3(0, 0, 1e-9));
  surface = contact_surface(body);
  EXPECT_EQ(MeshContact(rigid_mesh(block), surface, barrier).penetrating_vertex(surface.rest), -1);
  body = cube_surface(1, 0.5);
  move(body, Vector3(0.2, 0.2, 0.2));
  surface = contact_surface(body);
  const MeshContact container(rigid_mesh(block), surface, {0.25, 1e5});
  EXPECT_EQ(container.penetrating_vertex(surface.rest), -1);
  EXPECT_TRUE(std::isfinite(container.energy(surface.rest)));
  EXPECT_NEAR(container.smallest_gap(surface.rest), 0.2, 1e-14);
  // Numbers that are none.
  Vector x = surface.rest;
  x[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(container.penetrating_vertex(x), 2);
  EXPECT_EQ(container.energy(x), kInfinite);
  EXPECT_EQ(container.longest_step(surface.rest, x), 0.0);
}

// Random moves right through the obstacle, also of bodies stretched to needles: what longest_step() and
// clear_way() leave is free at all points of the way.
TEST(MeshContact, NothingCrossesOnTheWaysThatAreAllowed) {
  std::mt19937 random(46);
  for (int trial = 0; trial < 60; ++trial) {
    Triangles obstacle = cube_surface(2, 1.0);
    roughen(obstacle, 100U + static_cast<unsigned>(trial), 0.1);
    if (trial % 3 == 0) {
      for (Vector3& p : obstacle.points) p[0] = 0.5 + 0.02 * (p[0] - 0.5);
    }
    Triangles body = cube_surface(2, 0.6);
    roughen(body, 200U + static_cast<unsigned>(trial), 0.05);
    if (trial % 2 == 0) {
      for (Vector3& p : body.points) p[1] *= 0.01;
    }
    move(body, Vector3(0.2, 0.3, 1.3));
    const ContactSurface surface = contact_surface(body);
    const MeshContact contact(rigid_mesh(obstacle), surface, {0.1, 1e5});
    Vector x = surface.rest;
    ASSERT_EQ(contact.penetrating_vertex(x), -1);
    for (int step = 0; step < 4; ++step) {
      Vector d = random_vector(random, x.size(), 0.4);
      for (Index i = 0; i < d.size() / 3; ++i) vertex_block(d, i)[2] -= 1.0;
      const double t = contact.longest_step(x, d);
      ASSERT_GT(t, 0.0);
      for (int k = 1; k <= 40; ++k) {
        ASSERT_EQ(contact.penetrating_vertex(x + (t * k / 40.0) * d), -1) << trial << " " << step;
      }
      Vector y = x + d;
      contact.clear_way(x, y);
      for (int k = 1; k <= 40; ++k) {
        ASSERT_EQ(contact.penetrating_vertex(x + (k / 40.0) * (y - x)), -1) << trial;
      }
      EXPECT_GE((y - x).norm(), 0.0);
      EXPECT_EQ(contact.longest_step(x, y - x), 1.0);
      x = y;
      ASSERT_TRUE(std::isfinite(contact.energy(x)));
    }
  }
}

// Vertices that are far from the obstacle keep their way.
TEST(MeshContact, ClearWayChangesLittle) {
  Triangles body = cube_surface(4, 1.0);
  move(body, Vector3(1, 1, 0.05));
  const ContactSurface surface = contact_surface(body);
  const Triangles floor = flat_grid(5, 3.0);
  const MeshContact contact(rigid_mesh(floor), surface, {0.1, 1e5});
  const Vector from = surface.rest;
  Vector x = from;
  for (Index i = 0; i < x.size() / 3; ++i) x[3 * i + 2] -= 0.1;
  const Vector wanted = x;
  contact.clear_way(from, x);
  for (Index i = 0; i < x.size() / 3; ++i) {
    if (from[3 * i + 2] > 0.2) {
      EXPECT_EQ(x[3 * i + 2], wanted[3 * i + 2]);
    } else {
      EXPECT_GT(x[3 * i + 2], 0.0);
      EXPECT_LT(x[3 * i + 2], 0.02);
    }
  }
  const double t = contact.longest_step(from, wanted - from);
  EXPECT_GT(t, 0.4);
  EXPECT_LT(t, 0.5);
}

TEST(MeshContact, ContactPointsHaveTheForcesOfTheGradient) {
  const Corner c;
  std::vector<ContactPoint> points;
  c.contact.contact_points(c.x, points);
  ASSERT_GT(points.size(), 2U);
  Vector forces = Vector::Zero(c.x.size());
  for (const ContactPoint& p : points) {
    EXPECT_GE(p.force, 0.0);
    EXPECT_GE(p.stiffness, 0.0);
    EXPECT_NEAR(p.normal.norm(), 1.0, 1e-14);
    double sum = 0.0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(p.count); ++k) {
      vertex_block(forces, p.vertices[k]) += p.force * p.weights[k] * p.normal;
      sum += p.weights[k];
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
  Vector gradient = Vector::Zero(c.x.size());
  c.contact.add_gradient(c.x, gradient);
  // The torque of the mollifier and reentrant edges are not in the points.
  EXPECT_LT((forces + gradient).norm(), 0.05 * gradient.norm());
  std::vector<ContactPoint> mean;
  c.contact.mean_contact_points(c.x, c.x, mean);
  ASSERT_EQ(mean.size(), points.size());
  for (std::size_t k = 0; k < mean.size(); ++k) {
    EXPECT_EQ(mean[k].vertices, points[k].vertices);
    EXPECT_NEAR(mean[k].force, points[k].force, 1e-9 * points[k].force);
    EXPECT_LT((mean[k].normal - points[k].normal).norm(), 1e-8);
    EXPECT_NEAR(mean[k].stiffness, 0.5 * points[k].stiffness, 1e-7 * points[k].stiffness);
  }
}

// Over a flat floor each vertex of the lower face has its distance, its area and its speed downwards, whatever its way
// along the floor; and the stiffness of its layer is the Hessian's.
TEST(MeshContact, KnowsWhatComesNear) {
  const Barrier barrier{0.1, 1e5};
  Triangles body = cube_surface(2, 1.0);
  move(body, Vector3(1, 1, 0));
  const ContactSurface surface = contact_surface(body);
  const MeshContact contact(rigid_mesh(flat_grid(3, 3.0)), surface, barrier);
  for (const double d : {0.095, 0.05, 0.01}) {
    Vector x = surface.rest;
    for (Index i = 0; i < x.size() / 3; ++i) x[3 * i + 2] += d;
    DenseBlocks hessian(x.size() / 3);
    contact.add_hessian(x, true, hessian);
    std::vector<Approach> found;
    contact.approaching(x, Vector3(7.0, -3.0, -2.0).replicate(x.size() / 3, 1), 0.2, found);
    std::vector<bool> seen(static_cast<std::size_t>(x.size() / 3), false);
    for (const Approach& each : found) {
      if (std::abs(each.distance - d) > 1e-12) continue;
      seen[static_cast<std::size_t>(each.vertex)] = true;
      EXPECT_NEAR(each.speed, 2.0, 1e-9);
      const double k = hessian.matrix(3 * each.vertex + 2, 3 * each.vertex + 2);
      EXPECT_NEAR(k, each.weight * barrier.curvature(d), 1e-9 * k);
    }
    for (Index i = 0; i < x.size() / 3; ++i) {
      EXPECT_EQ(seen[static_cast<std::size_t>(i)], surface.rest[3 * i + 2] == 0.0) << i;
    }
    found.clear();
    contact.approaching(x, x, 0.5 * d, found);
    EXPECT_TRUE(found.empty());
  }
}

TEST(MeshContact, SameBitsForAnyNumberOfThreads) {
  Triangles body = cube_surface(16, 1.0);
  roughen(body, 47, 0.005);
  move(body, Vector3(0.4, 0.4, 1.02));
  Triangles obstacle = cube_surface(20, 2.0);
  roughen(obstacle, 48, 0.005);
  move(obstacle, Vector3(0, 0, -1));
  const ContactSurface surface = contact_surface(body);
  double energies[2];
  Vector gradients[2];
  double steps[2];
  for (const int run : {0, 1}) {
    set_thread_count(run == 0 ? 1 : 7);
    const MeshContact contact(rigid_mesh(obstacle), surface, {0.1, 1e5});
    energies[run] = contact.energy(surface.rest);
    gradients[run] = Vector::Zero(surface.rest.size());
    contact.add_gradient(surface.rest, gradients[run]);
    contact.add_discrete_gradient(surface.rest, surface.rest + 0.001 * gradients[run].normalized(),
                                  gradients[run]);
    steps[run] = contact.longest_step(surface.rest, -0.1 * gradients[run].normalized());
  }
  set_thread_count(0);
  ASSERT_TRUE(std::isfinite(energies[0]));
  ASSERT_GT(energies[0], 0.0);
  EXPECT_EQ(energies[0], energies[1]);
  EXPECT_EQ(gradients[0], gradients[1]);
  EXPECT_EQ(steps[0], steps[1]);
}

// What the parts cost, printed; nothing is asserted about times.
TEST(MeshContact, CostOfManyVertices) {
  for (const int n : {41, 100}) {
    Triangles body = cube_surface(n, 1.0);
    move(body, Vector3(0.513, 0.487, 1.0 + 0.03 / n));
    Triangles obstacle = cube_surface(n, 2.0);
    roughen(obstacle, 49, 0.001 / n);
    move(obstacle, Vector3(0, 0, -1));
    const ContactSurface surface = contact_surface(body);
    const auto now = [] { return std::chrono::steady_clock::now(); };
    const auto report = [&](const char* what, auto start) {
      std::cout << what << " " << std::chrono::duration<double, std::milli>(now() - start).count()
                << " ms\n";
    };
    auto start = now();
    const MeshContact contact(rigid_mesh(obstacle), surface, {0.1 / n, 1e5});
    std::cout << surface.vertices.size() << " vertices: ";
    report("construction", start);
    start = now();
    const double energy = contact.energy(surface.rest);
    report("energy", start);
    EXPECT_TRUE(std::isfinite(energy));
    EXPECT_GT(energy, 0.0);
    start = now();
    Vector gradient = Vector::Zero(surface.rest.size());
    contact.add_gradient(surface.rest, gradient);
    report("gradient", start);
    const Vector d = (0.3 / n) * gradient / gradient.cwiseAbs().maxCoeff();
    start = now();
    const double t = contact.longest_step(surface.rest, d);
    report("longest step", start);
    EXPECT_GT(t, 0.0);
    start = now();
    contact.add_discrete_gradient(surface.rest, surface.rest + 0.5 * t * d, gradient);
    report("discrete gradient", start);
  }
}

}  // namespace
}  // namespace tetraction
