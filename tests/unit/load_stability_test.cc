// Motions that loads feed against all eigenvalues of dense matrices.
#include "solver/modes/load_stability.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <complex>
#include <vector>

#include "support/bodies.h"
#include "support/dense_matrices.h"
#include "tetraction/material/neo_hookean.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A clamped beam of 4 × 1 × 1 with a pressure on its upper side, whose rim is free. `size` and `modulus` are those
// of the units.
struct Beam {
  TetMesh mesh;
  MechanicalSystem system;
  NormalModeOptions options;

  Beam(bool quadratic, double pressure, double size = 1.0, double modulus = 1e6)
      : mesh(make_mesh(quadratic, size)),
        system(mesh,
               NeoHookean(lame_from_young(modulus, 0.3).mu, lame_from_young(modulus, 0.3).lambda),
               1000.0) {
    constrain({});
    const std::vector<std::array<Index, 3>> top = select_triangles(mesh, SelectPlane{1, size, {}});
    system.set_pressures({PressureLoad{top, pressure * modulus, {}}});
    options.with_loads = true;
  }
  static TetMesh make_mesh(bool quadratic, double size) {
    const Vector3 lengths = size * Vector3(4, 1, 1);
    return quadratic ? with_edge_vertices(generate_box(lengths, {3, 1, 1}))
                     : generate_box(lengths, {6, 2, 2});
  }
  void constrain(std::vector<FixedDistance> distances) {
    const PrescribedVertices clamp =
        prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}), "clamp");
    system.set_constraints(
        Constraints({{clamp}, {}, std::move(distances), {}}, mesh, system.mass()));
  }
  Vector rest() const { return mesh.rest_positions(); }
  bool is_sure(double growth) const {
    return examine_loads(system, rest(), options, growth).is_bounded;
  }

  // In coordinates that the constraints allow.
  DenseMatrices matrices() const {
    const Vector q = rest();
    DenseMatrices all = dense_matrices(system, q);
    const Index n = all.mass.rows();
    const Constraints& constraints = system.constraints();
    if (constraints.has_equations()) {
      const Matrix b = constraints.selector();
      all.stiffness += b * constraints.curvature(options.multipliers) * b.transpose();
      const Matrix gradients = b * constraints.gradients(constraints.configuration(q));
      const Matrix basis = Eigen::HouseholderQR<Matrix>(gradients).householderQ();
      const Matrix allowed = basis.rightCols(n - gradients.cols());
      for (Matrix* matrix : {&all.mass, &all.damping, &all.stiffness}) {
        *matrix = allowed.transpose() * *matrix * allowed;
      }
    }
    return all;
  }
  // ϱ from the eigenvalues of S⁻¹R; 0 if S is not positive definite.
  double coupling() const {
    const Matrix k = matrices().stiffness;
    const Matrix symmetric = 0.5 * (k + k.transpose());
    if (symmetric.llt().info() != Eigen::Success) return 0.0;
    const Matrix skew = 0.5 * (k - k.transpose());
    return Eigen::EigenSolver<Matrix>(symmetric.partialPivLu().solve(skew), false)
        .eigenvalues()
        .cwiseAbs()
        .maxCoeff();
  }
  // All λ of λ²M + λC + K with Im λ > 0, and those that diverge, in the order of |λ|.
  std::vector<std::complex<double>> rates() const {
    return rates_of(matrices(), [](const std::complex<double>& value) {
      return value.imag() > 0.0 || (value.imag() == 0.0 && value.real() > 0.0);
    });
  }
};

// The growth for each radian is ½ϱ at most. What is less is not sure, what is well above it is.
void expect_bound(const Beam& beam) {
  const double coupling = beam.coupling();
  ASSERT_GT(coupling, 1e-5);
  EXPECT_FALSE(beam.is_sure(0.49 * coupling));
  EXPECT_FALSE(beam.is_sure(0.01 * coupling));
  EXPECT_TRUE(beam.is_sure(0.75 * coupling));
  EXPECT_TRUE(beam.is_sure(100.0 * coupling));
}

TEST(LoadStability, IsThatOfDenseMatrices) {
  for (const bool quadratic : {false, true}) {
    for (const double pressure : {1e-4, 1e-3, -1e-3}) expect_bound(Beam(quadratic, pressure));
  }
}

