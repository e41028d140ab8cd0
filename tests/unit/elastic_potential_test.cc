#include "tetraction/fem/elastic_potential.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "support/assembled.h"
#include "support/bodies.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// The assembled Hessian over all DOFs as a dense matrix.
Matrix dense_hessian(const ElasticPotential& potential, const FreeCoordinates& coordinates,
                     const Vector& q) {
  const SparsityPattern pattern(potential.rest(), coordinates);
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  EXPECT_TRUE(potential.add_hessian(q, pattern, values.data()).ok());
  return dense_matrix(pattern, values);
}

class ElasticPotentialOf : public testing::TestWithParam<std::size_t> {
 protected:
  const MaterialModel material_ = all_materials()[GetParam()];
  const TetMesh mesh_ = small_block();
  const RestState rest_{mesh_};
  const ElasticPotential potential_{rest_, material_};
  const FreeCoordinates free_{mesh_.vertex_count()};
};

TEST_P(ElasticPotentialOf, RigidMotionGivesNeitherEnergyNorForce) {
  const Matrix3 rotation = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).matrix();
  Vector q = mesh_.rest_positions();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    const Vector3 x = q.segment<3>(3 * v);
    q.segment<3>(3 * v) = rotation * x + Vector3(3, -2, 5);
  }
  double energy = 1.0;
  Vector gradient;
  ASSERT_TRUE(potential_.value_and_gradient(q, energy, gradient).ok());
  const double modulus = initial_lame(material_).mu;
  EXPECT_NEAR(energy, 0.0, 1e-12 * modulus);
  EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-12 * modulus);
}

TEST_P(ElasticPotentialOf, InnerForcesAddUpToZeroForceAndTorque) {
  const Vector q = strained_state(potential_, mesh_.rest_positions(), 0.2);
  const auto [energy, gradient] = value_and_gradient_of(potential_, q);
  Vector3 force = Vector3::Zero();
  Vector3 torque = Vector3::Zero();
  double scale = 0.0;
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    const Vector3 f = gradient.segment<3>(3 * v);
    force += f;
    torque += q.segment<3>(3 * v).cross(f);
    scale += f.norm();
  }
  ASSERT_GT(scale, 1.0);
  EXPECT_LT(force.norm(), 1e-13 * scale);
  EXPECT_LT(torque.norm(), 1e-13 * scale);
}

TEST_P(ElasticPotentialOf, ConstantStrainPatchOnADistortedMesh) {
  TetMesh distorted = mesh_;
  const Vector moved = jiggled(mesh_.rest_positions(), 0.05);
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    distorted.vertices.own()[static_cast<std::size_t>(v)] = moved.segment<3>(3 * v);
  }
  const RestState rest(distorted);
  const ElasticPotential potential(rest, material_);
  Matrix3 f;
  f << 1.2, 0.1, -0.05, 0.02, 0.9, 0.15, 0.0, -0.1, 1.1;
  Vector q(moved.size());
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    q.segment<3>(3 * v) = f * moved.segment<3>(3 * v);
  }
  const auto [energy, gradient] = value_and_gradient_of(potential, q);
  const Matrix3 stress = potential.first_piola(0, q);
  ASSERT_GT(stress.norm(), 1e4);
  for (Index e = 0; e < rest.element_count(); ++e) {
    EXPECT_LT((potential.first_piola(e, q) - stress).norm(), 1e-12 * stress.norm());
  }
  // Constant stress is in balance: only boundary vertices feel a force.
  std::vector<bool> boundary(distorted.vertices.size(), false);
  for (const auto& face : boundary_faces(distorted)) {
    for (const Index v : face) boundary[static_cast<std::size_t>(v)] = true;
  }
  int inner = 0;
  for (Index v = 0; v < distorted.vertex_count(); ++v) {
    if (boundary[static_cast<std::size_t>(v)]) continue;
    ++inner;
    EXPECT_LT(gradient.segment<3>(3 * v).norm(), 1e-12 * stress.norm());
  }
  EXPECT_GT(inner, 0);
}

TEST_P(ElasticPotentialOf, DerivativesAgreeWithCentralDifferences) {
  const Vector q = strained_state(potential_, mesh_.rest_positions());
  const DerivativeErrors errors = check_derivatives(potential_, q);
  EXPECT_GT(errors.force_norm, 1.0);
  EXPECT_LT(errors.force, 1e-7);
  EXPECT_LT(errors.stiffness, 1e-7);
}

TEST_P(ElasticPotentialOf, HessianAndProductAreTheDerivativeOfTheGradient) {
  const Vector q = strained_state(potential_, mesh_.rest_positions());
  const Vector direction = jiggled(Vector::Zero(q.size()), 1.0, 3);
  constexpr double kStep = 1e-6;
  double energy = 0.0;
  Vector above;
  Vector below;
  ASSERT_TRUE(potential_.value_and_gradient(Vector(q + kStep * direction), energy, above).ok());
  ASSERT_TRUE(potential_.value_and_gradient(Vector(q - kStep * direction), energy, below).ok());
  const Vector difference = (above - below) / (2.0 * kStep);
  Vector product;
  potential_.product(q, direction, product);
  EXPECT_LT((product - difference).norm(), 1e-7 * difference.norm());
  const Vector assembled = dense_hessian(potential_, free_, q) * direction;
  EXPECT_LT((product - assembled).norm(), 1e-13 * product.norm());
}

