#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/nodal_fields.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

using namespace testing_support;

class DerivedFields : public testing::Test {
 protected:
  // q = f X + t for every vertex.
  Vector moved(const Matrix3& f, const Vector3& t) const {
    Vector q(system_.dof_count());
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      q.segment<3>(3 * v) = f * system_.mesh().vertices[static_cast<std::size_t>(v)] + t;
    }
    return q;
  }
  const MechanicalSystem system_{small_block(), NeoHookean(2.0, 3.0), 1000.0};
  const Matrix3 rotation_ = Eigen::AngleAxisd(2.0, Vector3(1, -1, 2).normalized()).matrix();
};

TEST_F(DerivedFields, SimpleShearOfANeoHookeanBody) {
  constexpr double kShear = 0.4;
  Matrix3 f = Matrix3::Identity();
  f(0, 1) = kShear;
  const ElementFields fields = element_fields(system_, moved(f, {1, 2, 3}));
  // J = 1: σ = μ (F Fᵀ − I).
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    const double xx = 2.0 * kShear * kShear;
    const double xy = 2.0 * kShear;
    EXPECT_NEAR(fields.cauchy_stress(0, e), xx, 1e-12);
    EXPECT_NEAR(fields.cauchy_stress(1, e), 0.0, 1e-12);
    EXPECT_NEAR(fields.cauchy_stress(3, e), xy, 1e-12);
    EXPECT_NEAR(fields.cauchy_stress(4, e), 0.0, 1e-12);
    EXPECT_NEAR(fields.von_mises(0, e), std::sqrt(xx * xx + 3.0 * xy * xy), 1e-12);
    EXPECT_NEAR(fields.jacobian(0, e), 1.0, 1e-13);
    EXPECT_NEAR(fields.energy_density(0, e), 0.5 * 2.0 * kShear * kShear, 1e-12);
    EXPECT_NEAR(fields.green_strain(1, e), 0.5 * kShear * kShear, 1e-13);
    EXPECT_NEAR(fields.green_strain(3, e), 0.5 * kShear, 1e-13);
  }
}

// The largest difference of the columns of a field from column(e).
template <class Column>
double largest_difference(const Matrix& field, const Column& column) {
  double largest = 0.0;
  for (Index e = 0; e < field.cols(); ++e) {
    largest = std::max(largest, (field.col(e) - column(e)).norm());
  }
  return largest;
}

// Two fields that come from one loop have the bits that each has alone.
void expect_same_pairs(const MechanicalSystem& system, const Vector& q, const std::string& name) {
  Matrix first;
  Matrix second;
  stresses_and_energies(system, q, first, second);
  EXPECT_EQ(first, cauchy_stresses(system, q)) << name;
  EXPECT_EQ(second, energy_densities(system, q)) << name;
  strains_and_ratios(system, q, first, second);
  EXPECT_EQ(first, green_strains(system, q)) << name;
  EXPECT_EQ(second, Matrix(volume_ratios(system, q).transpose())) << name;
}

