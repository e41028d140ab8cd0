// Equilibria of loaded bodies against the closed solutions of linear elasticity.
#include <cmath>
#include <numbers>
#include <optional>

#include "support/runs.h"
#include "tetraction/dynamics/terms/consistent_loads.h"
#include "tetraction/dynamics/terms/vertex_potential.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A body that has the tetrahedra of a box, whose vertices are moved by `map`.
template <class Map>
TetMesh mapped_box(const Vector3& size, const std::array<int, 3>& cells, const Map& map) {
  TetMesh mesh = generate_box(size, cells);
  for (Vector3& x : mesh.vertices.own()) x = map(Vector3(x));
  return mesh;
}

PrescribedVertices sliding(const TetMesh& mesh, const Selection& selection, std::size_t axis) {
  PrescribedVertices held = prescribe_at_rest(mesh, select_vertices(mesh, selection));
  held.components = {false, false, false};
  held.components[axis] = true;
  return held;
}

// The relative error of the sum of all displacements away from the z axis, which should be exact(r).
template <class Exact>
double radial_error(const TetMesh& mesh, const Vector& position, const Exact& exact) {
  double sum = 0.0;
  double expected = 0.0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
    const double r = std::hypot(x.x(), x.y());
    if (r == 0.0) continue;
    const Vector3 u = vertex_block(position, v) - x;
    sum += (u.x() * x.x() + u.y() * x.y()) / r;
    expected += exact(r);
  }
  return std::abs(sum / expected - 1.0);
}

// Holds the three planes of symmetry x = 0, y = 0 and z = 0, and another plane z if one is given.
Constraints symmetric(const MechanicalSystem& system, std::optional<double> another_z = {}) {
  const TetMesh& mesh = system.mesh();
  ConstraintList list;
  for (int axis = 0; axis < 3; ++axis) {
    list.held.push_back(sliding(mesh, SelectPlane{axis, 0.0, {}}, static_cast<std::size_t>(axis)));
  }
  if (another_z) list.held.push_back(sliding(mesh, SelectPlane{2, *another_z, {}}, 2));
  return Constraints(list, mesh, system.mass());
}

MaterialModel soft(double young, double poisson) {
  const LameParameters lame = lame_from_young(young, poisson);
  return StVenantKirchhoff(lame.mu, lame.lambda);
}

// A quarter of a long tube, which cannot become longer, under a pressure inside. Lamé's displacement
// is u(r) = p a² r (1 + ν)/(E (b² − a²)) (1 − 2ν + b²/r²).
TEST(ClosedForm, ATubeUnderPressureInside) {
  constexpr double kInner = 1.0;
  constexpr double kOuter = 2.0;
  constexpr double kYoung = 1e6;
  constexpr double kPoisson = 0.3;
  constexpr double kPressure = 100.0;
  double errors[2] = {};
  for (const int level : {0, 1}) {
    const int n = level == 0 ? 8 : 16;
    const TetMesh mesh = mapped_box({1.0, 1.0, 0.2}, {n, n, 2}, [&](const Vector3& x) {
      const double r = kInner + (kOuter - kInner) * x.x();
      const double angle = 0.5 * std::numbers::pi * x.y();
      // Exactly zero on the planes of symmetry.
      return Vector3(x.y() == 1.0 ? 0.0 : r * std::cos(angle),
                     x.y() == 0.0 ? 0.0 : r * std::sin(angle), x.z());
    });
    MechanicalSystem system(mesh, soft(kYoung, kPoisson), 1000.0);
    system.set_constraints(symmetric(system, 0.2));
    PressureLoad pressure;
    for (const auto& triangle : boundary_faces(mesh)) {
      const bool is_inside = std::all_of(triangle.begin(), triangle.end(), [&](Index v) {
        const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
        return std::hypot(x.x(), x.y()) < kInner * (1.0 + 1e-9);
      });
      if (is_inside) pressure.triangles.push_back(triangle);
    }
    ASSERT_EQ(pressure.triangles.size(), static_cast<std::size_t>(4 * n));
    pressure.value = kPressure;
    system.set_pressures({pressure});
    const Equilibrium equilibrium = find_equilibrium(system);
    ASSERT_TRUE(equilibrium.found) << equilibrium.message;
    errors[level] = radial_error(mesh, equilibrium.position, [&](double r) {
      return kPressure * kInner * kInner * r * (1.0 + kPoisson) /
             (kYoung * (kOuter * kOuter - kInner * kInner)) *
             (1.0 - 2.0 * kPoisson + kOuter * kOuter / (r * r));
    });
  }
  EXPECT_LT(errors[1], 0.01);
  EXPECT_LT(errors[1], 0.35 * errors[0]);
}

// U = −½ m ω² (x² + y²), the centrifugal potential of a body that turns about the z axis.
class Centrifugal : public VertexPotential {
 public:
  explicit Centrifugal(double omega) : squared_(omega * omega) {}
  std::string name() const override { return "centrifugal"; }
  double value(double mass, const Vector3& x) const override {
    return -0.5 * mass * squared_ * (x.x() * x.x() + x.y() * x.y());
  }
  Vector3 gradient(double mass, const Vector3& x) const override {
    return -mass * squared_ * Vector3(x.x(), x.y(), 0.0);
  }
  Matrix3 hessian(double mass, const Vector3& /*x*/) const override {
    return -mass * squared_ * Matrix3(Vector3(1.0, 1.0, 0.0).asDiagonal());
  }

