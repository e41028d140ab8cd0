// Contact with obstacles at rest and in motion: derivatives, the discrete gradient, ways, and what is refused.
#include "tetraction/dynamics/contact/contact.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/decompositions.h"
#include "support/bodies.h"
#include "support/messages.h"
#include "support/scene_parts.h"
#include "tetraction/dynamics/contact/barrier.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

using namespace testing_support;

// The box [0, 0.3] × [0, 0.2] × [0, 0.25] m, of which every obstacle has many vertices in its layer.
TetMesh touching_box(bool is_quadratic) {
  TetMesh mesh = generate_box({0.3, 0.2, 0.25}, {2, 2, 2});
  return is_quadratic ? with_edge_vertices(std::move(mesh)) : mesh;
}

Obstacle obstacle_around_box(const TetMesh& mesh, const ObstacleShape& shape) {
  Obstacle obstacle;
  obstacle.name = "wall";
  obstacle.shape = shape;
  obstacle.thickness = 0.15;
  obstacle.stiffness = 2e3;
  obstacle.surface = boundary_faces(mesh);
  return obstacle;
}

struct ContactCase {
  std::string name;
  ObstacleShape shape;
  bool moves = false;
  bool is_quadratic = false;
};

std::vector<ContactCase> contact_cases() {
  const Vector3 center(0.15, 0.1, 0.12);
  const std::vector<std::pair<std::string, ObstacleShape>> shapes{
      {"plane", PlaneShape{{0.1, -0.05, 0.1}, {0.1, 1.0, 0.2}}},
      {"sphere", SphereShape{{0.15, -0.5, 0.12}, 0.47, false}},
      {"sphere_inside", SphereShape{center, 0.26, true}},
      {"cylinder", CylinderShape{{0.15, -0.35, 0.0}, {0.2, 0.1, 1.0}, 0.3, false}},
      {"cylinder_inside", CylinderShape{center, {1.0, 0.2, -0.3}, 0.24, true}},
      {"room", RoomShape{{-0.06, -0.05, -0.04}, {0.38, 0.27, 0.33}}}};
  std::vector<ContactCase> all;
  for (const auto& [name, shape] : shapes) {
    all.push_back({name, shape});
    all.push_back({name + "_that_moves", shape, true});
  }
  all.push_back({"quadratic", shapes[1].second, true, true});
  return all;
}

class Contacts : public testing::TestWithParam<ContactCase> {
 protected:
  Contacts()
      : mesh_(touching_box(GetParam().is_quadratic)),
        mass_(Vector::Ones(mesh_.vertex_count())),
        obstacle_(obstacle_around_box(mesh_, GetParam().shape)) {
    if (GetParam().moves) {
      obstacle_.motion.velocity = {0.7, -0.4, 0.2};
      obstacle_.motion.angular_velocity = {0.5, 1.8, -0.9};
      obstacle_.motion.about = {0.1, 0.3, -0.2};
      obstacle_.motion.offset = {0.004, 0.01, -0.003};
    }
  }
  // A state near the obstacle at a time: positions that differ from those at rest by up to 6 mm, moved with it.
  Vector state_at(double time, unsigned seed) const {
    Vector x = jiggled(mesh_.rest_positions(), 6e-3, seed);
    const ObstacleFrame frame = frame_at(obstacle_.motion, time);
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      vertex_block(x, v) = frame.to_world(vertex_block(x, v));
    }
    return x;
  }
  Contact contact() const { return {mesh_, {obstacle_}}; }
  ForcePoint at(const Vector& x, double time) const { return {mass_, x, time}; }

  TetMesh mesh_;
  Vector mass_;
  Obstacle obstacle_;
};

TEST_P(Contacts, HaveTheDerivativesOfTheirEnergy) {
  const Contact contact = this->contact();
  const Vector x = state_at(0.3, 1);
  ASSERT_GT(contact.energy(at(x, 0.3)), 0.1);
  const ForceTermErrors errors =
      check_derivatives(contact, at(x, 0.3), Vector::Zero(x.size()), 1e-6);
  EXPECT_GT(errors.potential.gradient_norm, 1.0);
  EXPECT_LT(errors.potential.gradient, 1e-7);
  EXPECT_LT(errors.potential.hessian, 1e-6);
  EXPECT_GT(errors.potential.least_eigenvalue, -1e-13);
}

