// Quadratic tetrahedra: the points of an element (mesh/quadratic_points.h), and everything that is
// computed with them.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <functional>

#include "fem/discrete_gradient.h"
#include "fem/tangent_operator.h"
#include "mesh/quadratic_points.h"
#include "support/assembled.h"
#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/fem/step_length.h"
#include "tetraction/fem/viscous_potential.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block whose vertices, also those in the middles of edges, are moved: all its edges are curved.
TetMesh curved_block(const std::array<int, 3>& cells = {4, 3, 2}) {
  TetMesh mesh = with_edge_vertices(small_block(cells));
  const Vector moved = jiggled(mesh.rest_positions(), 0.01);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    mesh.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(moved, v);
  }
  return mesh;
}

Vector apply(const TetMesh& mesh, const std::function<Vector3(const Vector3&)>& map) {
  Vector q = mesh.rest_positions();
  for (Index v = 0; v < mesh.vertex_count(); ++v) vertex_block(q, v) = map(vertex_block(q, v));
  return q;
}

TEST(QuadraticTetrahedra, EdgesGetOneVertexEach) {
  const TetMesh linear = small_block();
  const TetMesh mesh = with_edge_vertices(linear);
  ASSERT_TRUE(mesh.is_quadratic());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const auto i = static_cast<std::size_t>(e);
    for (std::size_t k = 0; k < 6; ++k) {
      const auto t = mesh.tetrahedra[i];
      const Vector3 middle =
          0.5 * (mesh.vertices[static_cast<std::size_t>(t[kTetrahedronEdges[k][0]])] +
                 mesh.vertices[static_cast<std::size_t>(t[kTetrahedronEdges[k][1]])]);
      EXPECT_EQ(mesh.vertices[static_cast<std::size_t>(mesh.edge_vertices[i][k])], middle);
    }
  }
  // Euler: V − E + F − T = 1, and each tetrahedron has four faces, shared but for the boundary.
  const Index faces =
      (4 * linear.tetrahedron_count() + static_cast<Index>(boundary_faces(linear).size())) / 2;
  const Index edges = linear.vertex_count() + faces - linear.tetrahedron_count() - 1;
  EXPECT_EQ(mesh.vertex_count(), linear.vertex_count() + edges);
  const TetMesh back = without_edge_vertices(mesh);
  EXPECT_EQ(back.vertices, linear.vertices);
  EXPECT_EQ(back.tetrahedra, linear.tetrahedra);
}

TEST(QuadraticTetrahedra, PointsHaveTheGradientsOfTheShapeFunctions) {
  // A quadratic map of the reference element has the exact gradient at the points.
  const TetMesh mesh = curved_block();
  const RestState rest(mesh);
  Matrix3 a;
  a << 1.1, 0.2, -0.1, 0.05, 0.9, 0.1, -0.2, 0.1, 1.05;
  const Vector q = apply(mesh, [&](const Vector3& x) -> Vector3 { return a * x; });
  double volume = 0.0;
  for (Index i = 0; i < rest.point_count(); ++i) {
    const Matrix3 f = deformation_gradient(rest.point(i), 0, rest.gather(q, i));
    EXPECT_LT((f - a).norm(), 1e-12);
    volume += rest.point_volume(i);
  }
  EXPECT_NEAR(volume, 2.0, 0.05);
  // With straight edges the gradient of a quadratic map is exact, too.
  const TetMesh straight = with_edge_vertices(small_block());
  const RestState at_rest(straight);
  const auto square = [](const Vector3& x) {
    return Vector3(x[0] + 0.1 * x[0] * x[1], x[1] + 0.2 * x[2] * x[2], x[2] - 0.1 * x[0] * x[0]);
  };
  const Vector bent = apply(straight, square);
  for (Index e = 0; e < at_rest.element_count(); ++e) {
    const auto t = straight.tetrahedra[static_cast<std::size_t>(e)];
    for (int p = 0; p < 4; ++p) {
      Vector3 x = Vector3::Zero();
      for (int c = 0; c < 4; ++c) {
        x += (c == p ? QuadraticPoints::kNear : QuadraticPoints::kFar) *
             straight.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(c)])];
      }
      Matrix3 exact;
      exact << 1.0 + 0.1 * x[1], 0.1 * x[0], 0.0, 0.0, 1.0, 0.4 * x[2], -0.2 * x[0], 0.0, 1.0;
      const Index i = 4 * e + p;
      EXPECT_LT((deformation_gradient(at_rest.point(i), 0, at_rest.gather(bent, i)) - exact).norm(),
                1e-12);
    }
    EXPECT_NEAR(at_rest.volume(e), straight.volume(e), 1e-15);
  }
}

