#include "tetraction/simulation/probe.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "mesh/quadratic_shapes.h"
#include "support/allocations.h"
#include "support/runs.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block that is clamped at one end and pushed at the other.
Scene pushed_block(Integrator integrator = Integrator::kVerlet) {
  Scene scene = spinning_block(integrator, 1e-3, 0.2);
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {2, 1, 1}, {4, 2, 2}};
  scene.initial.angular_velocity.setZero();
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  scene.force = {load(SelectPlane{0, 2.0, {}}, {3.0, -20.0, 10.0})};
  return scene;
}

TEST(Probe, ValuesOfSelectionsAreMeansAndSums) {
  Scene scene = pushed_block();
  const Selection end = SelectPlane{0, 2.0, {}};
  const Selection half = SelectBox{{0, 0, 0}, {1, 1, 1}};
  for (const ProbeQuantity quantity : values_of<ProbeQuantity>()) {
    if (quantity_of(quantity).is_of_obstacle) continue;
    const bool of_tetrahedra = quantity == ProbeQuantity::kCauchyStress ||
                               quantity == ProbeQuantity::kVonMises ||
                               quantity == ProbeQuantity::kJacobian;
    scene.probe.push_back(probe_of(to_string(quantity), quantity, of_tetrahedra ? half : end));
  }
  scene.probe[5].select = SelectPlane{0, 0.0, {}};
  Session session(scene, generate_mesh(*scene.mesh.generate));
  for (int k = 0; k < 37; ++k) ASSERT_TRUE(session.step()) << session.message();
  const ProbeSet& probes = session.probes();
  ASSERT_EQ(probes.value_count(), 6U * 3U + 6U + 2U);
  std::vector<double> values(probes.value_count());
  probes.evaluate(session, values.data());
  const auto vector = [&](std::size_t i) {
    return Vector3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  };

  const MechanicalSystem& system = session.system();
  const State& state = session.state();
  const Vector rest = system.mesh().rest_positions();
  const Vector force = session.external_force();
  Vector3 displacement = Vector3::Zero(), position = Vector3::Zero(), velocity = Vector3::Zero(),
          momentum = Vector3::Zero(), push = Vector3::Zero();
  const std::vector<Index> vertices = select_vertices(system.mesh(), end);
  ASSERT_EQ(vertices.size(), 9U);
  for (const Index v : vertices) {
    displacement += state.position.segment<3>(3 * v) - rest.segment<3>(3 * v);
    position += state.position.segment<3>(3 * v);
    velocity += state.velocity.segment<3>(3 * v);
    momentum += state.momentum.segment<3>(3 * v);
    push += force.segment<3>(3 * v);
  }
  EXPECT_LT((vector(0) - displacement / 9.0).norm(), 1e-15);
  EXPECT_LT((vector(1) - position / 9.0).norm(), 1e-15);
  EXPECT_LT((vector(2) - velocity / 9.0).norm(), 1e-14);
  EXPECT_LT((vector(3) - momentum).norm(), 1e-12 * momentum.norm());
  EXPECT_LT((vector(4) - Vector3(27.0, -180.0, 90.0)).norm(), 1e-12);
  EXPECT_LT((vector(4) - push).norm(), 1e-12);
  Vector3 reaction = Vector3::Zero();
  for (Index v = 0; v < system.vertex_count(); ++v) {
    reaction += session.reaction_force().segment<3>(3 * v);
  }
  EXPECT_GT(reaction.norm(), 1.0);
  EXPECT_LT((vector(5) - reaction).norm(), 1e-12 * reaction.norm());

  const ElementFields fields = element_fields(system, state.position);
  Vector stress = Vector::Zero(6);
  double von_mises = 0.0, jacobian = 0.0, volume = 0.0;
  for (const Index e : select_tetrahedra(system.mesh(), half)) {
    const double v = system.mesh().volume(e);
    stress += v * fields.cauchy_stress.col(e);
    von_mises += v * fields.von_mises(0, e);
    jacobian += v * fields.jacobian(0, e);
    volume += v;
  }
  EXPECT_NEAR(volume, 1.0, 1e-12);
  const Eigen::Map<const Vector> measured(values.data() + 18, 6);
  EXPECT_LT((measured - stress / volume).norm(), 1e-12 * stress.norm());
  EXPECT_NEAR(values[24], von_mises / volume, 1e-12 * von_mises);
  EXPECT_NEAR(values[25], jacobian / volume, 1e-13);
}

