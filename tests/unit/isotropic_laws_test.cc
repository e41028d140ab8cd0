// All isotropic laws: kernels against the element by element sums, tangent operators
// against the assembled stiffness, and closed forms.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "fem/tangent_operator.h"
#include "support/assembled.h"
#include "support/bodies.h"
#include "support/instruction_sets.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr VolumetricPart kQuadratic = VolumetricPart::kQuadratic;

struct NamedLaw {
  std::string name;
  MaterialModel law;
};
// A filled rubber (C₂₀ < 0), laws with another volumetric part, and all models of the program. All have the same
// small strains.
std::vector<NamedLaw> laws() {
  const LameParameters lame = lame_from_young(1e6, 0.4);
  const double mu2 = 0.3 * lame.mu;
  std::vector<NamedLaw> all{
      {"filled", Yeoh::from_young(lame, -0.06 * lame.mu, 0.02 * lame.mu)},
      {"one_term", Yeoh::from_young(lame, 0.0, 0.0)},
      {"quadratic_neo_hookean", NeoHookean(lame.mu, lame.lambda, kQuadratic)},
      {"quadratic_mooney_rivlin",
       MooneyRivlin(lame.mu - mu2, mu2, lame.lambda - 2.0 * mu2, kQuadratic)}};
  for (const MaterialModel& law : materials_like(lame)) {
    std::string name = material_name(law);
    std::replace(name.begin(), name.end(), '-', '_');
    all.push_back({name, law});
  }
  return all;
}
// The name of a law, and that of all laws in one body behind the last one.
std::string law_name(std::size_t which) {
  return which < laws().size() ? laws()[which].name : "mixed";
}

// The law with every parameter of element e multiplied by a factor of its own between 0.6 and 1.4. A
// Yeoh material may become unstable by that, but these tests need no stability.
MaterialField varying(const MaterialModel& law, Index elements) {
  std::vector<IsotropicModel> models;
  for (Index e = 0; e < elements; ++e) {
    std::visit(
        [&]<class M>(const M& m) {
          if constexpr (!std::same_as<M, CustomMaterial>) {
            auto values = m.parameter_values();
            for (std::size_t i = 0; i < values.size(); ++i) {
              values[i] *=
                  1.0 + 0.4 * std::sin(static_cast<double>(17 * e + 5 * static_cast<Index>(i)));
            }
            models.emplace_back(MaterialField::with_parameters(m, values.data()));
          }
        },
        law);
  }
  return MaterialField(models);
}

class Laws : public testing::TestWithParam<std::tuple<std::int64_t, std::size_t, bool>> {
 protected:
  std::vector<MaterialField> materials(Index elements) const {
    const std::size_t which = std::get<1>(GetParam());
    std::vector<MaterialField> fields;
    for (const auto& [name, law] :
         which < laws().size() ? std::vector<NamedLaw>{laws()[which]} : laws()) {
      fields.push_back(std::get<2>(GetParam()) ? varying(law, elements) : MaterialField(law));
    }
    return fields;
  }
  static std::vector<int> regions(Index elements) {
    std::vector<int> region(static_cast<std::size_t>(elements));
    for (Index e = 0; e < elements; ++e)
      region[static_cast<std::size_t>(e)] = static_cast<int>(e % static_cast<Index>(laws().size()));
    return region;
  }
  const UseInstructionSet use_{std::get<0>(GetParam())};
};

void expect_like_elements(const ElasticPotential& potential, const Vector& q, double tolerance) {
  double sum = 0.0;
  double scale = 0.0;
  Vector expected = Vector::Zero(q.size());
  for (Index e = 0; e < potential.rest().element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    ASSERT_TRUE(potential.element_terms(e, q, false, terms));
    sum += terms.energy;
    scale += terms.gradient.squaredNorm();
    for (int a = 0; a < 4; ++a) {
      expected.segment<3>(3 * potential.rest().nodes(e)[static_cast<std::size_t>(a)]) +=
          terms.gradient.col(a);
    }
  }
  double alone = 0.0;
  double energy = 0.0;
  Vector gradient;
  ASSERT_TRUE(potential.value(q, alone).ok());
  ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());
  EXPECT_EQ(alone, energy);
  EXPECT_NEAR(energy, sum, tolerance * sum);
  EXPECT_LT((gradient - expected).norm(), tolerance * std::sqrt(scale));
}

