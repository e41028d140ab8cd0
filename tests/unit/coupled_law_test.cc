// The element templates with a law of which no derivative vanishes: every term of the stiffness.

#include "core/simd_targets.h"
#include "fem/element_blocks.h"
#include "fem/kernels/tangent_kernels-inl.h"
#include "material/isotropic_material-inl.h"
#include "support/bodies.h"

namespace tetraction {

// With x = I₁ − 3, y = I₂ − 3 and L = ln J, Ψ = a x + b y − (2a + 4b) L + ½ (x, y, L) S (x, y, L)ᵀ.
class CoupledLaw : public IsotropicMaterial<CoupledLaw> {
 public:
  CoupledLaw() = default;
  template <class T>
  struct Parameters {};
  static Parameters<double> parameters() { return {}; }
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr double kA = 1.0;
  static constexpr double kB = 0.6;
  static constexpr double kXX = 0.31;
  static constexpr double kXY = -0.17;
  static constexpr double kXL = 0.43;
  static constexpr double kYY = 0.23;
  static constexpr double kYL = -0.29;
  static constexpr double kLL = 2.5;
};

namespace HWY_NAMESPACE {
template <>
struct Law<CoupledLaw> {
  using M = CoupledLaw;
  template <class P, class N>
  static N energy(const P&, const Invariants<N>& s) {
    const N x = s.i1 - N(3.0);
    const N y = s.i2_term + N(4.0) * s.log_j;
    const N l = s.log_j;
    return N(M::kA) * s.i1_term + N(M::kB) * s.i2_term +
           N(0.5) * (N(M::kXX) * x * x + N(M::kYY) * y * y + N(M::kLL) * l * l) +
           N(M::kXY) * x * y + N(M::kXL) * x * l + N(M::kYL) * y * l;
  }
  template <class P, class N>
  static auto first_derivatives(const P&, const Invariants<N>& s) {
    const N x = s.i1 - N(3.0);
    const N y = s.i2_term + N(4.0) * s.log_j;
    const N l = s.log_j;
    return FirstDerivatives{
        N(M::kA) + N(M::kXX) * x + N(M::kXY) * y + N(M::kXL) * l,
        N(M::kB) + N(M::kXY) * x + N(M::kYY) * y + N(M::kYL) * l,
        N(-2.0 * M::kA - 4.0 * M::kB) + N(M::kXL) * x + N(M::kYL) * y + N(M::kLL) * l};
  }
  template <class P, class N>
  static auto second_derivatives(const P&, const Invariants<N>&) {
    return SecondDerivatives{N(M::kXX), N(M::kXY), N(M::kYY), N(M::kXL), N(M::kYL), N(M::kLL)};
  }
};
}  // namespace HWY_NAMESPACE

namespace {

using namespace testing_support;
using Shape = RestState::Shape;

Matrix3 deformation() {
  Matrix3 f;
  f << 1.2, 0.3, -0.1, -0.2, 0.9, 0.25, 0.15, -0.05, 1.1;
  return f;
}

TEST(CoupledLaw, ScalarDerivativesAreConsistent) {
  const CoupledLaw law{};
  EXPECT_EQ(law.energy_density(Matrix3::Identity()), 0.0);
  EXPECT_LT(law.first_piola(Matrix3::Identity()).norm(), 1e-15);
  const Matrix3 f = deformation();
  const Matrix9 stiffness = law.stiffness(f);
  EXPECT_LT((stiffness - stiffness.transpose()).norm(), 1e-14 * stiffness.norm());
  const double h = 1e-5;
  for (int k = 0; k < 9; ++k) {
    Matrix3 unit = Matrix3::Zero();
    unit(k % 3, k / 3) = 1.0;
    const double slope =
        (law.energy_density(f + h * unit) - law.energy_density(f - h * unit)) / (2.0 * h);
    EXPECT_NEAR(slope, law.first_piola(f)(k % 3, k / 3), 1e-8) << k;
    const Vector9 column =
        flatten((law.first_piola(f + h * unit) - law.first_piola(f - h * unit)) / (2.0 * h));
    EXPECT_LT((column - stiffness.col(k)).norm(), 1e-8 * stiffness.norm()) << k;
  }
}

template <TangentForm kForm>
void expect_like_scalar() {
  const CoupledLaw law{};
  const TetMesh mesh = small_block({2, 2, 1});
  const RestState rest(mesh);
  const ElementBlocks blocks(rest, {}, 1);
  ASSERT_EQ(blocks.block_count(), 1);
  const ElementBlocks::Block& block = blocks.block(0);
  const BatchView batches = blocks.batches(block);
  Vector q = jiggled(mesh.rest_positions(), 0.05);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    q.segment<3>(3 * v) = deformation() * q.segment<3>(3 * v);
  }
  const Vector x = jiggled(Vector::Zero(q.size()), 0.3, 3);
  const auto numbers = static_cast<std::size_t>(tangent_numbers(kForm)) * kBatchLanes;
  AlignedVector<double> positions(static_cast<std::size_t>(4 * block.record_count));
  AlignedVector<double> displacements(positions.size());
  AlignedVector<double> result(positions.size(), 0.0);
  AlignedVector<double> on(positions.size(), 0.0);
  AlignedVector<double> off(positions.size(), 0.0);
  AlignedVector<double> state(numbers * static_cast<std::size_t>(block.batch_count));
  blocks.load_records(block, q.data(), positions.data());
  blocks.load_displacements(block, x.data(), displacements.data());
  HWY_NAMESPACE::prepare<kForm>(batches, HWY_NAMESPACE::UniformParameters<CoupledLaw>(law),
                                positions.data(), state.data());
  HWY_NAMESPACE::apply<kForm>(batches, state.data(), displacements.data(), result.data());
  HWY_NAMESPACE::diagonal_blocks<kForm>(batches, state.data(), on.data(), off.data());