// The fields of all elements come from vectorised loops, those of one element from F, and stresses from P Fᵀ/J.
TEST(FieldsOfElements, AreThoseOfEachElementForEveryMaterialAndShape) {
  Matrix3 f;
  f << 1.2, 0.3, -0.1, 0.0, 0.9, 0.2, 0.1, 0.0, 1.1;
  for (const double thickness : {0.4, 0.02}) {  // the flat elements are computed one by one
    const TetMesh mesh = generate_box({1.0, 0.5, thickness}, {4, 3, 7});
    for (const MaterialModel& material : all_materials()) {
      for (const VolumeRule rule : {VolumeRule::kElement, VolumeRule::kNodal}) {
        std::optional<MechanicalSystem> system;
        try {
          system.emplace(mesh, std::vector<BodyRegion>{{material, 1000.0}}, std::vector<int>{},
                         rule);
        } catch (const InputError&) {
          continue;  // a material without nodal volumes
        }
        Vector q(system->dof_count());
        for (Index v = 0; v < system->vertex_count(); ++v) {
          const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
          q.segment<3>(3 * v) =
              f * x + 0.1 * x.x() * x.x() * Vector3(0.3, 1.0, -0.2) + Vector3(10.0, -20.0, 5.0);
        }
        const Matrix stresses = cauchy_stresses(*system, q);
        ASSERT_EQ(stresses.cols(), mesh.tetrahedron_count());
        const double size = stresses.colwise().norm().maxCoeff();
        const auto stress_of = [&](Index e) {
          return six_components(cauchy_stress(*system, e, q));
        };
        const auto strain_of = [&](Index e) {
          return six_components(values_at(*system, e, {0.25, 0.25, 0.25, 0.25}, q).green_strain);
        };
        const auto ratio_of = [&](Index e) {
          return Vector::Constant(1, volume_ratio(*system, e, q));
        };
        ElasticPotential::ElementTerms terms;
        const auto density_of = [&](Index e) {
          EXPECT_TRUE(system->elastic().element_terms(e, q, false, terms));
          return Vector::Constant(1, terms.energy / system->rest().volume(e));
        };
        Vector densities;
        system->elastic().energy_densities(q, densities);
        const std::string name = material_name(material) + " " + std::to_string(thickness);
        // The positions are 20 m, and edges of 3 mm are differences of them.
        EXPECT_LT(largest_difference(stresses, stress_of), 1e-11 * size) << name;
        EXPECT_GT(size, 0.0);
        EXPECT_LT(largest_difference(green_strains(*system, q), strain_of), 1e-12) << name;
        EXPECT_LT(largest_difference(volume_ratios(*system, q).transpose(), ratio_of), 1e-12)
            << name;
        EXPECT_LT(largest_difference(densities.transpose(), density_of),
                  1e-11 * densities.maxCoeff())
            << name;
        EXPECT_GT(densities.minCoeff(), 0.0);
        expect_same_pairs(*system, q, name);
      }
    }
  }
}

// The energy densities of a motion that fails are those where they are defined.
TEST(FieldsOfElements, HaveNoEnergyWhereItIsNotDefined) {
  const TetMesh mesh = generate_box({1.0, 0.5, 0.4}, {4, 3, 3});
  for (const MaterialModel& material : {MaterialModel(NeoHookean(2.0, 3.0)),
                                        MaterialModel(mooney_rivlin_from_young(1.0, 0.4, 0.25)),
                                        MaterialModel(Gent(2.0, 3.0, 0.5))}) {
    const MechanicalSystem system(mesh, material, 1000.0);
    Vector q = mesh.rest_positions();
    // The first vertex turns tetrahedra inside out and stretches others beyond the limit of Gent's law.
    q[0] += 0.4;
    q.tail<3>() *= 1.1;
    Vector densities;
    system.elastic().energy_densities(q, densities);
    Index undefined = 0;
    ElasticPotential::ElementTerms terms;
    for (Index e = 0; e < densities.size(); ++e) {
      const bool is_defined = system.elastic().element_terms(e, q, false, terms);
      const double density = is_defined ? terms.energy / system.rest().volume(e) : 0.0;
      EXPECT_NEAR(densities[e], density, 1e-13 + 1e-12 * density) << e;
      if (!is_defined) ++undefined;
    }
    EXPECT_GT(undefined, 0) << material_name(material);
    EXPECT_LT(undefined, 20) << material_name(material);
    EXPECT_GT(densities.maxCoeff(), 0.01) << material_name(material);
  }
}

