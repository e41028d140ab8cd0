#include "solver/linear/coarse_space.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "support/step_problems.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block that is held on one side, with vertices on a plane and on a line.
class CoarseSpaceOf : public testing::TestWithParam<std::size_t> {
 protected:
  CoarseSpaceOf() {
    const TetMesh& mesh = system_.mesh();
    const std::vector<Index> held = select_vertices(mesh, SelectPlane{0, 0.0, {}});
    const std::vector<Index> right = select_vertices(mesh, SelectPlane{0, 2.0, {}});
    Matrix plane(3, 2);
    plane.col(0) = Vector3(1.0, 1.0, 0.0).normalized();
    plane.col(1) = Vector3(0.0, 0.0, 1.0);
    const Matrix line = Vector3(1.0, 2.0, 2.0) / 3.0;
    const auto guide = [&](std::vector<Index> vertices, const Matrix& directions,
                           const std::string& name) {
      const Matrix points = prescribe_at_rest(mesh, vertices).start;
      return GuidedVertices{std::move(vertices), directions, points, name};
    };
    system_.set_constraints(Constraints({{prescribe_at_rest(mesh, held, "hold")},
                                         {guide({right[0], right[1], right[2]}, plane, "plane"),
                                          guide({right[5], right[6]}, line, "line")},
                                         {},
                                         {}},
                                        mesh, Vector::Ones(mesh.vertex_count())));
    q_ = strained_state(system_.elastic(), mesh.rest_positions(), 0.1);
  }

  Matrix3 vertex_term(Index vertex) const {
    const double i = static_cast<double>(vertex);
    Matrix3 m = Vector3(2e5 + i, 3e5, 1e5 + 2.0 * i).asDiagonal();
    m(0, 1) = m(1, 0) = 2e4;
    return m;
  }

  // A over all directions of all vertices.
  Matrix dense() const {
    const SparsityPattern pattern(system_.rest(), FreeCoordinates(system_.vertex_count()));
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    EXPECT_TRUE(system_.elastic().add_hessian(q_, pattern, values.data()).ok());
    Matrix a = dense_matrix(pattern, values);
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      a.block<3, 3>(3 * v, 3 * v) += vertex_term(v);
    }
    return a;
  }

  // The columns of P, from their definition.
  Matrix motions(const VertexGroups& groups) const {
    Matrix p = Matrix::Zero(system_.dof_count(), 6 * groups.count());
    for (Index g = 0; g < groups.count(); ++g) {
      Vector3 center = Vector3::Zero();
      double radius = 0.0;
      for (Index i = groups.begin(g); i < groups.end(g); ++i) {
        center += vertex_block(q_, groups.vertex(i));
      }
      center /= static_cast<double>(groups.end(g) - groups.begin(g));
      for (Index i = groups.begin(g); i < groups.end(g); ++i) {
        radius = std::max(radius, (vertex_block(q_, groups.vertex(i)) - center).norm());
      }
      for (Index i = groups.begin(g); i < groups.end(g); ++i) {
        const Index v = groups.vertex(i);
        for (int k = 0; k < 6; ++k) {
          const Vector3 axis = Vector3::Unit(k % 3);
          const Vector3 arm = (vertex_block(q_, v) - center) / radius;
          p.block<3, 1>(3 * v, 6 * g + k) = k < 3 ? axis : Vector3(axis.cross(arm));
        }
      }
    }
    const FreeCoordinates& coordinates = system_.coordinates();
    for (Index j = 0; j < p.cols(); ++j)
      p.col(j) = coordinates.extend(coordinates.restrict(p.col(j)));
    return p;
  }

  template <class T>
  Vector solve(CoarseSpace<T>& space, const Vector& right) const {
    for (Index g = 0; g < right.size() / 6; ++g) space.motion(g) = right.segment<6>(6 * g);
    Vector solution(right.size());
    const double product = space.solve();
    for (Index g = 0; g < right.size() / 6; ++g) solution.segment<6>(6 * g) = space.motion(g);
    EXPECT_NEAR(product, right.dot(solution), 1e-12 * std::abs(product));
    return solution;
  }

  template <class T>
  void expect_inverse(double tolerance) {
    const VertexGroups groups(system_.rest());
    ASSERT_GT(groups.count(), 3);
    TangentOperator<T> tangent(system_.elastic(), groups.order());
    tangent.set(q_);
    CoarseSpace<T> space(system_, groups);
    ASSERT_TRUE(space.update(
        tangent, [&](Index place) { return vertex_term(groups.vertex(place)); }, q_));
    const Matrix p = motions(groups);
    const Matrix coarse = p.transpose() * dense() * p;
    const Vector right = jiggled(Vector::Zero(coarse.rows()), 1.0);
    const Vector expected = coarse.llt().solve(right);
    const Vector found = solve(space, right);
    EXPECT_LT((found - expected).norm(), tolerance * expected.norm());
    // Once more, from another point: nothing is left of the first.
    q_ = strained_state(system_.elastic(), system_.mesh().rest_positions(), 0.05);
    tangent.set(q_);
    ASSERT_TRUE(space.update(
        tangent, [&](Index place) { return vertex_term(groups.vertex(place)); }, q_));
    const Matrix p2 = motions(groups);
    const Vector again = (p2.transpose() * dense() * p2).llt().solve(right);
    EXPECT_LT((solve(space, right) - again).norm(), tolerance * again.norm());
    EXPECT_GT((again - expected).norm(), 100.0 * tolerance * expected.norm());
  }

  MechanicalSystem system_{small_block({10, 5, 5}), all_materials()[GetParam()], 1000.0};
  Vector q_;
};

