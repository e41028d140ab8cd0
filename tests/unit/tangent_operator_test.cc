#include "fem/tangent_operator.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "support/assembled.h"
#include "support/bodies.h"
#include "support/fibre_rubber.h"
#include "support/instruction_sets.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

template <class T>
AlignedVector<T> records_of(const Vector& x) {
  AlignedVector<T> rows(static_cast<std::size_t>(x.size() / 3 * 4), T(0));
  for (Index v = 0; v < x.size() / 3; ++v) {
    for (Index k = 0; k < 3; ++k)
      rows[static_cast<std::size_t>(4 * v + k)] = static_cast<T>(x[3 * v + k]);
  }
  return rows;
}

template <class T>
Vector product_of(TangentOperator<T>& tangent, const Vector& x) {
  const AlignedVector<T> rows = records_of<T>(x);
  tangent.multiply(rows.data());
  Vector result(x.size());
  for (Index v = 0; v < x.size() / 3; ++v) {
    const Eigen::Matrix<T, 4, 1> sum = tangent.record_sum(v);
    EXPECT_EQ(sum[3], T(0));
    result.segment<3>(3 * v) = sum.template head<3>().template cast<double>();
  }
  return result;
}

// Which materials a body has: one of all_materials(), or (3) all three mixed.
std::vector<MaterialModel> materials_of(std::size_t which) {
  const std::vector<MaterialModel> all = all_materials();
  return which < all.size() ? std::vector<MaterialModel>{all[which]} : all;
}
std::vector<int> regions_of(Index elements) {
  std::vector<int> region(static_cast<std::size_t>(elements));
  for (Index e = 0; e < elements; ++e) region[static_cast<std::size_t>(e)] = e % 11 < 5 ? 0 : 2;
  for (Index e = 0; e < elements; e += 13) region[static_cast<std::size_t>(e)] = 1;
  return region;
}

class TangentOperatorOf : public testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  const UseInstructionSet use_{std::get<0>(GetParam())};
  const TetMesh mesh_ = small_block({8, 5, 5});  // 1200 elements: padded blocks
  const RestState rest_{mesh_};
  const ElasticPotential potential_{rest_, materials_of(std::get<1>(GetParam())),
                                    regions_of(rest_.element_count())};
  const Vector q_ = strained_state(potential_, mesh_.rest_positions(), 0.2);
  const Vector x_ = jiggled(Vector::Zero(q_.size()), 0.3, 3);
  ViscousPotential viscous_{potential_};

  const Vector start_ = strained_state(potential_, mesh_.rest_positions(), 0.05);
  const Vector displacement_ = q_ - start_;

  void make_viscous() {
    viscous_.begin(start_, 3e5);
    viscous_.set_estimate(jiggled(Vector::Zero(q_.size()), 0.05, 4));
  }
  // The lower triangle of the assembled stiffness.
  std::vector<double> assembled(const SparsityPattern& pattern) const {
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    EXPECT_TRUE(potential_.add_hessian(q_, pattern, values.data()).ok());
    viscous_.add_hessian(displacement_, pattern, values.data());
    return values;
  }
  Vector assembled_product() const {
    const SparsityPattern pattern(rest_, FreeCoordinates(rest_.vertex_count()));
    return sparse_product(pattern, assembled(pattern), x_);
  }
  template <class T>
  void expect_diagonal_blocks(double tolerance) {
    const SparsityPattern pattern(rest_, FreeCoordinates(rest_.vertex_count()));
    const Matrix entry = dense_matrix(pattern, assembled(pattern));
    TangentOperator<T> tangent(potential_);
    tangent.set(q_, viscous_, displacement_);
    AlignedVector<T> on;
    AlignedVector<T> off;
    tangent.diagonal(on, off);
    for (Index v = 0; v < rest_.vertex_count(); ++v) {
      Matrix3 exact;
      Matrix3 found;
      for (Index j = 0; j < 3; ++j) {
        for (Index i = j; i < 3; ++i) {
          exact(i, j) = exact(j, i) = entry(3 * v + i, 3 * v + j);
          const auto at = static_cast<std::size_t>(4 * v + (i == j ? i : i + j - 1));
          found(i, j) = found(j, i) = static_cast<double>(i == j ? on[at] : off[at]);
        }
      }
      EXPECT_LT((found - exact).norm(), tolerance * exact.norm()) << v;
    }
  }
};

TEST_P(TangentOperatorOf, ProductsInDoublePrecision) {
  TangentOperator<double> tangent(potential_);
  tangent.set(q_, viscous_, displacement_);
  Vector exact;
  potential_.product(q_, x_, exact);
  EXPECT_LT((product_of(tangent, x_) - exact).norm(), 1e-12 * exact.norm());
  make_viscous();
  tangent.set(q_, viscous_, displacement_);
  const Vector both = assembled_product();
  ASSERT_GT((both - exact).norm(), 1e-3 * exact.norm());
  EXPECT_LT((product_of(tangent, x_) - both).norm(), 1e-12 * both.norm());
  // And back again without viscosity.
  viscous_.begin(q_, 0.0);
  tangent.set(q_, viscous_, displacement_);
  EXPECT_LT((product_of(tangent, x_) - exact).norm(), 1e-12 * exact.norm());
}

