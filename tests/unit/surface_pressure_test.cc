// Pressure on the boundary: derivatives, resultants, rims, work.
#include "tetraction/dynamics/terms/surface_pressure.h"

#include <Eigen/Geometry>

#include <array>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

// The shape functions of a face at (ξ, η), and their derivatives: three of a linear element, six of a
// quadratic one.
struct FacePoint {
  Eigen::VectorXd shape;
  Eigen::VectorXd along_xi;
  Eigen::VectorXd along_eta;
  double weight;
};

FacePoint face_point(double xi, double eta, bool is_quadratic) {
  const double l = 1.0 - xi - eta;
  FacePoint point;
  if (is_quadratic) {
    point.shape = Eigen::VectorXd{{l * (2 * l - 1), xi * (2 * xi - 1), eta * (2 * eta - 1),
                                   4 * l * xi, 4 * xi * eta, 4 * eta * l}};
    point.along_xi = Eigen::VectorXd{{1 - 4 * l, 4 * xi - 1, 0, 4 * (l - xi), 4 * eta, -4 * eta}};
    point.along_eta = Eigen::VectorXd{{1 - 4 * l, 0, 4 * eta - 1, -4 * xi, 4 * xi, 4 * (l - eta)}};
  } else {
    point.shape = Eigen::VectorXd{{l, xi, eta}};
    point.along_xi = Eigen::VectorXd{{-1, 1, 0}};
    point.along_eta = Eigen::VectorXd{{-1, 0, 1}};
  }
  return point;
}

// Gauss points of the square (u, v), with ξ = u and η = v (1 − u): exact for degree 4.
std::vector<FacePoint> face_points(bool is_quadratic) {
  constexpr std::array kPoints{0.0, -0.7745966692414834, 0.7745966692414834};
  constexpr std::array kWeights{8.0 / 9.0, 5.0 / 9.0, 5.0 / 9.0};
  std::vector<FacePoint> points;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double u = 0.5 * (1.0 + kPoints[i]);
      const double v = 0.5 * (1.0 + kPoints[j]);
      points.push_back(face_point(u, v * (1.0 - u), is_quadratic));
      points.back().weight = 0.25 * kWeights[i] * kWeights[j] * (1.0 - u);
    }
  }
  return points;
}

// On linear elements and on quadratic ones.
class PressureOnABox : public testing::TestWithParam<bool> {
 protected:
  PressureOnABox()
      : mesh_(GetParam() ? with_edge_vertices(generate_box({1.0, 0.6, 0.8}, {2, 2, 2}))
                         : generate_box({1.0, 0.6, 0.8}, {2, 2, 2})),
        system_(mesh_, NeoHookean(1e5, 1e5), 1000.0),
        position_(strained_state(system_.elastic(), mesh_.rest_positions(), 0.3)) {}