// P = J σ F⁻ᵀ; the invariants of σ do not depend on the axes.
TEST_F(DerivedFields, FurtherStressesFitTheCauchyStress) {
  Matrix3 f;
  f << 1.2, 0.3, -0.1, 0.0, 0.9, 0.2, 0.1, 0.0, 1.1;
  const Vector q = moved(f, {1, 2, 3});
  const ElementFields fields = element_fields(system_, q);
  const Matrix first_piola = first_piola_stress(system_, q);
  const Matrix principal = principal_stresses(fields.cauchy_stress);
  const Matrix pressure = pressures(fields.cauchy_stress);
  ASSERT_EQ(first_piola.rows(), 9);
  ASSERT_EQ(principal.rows(), 3);
  ASSERT_EQ(pressure.rows(), 1);
  for (Index e = 0; e < first_piola.cols(); ++e) {
    const Matrix3 stress = cauchy_stress(system_, e, q);
    EXPECT_NEAR((six_components(stress) - fields.cauchy_stress.col(e)).norm(), 0.0, 1e-13);
    const Matrix3 expected = f.determinant() * stress * f.inverse().transpose();
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        EXPECT_NEAR(first_piola(3 * i + j, e), expected(i, j), 1e-12);
      }
    }
    const Vector3 s = principal.col(e);
    EXPECT_GE(s[0], s[1]);
    EXPECT_GE(s[1], s[2]);
    EXPECT_NEAR(s.sum(), stress.trace(), 1e-12);
    EXPECT_NEAR(s.prod(), stress.determinant(), 1e-12);
    EXPECT_NEAR(s.squaredNorm(), stress.squaredNorm(), 1e-12);
    EXPECT_NEAR(pressure(0, e), -stress.trace() / 3.0, 1e-13);
    EXPECT_NEAR(von_mises(stress), fields.von_mises(0, e), 1e-13);
  }
}

TEST_F(DerivedFields, NodalAveragesAreWeightedByTheVolumes) {
  const RestState& rest = system_.rest();
  Matrix field(2, rest.element_count());
  for (Index e = 0; e < field.cols(); ++e) {
    field(0, e) = 7.0;
    field(1, e) = std::sin(static_cast<double>(e));
  }
  const Matrix average = nodal_average(system_, field);
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    double sum = 0.0;
    double volume = 0.0;
    for (Index e = 0; e < field.cols(); ++e) {
      for (const Index corner : rest.nodes(e)) {
        if (corner != v) continue;
        sum += rest.volume(e) * field(1, e);
        volume += rest.volume(e);
      }
    }
    EXPECT_NEAR(average(0, v), 7.0, 1e-14);
    EXPECT_NEAR(average(1, v), sum / volume, 1e-14);
  }
}

TEST_F(DerivedFields, RecoveryOfALinearFieldIsExact) {
  // Irregular vertices; those at the edges and corners of the block have patches of few elements.
  for (const std::array<int, 3>& cells : {std::array{4, 3, 3}, {6, 5, 2}}) {
    TetMesh mesh = small_block(cells);
    const Vector moved = jiggled(mesh.rest_positions(), 0.03);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      mesh.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(moved, v);
    }
    const MechanicalSystem system(mesh, NeoHookean(2.0, 3.0), 1000.0);
    const auto linear = [](const Vector3& x) {
      return Eigen::Vector2d(3.0 - 2.0 * x[0] + 5.0 * x[1] + x[2], x[1] - 4.0 * x[2]);
    };
    Matrix field(2, mesh.tetrahedron_count());
    for (Index e = 0; e < field.cols(); ++e) field.col(e) = linear(system.rest().center(e));
    const Matrix recovered = recovered_field(system, field);
    const Matrix average = nodal_average(system, field);
    double error = 0.0;
    double error_of_means = 0.0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector2d exact = linear(mesh.vertices[static_cast<std::size_t>(v)]);
      error = std::max(error, (recovered.col(v) - exact).norm());
      error_of_means = std::max(error_of_means, (average.col(v) - exact).norm());
    }
    EXPECT_LT(error, 1e-11);
    EXPECT_GT(error_of_means, 0.5);
  }
}