TEST(Probe, PointsAreInterpolatedInTheirTetrahedron) {
  Scene scene = pushed_block();
  scene.initial.velocity = {0.3, -0.2, 0.1};
  scene.fix.clear();
  scene.force.clear();
  const Vector3 point(0.37, 0.61, 0.83);
  scene.probe = {probe_at("u", ProbeQuantity::kDisplacement, point),
                 probe_at("q", ProbeQuantity::kPosition, point),
                 probe_at("v", ProbeQuantity::kVelocity, point),
                 probe_at("s", ProbeQuantity::kCauchyStress, point),
                 probe_at("j", ProbeQuantity::kJacobian, point),
                 probe_at("corner", ProbeQuantity::kPosition, {2.0, 1.0, 1.0})};
  Session session(scene, generate_mesh(*scene.mesh.generate));
  std::vector<double> values(session.probes().value_count());
  session.probes().evaluate(session, values.data());
  // The initial stretch is about the centre of mass. It is linear, and so is the interpolation.
  const Vector3 center(1.0, 0.5, 0.5);
  const Vector3 expected = center + scene.initial.stretch.cwiseProduct(point - center);
  const auto vector = [&](std::size_t first) {
    return Vector3(values[first], values[first + 1], values[first + 2]);
  };
  EXPECT_LT((vector(0) - (expected - point)).norm(), 1e-14);
  EXPECT_LT((vector(3) - expected).norm(), 1e-14);
  EXPECT_LT((vector(6) - scene.initial.velocity).norm(), 1e-14);
  EXPECT_NEAR(values[15], 1.1 * 0.95, 1e-13);
  EXPECT_LT((vector(16) - (center + Vector3(1.1, 0.475, 0.5))).norm(), 1e-14);
  // All tetrahedra have the same stress.
  const ElementFields fields = element_fields(session.system(), session.state().position);
  for (Index c = 0; c < 6; ++c) {
    EXPECT_NEAR(values[9 + static_cast<std::size_t>(c)], fields.cauchy_stress(c, 0), 1e-7);
  }
}

TEST(Probe, StressOfAPointIsThatOfTheTetrahedronAroundIt) {
  Scene scene = pushed_block();
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  const RestState rest(mesh);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    scene.probe.push_back(
        probe_at(fmt::format("e{}", e), ProbeQuantity::kVonMises, rest.center(e)));
  }
  Session session(scene, mesh);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(session.step());
  std::vector<double> values(session.probes().value_count());
  session.probes().evaluate(session, values.data());
  const ElementFields fields = element_fields(session.system(), session.state().position);
  const Vector stress = fields.von_mises.transpose();
  const double kRoundOff = 1e-13 * initial_lame(session.system().materials().front().model()).mu;
  EXPECT_GT(stress.minCoeff(), 1e6 * kRoundOff);
  for (Index e = 0; e < stress.size(); ++e) {
    // The field comes from the gradient of the energy, the probe from P: they differ by round-off.
    EXPECT_NEAR(values[static_cast<std::size_t>(e)], stress[e], kRoundOff) << "element " << e;
  }
}

std::string refusal(const std::vector<ProbeSettings>& probes) {
  Scene scene = pushed_block();
  scene.probe = probes;
  for (ProbeSettings& settings : scene.probe) settings.where = "here.toml:3:1: probe.0";
  return message_of([&] { const Session session(scene, generate_mesh(*scene.mesh.generate)); });
}