 private:
  double squared_;
};

// A thin disc that turns: u(r) = ρω² (1 − ν) r ((3 + ν) a² − (1 + ν) r²)/(8E).
TEST(ClosedForm, ARotatingDisc) {
  constexpr double kRadius = 1.0;
  constexpr double kYoung = 1e6;
  constexpr double kPoisson = 0.3;
  constexpr double kDensity = 1000.0;
  constexpr double kOmega = 0.3;
  double errors[2] = {};
  for (const int level : {0, 1}) {
    const int n = level == 0 ? 8 : 16;
    // A quarter: the square becomes the quarter of a circle.
    const TetMesh mesh = mapped_box({1.0, 1.0, 0.02}, {n, n, 1}, [&](const Vector3& x) {
      return Vector3(x.x() * std::sqrt(1.0 - 0.5 * x.y() * x.y()),
                     x.y() * std::sqrt(1.0 - 0.5 * x.x() * x.x()), x.z());
    });
    MechanicalSystem system(mesh, soft(kYoung, kPoisson), kDensity);
    system.add_force_term(std::make_shared<Centrifugal>(kOmega));
    system.set_constraints(symmetric(system));
    const Equilibrium equilibrium = find_equilibrium(system);
    ASSERT_TRUE(equilibrium.found) << equilibrium.message;
    errors[level] = radial_error(mesh, equilibrium.position, [&](double r) {
      return kDensity * kOmega * kOmega * (1.0 - kPoisson) * r *
             ((3.0 + kPoisson) * kRadius * kRadius - (1.0 + kPoisson) * r * r) / (8.0 * kYoung);
    });
  }
  EXPECT_LT(errors[1], 0.01);
  EXPECT_LT(errors[1], 0.35 * errors[0]);
}

// A bar that is pulled by a traction: the stretch is that of the constitutive law, on any mesh.
TEST(ClosedForm, ABarUnderTractionIsUniform) {
  for (const std::array<int, 3> cells : {std::array{1, 1, 1}, {5, 3, 2}}) {
    const TetMesh mesh = generate_box({1.0, 0.3, 0.2}, cells);
    MechanicalSystem system(mesh, soft(1e6, 0.3), 1000.0);
    system.set_constraints(symmetric(system));
    system.add_force(distributed_force(
        surface_distribution(mesh, select_triangles(mesh, SelectPlane{0, 1.0, {}})),
        Vector3(2e5, 0.0, 0.0)));
    const Equilibrium equilibrium = find_equilibrium(system);
    ASSERT_TRUE(equilibrium.found) << equilibrium.message;
    // St Venant–Kirchhoff in uniaxial stress: P = E s (s² − 1)/2 for the stretch s.
    double stretch = 1.2;
    for (int i = 0; i < 50; ++i) {
      stretch -= (0.5e6 * stretch * (stretch * stretch - 1.0) - 2e5) /
                 (0.5e6 * (3.0 * stretch * stretch - 1.0));
    }
    const double across = std::sqrt(1.0 - 0.3 * (stretch * stretch - 1.0));
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
      const Vector3 expected(stretch * x.x(), across * x.y(), across * x.z());
      EXPECT_LT((vertex_block(equilibrium.position, v) - expected).norm(), 1e-12);
    }
  }
}

// Stretches far from rest, where the stiffness is up to 1e4 times that at rest and round-off of the forces is, too. The
// stretches along and across solve P₁ = traction and P₂ = 0, in forty digits. Forces of 7e-4 N, the round-off of the
// second body, move it by 1e-10 of its length.
TEST(ClosedForm, ABarFarFromRestIsInEquilibriumUpToRoundOff) {
  struct Case {
    MaterialModel material;
    double traction;
    double along;
    double across;
  };
  const Case cases[] = {
      {Gent(4e5, 1.0, 1e6), 1e8, 3.80948534784994619520, 1.75846995484542921140},
      {Ogden({4e5}, {2.0}, 1e6), 1e7, 232.355534265381952523, 0.349206656099503294915}};
  const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {1, 1, 1});
  for (const Case& bar : cases) {
    for (const double increment : {1.0, 0.01}) {
      MechanicalSystem system(mesh, bar.material, 1000.0);
      system.set_constraints(symmetric(system));
      system.add_force(distributed_force(
          surface_distribution(mesh, select_triangles(mesh, SelectPlane{0, 1.0, {}})),
          Vector3(bar.traction, 0.0, 0.0)));
      const Equilibrium equilibrium = find_equilibrium(system, {}, 0.0, increment);
      ASSERT_TRUE(equilibrium.found) << material_name(bar.material) << equilibrium.message;
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
        const Vector3 expected(bar.along * x.x(), bar.across * x.y(), bar.across * x.z());
        EXPECT_LT((vertex_block(equilibrium.position, v) - expected).norm(), 1e-10 * bar.along);
      }
    }
  }
}

}  // namespace
}  // namespace tetraction