class QuadraticPotential : public testing::TestWithParam<std::size_t> {
 protected:
  const MaterialModel material_ = all_materials()[GetParam()];
  const TetMesh mesh_ = curved_block({8, 5, 5});  // 1200 elements: several blocks, padding
  const RestState rest_{mesh_};
  const ElasticPotential potential_{rest_, material_};
  const FreeCoordinates free_{mesh_.vertex_count()};
  const Vector q_ = strained_state(potential_, mesh_.rest_positions(), 0.1);

  // The sum of the terms of all elements.
  double summed(Vector& gradient, const Vector* x, Vector* product) const {
    double energy = 0.0;
    gradient = Vector::Zero(q_.size());
    if (product != nullptr) *product = Vector::Zero(q_.size());
    for (Index e = 0; e < rest_.element_count(); ++e) {
      ElasticPotential::ElementTerms terms;
      EXPECT_TRUE(potential_.element_terms(e, q_, x != nullptr, terms));
      energy += terms.energy;
      const ElementNodes nodes = rest_.nodes(e);
      Vector local(30);
      for (std::size_t a = 0; a < 10; ++a) {
        vertex_block(gradient, nodes[a]) += terms.gradient.col(static_cast<Index>(a));
        if (x != nullptr) vertex_block(local, static_cast<Index>(a)) = vertex_block(*x, nodes[a]);
      }
      if (x == nullptr) continue;
      local = (terms.hessian * local).eval();
      for (std::size_t a = 0; a < 10; ++a) {
        vertex_block(*product, nodes[a]) += vertex_block(local, static_cast<Index>(a));
      }
    }
    return energy;
  }
};

TEST_P(QuadraticPotential, DerivativesAreThoseOfTheEnergy) {
  const TetMesh mesh = curved_block({2, 1, 1});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  const DerivativeErrors errors =
      check_derivatives(potential, strained_state(potential, mesh.rest_positions(), 0.1));
  EXPECT_LT(errors.force, 1e-8);
  EXPECT_LT(errors.stiffness, 1e-8);
  EXPECT_GT(errors.force_norm, 1.0);
}

TEST_P(QuadraticPotential, KernelsAgreeWithSingleElements) {
  const Vector x = jiggled(Vector::Zero(q_.size()), 1.0);
  Vector expected;
  Vector expected_product;
  const double expected_energy = summed(expected, &x, &expected_product);
  const auto [energy, gradient] = value_and_gradient_of(potential_, q_);
  EXPECT_NEAR(energy, expected_energy, 1e-11 * expected_energy);
  EXPECT_LT((gradient - expected).norm(), 1e-12 * expected.norm());
  Vector product;
  potential_.product(q_, x, product);
  EXPECT_LT((product - expected_product).norm(), 1e-12 * expected_product.norm());

  TangentOperator<double> tangent(potential_);
  tangent.set(q_);
  AlignedVector<double> rows(static_cast<std::size_t>(4 * mesh_.vertex_count()), 0.0);
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    for (Index k = 0; k < 3; ++k) rows[static_cast<std::size_t>(4 * v + k)] = x[3 * v + k];
  }
  tangent.multiply(rows.data());
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    vertex_block(product, v) = tangent.record_sum(v).head<3>();
  }
  EXPECT_LT((product - expected_product).norm(), 1e-11 * expected_product.norm());

  // Assembled, and the diagonal blocks.
  const SparsityPattern pattern(rest_, free_);
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  ASSERT_TRUE(potential_.add_hessian(q_, pattern, values.data()).ok());
  AlignedVector<double> on;
  AlignedVector<double> off;
  tangent.diagonal(on, off);
  for_each_entry(pattern, values, [&](Index i, Index j, double entry) {
    if (i == j) {
      EXPECT_NEAR(on[static_cast<std::size_t>(4 * (i / 3) + i % 3)], entry, 1e-9 * entry);
    }
    if (i == j + 1 && j % 3 == 0) {
      EXPECT_NEAR(off[static_cast<std::size_t>(4 * (i / 3))], entry, 1e-9 * on[0]);
    }
  });
  product = sparse_product(pattern, values, x);
  EXPECT_LT((product - expected_product).norm(), 1e-11 * expected_product.norm());
}