// Seen by an obstacle that moves, a body that moves with it is at rest.
TEST_P(Contacts, HaveTheSameEnergyInEveryFrame) {
  const Contact contact = this->contact();
  const double start = contact.energy(at(state_at(0.0, 2), 0.0));
  EXPECT_NEAR(contact.energy(at(state_at(0.7, 2), 0.7)), start, 1e-12 * start);
  const double gap = contact.smallest_gap(at(state_at(0.0, 2), 0.0));
  EXPECT_NEAR(contact.smallest_gap(at(state_at(0.7, 2), 0.7)), gap, 1e-14);
}

TEST_P(Contacts, HaveADiscreteGradientThatGivesTheChangeOfTheEnergy) {
  const Contact contact = this->contact();
  constexpr double kBegin = 0.2;
  const Vector from = state_at(kBegin, 3);
  // A step, a hundredth of a second that hardly moves, and none at all.
  for (const double step : {0.05, 1e-7, 0.0}) {
    const double end = kBegin + step;
    const Vector to = step > 0.01 ? state_at(end, 4) : Vector(state_at(end, 3));
    Vector mean = Vector::Zero(from.size());
    contact.add_discrete_gradient(at(from, kBegin), at(to, end), mean);
    const double before = contact.energy(at(from, kBegin));
    const double after = contact.energy(at(to, end));
    const double work = contact.driven_work(at(from, kBegin), at(to, end));
    EXPECT_NEAR(mean.dot(to - from), after - before - work, 2e-14 * (before + after)) << step;
    if (!GetParam().moves) {
      EXPECT_EQ(work, 0.0);
    }
    // The mean forces of the obstacle are minus the sum.
    const std::vector<ObstacleForce> forces = contact.mean_forces(at(from, kBegin), at(to, end));
    ASSERT_EQ(forces.size(), 1U);
    ObstacleForce sum;
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      const Vector3 middle = 0.5 * (vertex_block(from, v) + vertex_block(to, v));
      sum.force -= vertex_block(mean, v);
      sum.moment -= middle.cross(vertex_block(mean, v));
    }
    EXPECT_LT((forces[0].force - sum.force).norm(), 1e-12 * mean.norm());
    EXPECT_LT((forces[0].moment - sum.moment).norm(), 1e-12 * mean.norm());
    if (step > 0.01) continue;
    Vector gradient = Vector::Zero(from.size());
    contact.add_gradient(at(from, kBegin), gradient);
    EXPECT_LT((mean - gradient).norm(), 1e-4 * gradient.norm());
  }
}

// An obstacle that only translates does the work of its force: the impulse times its velocity.
TEST(Contact, CountsTheWorkOfAnObstacleThatTranslates) {
  const TetMesh mesh = touching_box(false);
  Obstacle obstacle = obstacle_around_box(mesh, PlaneShape{{0.1, -0.05, 0.1}, {0.1, 1.0, 0.2}});
  obstacle.motion.velocity = {0.3, 0.2, -0.4};
  const Contact contact(mesh, {obstacle});
  const Vector mass = Vector::Ones(mesh.vertex_count());
  const Vector from = jiggled(mesh.rest_positions(), 6e-3, 5);
  const Vector to = jiggled(mesh.rest_positions(), 6e-3, 6);
  const ForcePoint begin{mass, from, 0.0};
  const ForcePoint end{mass, to, 0.02};
  const ObstacleForce force = contact.mean_forces(begin, end)[0];
  const double work = contact.driven_work(begin, end);
  EXPECT_GT(std::abs(work), 1e-3);
  EXPECT_NEAR(work, 0.02 * force.force.dot(obstacle.motion.velocity),
              1e-13 * std::abs(work) + 1e-15);
}