TEST_P(TangentOperatorOf, ProductsInSinglePrecision) {
  TangentOperator<float> tangent(potential_);
  tangent.set(q_, viscous_, displacement_);
  Vector exact;
  potential_.product(q_, x_, exact);
  EXPECT_LT((product_of(tangent, x_) - exact).norm(), 1e-5 * exact.norm());
  make_viscous();
  tangent.set(q_, viscous_, displacement_);
  const Vector both = assembled_product();
  EXPECT_LT((product_of(tangent, x_) - both).norm(), 1e-5 * both.norm());
}

TEST_P(TangentOperatorOf, DiagonalBlocks) {
  expect_diagonal_blocks<double>(1e-12);
  expect_diagonal_blocks<float>(1e-5);
  make_viscous();
  expect_diagonal_blocks<double>(1e-12);
  expect_diagonal_blocks<float>(1e-5);
}

TEST_P(TangentOperatorOf, IsSymmetric) {
  TangentOperator<double> tangent(potential_);
  make_viscous();
  tangent.set(q_, viscous_, displacement_);
  const Vector y = jiggled(Vector::Zero(q_.size()), 1.0, 8);
  const Vector kx = product_of(tangent, x_);
  const Vector ky = product_of(tangent, y);
  EXPECT_NEAR(kx.dot(y), ky.dot(x_), 1e-13 * kx.norm() * y.norm());
}

TEST_P(TangentOperatorOf, IsBitwiseTheSameForAnyNumberOfThreads) {
  TangentOperator<float> tangent(potential_);
  make_viscous();
  Vector first;
  AlignedVector<float> first_on;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    tangent.set(q_, viscous_, displacement_);
    const Vector product = product_of(tangent, x_);
    AlignedVector<float> on;
    AlignedVector<float> off;
    tangent.diagonal(on, off);
    if (threads == 1) {
      first = product;
      first_on = on;
    }
    EXPECT_EQ(product, first);
    EXPECT_EQ(on, first_on);
  }
  set_thread_count(0);
}

// Least J(t)/J(0) over the elements that need J > 0, at 200 places of the way.
double least_on_the_way(const ElasticPotential& potential, const Vector& q, const Vector& d) {
  const RestState& rest = potential.rest();
  double least = 1.0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const MaterialModel material = potential.material(e);
    if (std::holds_alternative<StVenantKirchhoff>(material)) continue;
    const Matrix3 f = deformation_gradient(rest.point(e), 0, rest.gather(q, e));
    const Matrix3 df = deformation_gradient(rest.point(e), 0, rest.gather(d, e));
    for (int i = 1; i <= 200; ++i) {
      least = std::min(least, (f + i / 200.0 * df).determinant() / f.determinant());
    }
  }
  return least;
}

TEST_P(TangentOperatorOf, StepsThatAreCalledSafeAre) {
  TangentOperator<double> tangent(potential_);
  TangentOperator<float> single(potential_);
  for (const bool viscous : {false, true}) {
    if (viscous) make_viscous();
    tangent.set(q_, viscous_, displacement_);
    single.set(q_, viscous_, displacement_);
    int safe = 0;
    int unsafe = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      for (const double size : {1e-3, 0.01, 0.02, 0.05, 0.3}) {
        const Vector d = jiggled(Vector::Zero(q_.size()), size, seed);
        const bool yes = tangent.step_is_safe(records_of<double>(d).data());
        (yes ? safe : unsafe) += 1;
        if (size == 1e-3) {
          EXPECT_TRUE(yes);
        }
        if (yes) {
          EXPECT_GT(least_on_the_way(potential_, q_, d), 0.0999999);
        }
        if (single.step_is_safe(records_of<float>(d).data())) {
          EXPECT_GT(least_on_the_way(potential_, q_, d), 0.0999);
        }
      }
    }
    EXPECT_GE(safe, 10);
    if (std::get<1>(GetParam()) == 0) {
      EXPECT_EQ(unsafe, 0);  // St Venant and Kirchhoff's is defined for any J
    } else {
      EXPECT_GE(unsafe, 10);
    }
  }
}

