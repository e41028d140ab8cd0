// Pressure on the boundary: derivatives, resultants, rims, work.
#include "tetraction/dynamics/surface_pressure.h"

#include <Eigen/Geometry>

#include "support/bodies.h"
#include "tetraction/dynamics/derivative_check.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {
namespace {

using namespace testing_support;

class PressureOnABox : public testing::Test {
 protected:
  PressureOnABox()
      : mesh_(generate_box({1.0, 0.6, 0.8}, {2, 2, 2})),
        system_(mesh_, NeoHookean(1e5, 1e5), 1000.0),
        position_(strained_state(system_.elastic(), mesh_.rest_positions(), 0.3)) {}

  PressureLoad pressure(const Selection& selection, double value) const {
    return {select_triangles(mesh_, selection), value, {}};
  }
  ForcePoint at(const Vector& x) const { return system_.force_point(x, 0.0); }
  // The force of the term: minus the gradient, and the load.
  Vector force_of(const ForceTerm& term, const Vector& x) const {
    Vector gradient = Vector::Zero(x.size());
    term.add_gradient(at(x), gradient);
    Vector force = -gradient;
    if (term.has_load()) term.add_load(at(x), force);
    return force;
  }
  // −p ∫ n dA of the present triangles, a third at each vertex.
  Vector follower(const PressureLoad& load, const Vector& x) const {
    Vector force = Vector::Zero(x.size());
    for (const auto& triangle : load.triangles) {
      const Vector3 a = vertex_block(x, triangle[0]);
      const Vector3 area = 0.5 * (Vector3(vertex_block(x, triangle[1])) - a)
                                     .cross(Vector3(vertex_block(x, triangle[2])) - a);
      for (const Index v : triangle) vertex_block(force, v) -= load.value / 3.0 * area;
    }
    return force;
  }
  static Vector3 sum(const Vector& force) {
    return force.reshaped(3, force.size() / 3).rowwise().sum();
  }

  TetMesh mesh_;
  MechanicalSystem system_;
  Vector position_;
};

TEST_F(PressureOnABox, DerivativesAreThoseOfThePotential) {
  for (const Selection& selection :
       {Selection(SelectSurface{}), Selection(SelectPlane{0, 1.0, {}})}) {
    const SurfacePressure term({pressure(selection, 3e4)}, mesh_.rest_positions(),
                               system_.coordinates());
    const ForceTermErrors errors =
        check_derivatives(term, at(position_), Vector::Zero(position_.size()), 1e-5);
    EXPECT_GT(errors.potential.gradient_norm, 100.0);
    EXPECT_LT(errors.potential.gradient, 1e-8);
    EXPECT_LT(errors.potential.hessian, 1e-8);
    EXPECT_GE(errors.potential.least_eigenvalue, 0.0);
  }
}

TEST_F(PressureOnABox, TheForceIsThatOfThePresentTrianglesAlsoAtARim) {
  for (const Selection& selection : {Selection(SelectSurface{}), Selection(SelectPlane{0, 1.0, {}}),
                                     Selection(SelectBox{{-1.0, 0.29, -1.0}, {2.0, 1.0, 2.0}})}) {
    const PressureLoad load = pressure(selection, -2e4);
    const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
    const Vector expected = follower(load, position_);
    EXPECT_LT((force_of(term, position_) - expected).norm(), 1e-12 * expected.norm());
  }
}

// The symmetric part of minus the derivative of the load at a rim, which is quadratic in positions.
TEST_F(PressureOnABox, TheLoadStiffnessIsTheSymmetricPartOfItsDerivative) {
  const SurfacePressure term({pressure(SelectPlane{0, 1.0, {}}, -2e4)}, mesh_.rest_positions(),
                             system_.coordinates());
  HessianBlocks stiffness;
  stiffness.reset(mesh_.vertex_count());
  term.add_load_stiffness(at(position_), stiffness);
  const auto derivative = [&](const Vector& direction) {
    constexpr double kStep = 0.01;
    Vector ahead = Vector::Zero(position_.size());
    Vector behind = ahead;
    const Vector forward = position_ + kStep * direction;
    const Vector backward = position_ - kStep * direction;
    term.add_load(at(forward), ahead);
    term.add_load(at(backward), behind);
    return Vector((behind - ahead) / (2.0 * kStep));
  };
  const Vector u = jiggled(Vector::Zero(position_.size()), 1.0, 3);
  const Vector v = jiggled(Vector::Zero(position_.size()), 1.0, 5);
  Vector product = Vector::Zero(position_.size());
  stiffness.add_product(u, product);
  const double expected = 0.5 * (v.dot(derivative(u)) + u.dot(derivative(v)));
  EXPECT_NEAR(v.dot(product), expected, 1e-11 * std::abs(expected));
  // The other part does not vanish.
  EXPECT_GT(std::abs(v.dot(derivative(u)) - expected), 1e-3 * std::abs(expected));
}

TEST_F(PressureOnABox, AClosedSurfaceHasNoResultantAndNoLoad) {
  const SurfacePressure term({pressure(SelectSurface{}, 5e4)}, mesh_.rest_positions(),
                             system_.coordinates());
  EXPECT_FALSE(term.has_load());
  const Vector force = force_of(term, position_);
  EXPECT_LT(sum(force).norm(), 1e-12 * force.norm());
  Vector3 moment = Vector3::Zero();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    moment += Vector3(vertex_block(position_, v)).cross(Vector3(vertex_block(force, v)));
  }
  EXPECT_LT(moment.norm(), 1e-12 * force.norm());
  // On the undeformed box the resultant of a face is the pressure times its area.
  const SurfacePressure face({pressure(SelectPlane{2, 0.8, {}}, 5e4)}, mesh_.rest_positions(),
                             system_.coordinates());
  EXPECT_LT((sum(force_of(face, mesh_.rest_positions())) - Vector3(0.0, 0.0, -5e4 * 0.6)).norm(),
            1e-9);
}

