// The rigid surface of an obstacle, and the potential of a point near it.
#include "dynamics/contact/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "dynamics/contact/mesh/point_on_mesh.h"
#include "dynamics/contact/pairs/pair_distance.h"
#include "support/contact_surfaces.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::vector<Index> all_triangles(const TriangleMesh& mesh) {
  std::vector<Index> all(mesh.triangles().size());
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

std::string refusal(const Triangles& t) {
  try {
    const TriangleMesh mesh(t.points, t.triangles);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// A wavy open surface, whose edges are convex, concave and bordering.
Triangles wavy_grid(int n) {
  Triangles grid = flat_grid(n, 1.0);
  std::mt19937 random(31);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (Vector3& p : grid.points) {
    p += 0.2 / n * Vector3(uniform(random), uniform(random), uniform(random));
  }
  return grid;
}

TEST(TriangleMesh, WeldsRepeatedPoints) {
  Triangles cube = cube_surface(2, 1.0);
  Triangles soup;
  for (const auto& t : cube.triangles) {
    const Index first = static_cast<Index>(soup.points.size());
    for (const Index i : t) soup.points.push_back(cube.points[static_cast<std::size_t>(i)]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  // As text of STL may have it.
  for (Vector3& p : soup.points) {
    if (p[0] == 0.0) p[0] = -0.0;
  }
  soup.triangles.push_back(soup.triangles.front());
  soup.points.emplace_back(7, 7, 7);
  const TriangleMesh mesh(soup.points, soup.triangles);
  EXPECT_EQ(mesh.points().size(), 26U);
  EXPECT_EQ(mesh.triangles().size(), 48U);
  EXPECT_EQ(mesh.edges().size(), 72U);
  EXPECT_TRUE(mesh.watertight());
  // The twelve edges of the cube, each of two; the others are flat.
  EXPECT_EQ(mesh.sharp_edges().size(), 24U);
  EXPECT_EQ(mesh.sharp_vertices().size(), 20U);
  for (Index f = mesh.first_edge(); f < mesh.feature_count(); ++f) {
    EXPECT_EQ(mesh.coefficient(f), f < mesh.first_vertex() ? -1.0 : 1.0);
  }
}

TEST(TriangleMesh, OpenSurfacesHaveABorder) {
  const Triangles grid = flat_grid(3, 1.0);
  const TriangleMesh mesh(grid.points, grid.triangles);
  EXPECT_FALSE(mesh.watertight());
  EXPECT_EQ(mesh.sharp_edges().size(), 12U);
  EXPECT_EQ(mesh.sharp_vertices().size(), 12U);
  double edges = 0.0;
  double vertices = 0.0;
  for (Index f = mesh.first_edge(); f < mesh.feature_count(); ++f) {
    (f < mesh.first_vertex() ? edges : vertices) += mesh.coefficient(f);
  }
  EXPECT_EQ(edges, -21.0);
  EXPECT_EQ(vertices, 4.0);
}

TEST(TriangleMesh, RefusesWhatIsNoSurface) {
  Triangles t = flat_grid(2, 1.0);
  EXPECT_EQ(refusal(t), "");
  Triangles bad = t;
  bad.triangles.clear();
  EXPECT_NE(refusal(bad).find("no triangle"), std::string::npos);
  bad = t;
  bad.points[3][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(bad).find("Point 3"), std::string::npos);
  bad = t;
  bad.triangles[5][2] = 9;
  EXPECT_NE(refusal(bad).find("Triangle 5"), std::string::npos);
  bad.triangles[5][2] = -1;
  EXPECT_NE(refusal(bad).find("corner -1"), std::string::npos);
  bad = t;
  bad.triangles[4] = {0, 1, 2};
  EXPECT_NE(refusal(bad).find("Triangle 4"), std::string::npos);
  EXPECT_NE(refusal(bad).find("no area"), std::string::npos);
  bad.triangles[4] = {0, 1, 1};
  EXPECT_NE(refusal(bad).find("no area"), std::string::npos);
  // Small and large units are no reason.
  for (const double scale : {1e-9, 1e9}) {
    Triangles scaled = t;
    for (Vector3& p : scaled.points) p *= scale;
    EXPECT_EQ(refusal(scaled), "");
  }
}

TEST(TriangleMesh, ClosestFeaturesGiveTheDistance) {
  const Triangles grid = wavy_grid(5);
  const TriangleMesh mesh(grid.points, grid.triangles);
  std::mt19937 random(32);
  std::uniform_real_distribution<double> uniform(-0.3, 1.3);
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3 x(uniform(random), uniform(random), 0.3 * uniform(random));
    for (const Index t : all_triangles(mesh)) {
      PairPoints p;
      p.col(0) = x;
      for (int k = 0; k < 3; ++k) {
        const auto& corners = mesh.triangles()[static_cast<std::size_t>(t)];
        p.col(k + 1) =
            mesh.points()[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])];
      }
      const PairDistance d = pair_distance(PairKind::kPointTriangle, p);
      const Vector3 offset = mesh.offset(mesh.closest_feature_of_triangle(t, x), x);
      EXPECT_LT((offset - d.difference).norm(), 1e-13);
    }
  }
}

// U of a point over a flat part is U_b of its distance from the plane, also over edges and vertices, and for
// triangles of any shape; the mean force of a long slide has the direction of the normal.
TEST(PointOnMesh, FlatSurfaceActsAsAPlane) {
  std::mt19937 random(33);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Triangles grid = flat_grid(8, 1.0);
  for (Vector3& p : grid.points) {
    p += 0.04 * Vector3(uniform(random), uniform(random), 0.0);
  }
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, -0.5).normalized()).toRotationMatrix();
  const Vector3 shift(3, -2, 1);
  for (Vector3& p : grid.points) p = turn * p + shift;
  const Vector3 normal = turn.col(2);
  const TriangleMesh mesh(grid.points, grid.triangles);
  const std::vector<Index> all = all_triangles(mesh);
  const Barrier barrier{0.3, 1e6};
  PointOnMesh point(mesh, barrier);
  for (int trial = 0; trial < 300; ++trial) {
    const double d = 0.3 * std::pow(10.0, -2.0 * std::abs(uniform(random)));
    Vector3 x = turn * Vector3(0.5 + 0.4 * uniform(random), 0.5 + 0.4 * uniform(random), 0) + shift;
    if (trial % 3 == 0) x = mesh.points()[40 + static_cast<std::size_t>(trial / 150)];
    if (trial % 3 == 1) {
      const auto& e = mesh.edges()[100];
      x = 0.3 * mesh.points()[static_cast<std::size_t>(e[0])] +
          0.7 * mesh.points()[static_cast<std::size_t>(e[1])];
    }
    const double side = trial % 2 == 0 ? 1.0 : -1.0;
    x += side * d * normal;
    EXPECT_NEAR(point.energy(all, x), barrier.value(d), 1e-12 * barrier.value(d));
    EXPECT_LT((point.gradient(all, x) - side * barrier.slope(d) * normal).norm(),
              -1e-11 * barrier.slope(d));
    EXPECT_NEAR(point.distance(all, x), d, 1e-14);
    const Vector3 y = turn * Vector3(0.5 + 0.4 * uniform(random), 0.5 + 0.4 * uniform(random),
                                     side * 0.3 * std::abs(uniform(random))) +
                      shift;
    const double e = std::abs(normal.dot(y - shift));
    const Vector3 mean = point.mean_gradient(all, x, y);
    EXPECT_NEAR(mean.dot(y - x), barrier.value(e) - barrier.value(d),
                1e-11 * (barrier.value(d) + barrier.value(e)));
    // The parts of the way have secants of their own, all along the normal.
    EXPECT_LT((mean - normal.dot(mean) * normal).norm(), 1e-11 * mean.norm());
  }
}