TEST_P(TangentOperatorOf, StepsThroughInvertedElementsAreNotSafe) {
  const auto step_to = [&](const Matrix3& f) {
    Vector d(q_.size());
    for (Index v = 0; v < rest_.vertex_count(); ++v) {
      d.segment<3>(3 * v) = f * q_.segment<3>(3 * v) - q_.segment<3>(3 * v);
    }
    return d;
  };
  const bool any_j = std::get<1>(GetParam()) == 0;
  TangentOperator<double> tangent(potential_);
  TangentOperator<float> single(potential_);
  tangent.set(q_, viscous_, displacement_);
  single.set(q_, viscous_, displacement_);
  const Matrix3 half_turn =
      Eigen::AngleAxisd(3.14159265358979323846, Vector3(2, 1, -1).normalized()).matrix();
  const Matrix3 through = Vector3(-1.0, -0.5, 1.0).asDiagonal();  // J = (1 − 2t)(1 − 1.5t)
  const Matrix3 inside_out = -Matrix3::Identity();
  for (const Matrix3& f : {half_turn, through, inside_out}) {
    const Vector d = step_to(f);
    EXPECT_EQ(tangent.step_is_safe(records_of<double>(d).data()), any_j);
    EXPECT_EQ(single.step_is_safe(records_of<float>(d).data()), any_j);
  }
  // A turn by 10° and growth by any factor are.
  const Matrix3 turn = Eigen::AngleAxisd(0.17, Vector3(2, 1, -1).normalized()).matrix();
  for (const Matrix3& f : {turn, Matrix3(5.0 * Matrix3::Identity())}) {
    EXPECT_TRUE(tangent.step_is_safe(records_of<double>(step_to(f)).data()));
  }
  // One vertex alone, of the last element.
  Vector d = Vector::Zero(q_.size());
  const Index v = rest_.nodes(0)[1];
  d.segment<3>(3 * v) = Vector3(1.0, 1.0, 1.0);
  const double least = least_on_the_way(potential_, q_, d);
  EXPECT_EQ(tangent.step_is_safe(records_of<double>(d).data()), least > 0.1);
  // NaN is not safe.
  d[3 * v] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(tangent.step_is_safe(records_of<double>(d).data()), any_j);
}

INSTANTIATE_TEST_SUITE_P(All, TangentOperatorOf,
                         testing::Combine(testing::ValuesIn(instruction_sets()),
                                          testing::Values(0U, 1U, 2U, 3U)),
                         [](const auto& test) {
                           const std::size_t which = std::get<1>(test.param);
                           std::string name =
                               instruction_set_name(std::get<0>(test.param)) + "_" +
                               (which < 3 ? material_name(all_materials()[which]) : "mixed");
                           std::erase(name, '-');
                           return name;
                         });

TEST(TangentOperator, KnowsTheBuiltInMaterialsOnly) {
  const TetMesh mesh = generate_tetrahedron();
  const RestState rest(mesh);
  for (const MaterialModel& material : all_materials()) {
    EXPECT_TRUE(TangentOperator<float>::supports(ElasticPotential(rest, material)));
  }
  const LameParameters lame = lame_from_young(1e6, 0.4);
  const MaterialModel fibres = CustomMaterial(FibreRubber(lame, 1e5, 1.0, Vector3::UnitX()));
  EXPECT_FALSE(TangentOperator<float>::supports(ElasticPotential(rest, fibres)));
  EXPECT_FALSE(TangentOperator<double>::supports(
      ElasticPotential(rest, std::vector<MaterialModel>{all_materials()[1], fibres}, {0})));
}

TEST(TangentOperator, ConvexifiedStiffnessIsPositiveSemidefinite) {
  const TetMesh mesh = small_block({2, 1, 1});
  const RestState rest(mesh);
  for (const bool metric : {false, true}) {
    const ElasticPotential potential(rest,
                                     std::vector<MaterialModel>{all_materials()[metric ? 0 : 1]},
                                     std::vector<int>(rest.element_count(), 0));
    Vector q = jiggled(mesh.rest_positions(), 0.03);
    for (Index v = 0; v < mesh.vertex_count(); ++v) q[3 * v] *= 0.4;  // compressed
    TangentOperator<double> tangent(potential);
    const auto matrix = [&] {
      Matrix k(q.size(), q.size());
      for (Index j = 0; j < q.size(); ++j)
        k.col(j) = product_of(tangent, Vector::Unit(q.size(), j));
      return k;
    };
    const auto lowest = [](const Matrix& k) {
      return Eigen::SelfAdjointEigenSolver<Matrix>(k, Eigen::EigenvaluesOnly).eigenvalues()[0];
    };
    tangent.set(q);
    const Matrix exact = matrix();
    tangent.convexify();
    const Matrix convex = matrix();
    const double scale = exact.norm();
    ASSERT_LT(lowest(exact), -1e-3 * scale);
    EXPECT_GT(lowest(convex), -1e-12 * scale);
    EXPECT_GT(lowest(convex - exact), -1e-12 * scale);
    // Until the next point, and nothing is changed where there is no compression.
    tangent.set(mesh.rest_positions());
    const Matrix at_rest = matrix();
    tangent.convexify();
    EXPECT_LT((matrix() - at_rest).norm(), 1e-12 * at_rest.norm());
  }
}

}  // namespace
}  // namespace tetraction