TEST_P(Contacts, HaveTheDerivativeOfTheDiscreteGradient) {
  const Contact contact = this->contact();
  constexpr double kBegin = 0.2;
  constexpr double kEnd = 0.23;
  const Vector from = state_at(kBegin, 7);
  const Vector to = state_at(kEnd, 8);
  HessianBlocks exact;
  exact.reset(mesh_.vertex_count());
  contact.add_discrete_hessian(at(from, kBegin), at(to, kEnd), HessianForm::kExact, false, exact);
  HessianBlocks convex;
  convex.reset(mesh_.vertex_count());
  contact.add_discrete_hessian(at(from, kBegin), at(to, kEnd), HessianForm::kConvex, true, convex);
  constexpr double kStep = 1e-6;
  for (Index i = 0; i < to.size(); ++i) {
    Vector ahead = Vector::Zero(to.size());
    Vector behind = Vector::Zero(to.size());
    Vector x = to;
    x[i] = to[i] + kStep;
    contact.add_discrete_gradient(at(from, kBegin), at(x, kEnd), ahead);
    x[i] = to[i] - kStep;
    contact.add_discrete_gradient(at(from, kBegin), at(x, kEnd), behind);
    Vector column = Vector::Zero(to.size());
    exact.add_product(Vector::Unit(to.size(), i), column);
    EXPECT_LT((column - (ahead - behind) / (2.0 * kStep)).norm(), 1e-4 + 1e-6 * column.norm()) << i;
  }
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    const Matrix block = convex.diagonal(v);
    EXPECT_EQ(block, block.transpose());
    EXPECT_GT(symmetric_eigen(block).values.minCoeff(), -1e-9);
  }
}

// The way is that which the obstacle sees: a body that moves with it crosses nothing.
TEST_P(Contacts, CutWaysWhereTheObstacleSeesThem) {
  const Contact contact = this->contact();
  const Vector from = state_at(0.1, 9);
  const Vector with_it = state_at(0.6, 9);
  EXPECT_FALSE(contact.crossing(at(from, 0.1), at(with_it, 0.6)).has_value());
  Vector x = with_it;
  EXPECT_FALSE(contact.clear_way(at(from, 0.1), at(with_it, 0.6), x));
  EXPECT_EQ(x, with_it);
  // Everything jumps by two metres in many directions.
  for (const Vector3& jump : {Vector3(0, -2, 0), Vector3(2, 0.1, 0), Vector3(0.3, 1, -2)}) {
    Vector far = with_it;
    for (Index v = 0; v < mesh_.vertex_count(); ++v) vertex_block(far, v) += jump;
    x = far;
    const bool crosses = contact.crossing(at(from, 0.1), at(far, 0.6)).has_value();
    if (crosses) {
      EXPECT_TRUE(contact.clear_way(at(from, 0.1), at(far, 0.6), x));
    }
    contact.clear_way(at(from, 0.1), at(far, 0.6), x);
    EXPECT_FALSE(contact.crossing(at(from, 0.1), at(x, 0.6)).has_value());
    EXPECT_TRUE(contact.penetrations(at(x, 0.6)).empty());
    // A part of the displacement at one instant.
    const Vector displacement = far - with_it;
    const double longest = contact.longest_step(at(with_it, 0.6), displacement);
    ASSERT_GT(longest, 0.0);
    if (longest > 1.0) continue;
    EXPECT_EQ(contact.undefined_vertex(at(with_it + 0.999 * longest * displacement, 0.6)), -1);
    EXPECT_GE(contact.undefined_vertex(at(with_it + 1.001 * longest * displacement, 0.6)), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, Contacts, testing::ValuesIn(contact_cases()),
                         [](const auto& test) { return test.param.name; });

// A body that jumps over a ball and a plate: the ball has an inside, and must not hide the plate.
TEST(Contact, FindsWhatIsCrossedWithoutAnInside) {
  const TetMesh mesh = touching_box(false);
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  Vector beyond = rest;
  for (Index v = 0; v < mesh.vertex_count(); ++v) beyond[3 * v + 1] -= 8.0;
  const ForcePoint from{mass, rest, 0.0};
  const ForcePoint to{mass, beyond, 0.0};
  Obstacle ball = obstacle_around_box(mesh, SphereShape{{0.1, -2.0, 0.1}, 1.0, false});
  ball.name = "ball";
  const Obstacle plate = obstacle_around_box(
      mesh,
      MeshShape{{{-9, -4, -9}, {9, -4, -9}, {9, -4, 9}, {-9, -4, 9}}, {{0, 1, 2}, {0, 2, 3}}});
  const Contact both(mesh, {ball, plate});
  const auto first = both.crossing(from, to);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->obstacle, 0U);
  const auto crossed = both.crossing_without_inside(from, to);
  ASSERT_TRUE(crossed.has_value());
  EXPECT_EQ(crossed->obstacle, 1U);
  EXPECT_FALSE(Contact(mesh, {ball}).crossing_without_inside(from, to).has_value());
  EXPECT_FALSE(both.crossing_without_inside(from, from).has_value());
}

// Of a uniform pressure: every vertex has the same −U′, and the forces are those of a pressure on the face.
TEST(Contact, HasTheAreasOfTheFaces) {
  for (const bool is_quadratic : {false, true}) {
    // Where the guards of corners are at rest.
    const double distance = is_quadratic ? 0.08 : 0.03;
    const TetMesh mesh = touching_box(is_quadratic);
    Obstacle obstacle =
        obstacle_around_box(mesh, PlaneShape{{0.0, -distance, 0.0}, {0.0, 4.0, 0.0}});
    obstacle.surface = select_triangles(mesh, SelectFaces{{0.0, -1.0, 0.0}, {}});
    const Contact contact(mesh, {obstacle});
    const Vector rest = mesh.rest_positions();
    const Vector mass = Vector::Ones(mesh.vertex_count());
    const double p = -Barrier{obstacle.thickness, obstacle.stiffness}.slope(distance);
    const ForcePoint at{mass, rest, 0.0};
    const ObstacleForce force = contact.forces(at)[0];
    EXPECT_NEAR(force.force.y(), p * 0.3 * 0.25, 1e-12 * p);
    EXPECT_LT(force.force.cwiseProduct(Vector3(1, 0, 1)).norm(), 1e-12 * p);
    // The resultant acts in the middle of the face.
    EXPECT_NEAR(force.moment.z(), 0.15 * force.force.y(), 1e-12 * p);
    EXPECT_NEAR(force.moment.x(), -0.125 * force.force.y(), 1e-12 * p);
    Vector pressure;
    Vector gap;
    contact.fields(at, pressure, gap);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const bool touches = rest[3 * v + 1] == 0.0;
      EXPECT_NEAR(pressure[v], touches ? p : 0.0, 1e-12 * p) << v;
      if (touches) {
        EXPECT_NEAR(gap[v], distance, 1e-15);
      }
    }
    EXPECT_NEAR(contact.smallest_gap(at), distance, 1e-15);
  }
}