TEST(LoadStability, InTheSpaceThatARodAllows) {
  Beam beam(false, 1e-3);
  beam.constrain({FixedDistance{0, 6, 4.0, "rod"}});
  for (const double tension : {0.0, 5e3, -5e3}) {
    beam.options.multipliers = Vector::Constant(1, tension);
    expect_bound(beam);
  }
}

TEST(LoadStability, DoesNotDependOnUnits) {
  const double coupling = Beam(false, 1e-3).coupling();
  for (const double size : {1e-6, 1e3}) {
    for (const double modulus : {1e-10, 1e12}) {
      const Beam beam(false, 1e-3, size, modulus);
      EXPECT_FALSE(beam.is_sure(0.49 * coupling)) << size << ' ' << modulus;
      EXPECT_TRUE(beam.is_sure(0.75 * coupling)) << size << ' ' << modulus;
    }
  }
}

// The motions of a beam with a pressure on its tip or on its upper side, without and with damping: which of the six
// lowest grows fastest is that of all roots of the dense problem.
TEST(LoadStability, FindsTheFastestMotion) {
  struct Case {
    SelectPlane face;
    double pressure, viscosity, mass_damping;
    bool quadratic, grows;
  };
  const SelectPlane tip{0, 4.0, {}};
  const SelectPlane top{1, 1.0, {}};
  for (const Case& c :
       {Case{tip, 0.01, 0.0, 0.0, true, false}, Case{tip, 0.07, 50.0, 0.0, true, false},
        Case{top, 0.01, 50.0, 0.0, true, false}, Case{top, 0.03, 0.0, 0.0, false, true},
        Case{top, 0.03, 50.0, 0.0, false, true}, Case{top, 0.03, 50.0, 0.1, false, true},
        Case{top, 0.03, 50.0, 0.5, false, false}, Case{top, -0.05, 50.0, 0.0, false, true},
        Case{top, 0.05, 50.0, 0.0, false, true}, Case{tip, -0.02, 0.0, 0.0, true, true},
        Case{tip, -0.02, 50.0, 1.0, false, false}, Case{tip, 0.12, 0.0, 0.0, true, false}}) {
    Beam beam(c.quadratic, 0.0);
    const auto face = select_triangles(beam.mesh, c.face);
    beam.system.set_pressures({PressureLoad{face, c.pressure * 1e6, {}}});
    beam.system.set_damping({0.0, c.mass_damping, c.viscosity});
    beam.options.count = 6;
    const LoadStability found = examine_loads(beam.system, beam.rest(), beam.options, 1e-3);
    EXPECT_TRUE(found.is_known) << c.pressure;
    double fastest = 0.0;
    double ratio = 0.0;
    const std::vector<std::complex<double>> rates = beam.rates();
    for (std::size_t i = 0; i < 6; ++i) {
      if (!(rates[i].real() > std::max(fastest, 1e-3 * std::abs(rates[i])))) continue;
      fastest = rates[i].real();
      ratio = fastest / std::abs(rates[i]);
    }
    EXPECT_EQ(fastest > 0.0, c.grows) << c.pressure << ' ' << c.viscosity << ' ' << c.mass_damping;
    EXPECT_NEAR(found.growth_rate, fastest, 1e-6 * fastest);
    EXPECT_NEAR(found.ratio, ratio, 1e-6 * ratio);
    EXPECT_EQ(found.is_flutter, c.grows && ratio < 0.999999);
  }
}

// A body that may move freely, or that a rod in compression lets go away, is not sure to be stable.
TEST(LoadStability, NothingIsSureWithoutPositiveStiffness) {
  Beam beam(false, 1e-4);
  beam.constrain({FixedDistance{0, 6, 4.0, "rod"}});
  beam.options.multipliers = Vector::Constant(1, -5e6);
  EXPECT_EQ(beam.coupling(), 0.0);
  EXPECT_FALSE(beam.is_sure(0.5));
  Beam free(false, 1e-4);
  free.system.set_constraints(Constraints(free.mesh.vertex_count()));
  EXPECT_FALSE(free.is_sure(0.5));
}

}  // namespace
}  // namespace tetraction