TEST(Probe, WrongSettingsAreRefused) {
  const auto expect = [](const std::vector<ProbeSettings>& probes, const std::string& part) {
    const std::string message = refusal(probes);
    EXPECT_EQ(message.find("here.toml:3:1: probe.0"), 0U) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const Selection all = SelectAll{};
  // The distance from the box is that of its corner, edge and face.
  expect({probe_at("a", ProbeQuantity::kPosition, {3.0, 0.5, 0.5})}, "1 m from the nearest");
  expect({probe_at("a", ProbeQuantity::kPosition, {2.3, 1.4, 0.5})}, "0.5 m from the nearest");
  expect({probe_at("a", ProbeQuantity::kPosition, {-2.0, -1.0, -2.0})}, "3 m from the nearest");
  expect({probe_of("a", ProbeQuantity::kPosition, SelectPlane{0, 0.3, {}})}, "selects no vertex");
  expect({probe_of("a", ProbeQuantity::kVonMises, SelectPlane{0, 0.0, {}})},
         "selects no tetrahedron");
  expect({probe_of("a", ProbeQuantity::kForce, all), probe_of("a", ProbeQuantity::kPosition, all)},
         "the column \"a_x\"");
  expect(
      {probe_of("a", ProbeQuantity::kForce, all), probe_of("a_y", ProbeQuantity::kVonMises, all)},
      "the column \"a_y\"");
  expect({probe_of("time", ProbeQuantity::kVonMises, all)}, "the column \"time\"");
  expect({probe_of("a b", ProbeQuantity::kForce, all)}, "letters, digits and underscores");
  expect({probe_of("", ProbeQuantity::kForce, all)}, "letters, digits and underscores");
  expect({probe_at("a", ProbeQuantity::kReaction, {1, 0.5, 0.5})}, "sum over vertices");
  EXPECT_EQ(refusal({probe_of("a", ProbeQuantity::kForce, all),
                     probe_of("a_1", ProbeQuantity::kPosition, all),
                     probe_at("b", ProbeQuantity::kPosition, {2.0, 0.5, 0.5})}),
            "accepted");
}

// In a quarter of a ring with curved elements a point is where the shape functions of ten nodes say.
TEST(Probe, PointsOfCurvedElements) {
  TetMesh mesh = with_edge_vertices(generate_box({1, 1, 0.5}, {2, 2, 1}));
  for (Vector3& x : mesh.vertices.own()) {
    const double r = 1.0 + x.x();
    const double angle = 0.5 * std::numbers::pi * x.y();
    x = Vector3(r * std::cos(angle), r * std::sin(angle), x.z());
  }
  Scene scene = scene_of(elastic(1e5, 0.3));
  std::vector<Vector3> points(mesh.vertices.begin(), mesh.vertices.end());
  for (const double angle : {0.05, 0.3, 0.77, 1.2, 1.5}) {
    for (const double r : {1.02, 1.4, 1.97}) {
      points.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.2 * r);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    scene.probe.push_back(probe_at(fmt::format("p{}", i), ProbeQuantity::kPosition, points[i]));
  }
  Session session(scene, mesh);
  std::vector<double> values(session.probes().value_count());
  session.probes().evaluate(session, values.data());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 found(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    EXPECT_LT((found - points[i]).norm(), 1e-12) << i;
  }
  scene.probe = {probe_at("far", ProbeQuantity::kPosition, {0.6, 0.6, 0.2})};
  EXPECT_THROW(Session(scene, mesh), InputError);
  // The distance is that of the curved surface: this point is beside a vertex in the middle of an arc,
  // whose chord is 0.15 m away.
  constexpr double kOff = 1e-6;
  const double angle = std::numbers::pi / 8.0;
  scene.probe = {probe_at("near", ProbeQuantity::kPosition,
                          (2.0 + kOff) * Vector3(std::cos(angle), std::sin(angle), 0.0))};
  try {
    const Session session_outside(scene, mesh);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    const std::string text = error.what();
    const std::string words = "outside the body, ";
    const std::size_t at = text.find(words);
    ASSERT_NE(at, std::string::npos) << text;
    const double distance = std::stod(text.substr(at + words.size()));
    EXPECT_LE(distance, 1.0001 * kOff) << text;
    EXPECT_GE(distance, 0.5 * kOff) << text;
  }
}

// The stress of a quadratic element varies inside it. Where elements meet, a probe has the mean of their
// values there, weighted with their volumes.
TEST(Probe, StressesAtPointsOfQuadraticElements) {
  TetMesh mesh = with_edge_vertices(generate_box({2, 1, 1}, {2, 1, 1}));
  for (Vector3& x : mesh.vertices.own()) x.z() += 0.1 * x.x() * x.x() - 0.05 * x.y() * x.x();
  const RestState rest(mesh);
  Matrix moved(3, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3& x = mesh.vertices[static_cast<std::size_t>(v)];
    moved.col(v) = Vector3(0.1 * std::sin(3.0 * x.y()), 0.05 * x.x() * x.z(), 0.1 * x.x());
  }
  mesh.point_arrays["u"] = moved;
  Scene scene = scene_of(elastic(1e5, 0.3));
  scene.initial.displacement_array = "u";
  const Index vertex = rest.nodes(0)[1];
  const Vector3 node = rest.position(vertex);
  const Index element = 3;
  const std::array<double, 4> l{0.4, 0.3, 0.2, 0.1};
  Vector3 inside = Vector3::Zero();
  const auto shapes = quadratic_shapes(l);
  for (std::size_t a = 0; a < 10; ++a) inside += shapes[a] * rest.position(rest.nodes(element)[a]);
  const Selection all = SelectAll{};
  scene.probe = {probe_at("s", ProbeQuantity::kCauchyStress, inside),
                 probe_at("m", ProbeQuantity::kVonMises, inside),
                 probe_at("j", ProbeQuantity::kJacobian, inside),
                 probe_at("t", ProbeQuantity::kCauchyStress, node),
                 probe_at("n", ProbeQuantity::kVonMises, node),
                 probe_at("k", ProbeQuantity::kJacobian, node),
                 probe_of("all", ProbeQuantity::kJacobian, all)};
  Session session(scene, mesh);
  std::vector<double> values(session.probes().value_count());
  session.probes().evaluate(session, values.data());
  const MechanicalSystem& system = session.system();
  const Vector& q = session.state().position;
  const PlaceValues at = values_at(system, element, l, q);
  const auto stress = [&](std::size_t first) {
    return Vector6(Eigen::Map<const Vector6>(values.data() + first));
  };
  EXPECT_LT((stress(0) - six_components(at.cauchy_stress)).norm(), 1e-9 * at.cauchy_stress.norm());
  EXPECT_NEAR(values[6], at.von_mises, 1e-9 * at.von_mises);
  EXPECT_NEAR(values[7], at.jacobian, 1e-12);
  EXPECT_GT((stress(0) - six_components(cauchy_stress(system, element, q))).norm(),
            0.01 * at.cauchy_stress.norm());
  const NodalFields fields = nodal_fields(system, q);
  EXPECT_LT((stress(8) - fields.cauchy_stress.col(vertex)).norm(), 1e-9 * stress(8).norm());
  EXPECT_NEAR(values[14], fields.von_mises(0, vertex), 1e-9 * values[14]);
  EXPECT_NEAR(values[15], fields.jacobian(0, vertex), 1e-12);
  // The mean of J is the ratio of the volumes.
  TetMesh deformed = mesh;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    deformed.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(q, v);
  }
  EXPECT_NEAR(values[16], deformed.total_volume() / mesh.total_volume(), 1e-14);
}