TEST_P(CoarseSpaceOf, InvertsTheProjectedMatrix) {
  expect_inverse<double>(1e-5);
}

TEST_P(CoarseSpaceOf, InvertsTheProjectedMatrixInSinglePrecision) {
  expect_inverse<float>(1e-4);
}

TEST_P(CoarseSpaceOf, IsBitwiseTheSameForAnyNumberOfThreads) {
  const VertexGroups groups(system_.rest());
  TangentOperator<float> tangent(system_.elastic(), groups.order());
  tangent.set(q_);
  const Vector right = jiggled(Vector::Zero(6 * groups.count()), 1.0);
  std::vector<Vector> found;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    CoarseSpace<float> space(system_, groups);
    ASSERT_TRUE(space.update(
        tangent, [&](Index place) { return vertex_term(groups.vertex(place)); }, q_));
    found.push_back(solve(space, right));
  }
  set_thread_count(0);
  EXPECT_EQ(found[1], found[0]);
  EXPECT_EQ(found[2], found[0]);
}

TEST_P(CoarseSpaceOf, SaysWhenTheMatrixIsNotPositiveDefinite) {
  const VertexGroups groups(system_.rest());
  TangentOperator<double> tangent(system_.elastic(), groups.order());
  tangent.set(q_);
  CoarseSpace<double> space(system_, groups);
  EXPECT_FALSE(space.update(
      tangent, [](Index) { return Matrix3(-1e9 * Matrix3::Identity()); }, q_));
}

INSTANTIATE_TEST_SUITE_P(Materials, CoarseSpaceOf, testing::Values(0, 1, 2));

// One tetrahedron with one free vertex: the turns of its group are no motions of their own.
TEST(CoarseSpace, TakesGroupsWithTooFewFreeVertices) {
  MechanicalSystem system(generate_tetrahedron(), all_materials()[1], 1000.0);
  system.set_constraints(
      Constraints({{prescribe_at_rest(system.mesh(), {0, 1, 2}, "hold")}, {}, {}, {}},
                  system.mesh(), Vector::Ones(4)));
  const Vector q = system.mesh().rest_positions();
  const VertexGroups groups(system.rest());
  TangentOperator<double> tangent(system.elastic(), groups.order());
  tangent.set(q);
  CoarseSpace<double> space(system, groups);
  ASSERT_TRUE(space.update(
      tangent, [](Index) { return Matrix3(Matrix3::Zero()); }, q));
  for (Index g = 0; g < groups.count(); ++g) space.motion(g).setOnes();
  EXPECT_TRUE(std::isfinite(space.solve()));
}

}  // namespace
}  // namespace tetraction