TEST_P(Laws, KernelsAgreeWithTheScalarElement) {
  const TetMesh mesh = small_block({9, 5, 5});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, materials(rest.element_count()),
                                   regions(rest.element_count()));
  for (const double strain : {0.05, 0.2}) {
    expect_like_elements(potential, strained_state(potential, mesh.rest_positions(), strain),
                         1e-13);
  }
  const Vector q = strained_state(potential, mesh.rest_positions(), 0.1);
  for (const double factor : {0.3, 0.9, 0.95, 1.05, 1.1, 4.0}) {
    expect_like_elements(potential, factor * q, 2e-13);
  }
}

// In displacements that the positions hold exactly, energies keep their digits down to strains of 1e-8.
TEST_P(Laws, KernelsKeepTheDigitsOfTinyEnergies) {
  const TetMesh mesh = generate_box({2, 1, 1}, {4, 2, 2});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, materials(rest.element_count()),
                                   regions(rest.element_count()));
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  for (const double strain : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8}) {
    Vector q = mesh.rest_positions();
    const Vector moved = jiggled(Vector::Zero(q.size()), 0.5 * strain);
    for (Index i = 0; i < q.size(); ++i) {
      q[i] += std::ldexp(std::round(std::ldexp(moved[i], 40)), -40);
    }
    expect_like_elements(potential, q, 32.0 * kEpsilon / strain);
  }
}

TEST_P(Laws, TangentOperatorsAgreeWithTheElements) {
  const TetMesh mesh = small_block({8, 5, 5});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, materials(rest.element_count()),
                                   regions(rest.element_count()));
  const Vector q = strained_state(potential, mesh.rest_positions(), 0.2);
  const Vector start = strained_state(potential, mesh.rest_positions(), 0.05);
  const Vector x = jiggled(Vector::Zero(q.size()), 0.3, 3);
  ViscousPotential viscous(potential);
  const SparsityPattern pattern(rest, FreeCoordinates(rest.vertex_count()));
  for (const double factor : {0.0, 3e5}) {
    viscous.begin(start, factor);
    // From the matrices of single elements.
    Vector product = Vector::Zero(q.size());
    Matrix diagonal = Matrix::Zero(3, q.size());
    for (Index e = 0; e < rest.element_count(); ++e) {
      ElasticPotential::ElementTerms terms;
      ASSERT_TRUE(potential.element_terms(e, q, true, terms));
      viscous.add_element_terms(e, Positions(start, q - start), true, terms);
      const RestState::Shape::NodeMatrix local = rest.gather(x, e);
      const RestState::Shape::DofVector force =
          terms.hessian * Eigen::Map<const RestState::Shape::DofVector>(local.data());
      for (int a = 0; a < 4; ++a) {
        const Index v = rest.nodes(e)[static_cast<std::size_t>(a)];
        product.segment<3>(3 * v) += force.segment<3>(3 * a);
        diagonal.middleCols<3>(3 * v) += terms.hessian.block<3, 3>(3 * a, 3 * a);
      }
    }
    // The assembled matrix, from the kernels.
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    ASSERT_TRUE(potential.add_hessian(q, pattern, values.data()).ok());
    viscous.add_hessian(q - start, pattern, values.data());
    const Vector assembled = sparse_product(pattern, values, x);
    EXPECT_LT((assembled - product).norm(), 1e-12 * product.norm());
    const auto check = [&]<class T>(TangentOperator<T> tangent, double tolerance) {
      tangent.set(q, viscous, q - start);
      AlignedVector<T> rows(static_cast<std::size_t>(4 * rest.vertex_count()), T(0));
      for (Index i = 0; i < q.size(); ++i) {
        rows[static_cast<std::size_t>(i / 3 * 4 + i % 3)] = static_cast<T>(x[i]);
      }
      tangent.multiply(rows.data());
      Vector found_product(q.size());
      for (Index v = 0; v < rest.vertex_count(); ++v) {
        found_product.segment<3>(3 * v) =
            tangent.record_sum(v).template head<3>().template cast<double>();
      }
      EXPECT_LT((found_product - product).norm(), tolerance * product.norm());
      AlignedVector<T> on;
      AlignedVector<T> off;
      tangent.diagonal(on, off);
      for (Index v = 0; v < rest.vertex_count(); ++v) {
        const Matrix3 exact = diagonal.middleCols<3>(3 * v);
        Matrix3 found;
        for (Index j = 0; j < 3; ++j) {
          for (Index i = j; i < 3; ++i) {
            const auto at = static_cast<std::size_t>(4 * v + (i == j ? i : i + j - 1));
            found(i, j) = found(j, i) = static_cast<double>(i == j ? on[at] : off[at]);
          }
        }
        EXPECT_LT((found - exact).norm(), tolerance * exact.norm()) << v;
      }
    };
    check(TangentOperator<double>(potential), 1e-12);
    check(TangentOperator<float>(potential), 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Laws,
                         testing::Combine(testing::ValuesIn(instruction_sets()),
                                          testing::Range<std::size_t>(0, laws().size() + 1),
                                          testing::Bool()),
                         [](const auto& test) {
                           return instruction_set_name(std::get<0>(test.param)) + "_" +
                                  law_name(std::get<1>(test.param)) +
                                  (std::get<2>(test.param) ? "_varying" : "");
                         });

TEST(YeohTangent, ConvexifiedIsPositiveSemidefinite) {
  const TetMesh mesh = small_block({2, 1, 1});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, laws()[0].law);
  TangentOperator<double> tangent(potential);
  const auto matrix = [&] {
    Matrix k(3 * rest.vertex_count(), 3 * rest.vertex_count());
    for (Index j = 0; j < k.cols(); ++j) {
      AlignedVector<double> rows(static_cast<std::size_t>(4 * rest.vertex_count()), 0.0);
      rows[static_cast<std::size_t>(j / 3 * 4 + j % 3)] = 1.0;
      tangent.multiply(rows.data());
      for (Index v = 0; v < rest.vertex_count(); ++v) {
        k.col(j).segment<3>(3 * v) = tangent.record_sum(v).head<3>();
      }
    }
    return k;
  };
  const auto lowest = [](const Matrix& k) {
    return Eigen::SelfAdjointEigenSolver<Matrix>(k, Eigen::EigenvaluesOnly).eigenvalues()[0];
  };
  for (const double along : {0.4, 2.0}) {
    Vector q = jiggled(mesh.rest_positions(), 0.03);
    for (Index v = 0; v < mesh.vertex_count(); ++v) q[3 * v] *= along;
    tangent.set(q);
    const Matrix exact = matrix();
    tangent.convexify();
    const double scale = exact.norm();
    if (along < 1.0) {
      EXPECT_LT(lowest(exact), -1e-3 * scale);
    }
    EXPECT_GT(lowest(matrix()), -1e-12 * scale) << along;
  }
  tangent.set(mesh.rest_positions());
  const Matrix at_rest = matrix();
  tangent.convexify();
  EXPECT_LT((matrix() - at_rest).norm(), 1e-12 * at_rest.norm());
}