TEST(Probe, EvaluationAndTracesDoNotAllocate) {
  if (!can_count_allocations()) GTEST_SKIP() << "the address sanitizer has malloc";
  Scene scene = pushed_block();
  for (const ProbeQuantity quantity : values_of<ProbeQuantity>()) {
    if (quantity_of(quantity).is_of_obstacle) continue;
    scene.probe.push_back(probe_of(to_string(quantity), quantity, SelectAll{}));
    scene.probe.push_back(probe_of(to_string(quantity) + "2", quantity, SelectAll{}));
    scene.probe.back().every = 7;
    if (!quantity_of(quantity).is_sum) {
      scene.probe.push_back(probe_at(to_string(quantity) + "3", quantity, {0.4, 0.5, 0.6}));
    }
  }
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const ProbeSet& probes = session.probes();
  std::vector<double> values(probes.value_count());
  ProbeTraces traces(probes, session.step_count());
  ASSERT_EQ(session.step_count(), 200);
  ASSERT_TRUE(session.step());
  {
    const AllocationCounter counter(1);
    for (Index step = 0; step <= 200; ++step) {
      probes.evaluate(session, values.data());
      traces.add(step, 1e-3 * static_cast<double>(step), values.data(), step == 200);
    }
    EXPECT_EQ(counter.count(), 0);
  }
  EXPECT_EQ(traces.trace(0).times.size(), 201U);
  EXPECT_EQ(traces.trace(1).times.size(), 30U);  // 0, 7, …, 196 and the last one
  EXPECT_EQ(traces.trace(1).times.back(), 0.2);
}