  PressureLoad pressure(const Selection& selection, double value) const {
    PressureLoad load = pressure_on(mesh_, select_triangles(mesh_, selection));
    load.value = value;
    EXPECT_EQ(load.triangles.empty(), GetParam());
    return load;
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
  // Calls add(nodes, point, x, area) for all points of the load's faces, with the position and n dA there.
  template <class Add>
  static void integrate(const PressureLoad& load, const Vector& x, const Add& add) {
    const auto integrate_face = [&](const auto& face) {
      for (const FacePoint& point : face_points(face.size() == 6)) {
        Vector3 position = Vector3::Zero();
        Vector3 xi = position;
        Vector3 eta = position;
        for (std::size_t a = 0; a < face.size(); ++a) {
          const auto i = static_cast<Index>(a);
          position += point.shape[i] * vertex_block(x, face[a]);
          xi += point.along_xi[i] * vertex_block(x, face[a]);
          eta += point.along_eta[i] * vertex_block(x, face[a]);
        }
        add(face, point, position, Vector3(point.weight * xi.cross(eta)));
      }
    };
    for (const auto& face : load.triangles) integrate_face(face);
    for (const auto& face : load.quadratic_faces) integrate_face(face);
  }
  // −p ∫ N_a n dA of the present faces.
  static Vector follower(const PressureLoad& load, const Vector& x) {
    Vector force = Vector::Zero(x.size());
    integrate(load, x,
              [&](const auto& face, const FacePoint& point, const Vector3&, const Vector3& area) {
                for (std::size_t a = 0; a < face.size(); ++a) {
                  vertex_block(force, face[a]) -=
                      load.value * point.shape[static_cast<Index>(a)] * area;
                }
              });
    return force;
  }
  // ⅓ ∫ x·n dA.
  static double volume(const PressureLoad& load, const Vector& x) {
    double sum = 0.0;
    integrate(load, x,
              [&](const auto&, const FacePoint&, const Vector3& position, const Vector3& area) {
                sum += position.dot(area) / 3.0;
              });
    return sum;
  }
  static Vector3 sum(const Vector& force) {
    return force.reshaped(3, force.size() / 3).rowwise().sum();
  }

  TetMesh mesh_;
  MechanicalSystem system_;
  Vector position_;
};

TEST_P(PressureOnABox, DerivativesAreThoseOfThePotential) {
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

TEST_P(PressureOnABox, TheForceIsThatOfThePresentTrianglesAlsoAtARim) {
  for (const Selection& selection : {Selection(SelectSurface{}), Selection(SelectPlane{0, 1.0, {}}),
                                     Selection(SelectBox{{-1.0, 0.29, -1.0}, {2.0, 1.0, 2.0}})}) {
    const PressureLoad load = pressure(selection, -2e4);
    const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
    const Vector expected = follower(load, position_);
    EXPECT_LT((force_of(term, position_) - expected).norm(), 1e-12 * expected.norm());
  }
}

// Minus the derivative of the load at a rim, which is quadratic in positions, its transpose and its symmetric
// part.
TEST_P(PressureOnABox, TheLoadStiffnessIsMinusItsDerivative) {
  const SurfacePressure term({pressure(SelectPlane{0, 1.0, {}}, -2e4)}, mesh_.rest_positions(),
                             system_.coordinates());
  LoadStiffness stiffness(2.0);
  term.add_load_stiffness(at(position_), stiffness);
  // The differences that a term of a user's program has.
  LoadStiffness by_differences(2.0);
  term.ForceTerm::add_load_stiffness(at(position_), by_differences);
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
  const Vector expected = 2.0 * derivative(u);
  Vector product = Vector::Zero(position_.size());
  stiffness.add_product(u, product);
  EXPECT_LT((product - expected).norm(), 1e-11 * expected.norm());
  product.setZero();
  by_differences.add_product(u, product);
  EXPECT_LT((product - expected).norm(), 1e-8 * expected.norm());
  Vector transposed = Vector::Zero(position_.size());
  stiffness.add_transposed_product(v, transposed);
  EXPECT_NEAR(transposed.dot(u), v.dot(expected), 1e-11 * std::abs(v.dot(expected)));
  // The stiffness is not symmetric.
  EXPECT_GT((transposed - 2.0 * derivative(v)).norm(), 1e-3 * expected.norm());
  HessianBlocks symmetric;
  symmetric.reset(mesh_.vertex_count());
  stiffness.add_symmetric_part(symmetric);
  product.setZero();
  symmetric.add_product(u, product);
  const double mean = v.dot(derivative(u)) + u.dot(derivative(v));
  EXPECT_NEAR(v.dot(product), mean, 1e-11 * std::abs(mean));
}

TEST_P(PressureOnABox, AClosedSurfaceHasNoResultantAndNoLoad) {
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
TEST_P(PressureOnABox, ARimInAPlaneOfSymmetryNeedsNoLoad) {
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

// Vertices on a plane that may only slide in it.
PrescribedVertices sliding_in(const TetMesh& mesh, int axis, double at) {
  PrescribedVertices sliding =
      prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{axis, at, {}}));
  sliding.components = {axis == 0, axis == 1, axis == 2};
  return sliding;
}

// Supports of the rim of the face y = 0.6 on which its forces do no work.
struct RimCase {
  std::string name;
  ConstraintList list;
};

std::vector<RimCase> resting_rims(const TetMesh& mesh) {
  const PrescribedVertices left = sliding_in(mesh, 0, 0.0);
  const PrescribedVertices right = sliding_in(mesh, 0, 1.0);
  const PrescribedVertices front = sliding_in(mesh, 2, 0.0);
  const PrescribedVertices back = sliding_in(mesh, 2, 0.8);
  const auto clamped = [&](const PrescribedVertices& at) {
    return prescribe_at_rest(mesh, at.vertices);
  };
  std::vector<RimCase> cases(2);
  cases[0] = {"two planes and two clamps", {}};
  cases[0].list.held = {left, front, clamped(right), clamped(back)};
  cases[1] = {"clamped all around", {}};
  cases[1].list.held = {clamped(left), clamped(front), clamped(right), clamped(back)};
  return cases;
}

// The pressure then has a potential, and its gradient is minus the whole force, also on supports.
TEST_P(PressureOnABox, ARimThatRestsOnSupportsHasNoLoad) {
  for (const RimCase& c : resting_rims(mesh_)) {
    SCOPED_TRACE(c.name);
    system_.set_constraints(Constraints(c.list, mesh_, system_.mass()));
    const FreeCoordinates& free = system_.coordinates();
    const PressureLoad load = pressure(SelectPlane{1, 0.6, {}}, 3e4);
    const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
    ASSERT_FALSE(term.has_load());
    Vector x = position_;
    system_.constraints().prescribe(0.0, x);
    const Vector expected = follower(load, x);
    const Vector force = force_of(term, x);
    EXPECT_LT((force - expected).norm(), 1e-12 * expected.norm());
    const Vector d = free.extend(jiggled(Vector::Zero(free.count()), 1.0, 3));
    const Vector e = free.extend(jiggled(Vector::Zero(free.count()), 1.0, 5));
    // U is of the third degree: its slope follows from four values.
    const auto energy = [&](double t) { return term.energy(at(Vector(x + t * d))); };
    constexpr double kStep = 0.05;
    const double slope =
        (8.0 * (energy(kStep) - energy(-kStep)) - (energy(2.0 * kStep) - energy(-2.0 * kStep))) /
        (12.0 * kStep);
    EXPECT_NEAR(slope, -force.dot(d), 1e-10 * force.norm() * d.norm());
    HessianBlocks hessian;
    hessian.reset(mesh_.vertex_count());
    term.add_hessian(at(x), HessianForm::kExact, hessian);
    Vector product = Vector::Zero(x.size());
    hessian.add_product(d, product);
    const Vector change =
        (force_of(term, x - kStep * d) - force_of(term, x + kStep * d)) / (2.0 * kStep);
    EXPECT_NEAR(product.dot(e), change.dot(e), 1e-10 * change.norm() * e.norm());
    // The discrete gradient gives the change of energy.
    const Vector y = x + 0.3 * d + 0.2 * e;
    Vector mean = Vector::Zero(x.size());
    term.add_discrete_gradient(at(x), at(y), mean);
    const double rise = term.energy(at(y)) - term.energy(at(x));
    EXPECT_NEAR(mean.dot(y - x), rise, 1e-11 * mean.norm() * (y - x).norm());
    EXPECT_NEAR(term.energy_change(at(x), at(y)), rise, 1e-11 * mean.norm() * (y - x).norm());
    EXPECT_NEAR(term.driven_work(at(x), at(y)), 0.0, 1e-11 * mean.norm() * (y - x).norm());
  }
}

// With one side of the rim free, between parallel planes, and with supports that move, there is a load.
TEST_P(PressureOnABox, ARimThatDoesNotRestOnItsSupportsHasALoad) {
  const std::vector<RimCase> cases = resting_rims(mesh_);
  system_.set_pressures({pressure(SelectPlane{1, 0.6, {}}, 3e4)});
  const auto has_load = [&](const ConstraintList& list) {
    system_.set_constraints(Constraints(list, mesh_, system_.mass()));
    return system_.has_load_of_position();
  };
  EXPECT_TRUE(has_load({}));
  for (const RimCase& c : cases) EXPECT_FALSE(has_load(c.list)) << c.name;
  ConstraintList changed = cases[1].list;
  for (PrescribedVertices& held : changed.held) held.motion.velocity = Vector3(0.1, 0.0, 0.0);
  EXPECT_TRUE(has_load(changed));
  changed = cases[1].list;
  changed.held.pop_back();
  EXPECT_TRUE(has_load(changed));
  changed = cases[0].list;
  changed.held[2] = sliding_in(mesh_, 0, 1.0);
  EXPECT_TRUE(has_load(changed));
}

TEST_P(PressureOnABox, TheEnergyChangeHasNoCancellation) {
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
TEST_P(PressureOnABox, TheWorkOfAStepIsThatOfTheMeanPressure) {
  PressureLoad load = pressure(SelectSurface{}, 1e4);
  load.history.amplitude =
      std::make_shared<const Amplitude>(Amplitude::piecewise_linear({{0.0, 1.0}, {1.0, 3.0}}));
  const SurfacePressure term({load}, mesh_.rest_positions(), system_.coordinates());
  const Vector rest = mesh_.rest_positions();
  const ForcePoint from = system_.force_point(rest, 0.2);
  const ForcePoint to = system_.force_point(position_, 0.6);
  const double work = -1.8e4 * (volume(load, position_) - 0.48);
  EXPECT_NEAR(term.driven_work(from, to) - term.energy_change(from, to), work,
              1e-9 * std::abs(work));
  EXPECT_NEAR(term.energy_change(from, to), term.energy(to) - term.energy(from),
              1e-9 * std::abs(term.energy(to)));
}

INSTANTIATE_TEST_SUITE_P(Elements, PressureOnABox, testing::Bool(),
                         [](const auto& test) { return test.param ? "Quadratic" : "Linear"; });

}  // namespace
}  // namespace tetraction
