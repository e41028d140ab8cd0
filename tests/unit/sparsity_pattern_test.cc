#include "tetraction/fem/sparsity_pattern.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "support/assembled.h"
#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(SparsityPattern, HoldsTheLowerTriangleWithAscendingRows) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const SparsityPattern pattern(rest, hold(mesh, SelectPlane{0, 0.0, {}}).coordinates());
  ASSERT_EQ(pattern.size(), 3 * (mesh.vertex_count() - 9));
  for (Index j = 0; j < pattern.size(); ++j) {
    const int begin = pattern.column_begin()[static_cast<std::size_t>(j)];
    const int end = pattern.column_begin()[static_cast<std::size_t>(j) + 1];
    ASSERT_LT(begin, end);
    EXPECT_EQ(pattern.rows()[static_cast<std::size_t>(begin)], j) << "the diagonal comes first";
    for (int k = begin + 1; k < end; ++k) {
      EXPECT_LT(pattern.rows()[static_cast<std::size_t>(k) - 1],
                pattern.rows()[static_cast<std::size_t>(k)]);
    }
  }
}

TEST(SparsityPattern, ElementsOfAColorShareNoVertex) {
  const TetMesh mesh = small_block({5, 4, 3});
  const RestState rest(mesh);
  const SparsityPattern pattern(rest, FreeCoordinates(mesh.vertex_count()));
  std::size_t count = 0;
  for (const auto& color : pattern.colors()) {
    std::set<Index> seen;
    for (const Index e : color) {
      for (const Index v : rest.nodes(e)) EXPECT_TRUE(seen.insert(v).second);
    }
    count += color.size();
  }
  EXPECT_EQ(count, mesh.tetrahedra.size());
}

// A held vertex, one on a line, one on a skew plane, and an affine set of three vertices.
FreeCoordinates mixed_coordinates(const TetMesh& mesh) {
  VertexFreedom line;
  line.count = 1;
  line.basis.col(0) = Vector3(1, 2, 2) / 3.0;
  VertexFreedom plane;
  plane.count = 2;
  plane.basis.col(0) = Vector3(2, -1, 0).normalized();
  plane.basis.col(1) = Vector3(0, 0, 1);
  VertexFreedom held;
  held.count = 0;
  AffineSet set;
  set.vertices = {2, 5, 7};
  set.coordinates.resize(1, 3);
  set.coordinates << -1.2, 0.0, 1.2;  // any numbers serve the pattern
  return {mesh.vertex_count(), {{0, held}, {1, line}, {3, plane}}, {set}};
}

TEST(SparsityPattern, ScatterMakesTheReducedMatrix) {
  const TetMesh mesh = generate_box({1, 1, 1}, {2, 1, 1});
  const RestState rest(mesh);
  const FreeCoordinates coordinates = mixed_coordinates(mesh);
  const SparsityPattern pattern(rest, coordinates);
  ASSERT_EQ(pattern.size(), 3 * (12 - 6) + 1 + 2 + 6);

  // Any symmetric element matrices, and the same summed into a dense one.
  Matrix full = Matrix::Zero(3 * mesh.vertex_count(), 3 * mesh.vertex_count());
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  for (Index e = 0; e < rest.element_count(); ++e) {
    SparsityPattern::Shape::DofMatrix local;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j) {
        local(i, j) = std::cos(static_cast<double>(e) + 3.0 * std::max(i, j) + std::min(i, j));
        const auto a = static_cast<std::size_t>(i / 3);
        const auto b = static_cast<std::size_t>(j / 3);
        full(3 * rest.nodes(e)[a] + i % 3, 3 * rest.nodes(e)[b] + j % 3) += local(i, j);
      }
    }
    pattern.scatter(e, local, values.data());
  }
  Matrix blocks(3, full.cols());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 d(1.0, 2.0, 3.0 + static_cast<double>(v));
    blocks.middleCols<3>(3 * v) = Matrix3(d.asDiagonal()) + 0.5 * d * d.transpose();
    full.block<3, 3>(3 * v, 3 * v) += blocks.middleCols<3>(3 * v);
  }
  pattern.add_vertex_blocks(blocks, values.data());

  Matrix t(full.rows(), coordinates.count());
  for (Index i = 0; i < t.cols(); ++i) t.col(i) = coordinates.extend(Vector::Unit(t.cols(), i));
  const Matrix reduced = t.transpose() * full * t;
  EXPECT_LT((dense_matrix(pattern, values) - reduced).norm(), 1e-13 * reduced.norm());
}

TEST(SparsityPattern, ElementsOfAColorShareNoFreeCoordinate) {
  const TetMesh mesh = generate_box({1, 1, 1}, {4, 2, 2});
  const RestState rest(mesh);
  const FreeCoordinates coordinates = mixed_coordinates(mesh);
  const SparsityPattern pattern(rest, coordinates);
  for (const auto& color : pattern.colors()) {
    std::set<int> seen;
    for (const Index e : color) {
      std::set<int> own;
      for (const Index v : rest.nodes(e)) {
        if (!coordinates.is_fully_prescribed(v)) own.insert(coordinates.map(v).first);
      }
      for (const int first : own) EXPECT_TRUE(seen.insert(first).second);
    }
  }
}

}  // namespace
}  // namespace tetraction