// Where the vertices of a rim may only slide in its plane, the forces on the rim do not act along
// any free coordinate.
TEST_F(PressureOnABox, ARimInAPlaneOfSymmetryNeedsNoLoad) {
  PrescribedVertices sliding =
      prescribe_at_rest(mesh_, select_vertices(mesh_, SelectPlane{1, 0.0, {}}));
  sliding.components = {false, true, false};
  ConstraintList list;
  list.held = {sliding};
  system_.set_constraints(Constraints(list, mesh_, system_.mass()));
  // The top face and the two sides that touch the plane y = 0.
  const PressureLoad load = pressure(SelectPlane{2, 0.8, {}}, 1e4);
  const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
  ASSERT_TRUE(term.has_load());
  Vector x = mesh_.rest_positions();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    x[3 * v] += 0.1 * x[3 * v + 2];
    x[3 * v + 2] += 0.05 * x[3 * v];
  }
  Vector rim = Vector::Zero(x.size());
  term.add_load(at(x), rim);
  for (const Index v : sliding.vertices) {
    if (std::abs(mesh_.vertices[static_cast<std::size_t>(v)].x() - 0.5) > 0.4) continue;  // corner
    EXPECT_LT(std::abs(rim[3 * v]) + std::abs(rim[3 * v + 2]), 1e-12 * rim.norm());
  }
}

TEST_F(PressureOnABox, TheEnergyChangeHasNoCancellation) {
  PressureLoad load = pressure(SelectSurface{}, 1e5);
  const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
  Vector moved = position_;
  moved[5] += 1e-13;
  Vector gradient = Vector::Zero(position_.size());
  term.add_gradient(at(position_), gradient);
  const double expected = gradient[5] * (moved[5] - position_[5]);
  EXPECT_NEAR(term.energy_change(at(position_), at(moved)), expected, 1e-9 * std::abs(expected));
}

// A pressure that changes in time: −ΔU and the driven work add up to −p ΔV.
TEST_F(PressureOnABox, TheWorkOfAStepIsThatOfTheMeanPressure) {
  PressureLoad load = pressure(SelectSurface{}, 1e4);
  load.history.amplitude =
      std::make_shared<const Amplitude>(Amplitude::piecewise_linear({{0.0, 1.0}, {1.0, 3.0}}));
  const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
  const Vector rest = mesh_.rest_positions();
  const ForcePoint from = system_.force_point(rest, 0.2);
  const ForcePoint to = system_.force_point(position_, 0.6);
  double volume = 0.0;
  for (const auto& [a, b, c] : load.triangles) {
    volume +=
        Vector3(vertex_block(position_, a))
            .dot(Vector3(vertex_block(position_, b)).cross(Vector3(vertex_block(position_, c)))) /
        6.0;
  }
  const double work = -1.8e4 * (volume - 0.48);
  EXPECT_NEAR(term.driven_work(from, to) - term.energy_change(from, to), work,
              1e-9 * std::abs(work));
  EXPECT_NEAR(term.energy_change(from, to), term.energy(to) - term.energy(from),
              1e-9 * std::abs(term.energy(to)));
}

}  // namespace
}  // namespace tetraction