// One body with a scalar probe, for the traces.
class Traces : public testing::Test {
 protected:
  const MechanicalSystem system_{generate_tetrahedron(), NeoHookean(2.0, 3.0), 1000.0};
  const ProbeSet probes_{{probe_of("j", ProbeQuantity::kJacobian, SelectAll{})}, system_};
};

TEST_F(Traces, HaveExtremesWithTimes) {
  ProbeTraces traces(probes_, 4);
  EXPECT_TRUE(std::isnan(traces.statistics()[0].min));
  const double values[] = {1.0, 5.0, -2.0, 5.0, 3.0};
  for (Index k = 0; k < 5; ++k) traces.add(k, 0.5 * static_cast<double>(k), values + k);
  const ProbeStatistics s = traces.statistics()[0];
  EXPECT_EQ(s.min, -2.0);
  EXPECT_EQ(s.min_time, 1.0);
  EXPECT_EQ(s.max, 5.0);
  EXPECT_EQ(s.max_time, 0.5);
  EXPECT_EQ(s.last, 3.0);
}

TEST_F(Traces, AreBoundedAndKeepExtremesAndFrequency) {
  constexpr double kFrequency = 3.21;
  constexpr Index kSteps = 2'700'000;
  constexpr double kStep = 1e-5;
  ProbeTraces traces(probes_, kSteps);
  for (Index k = 0; k <= kSteps; ++k) {
    const double t = kStep * static_cast<double>(k);
    double value = std::sin(2.0 * std::numbers::pi * kFrequency * t);
    if (k == 1'234'567) value = 9.0;
    traces.add(k, t, &value);
  }
  EXPECT_LE(traces.trace(0).times.size(), std::size_t{1} << 20U);
  EXPECT_GE(traces.trace(0).times.size(), std::size_t{1} << 19U);
  EXPECT_EQ(traces.trace(0).times.size(), traces.trace(0).values.size());
  const ProbeStatistics s = traces.statistics()[0];
  EXPECT_EQ(s.max, 9.0);
  EXPECT_DOUBLE_EQ(s.max_time, 12.34567);
  EXPECT_NEAR(s.last, std::sin(2.0 * std::numbers::pi * kFrequency * 27.0), 1e-9);
  EXPECT_NEAR(s.frequency, kFrequency, 1e-6);
}

struct Samples {
  std::vector<double> times, values;
};

template <class Value>
Samples samples(double end, int count, const Value& value, double jitter = 0.0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  Samples result;
  for (int i = 0; i <= count; ++i) {
    const double t = end * (i + (i > 0 && i < count ? move(random) : 0.0)) / count;
    result.times.push_back(t);
    result.values.push_back(value(t));
  }
  return result;
}

double wave(double frequency, double t, double phase = 0.0) {
  return std::sin(2.0 * std::numbers::pi * frequency * t + phase);
}