// Uniaxial tension: the lateral stretch that leaves no lateral stress gives
// P₁ = 2 (λ − J/λ² …); with σ the Cauchy stress and b the squared stretches, σ₁ − σ₂ = 2/J ∂Ψ/∂I₁ (b₁ − b₂).
TEST(YeohStress, OfUniaxialTensionIsTheClosedForm) {
  const double c10 = 0.19e6;
  const double c20 = -1.45e3;
  const double c30 = 38.8;
  for (const double kappa : {1e7, 1e9, 1e12}) {
    const Yeoh material(c10, c20, c30, kappa);
    for (const double stretch : {0.6, 1.0 + 1e-6, 1.5, 3.0, 6.0}) {
      const auto lateral_stress = [&](double lateral) {
        return material.first_piola(Vector3(stretch, lateral, lateral).asDiagonal())(1, 1);
      };
      double lateral = 1.0 / std::sqrt(stretch);
      for (int i = 0; i < 50; ++i) {  // Newton's method
        const Matrix9 a = material.stiffness(Vector3(stretch, lateral, lateral).asDiagonal());
        const double change = lateral_stress(lateral) / (a(4, 4) + a(4, 8));
        lateral -= change;
        if (std::abs(change) < 1e-15) break;
      }
      const Matrix3 f = Vector3(stretch, lateral, lateral).asDiagonal();
      const double j = f.determinant();
      const double cauchy = material.first_piola(f)(0, 0) * stretch / j;
      const double i1 = std::pow(j, -2.0 / 3.0) * f.squaredNorm();
      const double slope = c10 + 2.0 * c20 * (i1 - 3.0) + 3.0 * c30 * (i1 - 3.0) * (i1 - 3.0);
      const double exact =
          2.0 * std::pow(j, -5.0 / 3.0) * slope * (stretch * stretch - lateral * lateral);
      const double round_off = 1e-14 * kappa;
      EXPECT_NEAR(cauchy, exact, 1e-10 * std::abs(exact) + round_off) << kappa << " " << stretch;
      // The incompressible limit, from which a finite κ is away by about σ/κ.
      const double first = stretch * stretch + 2.0 / stretch - 3.0;
      const double limit = 2.0 * (stretch * stretch - 1.0 / stretch) *
                           (c10 + 2.0 * c20 * first + 3.0 * c30 * first * first);
      EXPECT_NEAR(cauchy, limit,
                  10.0 * (std::abs(limit) + c10) / kappa * std::abs(limit) + round_off)
          << kappa << " " << stretch;
    }
  }
}