TEST(PointOnMesh, DerivativesAgreeWithDifferences) {
  const Triangles grid = wavy_grid(6);
  const TriangleMesh mesh(grid.points, grid.triangles);
  const std::vector<Index> all = all_triangles(mesh);
  const Barrier barrier{0.2, 1e3};
  PointOnMesh point(mesh, barrier);
  std::mt19937 random(34);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  std::uniform_real_distribution<double> small(-0.15, 0.15);
  int compared = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const Vector3 x(uniform(random), uniform(random), small(random));
    const double d = point.distance(all, x);
    if (d < 0.02 || d > 0.19) continue;
    const double h = 1e-7;
    Vector3 slope;
    Matrix3 bend;
    for (int k = 0; k < 3; ++k) {
      const Vector3 step = h * Vector3::Unit(k);
      slope[k] = (point.energy(all, x + step) - point.energy(all, x - step)) / (2.0 * h);
      bend.col(k) = (point.gradient(all, x + step) - point.gradient(all, x - step)) / (2.0 * h);
    }
    const Vector3 gradient = point.gradient(all, x);
    EXPECT_LT((slope - gradient).norm(), 1e-6 * gradient.norm() + 1e-5);
    const Matrix3 hessian = point.hessian(all, x);
    // The closest feature of a triangle changes within few of the differences.
    if ((bend - hessian).norm() < 1e-5 * hessian.norm() + 1e-3) ++compared;
    EXPECT_GE(point.energy(all, x), 0.0);
  }
  EXPECT_GT(compared, 300);
}