TEST(DominantFrequency, OfASineIsExactWhateverTheTimes) {
  for (const double periods : {2.0, 2.37, 3.5, 11.1, 250.3}) {
    for (const double phase : {0.0, 0.4, 1.1, 2.9}) {
      for (const double jitter : {0.0, 0.4}) {
        const Samples s = samples(
            2.0, 2000, [&](double t) { return 40.0 + 0.01 * wave(periods / 2.0, t, phase); },
            jitter);
        EXPECT_NEAR(dominant_frequency(s.times, s.values), periods / 2.0, 1e-6 * periods)
            << periods << " periods, phase " << phase << ", jitter " << jitter;
      }
    }
  }
}

TEST(DominantFrequency, IsThatOfTheLargestPart) {
  const Samples s = samples(1.0, 4000, [](double t) {
    return wave(7.3, t) + 0.8 * wave(31.0, t, 0.3) + 0.3 * wave(211.0, t, 1.0);
  });
  EXPECT_NEAR(dominant_frequency(s.times, s.values), 7.3, 0.01);
  // A damped vibration about a static displacement.
  const Samples damped = samples(
      1.0, 4000, [](double t) { return -0.3 + 0.2 * std::exp(-3.0 * t) * wave(20.0, t, 1.5); });
  EXPECT_NEAR(dominant_frequency(damped.times, damped.values), 20.0, 0.05);
}

TEST(DominantFrequency, IsAbsentWithoutTwoPeriods) {
  const auto none = [](const Samples& s, double round_off = 0.0) {
    return std::isnan(dominant_frequency(s.times, s.values, round_off));
  };
  EXPECT_TRUE(none(samples(1.0, 500, [](double t) { return wave(1.9, t, 0.2); })));
  EXPECT_TRUE(none(samples(1.0, 500, [](double t) { return wave(0.7, t); })));
  EXPECT_TRUE(none(samples(1.0, 500, [](double) { return 3.0; })));
  EXPECT_TRUE(none(samples(1.0, 500, [](double t) { return 3.0 * t; })));
  EXPECT_TRUE(none(samples(1.0, 500, [](double t) { return t * t + 1e-3 * wave(9.0, t); })));
  EXPECT_TRUE(none(samples(1.0, 500, [](double t) { return 1.0 + 1e-14 * wave(9.0, t); }), 1e-12));
  EXPECT_TRUE(none(samples(1.0, 3, [](double t) { return wave(1.0, t); })));
  EXPECT_FALSE(none(samples(1.0, 500, [](double t) { return wave(2.1, t, 0.2); })));
}

// Four equal masses on springs, which move together: ω² = 2γ/m. Verlet turns ω into
// (2/h) asin(ωh/2).
TEST(DominantFrequency, OfAnOscillatorIsThatOfTheIntegrator) {
  Scene scene = scene_of({GeneratorKind::kTetrahedron}, elastic(1e5, 0.3));
  scene.initial.velocity = {0.1, 0.0, 0.0};
  FixSettings springs;
  springs.is_penalty = true;
  springs.penalty = 3e4;
  scene.fix = {springs};
  scene.probe = {probe_of("u", ProbeQuantity::kDisplacement, SelectAll{})};
  const double mass = 1000.0 / 6.0 / 4.0;
  const double omega = std::sqrt(2.0 * 3e4 / mass);
  const double h = 0.2 / omega;
  scene.time = {Integrator::kVerlet, h, false, 400.5 * h};
  Session session(scene, generate_mesh(*scene.mesh.generate));
  ProbeTraces traces(session.probes(), session.step_count());
  std::vector<double> values(3);
  do {
    session.probes().evaluate(session, values.data());
    traces.add(session.step_number(), session.time(), values.data(), true);
  } while (session.step());
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const std::vector<ProbeStatistics> s = traces.statistics();
  const double expected = 2.0 / h * std::asin(0.5 * omega * h) / (2.0 * std::numbers::pi);
  EXPECT_NEAR(s[0].frequency, expected, 1e-5 * expected);
  EXPECT_TRUE(std::isnan(s[1].frequency));
  EXPECT_TRUE(std::isnan(s[2].frequency));
}

}  // namespace
}  // namespace tetraction