// A vertex that comes down on the layer with the speed s presses it until it has the energy m s²/(2w), or the pressure
// of the impact of a half-space, ρ c s.
TEST(Contact, ForetellsTheLimitOfAnImpact) {
  const TetMesh mesh = touching_box(false);
  Obstacle obstacle = obstacle_around_box(mesh, PlaneShape{{0.0, -0.03, 0.0}, {0.0, 1.0, 0.0}});
  obstacle.surface = select_triangles(mesh, SelectFaces{{0.0, -1.0, 0.0}, {}});
  const Barrier layer{obstacle.thickness, obstacle.stiffness};
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  const double pressure = -layer.slope(0.03);
  // Their forces tell the areas.
  const Contact touching(mesh, {obstacle});
  Vector gradient = Vector::Zero(rest.size());
  touching.add_gradient({mass, rest, 0.0}, gradient);
  const double gap = 1.0001 * layer.thickness;
  obstacle.shape = PlaneShape{{0.0, -gap, 0.0}, {0.0, 1.0, 0.0}};
  const Contact contact(mesh, {obstacle});
  const ForcePoint at{mass, rest, 0.0};
  constexpr double kSpeed = 0.5;
  constexpr double kStep = 1e-4;
  const Vector fall = Vector3(0.0, -kSpeed, 0.0).replicate(mesh.vertex_count(), 1);
  for (const double impedance : {0.0, 1e3, 1e6}) {
    for (const double critical : {1e-4, 0.05}) {
      double rate = 0.0;
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const double area = -gradient[3 * v + 1] / pressure;
        if (!(area > 0.0)) continue;
        const double d = std::min(layer.distance_at_energy(0.5 * kSpeed * kSpeed / area),
                                  layer.distance_at_pressure(impedance * kSpeed));
        rate = std::max(rate, 0.25 * area * layer.curvature(d));
      }
      double limit = 1.0 / std::sqrt(1.0 / (critical * critical) + rate);
      limit = std::min(limit, layer.thickness / (4.0 * kSpeed));
      const auto forecast = contact.impact_forecast(at, fall, impedance, critical, kStep);
      EXPECT_NEAR(forecast.limit, limit, 1e-6 * limit) << impedance;
      EXPECT_EQ(forecast.valid_for, 0.0);
    }
  }
  // What goes away, or rests beyond the layer, sets no limit.
  EXPECT_EQ(contact.impact_forecast(at, -fall, 1e3, 0.05, kStep).limit, 0.05);
  EXPECT_EQ(contact.impact_forecast(at, 0.0 * fall, 1e3, 0.05, kStep).limit, 0.05);
  // In the layer there is the limit of its stiffness.
  EXPECT_LT(touching.impact_forecast(at, 0.0 * fall, 1e3, 0.05, kStep).limit, 0.05);
}

