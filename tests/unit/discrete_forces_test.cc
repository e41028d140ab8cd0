// The discrete gradients of force terms: their work, their symmetries, and small steps.
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <numbers>

#include "support/bodies.h"
#include "support/force_terms.h"
#include "support/scene_parts.h"
#include "tetraction/dynamics/terms/environment.h"
#include "tetraction/dynamics/terms/surface_pressure.h"

namespace tetraction {
namespace {

using namespace testing_support;

// An anharmonic field of a program's own.
class Bowl : public ForceField {
 public:
  double value(double mass, const Vector3& q) const override {
    return mass * (3.0 * q.squaredNorm() + std::pow(q.x(), 4) + q.y() * q.z() * q.z());
  }
  Vector3 gradient(double mass, const Vector3& q) const override {
    return mass * (6.0 * q + Vector3(4.0 * std::pow(q.x(), 3), q.z() * q.z(), 2.0 * q.y() * q.z()));
  }
  Matrix3 hessian(double mass, const Vector3& q) const override {
    Matrix3 h = 6.0 * Matrix3::Identity();
    h(0, 0) += 12.0 * q.x() * q.x();
    h(1, 2) += 2.0 * q.z();
    h(2, 1) += 2.0 * q.z();
    h(2, 2) += 2.0 * q.y();
    return mass * h;
  }
};

std::shared_ptr<const Amplitude> wave() {
  return std::make_shared<const Amplitude>(make_amplitude(sine("wave", 0.8, 0.3)));
}

struct TermCase {
  std::string name;
  std::function<std::shared_ptr<const ForceTerm>(const MechanicalSystem&)> make;
  bool is_internal = false;  // the sum and the moment of its forces are zero
  bool is_central = false;   // the moment of its forces about the origin is zero
};

Environment attraction(double softening) {
  return Environment::attraction(2e4, softening);
}

std::shared_ptr<const ForceTerm> pressure_on(const MechanicalSystem& system,
                                             const Selection& selection) {
  const PressureLoad load{select_triangles(system.mesh(), selection), 3e4, {}};
  return std::make_shared<SurfacePressure>(std::vector<PressureLoad>{load},
                                           system.mesh().rest_positions(), system.coordinates());
}

std::vector<TermCase> term_cases() {
  return {
      {"gravity",
       [](const MechanicalSystem&) {
         return std::make_shared<Environment>(Environment::uniform({0.0, -9.81, 1.0}));
       }},
      {"changing_gravity",
       [](const MechanicalSystem&) {
         auto environment = std::make_shared<Environment>(Environment::uniform({0.0, -9.81, 1.0}));
         environment->set_amplitude(wave());
         return environment;
       }},
      {"attraction",
       [](const MechanicalSystem&) { return std::make_shared<Environment>(attraction(0.0)); },
       false, true},
      {"soft_attraction",
       [](const MechanicalSystem&) { return std::make_shared<Environment>(attraction(0.4)); },
       false, true},
      {"field",
       [](const MechanicalSystem&) {
         return std::make_shared<Environment>(Environment::custom(std::make_shared<Bowl>()));
       }},
      {"changing_field",
       [](const MechanicalSystem&) {
         auto environment =
             std::make_shared<Environment>(Environment::custom(std::make_shared<Bowl>()));
         environment->set_amplitude(wave());
         return environment;
       }},
      {"floor",
       [](const MechanicalSystem&) { return std::make_shared<FloorBarrier>(-0.5, 1e4, 1.0); }},
      {"springs",
       [](const MechanicalSystem&) {
         return std::make_shared<PairSprings>(
             std::vector<std::pair<Index, Index>>{{0, 20}, {3, 40}, {7, 9}}, 1e3, 0.2);
       },
       true},
      {"swing", [](const MechanicalSystem&) { return std::make_shared<SwingingField>(3.0, 5.0); }},
      {"penalty",
       [](const MechanicalSystem& system) {
         PrescribedVertices held = prescribe_at_rest(
             system.mesh(), select_vertices(system.mesh(), SelectPlane{0, 0.0, {}}), "hold");
         held.penalty = 1e4;
         held.motion.velocity = {0.5, 0.2, 0.0};
         held.motion.angular_velocity = {0.0, 1.0, 2.0};
         return std::make_shared<PenaltySprings>(std::vector{held}, system.vertex_count());
       }},
      {"closed_pressure",
       [](const MechanicalSystem& system) { return pressure_on(system, SelectSurface{}); }, true},
      {"open_pressure", [](const MechanicalSystem& system) {
         return pressure_on(system, SelectPlane{0, 2.0, {}});
       }}};
}

class DiscreteGradientOfTerm : public testing::TestWithParam<TermCase> {
 protected:
  DiscreteGradientOfTerm()
      : system_(small_block(), all_materials()[1], 1000.0), term_(GetParam().make(system_)) {}