// The stresses of linear tetrahedra in a bent block: recovered ones converge with order 2 at all vertices,
// means with order 1 at those on the surface.
TEST_F(DerivedFields, RecoveredStressesConvergeWithOrderTwo) {
  std::array<double, 2> errors{};
  std::array<double, 2> errors_of_means{};
  for (std::size_t i = 0; i < 2; ++i) {
    const int n = i == 0 ? 6 : 12;
    const TetMesh mesh = small_block({2 * n, n, n});
    const MechanicalSystem system(mesh, StVenantKirchhoff(1.0, 2.0), 1000.0);
    constexpr double kSmall = 1e-7;
    Vector q = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
      vertex_block(q, v) +=
          kSmall * Vector3(std::sin(x[1]) * x[0], std::cos(x[2] + x[0]), std::exp(x[0] - x[1]));
    }
    const Matrix stress = element_fields(system, q).cauchy_stress;
    const Matrix recovered = recovered_field(system, stress) / kSmall;
    const Matrix average = nodal_average(system, stress) / kSmall;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
      Matrix3 gradient;
      const double s = -std::sin(x[2] + x[0]);
      const double e = std::exp(x[0] - x[1]);
      gradient << std::sin(x[1]), std::cos(x[1]) * x[0], 0.0, s, 0.0, s, e, -e, 0.0;
      const Matrix3 exact =
          2.0 * gradient.trace() * Matrix3::Identity() + gradient + gradient.transpose();
      errors[i] = std::max(errors[i], (recovered.col(v) - six_components(exact)).norm());
      errors_of_means[i] =
          std::max(errors_of_means[i], (average.col(v) - six_components(exact)).norm());
    }
  }
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.6);
  EXPECT_LT(std::log2(errors_of_means[0] / errors_of_means[1]), 1.2);
  EXPECT_LT(errors[1], 0.3 * errors_of_means[1]);
}

TEST_F(DerivedFields, RigidMotionIsNoDeformation) {
  const Matrix deformation = deformation_field(system_, moved(rotation_, {5, -1, 2}));
  EXPECT_LT(deformation.cwiseAbs().maxCoeff(), 1e-13);
}

// The best fit leaves neither a mean displacement nor a rotation: Σ m d = 0 and
// Σ m d × (q − q̄) = 0 (the misfit's derivative by the rotation).
TEST_F(DerivedFields, BestFitLeavesNeitherTranslationNorRotation) {
  Matrix3 stretch = Matrix3::Identity();
  stretch(0, 0) = 1.2;
  stretch(0, 2) = 0.1;
  const Vector q = moved(rotation_ * stretch, {5, -1, 2});
  const Matrix deformation = deformation_field(system_, q);
  ASSERT_GT(deformation.cwiseAbs().maxCoeff(), 0.05);
  const Vector3 center = center_of_mass(system_, q);
  Vector3 translation = Vector3::Zero();
  Vector3 rotation = Vector3::Zero();
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const Vector3 d = deformation.col(v);
    const Vector3 arm = q.segment<3>(3 * v) - center;
    translation += system_.mass()[v] * d;
    rotation += system_.mass()[v] * d.cross(arm);
  }
  EXPECT_LT(translation.norm(), 1e-11 * system_.total_mass());
  EXPECT_LT(rotation.norm(), 1e-11 * system_.total_mass());
}

TEST_F(DerivedFields, RotationStaysProperForMirroredAndFlatShapes) {
  for (const double z : {-1.0, 0.0}) {
    Matrix3 f = Matrix3::Identity();
    f(2, 2) = z;
    const Matrix deformation = deformation_field(system_, moved(f, Vector3::Zero()));
    ASSERT_TRUE(deformation.allFinite());
    // A mirror image cannot be rotated away: something of the size of the body is left.
    EXPECT_GT(deformation.cwiseAbs().maxCoeff(), 0.1);
  }
}

}  // namespace
}  // namespace tetraction