TEST_P(QuadraticPotential, InnerForcesAddUpToNothing) {
  const auto [energy, gradient] = value_and_gradient_of(potential_, q_);
  Vector3 force = Vector3::Zero();
  Vector3 torque = Vector3::Zero();
  double scale = 0.0;
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    force += vertex_block(gradient, v);
    torque += vertex_block(q_, v).cross(vertex_block(gradient, v));
    scale += vertex_block(gradient, v).norm();
  }
  ASSERT_GT(scale, 1.0);
  EXPECT_LT(force.norm(), 1e-13 * scale);
  EXPECT_LT(torque.norm(), 1e-13 * scale);
}

TEST_P(QuadraticPotential, ConstantStrainPatchHasInnerForcesOfZero) {
  Matrix3 a;
  a << 1.1, 0.2, -0.1, 0.05, 0.9, 0.1, -0.2, 0.1, 1.05;
  // Edges are straight. The four points do not integrate the gradients of curved elements exactly.
  TetMesh distorted = small_block();
  const Vector moved = jiggled(distorted.rest_positions(), 0.05);
  for (Index v = 0; v < distorted.vertex_count(); ++v) {
    distorted.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(moved, v);
  }
  const TetMesh mesh = with_edge_vertices(distorted);
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  const Vector q = apply(mesh, [&](const Vector3& x) -> Vector3 { return a * x; });
  const auto [energy, gradient] = value_and_gradient_of(potential, q);
  std::vector<bool> on_boundary(static_cast<std::size_t>(mesh.vertex_count()), false);
  const EdgeVertices edges(mesh);
  for (const auto& face : boundary_faces(mesh)) {
    for (const Index v : edges.of_face(face)) on_boundary[static_cast<std::size_t>(v)] = true;
  }
  double inner = 0.0;
  double outer = 0.0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const double force = vertex_block(gradient, v).norm();
    double& most = on_boundary[static_cast<std::size_t>(v)] ? outer : inner;
    most = std::max(most, force);
  }
  ASSERT_GT(outer, 1.0);
  EXPECT_LT(inner, 1e-12 * outer);
}

TEST_P(QuadraticPotential, BitsDoNotDependOnThreads) {
  Vector gradients[2];
  for (int i = 0; i < 2; ++i) {
    set_thread_count(i + 1);
    double energy = 0.0;
    ASSERT_TRUE(potential_.value_and_gradient(q_, energy, gradients[i]).ok());
  }
  set_thread_count(0);
  EXPECT_EQ(gradients[0], gradients[1]);
}

TEST_P(QuadraticPotential, DiscreteGradientGivesTheChangeOfEnergy) {
  const Vector end = q_ + jiggled(Vector::Zero(q_.size()), 0.01, 5);
  const Vector middle = 0.5 * (q_ + end);
  const Vector way = middle - q_;
  const DiscreteGradient discrete(potential_);
  Vector gradient = Vector::Zero(q_.size());
  ASSERT_TRUE(discrete.add({Positions(middle), way, 0.0}, gradient).ok());
  double before = 0.0;
  double after = 0.0;
  ASSERT_TRUE(potential_.value(q_, before).ok());
  ASSERT_TRUE(potential_.value(end, after).ok());
  ASSERT_GT(std::abs(after - before), 1e-3 * before);
  EXPECT_NEAR(gradient.dot(end - q_), after - before, 1e-11 * after);
}

TEST_P(QuadraticPotential, StepsStopBeforeAPointIsInverted) {
  const Vector d = apply(mesh_, [](const Vector3& x) { return Vector3(-2.0 * x[0], 0.0, 0.0); });
  const double t = admissible_step(rest_, q_, d);
  ASSERT_LT(t, 1.0);
  double least = 1.0;
  for (Index i = 0; i < rest_.point_count(); ++i) {
    least = std::min(
        least,
        deformation_gradient(rest_.point(i), 0, rest_.gather(Vector(q_ + t * d), i)).determinant());
  }
  EXPECT_GT(least, 0.0);
  EXPECT_LT(least, 0.3);
}