  // A step that turns the body by `size` and deforms it.
  void set_step(double size) {
    from_ = jiggled(system_.mesh().rest_positions(), 0.05, 5);
    const Matrix3 turn =
        Eigen::AngleAxisd(size, Vector3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    to_ = jiggled(from_, 0.1 * size, 8);
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 x = vertex_block(std::as_const(to_), v);
      vertex_block(to_, v) = turn * x + size * Vector3(0.1, 0.2, 0.1);
    }
  }
  Vector discrete_gradient() const {
    Vector result = Vector::Zero(system_.dof_count());
    term_->add_discrete_gradient(system_.force_point(from_, kStart), system_.force_point(to_, kEnd),
                                 result);
    return result;
  }

  static constexpr double kStart = 0.3;
  static constexpr double kEnd = 0.5;
  MechanicalSystem system_;
  std::shared_ptr<const ForceTerm> term_;
  Vector from_, to_;
};

TEST_P(DiscreteGradientOfTerm, DoesTheWorkOfThePotential) {
  for (const double size : {0.5, 0.05, 1e-3, 1e-6}) {
    set_step(size);
    const ForcePoint from = system_.force_point(from_, kStart);
    const ForcePoint to = system_.force_point(to_, kEnd);
    const double work = discrete_gradient().dot(to_ - from_);
    const double expected = term_->energy_change(from, to) - term_->driven_work(from, to);
    const double scale = std::abs(term_->energy(from)) + std::abs(term_->energy(to)) +
                         std::abs(term_->driven_work(from, to));
    EXPECT_GT(scale, 0.0);
    EXPECT_NEAR(work, expected, 2e-14 * scale) << size;
  }
}

TEST_P(DiscreteGradientOfTerm, HasTheMomentaOfTheTerm) {
  if (!GetParam().is_internal && !GetParam().is_central) return;
  set_step(0.5);
  const Vector f = discrete_gradient();
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  double scale = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const Vector3 each = vertex_block(f, v);
    const Vector3 x =
        0.5 * (vertex_block(std::as_const(from_), v) + vertex_block(std::as_const(to_), v));
    force += each;
    moment += x.cross(each);
    scale += each.norm();
  }
  EXPECT_LT(moment.norm(), 1e-13 * scale);
  if (GetParam().is_internal) {
    EXPECT_LT(force.norm(), 1e-13 * scale);
  }
}

TEST_P(DiscreteGradientOfTerm, IsNearTheGradientAtTheMiddle) {
  for (const double size : {1e-2, 1e-3, 1e-9}) {
    set_step(size);
    const Vector middle = 0.5 * (from_ + to_);
    Vector expected = Vector::Zero(middle.size());
    const TimeSpan step{kStart, kEnd};
    term_->add_gradient(system_.force_point(middle, 0.5 * (kStart + kEnd), step), expected);
    EXPECT_GT(expected.norm(), 0.0);
    // A term without a mean over the time has that of the two ends.
    const double of_time = GetParam().name == "swing" || GetParam().name == "penalty" ? 1.0 : 0.0;
    EXPECT_LT((discrete_gradient() - expected).norm(),
              (30.0 * size * size + 1e-6 * size + of_time + 1e-12) * expected.norm())
        << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Terms, DiscreteGradientOfTerm, testing::ValuesIn(term_cases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tetraction