// However far away an obstacle is, it must not shorten steps; and nothing may come near it unseen.
TEST(Contact, ForetellsHowLongNothingComesNear) {
  const TetMesh mesh = touching_box(false);
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  const Vector fall = Vector3(0.0, -3.0, 0.0).replicate(mesh.vertex_count(), 1);
  constexpr double kStep = 1e-3;
  for (const double depth : {0.3, 0.34, 1.0, 1e6}) {
    Obstacle obstacle = obstacle_around_box(mesh, PlaneShape{{0.0, -depth, 0.0}, {0, 1, 0}});
    const Contact contact(mesh, {obstacle});
    const auto forecast = contact.impact_forecast({mass, rest, 0.0}, fall, 1e6, 0.05, kStep);
    EXPECT_EQ(forecast.limit, 0.05);
    // At twice the speed the body comes no nearer than 1.5 layers.
    const double left = depth - 1.5 * obstacle.thickness;
    EXPECT_LE(6.0 * forecast.valid_for, left * (1.0 + 1e-9));
    EXPECT_NEAR(forecast.valid_for, std::min(16.0 * kStep, left / 6.0), 1e-9);
    // A floor that comes up at 30 m/s is nearer in time.
    obstacle.motion.velocity = {0.0, 30.0, 0.0};
    const Contact moving(mesh, {obstacle});
    EXPECT_NEAR(moving.impact_forecast({mass, rest, 0.0}, fall, 1e6, 0.05, kStep).valid_for,
                std::min(16.0 * kStep, left / 66.0), 1e-9);
  }
}

// A forecast whose limit knows of a vertex that comes fast is not valid for longer than now, although the vertex is
// farther away than what rests. What rests near a layer may begin to move.
TEST(Contact, ForeseesWhatIsFastAndWhatMayBeginToMove) {
  const TetMesh mesh = touching_box(false);
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  constexpr double kStep = 1e-3;
  Obstacle obstacle = obstacle_around_box(mesh, PlaneShape{{0.0, 0.0, 0.0}, {0, 1, 0}});
  const double d = obstacle.thickness;
  const auto forecast = [&](double depth, double speed) {
    obstacle.shape = PlaneShape{{0.0, -depth, 0.0}, {0, 1, 0}};
    const Contact contact(mesh, {obstacle});
    const Vector fall = Vector3(0.0, -speed, 0.0).replicate(mesh.vertex_count(), 1);
    return contact.impact_forecast({mass, rest, 0.0}, fall, 1e6, 0.05, kStep);
  };
  const double fast = d / kStep;
  EXPECT_LT(forecast(2.5 * d, fast).limit, 0.05);
  EXPECT_EQ(forecast(2.5 * d, fast).valid_for, 0.0);
  EXPECT_EQ(forecast(1.6 * d, 0.0).limit, 0.05);
  EXPECT_GT(forecast(1.6 * d, 0.0).valid_for, kStep);
  EXPECT_LT(forecast(1.6 * d, 0.0).valid_for, 4.0 * kStep);
  EXPECT_GT(forecast(3.0 * d, 0.0).valid_for, 15.0 * kStep);
}

TEST(Contact, HasNoForceWhereNothingIsNear) {
  const TetMesh mesh = touching_box(false);
  const Contact contact(mesh,
                        {obstacle_around_box(mesh, PlaneShape{{0.0, -0.151, 0.0}, {0, 1, 0}})});
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  const ForcePoint at{mass, rest, 0.0};
  Vector gradient = Vector::Zero(rest.size());
  contact.add_gradient(at, gradient);
  contact.add_discrete_gradient(at, at, gradient);
  EXPECT_TRUE(gradient.isZero(0.0));
  EXPECT_EQ(contact.energy(at), 0.0);
  EXPECT_EQ(contact.smallest_gap(at), std::numeric_limits<double>::infinity());
  EXPECT_EQ(contact.round_off(at), 0.0);
}