  Vector expected = Vector::Zero(q.size());
  Matrix diagonal = Matrix::Zero(3, q.size());
  alignas(64) double matrices[std::size_t{kStiffnessNumbers} * kBatchLanes];
  blocks.for_each_element(block, [&](Index e, Index batch, int lane) {
    const Shape::DofMatrix k = element_hessian<Shape>(rest.point(e), law, rest.gather(q, e));
    const Shape::NodeMatrix local = rest.gather(x, e);
    const Shape::DofVector force = k * Eigen::Map<const Shape::DofVector>(local.data());
    for (int a = 0; a < 4; ++a) {
      const Index v = rest.nodes(e)[static_cast<std::size_t>(a)];
      expected.segment<3>(3 * v) += force.segment<3>(3 * a);
      diagonal.middleCols<3>(3 * v) += k.block<3, 3>(3 * a, 3 * a);
    }
    HWY_NAMESPACE::stiffness<kForm>(state.data() + static_cast<std::size_t>(batch) * numbers,
                                    matrices);
    // The block of nodes 2 and 3 stands last, row by row.
    Matrix3 pair;
    for (int i = 0; i < 9; ++i) {
      pair(i / 3, i % 3) = matrices[(24 + 9 * 5 + i) * kBatchLanes + lane];
    }
    EXPECT_LT((pair - k.block<3, 3>(6, 9)).norm(), 1e-12 * k.norm()) << e;
  });
  Vector found(q.size());
  blocks.sum_records(result, found);
  EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm());
  Vector found_on(q.size());
  Vector found_off(q.size());
  blocks.sum_records(on, found_on);
  blocks.sum_records(off, found_off);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Matrix3 exact = diagonal.middleCols<3>(3 * v);
    const Vector3 exact_off(exact(0, 1), exact(0, 2), exact(1, 2));
    EXPECT_LT((found_on.segment<3>(3 * v) - exact.diagonal()).norm(), 1e-12 * exact.norm());
    EXPECT_LT((found_off.segment<3>(3 * v) - exact_off).norm(), 1e-12 * exact.norm());
  }
}

TEST(CoupledLaw, KernelsHaveEveryTerm) {
  constexpr TangentForm kForm = HWY_NAMESPACE::form_of<CoupledLaw>();
  static_assert(kForm == (TangentForm::kSpatial | TangentForm::kMetric | TangentForm::kCoupled |
                          TangentForm::kCoupledI2));
  expect_like_scalar<kForm>();
}

}  // namespace
}  // namespace tetraction