TEST_P(ElasticPotentialOf, FreeBodyHasSixZeroModesAtRest) {
  const Matrix k = dense_hessian(potential_, free_, mesh_.rest_positions());
  const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(k).eigenvalues();
  const double largest = eigenvalues[eigenvalues.size() - 1];
  EXPECT_LT(eigenvalues.head(6).cwiseAbs().maxCoeff(), 1e-12 * largest);
  EXPECT_GT(eigenvalues[6], 1e-4 * largest);
}

TEST_P(ElasticPotentialOf, AssemblyEliminatesConstrainedDofs) {
  const Vector q = strained_state(potential_, mesh_.rest_positions());
  const FreeCoordinates held = hold(mesh_, SelectPlane{0, 0.0, {}}).coordinates();
  const Matrix all = dense_hessian(potential_, free_, q);
  const Matrix reduced = dense_hessian(potential_, held, q);
  ASSERT_LT(reduced.rows(), all.rows());
  for (Index i = 0; i < all.rows(); ++i) {
    for (Index j = 0; j < all.cols(); ++j) {
      if (held.is_fully_prescribed(i / 3) || held.is_fully_prescribed(j / 3)) continue;
      EXPECT_EQ(reduced(held.first(i / 3) + i % 3, held.first(j / 3) + j % 3), all(i, j));
    }
  }
}

TEST_P(ElasticPotentialOf, ResultsAreBitwiseTheSameForAnyNumberOfThreads) {
  const TetMesh mesh = small_block({24, 10, 10});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  const Vector q = strained_state(potential, mesh.rest_positions());
  const FreeCoordinates free(mesh.vertex_count());
  const SparsityPattern pattern(rest, free);
  struct Result {
    double energy;
    Vector gradient;
    Vector product;
    std::vector<double> hessian;
    DerivativeErrors errors;
  };
  std::vector<Result> results;
  for (const int threads : {1, 2, 4, 2}) {
    set_thread_count(threads);
    Result r;
    r.hessian.assign(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    ASSERT_TRUE(potential.value_and_gradient(q, r.energy, r.gradient).ok());
    ASSERT_TRUE(potential.add_hessian(q, pattern, r.hessian.data()).ok());
    potential.product(q, r.gradient, r.product);
    r.errors = check_derivatives(potential, q);
    results.push_back(std::move(r));
  }
  set_thread_count(0);
  for (const Result& r : results) {
    EXPECT_EQ(r.energy, results[0].energy);
    EXPECT_EQ(r.gradient, results[0].gradient);
    EXPECT_EQ(r.product, results[0].product);
    EXPECT_EQ(r.hessian, results[0].hessian);
    EXPECT_EQ(r.errors.force, results[0].errors.force);
    EXPECT_EQ(r.errors.stiffness, results[0].errors.stiffness);
    EXPECT_EQ(r.errors.force_norm, results[0].errors.force_norm);
  }
}

// The lanes of the kernels that have no element add nothing to the energy of a tiny body.
TEST_P(ElasticPotentialOf, AMicroscopicBodyAtRestHasNoEnergy) {
  const TetMesh mesh = generate_box({1e-9, 1e-9, 1e-9}, {1, 1, 1});
  for (const TetMesh& body : {mesh, with_edge_vertices(mesh)}) {
    const RestState rest(body);
    const ElasticPotential potential(rest, all_materials()[GetParam()]);
    double energy = 1.0;
    ASSERT_TRUE(potential.value(body.rest_positions(), energy).ok());
    // Strains of round-off have less than E V ε² = 1e6 × 1e-27 × 1e-30.
    EXPECT_LT(std::abs(energy), 1e-50);
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, ElasticPotentialOf, testing::Values(0U, 1U, 2U),
                         [](const auto& test) {
                           std::string name = material_name(all_materials()[test.param]);
                           std::erase(name, '-');
                           return name;
                         });

TEST(ElasticPotential, NamesTheFirstInvertedElement) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const ElasticPotential potential(rest, all_materials()[1]);
  Vector q = mesh.rest_positions();
  // Pull the last vertex through its element.
  q.tail<3>() = mesh.vertices.front();
  double energy = 0.0;
  const EvaluationStatus status = potential.value(q, energy);
  ASSERT_FALSE(status.ok());
  Index first = 0;
  while (jacobian(deformation_gradient(rest.point(first), 0, rest.gather(q, first))) > 0.0) {
    ++first;
  }
  EXPECT_EQ(status.failed_element, first);
}

}  // namespace
}  // namespace tetraction