TEST(Contact, NamesWhatPenetrates) {
  const TetMesh mesh = touching_box(false);
  Obstacle far = obstacle_around_box(mesh, PlaneShape{{0.0, -9.0, 0.0}, {0, 1, 0}});
  far.name = "far";
  const Contact contact(mesh,
                        {far, obstacle_around_box(mesh, PlaneShape{{0.0, 0.02, 0.0}, {0, 1, 0}})});
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  const ForcePoint at{mass, rest, 0.0};
  const std::vector<Contact::Penetration> found = contact.penetrations(at);
  EXPECT_EQ(found.size(), 9U);
  for (const Contact::Penetration& each : found) {
    EXPECT_EQ(each.obstacle, 1U);
    EXPECT_EQ(rest[3 * each.vertex + 1], 0.0);
    EXPECT_NEAR(each.depth, 0.02, 1e-15);
  }
  EXPECT_EQ(contact.energy(at), std::numeric_limits<double>::infinity());
  EXPECT_GE(contact.undefined_vertex(at), 0);
}

// In an equilibrium the offset grows with the loads.
TEST(Contact, MovesAnObstacleByItsOffsetWithTheLoads) {
  const TetMesh mesh = touching_box(false);
  Obstacle obstacle = obstacle_around_box(mesh, PlaneShape{{0.0, -0.1, 0.0}, {0, 1, 0}});
  obstacle.motion.offset = {0.3, 0.08, 0.0};
  const Contact contact(mesh, {obstacle});
  const Vector rest = mesh.rest_positions();
  const Vector mass = Vector::Ones(mesh.vertex_count());
  for (const double factor : {0.0, 0.5, 1.0}) {
    ForcePoint at{mass, rest, 0.0};
    at.load_factor = factor;
    EXPECT_NEAR(contact.smallest_gap(at), 0.1 - 0.08 * factor, 1e-15);
  }
}

TEST(Contact, RefusesNumbersOutOfRangeAndSurfacesThatAreNone) {
  const TetMesh mesh = touching_box(false);
  const Obstacle good = obstacle_around_box(mesh, PlaneShape{});
  const auto refused = [&](void (*change)(Obstacle&), const std::string& part) {
    Obstacle obstacle = good;
    change(obstacle);
    expect_error([&] { Contact(mesh, {obstacle}); }, {"\"wall\"", part});
  };
  refused([](Obstacle& o) { o.thickness = 0.0; }, "thickness 0");
  refused([](Obstacle& o) { o.thickness = -1.0; }, "thickness -1");
  refused([](Obstacle& o) { o.thickness = std::numeric_limits<double>::quiet_NaN(); },
          "thickness nan");
  refused([](Obstacle& o) { o.stiffness = 0.0; }, "stiffness 0");
  refused([](Obstacle& o) { o.stiffness = std::numeric_limits<double>::infinity(); },
          "stiffness inf");
  refused([](Obstacle& o) { o.friction = -0.1; }, "friction -0.1");
  refused([](Obstacle& o) { o.slip_speed = 0.0; }, "slip speed 0");
  refused([](Obstacle& o) { o.surface.clear(); }, "No face");
  refused([](Obstacle& o) { o.surface.push_back({0, 1, 4711}); }, "vertex 4711");
  refused([](Obstacle& o) { o.surface.push_back({0, 1, -1}); }, "vertex -1");
  EXPECT_FALSE(Contact(mesh, {good}).has_friction());
}

// A scene whose body begins in an obstacle, or on it, is refused with the obstacle and vertices.
TEST(Contact, RefusesAStartThatPenetrates) {
  for (const double height : {0.0, 0.03}) {
    const bool is_on_it = height == 0.0;
    Scene scene = scene_of(GeneratorSettings{GeneratorKind::kBox, {0.3, 0.2, 0.2}, {1, 1, 1}},
                           elastic(1e5, 0.3));
    scene.time = {Integrator::kEnergyMomentum, 1e-3, false, 1.0};
    ObstacleSettings floor;
    floor.name = "the floor";
    floor.point = {0.0, height, 0.0};
    scene.obstacle.push_back(floor);
    expect_error([&] { Session(scene, mesh_of(scene)); },
                 {"\"the floor\"", "4 vertices (0, 1, 4, 5)", is_on_it ? "exactly on" : "0.03 m"});
  }
}

}  // namespace
}  // namespace tetraction