INSTANTIATE_TEST_SUITE_P(All, QuadraticPotential, testing::Values(0U, 1U, 2U));

TEST(QuadraticTetrahedra, ViscosityAgreesWithSingleElements) {
  const TetMesh mesh = curved_block();
  const RestState rest(mesh);
  const ElasticPotential elastic(rest, all_materials()[1]);
  ViscousPotential viscous(elastic);
  const Vector q = strained_state(elastic, mesh.rest_positions(), 0.1);
  const Vector u = jiggled(Vector::Zero(q.size()), 0.01, 3);
  viscous.begin(q, 2.5);
  viscous.set_estimate(u);
  double value = 0.0;
  Vector gradient = Vector::Zero(q.size());
  viscous.add_value_and_gradient(u, value, gradient);
  Vector expected = Vector::Zero(q.size());
  double sum = 0.0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    terms.gradient.setZero(3, 10);
    viscous.add_element_terms(e, Positions(q, u), false, terms);
    sum += terms.energy;
    Index a = 0;
    for (const Index v : rest.nodes(e)) vertex_block(expected, v) += terms.gradient.col(a++);
  }
  ASSERT_GT(sum, 0.0);
  EXPECT_NEAR(value, sum, 1e-12 * sum);
  EXPECT_LT((gradient - expected).norm(), 1e-11 * expected.norm());
}

TEST(QuadraticTetrahedra, MassesArePositiveAndHaveTheRightMoments) {
  const TetMesh mesh = with_edge_vertices(small_block());
  const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
  EXPECT_GT(system.mass().minCoeff(), 0.0);
  EXPECT_NEAR(system.total_mass(), 2000.0, 1e-9);
  EXPECT_LT((center_of_mass(system, mesh.rest_positions()) - Vector3(1.0, 0.5, 0.5)).norm(), 1e-13);
}

TEST(QuadraticTetrahedra, HaveNoNodalVolumes) {
  const TetMesh mesh = with_edge_vertices(small_block());
  const BodyRegion region{all_materials()[1], 1000.0};
  EXPECT_THROW(MechanicalSystem(mesh, {region}, {}, VolumeRule::kNodal), InputError);
}

TEST(QuadraticTetrahedra, FieldsOfAHomogeneousState) {
  const TetMesh mesh = curved_block();
  const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
  const Vector q =
      apply(mesh, [](const Vector3& x) { return Vector3(1.2 * x[0], 0.9 * x[1], x[2]); });
  const NodalFields at_vertices = nodal_fields(system, q);
  EXPECT_LT((at_vertices.jacobian.array() - 1.08).abs().maxCoeff(), 1e-12);
  EXPECT_LT((at_vertices.green_strain.row(0).array() - 0.22).abs().maxCoeff(), 1e-12);
  const ElementFields fields = element_fields(system, q);
  EXPECT_LT((at_vertices.cauchy_stress.colwise() - fields.cauchy_stress.col(0)).norm(),
            1e-9 * fields.cauchy_stress.norm());
  EXPECT_LT((fields.jacobian.array() - 1.08).abs().maxCoeff(), 1e-12);
  EXPECT_LT((fields.green_strain.row(0).array() - 0.22).abs().maxCoeff(), 1e-12);
  EXPECT_NEAR(fields.cauchy_stress.row(0).maxCoeff(), fields.cauchy_stress.row(0).minCoeff(),
              1e-10 * fields.cauchy_stress.cwiseAbs().maxCoeff());
}

// A map whose components are quadratic: the isoparametric elements of a straight mesh follow it exactly.
Vector3 bent(const Vector3& x) {
  return {x[0] * (1.0 + 0.3 * x[1]), x[1] * (1.0 + 0.2 * x[2]), x[2] * (1.0 + 0.25 * x[0])};
}
TetMesh bent_block(const std::array<int, 3>& cells) {
  TetMesh mesh = with_edge_vertices(small_block(cells));
  for (Vector3& x : mesh.vertices.own()) x = bent(x);
  return mesh;
}
// ∫ (1 + 0.3 y)(1 + 0.2 z)(1 + 0.25 x) + 0.015 x y z over 2 × 1 × 1.
constexpr double kBentVolume = 2.5 * 1.15 * 1.1 + 0.015 * 2.0 * 0.5 * 0.5;