// Simple shear keeps the volume: τ = 2 γ W′(γ²), and the law of the first term alone is linear.
TEST(YeohStress, OfSimpleShearIsTheClosedForm) {
  const Yeoh material(0.19e6, -1.45e3, 38.8, 1e8);
  for (const double gamma : {1e-8, 1e-4, 0.1, 1.0, 3.0}) {
    Matrix3 f = Matrix3::Identity();
    f(0, 1) = gamma;
    const double x = gamma * gamma;
    const double exact = 2.0 * gamma * (0.19e6 - 2.0 * 1.45e3 * x + 3.0 * 38.8 * x * x);
    EXPECT_NEAR(material.first_piola(f)(0, 1), exact, 1e-13 * exact) << gamma;
    const double energy = 0.19e6 * x - 1.45e3 * x * x + 38.8 * x * x * x;
    EXPECT_NEAR(material.energy_density(f), energy, 1e-13 * energy) << gamma;
  }
}

// Forces of tiny strains against the formula in extended precision. F itself is rounded to ε, and no
// formula can do better than ε/strain.
TEST(YeohStress, KeepsTheDigitsOfTinyStrains) {
  using Long = long double;
  using LongMatrix = Eigen::Matrix<Long, 3, 3>;
  const Yeoh material(1.0, -0.2, 0.05, 20.0);
  Matrix3 d;
  d << 4, -7, 2, 9, 3, -5, -6, 8, 1;
  for (const int exponent : {-6, -14, -24, -30}) {
    const Matrix3 f = Matrix3::Identity() + std::ldexp(1.0, exponent) * d;  // exact
    const LongMatrix g = f.cast<Long>();
    const Long j = g.determinant();
    const Long i1 = g.squaredNorm();
    const Long p = std::pow(j, -2.0L / 3.0L);
    const Long x = p * i1 - 3.0L;
    const Long slope = 1.0L + x * (-0.4L + x * 0.15L);
    const LongMatrix inverse = g.inverse().transpose();
    const LongMatrix stress =
        2.0L * p * slope * (g - i1 / 3.0L * inverse) + 20.0L * j * (j - 1.0L) * inverse;
    const double strain = std::ldexp(10.0, exponent);
    const double error = (material.first_piola(f) - stress.cast<double>()).norm() /
                         static_cast<double>(stress.norm());
    EXPECT_LT(error, 16.0 * std::numeric_limits<double>::epsilon() / strain) << exponent;
    RecordProperty("error_" + std::to_string(-exponent), std::to_string(error));
  }
}

// At rest only the small-strain parameters count.
TEST(YeohStability, LimitAtRestIsTheNeoHookeanOne) {
  const LameParameters lame = lame_from_young(1e6, 0.4);
  const auto limit = [&](const MaterialModel& material) {
    const MechanicalSystem system(small_block(), material, 1000.0);
    return stability_limit(system, system.mesh().rest_positions(), Integrator::kVerlet)
        .critical_step;
  };
  const double neo = limit(NeoHookean(lame.mu, lame.lambda));
  for (const auto& [name, law] : laws()) EXPECT_NEAR(limit(law), neo, 1e-3 * neo) << name;
}

}  // namespace
}  // namespace tetraction