TEST(PointOnMesh, MeanGradientGivesTheChangeOfEnergy) {
  const Triangles grid = wavy_grid(6);
  const TriangleMesh mesh(grid.points, grid.triangles);
  const std::vector<Index> all = all_triangles(mesh);
  const Barrier barrier{0.2, 1e3};
  PointOnMesh point(mesh, barrier);
  std::mt19937 random(35);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  double worst = 0.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vector3 x(uniform(random), uniform(random), 0.05 + 0.15 * std::abs(unit(random)));
    const double size = std::pow(10.0, -(trial % 8));
    const Vector3 y = x + size * Vector3(unit(random), unit(random), 0.1 * unit(random));
    if (point.distance(all, x) < 1e-3 || point.distance(all, y) < 1e-3) continue;
    const double a = point.energy(all, x);
    const double b = point.energy(all, y);
    if (a + b == 0.0) continue;
    const Vector3 mean = point.mean_gradient(all, x, y);
    worst = std::max(worst, std::abs(mean.dot(y - x) - (b - a)) / std::max(a, b));
  }
  EXPECT_LT(worst, 1e-11);
}

TEST(PointOnMesh, MeanHessianIsTheDerivative) {
  const Triangles grid = wavy_grid(6);
  const TriangleMesh mesh(grid.points, grid.triangles);
  const std::vector<Index> all = all_triangles(mesh);
  const Barrier barrier{0.2, 1e3};
  PointOnMesh point(mesh, barrier);
  std::mt19937 random(36);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int good = 0;
  int all_trials = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const Vector3 x(uniform(random), uniform(random), 0.08 + 0.1 * uniform(random));
    const Vector3 y = x + Vector3(0.2 * unit(random), 0.2 * unit(random), 0.03 * unit(random));
    if (point.distance(all, y) > 0.19 || point.distance(all, y) < 0.02) continue;
    const double h = 1e-7;
    Matrix3 bend;
    for (int k = 0; k < 3; ++k) {
      const Vector3 step = h * Vector3::Unit(k);
      bend.col(k) =
          (point.mean_gradient(all, x, y + step) - point.mean_gradient(all, x, y - step)) /
          (2.0 * h);
    }
    bend = (0.5 * (bend + bend.transpose())).eval();
    ++all_trials;
    if ((bend - point.mean_hessian(all, x, y)).norm() < 1e-4 * bend.norm() + 1e-2) ++good;
  }
  ASSERT_GT(all_trials, 200);
  // The others pass a kink within the differences.
  EXPECT_GT(good, all_trials * 95 / 100);
}

}  // namespace
}  // namespace tetraction