TEST(QuadraticTetrahedra, VolumesWithCurvedEdgesAreExact) {
  for (const std::array<int, 3>& cells : {std::array{1, 1, 1}, {3, 2, 1}}) {
    const TetMesh mesh = bent_block(cells);
    EXPECT_NEAR(mesh.total_volume(), kBentVolume, 1e-14);
    const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
    EXPECT_NEAR(system.total_mass(), 1000.0 * kBentVolume, 1e-10);
    // The loads per volume of statics have the same sum.
    MechanicalSystem consistent(mesh, all_materials()[1], 1000.0);
    consistent.use_consistent_weights();
    double sum = 0.0;
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) sum += consistent.element_weights(e).sum();
    EXPECT_NEAR(sum, kBentVolume, 1e-13);
  }
}

TEST(QuadraticTetrahedra, VolumesWithStraightEdgesHaveTheBitsOfTheFourPoints) {
  const TetMesh mesh = with_edge_vertices(small_block({3, 2, 2}));
  const RestState rest(mesh);
  for (Index e = 0; e < rest.element_count(); ++e) {
    double sum = 0.0;
    for (Index p = 0; p < 4; ++p) sum += rest.point_volume(4 * e + p);
    EXPECT_EQ(rest.volume(e), sum);
  }
}

TEST(QuadraticTetrahedra, MeansOfTheJacobianAreRatiosOfVolumes) {
  const TetMesh straight = with_edge_vertices(small_block({2, 1, 1}));
  const TetMesh curved = bent_block({2, 1, 1});
  const MechanicalSystem from_straight(straight, all_materials()[1], 1.0);
  const MechanicalSystem from_curved(curved, all_materials()[1], 1.0);
  const auto mean = [](const MechanicalSystem& system, const Vector& q) {
    double sum = 0.0;
    const ElementFields fields = element_fields(system, q);
    for (Index e = 0; e < fields.jacobian.cols(); ++e) {
      EXPECT_EQ(fields.jacobian(0, e), volume_ratio(system, e, q));
      sum += fields.jacobian(0, e) * system.mesh().volume(e);
    }
    return sum / system.mesh().total_volume();
  };
  EXPECT_NEAR(mean(from_straight, curved.rest_positions()), kBentVolume / 2.0, 1e-14);
  EXPECT_NEAR(mean(from_curved, straight.rest_positions()), 2.0 / kBentVolume, 1e-14);
}

// Small displacements that are linear in the curved X have a constant gradient; others, u_a at the nodes,
// the mean ∫ ∂u/∂X dV/V = ∮ u n dA/V. Both sides of a mesh of one element are exact here.
TEST(QuadraticTetrahedra, MeanStressesOfCurvedElementsAreExactForSmallStrains) {
  const TetMesh mesh = bent_block({1, 1, 1});
  const LameParameters lame = lame_from_young(1e6, 0.3);
  const MechanicalSystem system(mesh, StVenantKirchhoff(lame.mu, lame.lambda), 1.0);
  constexpr double kSmall = 1e-7;
  const Vector rest = mesh.rest_positions();
  const Vector u = kSmall * jiggled(Vector::Zero(rest.size()), 1.0);
  // ∫ ∂u_i/∂X_j dV is the derivative of the volume of the element when the component j of X moves
  // along u_i.
  const auto volume = [&](Index e, const Vector& x) {
    TetMesh moved = mesh;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      moved.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(x, v);
    }
    return moved.volume(e);
  };
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    Matrix3 gradient;
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        Vector change = Vector::Zero(rest.size());
        for (Index v = 0; v < mesh.vertex_count(); ++v) change[3 * v + j] = u[3 * v + i] / kSmall;
        constexpr double kStep = 1e-3;  // the volume is cubic in it
        const auto slope = [&](double h) {
          return (volume(e, rest + h * change) - volume(e, rest - h * change)) / (2.0 * h);
        };
        gradient(i, j) = kSmall / mesh.volume(e) * (4.0 * slope(kStep) - slope(2.0 * kStep)) / 3.0;
      }
    }
    const Matrix3 strain = 0.5 * (gradient + gradient.transpose());
    const Matrix3 expected =
        lame.lambda * strain.trace() * Matrix3::Identity() + 2.0 * lame.mu * strain;
    const Matrix3 found = cauchy_stress(system, e, rest + u);
    EXPECT_LT((found - expected).norm(), 1e-5 * expected.norm());
    const ElementFields fields = element_fields(system, rest + u);
    EXPECT_LT((fields.cauchy_stress.col(e) - six_components(found)).norm(), 1e-12 * found.norm());
  }
}

