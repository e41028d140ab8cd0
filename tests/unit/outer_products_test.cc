// Outer products of nodal volumes and of force terms, applied without a matrix.
#include "solver/linear/outer_products.h"

#include "support/bodies.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

using namespace testing_support;

template <class T>
class OuterProductsOf : public testing::Test {
 protected:
  OuterProductsOf() { terms_.reset(system_.vertex_count()); }
  ~OuterProductsOf() override { set_thread_count(0); }

  static std::vector<BodyRegion> regions() {
    // Their logarithmic U is concave where J is large.
    return {{NeoHookean(3e5, 2e7), 1000.0}, {MooneyRivlin(2e5, 1e5, 1e7), 1000.0}};
  }
  static std::vector<int> region_of_element(const TetMesh& mesh) {
    std::vector<int> region(mesh.tetrahedra.size());
    for (std::size_t e = 0; e < region.size(); ++e) region[e] = e % 3 == 0 ? 1 : 0;
    return region;
  }

  void add_terms(Index first) {
    const std::vector<Index> vertices{first + 3, first, first + 7};
    const std::vector<Vector3> vectors{{1.0, 2.0, -1.0}, {0.5, 0.0, 1.0}, {-2.0, 1.0, 0.3}};
    terms_.add_outer(-4e4, vertices, vectors);
    terms_.add_outer(3e4, std::span(vertices).first(2), std::span(vectors).last(2));
  }

  // The matrix, product by product in double precision.
  Matrix dense(const Vector& q, HessianForm form) const {
    HessianBlocks blocks = terms_;
    system_.nodal_volume()->add_outer_products(q, form, blocks);
    return dense_of(blocks);
  }
  static Matrix dense_of(const HessianBlocks& blocks) {
    const Index dofs = 3 * blocks.vertex_count();
    Matrix matrix = Matrix::Zero(dofs, dofs);
    for (const HessianBlocks::Outer& outer : blocks.outers()) {
      Vector b = Vector::Zero(dofs);
      for (std::size_t k = outer.begin; k < outer.end; ++k) {
        vertex_block(b, blocks.outer_vertices()[k]) = blocks.outer_vectors()[k];
      }
      matrix += outer.factor * b * b.transpose();
    }
    return matrix;
  }

  Vector product_of(OuterProducts<T>& outers, const Vector& x) const {
    AlignedVector<T> records(static_cast<std::size_t>(4 * system_.vertex_count()), T(0));
    for (Index i = 0; i < system_.vertex_count(); ++i) {
      for (Index k = 0; k < 3; ++k) {
        records[static_cast<std::size_t>(4 * i + k)] = static_cast<T>(x[3 * groups_.vertex(i) + k]);
      }
    }
    outers.multiply(records);
    Vector product(x.size());
    for (Index i = 0; i < system_.vertex_count(); ++i) {
      vertex_block(product, groups_.vertex(i)) =
          outers.product(i).template head<3>().template cast<double>();
    }
    return product;
  }

  void expect_matrix(OuterProducts<T>& outers, const Matrix& expected) const {
    const double tolerance = sizeof(T) == 4 ? 1e-5 : 1e-12;
    const Vector x = jiggled(Vector::Zero(expected.rows()), 1.0, 7);
    EXPECT_LT((product_of(outers, x) - expected * x).norm(), tolerance * (expected * x).norm());
    for (Index i = 0; i < system_.vertex_count(); ++i) {
      const Index v = groups_.vertex(i);
      const Matrix3 own = expected.block<3, 3>(3 * v, 3 * v);
      EXPECT_LT((outers.block(i) - own).norm(), tolerance * expected.norm()) << v;
    }
  }

  TetMesh mesh_ = small_block();
  MechanicalSystem system_{mesh_, regions(), region_of_element(mesh_), VolumeRule::kNodal};
  VertexGroups groups_{system_.rest()};
  HessianBlocks terms_;
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(OuterProductsOf, Precisions);

TYPED_TEST(OuterProductsOf, AreTheMatrixOfVolumesAndTerms) {
  const Vector rest = this->mesh_.rest_positions();
  // Stretched so far that U'' is negative at some vertices.
  Vector q = jiggled(rest, 0.05);
  for (Index v = 0; v < rest.size() / 3; ++v) vertex_block(q, v) *= 1.0 + 0.3 * rest[3 * v];
  OuterProducts<TypeParam> outers(this->groups_, this->system_.nodal_volume());
  EXPECT_TRUE(outers.empty());
  outers.set(q, HessianForm::kExact, this->terms_);
  const Matrix exact = this->dense(q, HessianForm::kExact);
  this->expect_matrix(outers, exact);
  double least = 0.0;
  for (Index i = 0; i < outers.count(); ++i) least = std::min(least, outers.sign(i));
  EXPECT_EQ(least, -1.0);
  outers.set(q, HessianForm::kConvex, this->terms_);
  const Matrix convex = this->dense(q, HessianForm::kConvex);
  this->expect_matrix(outers, convex);
  EXPECT_GT((exact - convex).norm(), 1e-3 * exact.norm());
  // Terms come, change their vertices, and go.
  for (const Index first : {0, 5}) {
    this->terms_.reset(this->system_.vertex_count());
    this->add_terms(first);
    outers.set(q, HessianForm::kExact, this->terms_);
    this->expect_matrix(outers, this->dense(q, HessianForm::kExact));
  }
  this->terms_.reset(this->system_.vertex_count());
  const Vector other = jiggled(rest, 0.1, 3);
  outers.set(other, HessianForm::kExact, this->terms_);
  this->expect_matrix(outers, this->dense(other, HessianForm::kExact));
}

TYPED_TEST(OuterProductsOf, OfTermsNeedNoVolume) {
  OuterProducts<TypeParam> outers(this->groups_, nullptr);
  outers.set(this->mesh_.rest_positions(), HessianForm::kExact, this->terms_);
  EXPECT_TRUE(outers.empty());
  this->add_terms(2);
  outers.set(this->mesh_.rest_positions(), HessianForm::kExact, this->terms_);
  EXPECT_EQ(outers.count(), 2);
  this->expect_matrix(outers, this->dense_of(this->terms_));
}

TYPED_TEST(OuterProductsOf, AreBitwiseTheSameForAnyNumberOfThreads) {
  const Vector q = jiggled(this->mesh_.rest_positions(), 0.05);
  const Vector x = jiggled(Vector::Zero(q.size()), 1.0, 7);
  std::vector<Vector> products;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    OuterProducts<TypeParam> outers(this->groups_, this->system_.nodal_volume());
    outers.set(q, HessianForm::kExact, this->terms_);
    products.push_back(this->product_of(outers, x));
  }
  EXPECT_EQ(products[1], products[0]);
  EXPECT_EQ(products[2], products[0]);
}

}  // namespace
}  // namespace tetraction