// With straight edges a quadratic displacement has its exact gradient everywhere, and all elements at a
// vertex have the same one there.
TEST(QuadraticTetrahedra, StressesAtVerticesAreThoseOfQuadraticDisplacements) {
  const TetMesh mesh = with_edge_vertices(small_block({2, 2, 1}));
  for (const MaterialModel& material : all_materials()) {
    const MechanicalSystem system(mesh, material, 1000.0);
    const Vector q = apply(mesh, bent);
    const NodalFields fields = nodal_fields(system, q);
    const auto check = [&](const Vector3& x, const Vector6& stress, double mises, double jacobian) {
      Matrix3 f;
      f << 1.0 + 0.3 * x[1], 0.3 * x[0], 0.0, 0.0, 1.0 + 0.2 * x[2], 0.2 * x[1], 0.25 * x[2], 0.0,
          1.0 + 0.25 * x[0];
      const Matrix3 p =
          std::visit([&](const auto& m) -> Matrix3 { return m.first_piola(f); }, material);
      const Matrix3 exact = p * f.transpose() / f.determinant();
      EXPECT_LT((stress - six_components(exact)).norm(), 1e-11 * 1e6);
      EXPECT_NEAR(mises, von_mises(exact), 1e-11 * 1e6);
      EXPECT_NEAR(jacobian, f.determinant(), 1e-13);
    };
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      check(mesh.vertices[static_cast<std::size_t>(v)], fields.cauchy_stress.col(v),
            fields.von_mises(0, v), fields.jacobian(0, v));
    }
    const std::array<double, 4> l{0.1, 0.2, 0.3, 0.4};
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      Vector3 x = Vector3::Zero();
      for (std::size_t a = 0; a < 4; ++a) {
        x += l[a] * mesh.vertices[static_cast<std::size_t>(
                        mesh.tetrahedra[static_cast<std::size_t>(e)][a])];
      }
      const PlaceValues values = values_at(system, e, l, q);
      check(x, six_components(values.cauchy_stress), values.von_mises, values.jacobian);
    }
  }
}

// Where an element has no gradient or no energy, the values are those of a point of quadrature.
TEST(QuadraticTetrahedra, StressesAreFiniteWhereElementsTurnInsideOut) {
  TetMesh quarter = with_edge_vertices(generate_tetrahedron(1.0));
  // The edge vertices at the quarters next to corner 0, as at the tip of a crack: ∂X/∂ξ is zero there.
  for (const std::size_t k : {0U, 2U, 3U}) {
    const auto corner = [&](std::size_t a) {
      return Vector3(quarter.vertices[static_cast<std::size_t>(quarter.tetrahedra[0][a])]);
    };
    const auto middle = static_cast<std::size_t>(quarter.edge_vertices[0][k]);
    quarter.vertices.own()[middle] = 0.75 * corner(0) + 0.25 * corner(k == 0U   ? 1U
                                                                      : k == 2U ? 2U
                                                                                : 3U);
  }
  const TetMesh straight = with_edge_vertices(generate_tetrahedron(1.0));
  for (const bool is_inverted : {false, true}) {
    const TetMesh& mesh = is_inverted ? straight : quarter;
    const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
    Vector q = 1.1 * mesh.rest_positions();
    // J < 0 at the corner 1, and positive at the four points.
    const auto corner = mesh.tetrahedra[0][1];
    if (is_inverted) {
      vertex_block(q, corner) -=
          0.6 * (vertex_block(q, corner) - vertex_block(q, mesh.tetrahedra[0][0]));
    }
    ASSERT_GT(least_jacobian(system, 0, q), 0.0);
    const NodalFields fields = nodal_fields(system, q);
    EXPECT_TRUE(fields.cauchy_stress.allFinite());
    EXPECT_TRUE(fields.von_mises.allFinite());
    EXPECT_GT(fields.jacobian.minCoeff(), 0.0);
    EXPECT_TRUE(cauchy_stress(system, 0, q).allFinite());
    EXPECT_LT(fields.jacobian.maxCoeff(), 10.0);
  }
}

}  // namespace
}  // namespace tetraction
