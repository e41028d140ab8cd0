#include "tetraction/fem/sparsity_pattern.h"

#include <set>

#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(SparsityPattern, HoldsTheLowerTriangleWithAscendingRows) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const SparsityPattern pattern(rest, hold(mesh, SelectPlane{0, 0.0, {}}));
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
  const SparsityPattern pattern(rest, DofConstraints(3 * mesh.vertex_count()));
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

TEST(SparsityPattern, ScatterLeavesFixedDofsOut) {
  const TetMesh mesh = generate_tetrahedron();
  const RestState rest(mesh);
  std::vector<std::uint8_t> fixed(12, 0);
  fixed[1] = fixed[5] = 1;  // y of vertex 0, z of vertex 1
  const DofConstraints constraints(fixed);
  const SparsityPattern pattern(rest, constraints);
  SparsityPattern::Shape::DofMatrix local;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) local(i, j) = 100.0 * std::max(i, j) + std::min(i, j);
  }
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  pattern.scatter(0, local, values.data());
  ASSERT_EQ(pattern.size(), 10);
  for (Index i = 0; i < 12; ++i) {
    for (Index j = 0; j <= i; ++j) {
      if (constraints.is_fixed(i) || constraints.is_fixed(j)) continue;
      const int row = constraints.reduced(i);
      const auto column = static_cast<std::size_t>(constraints.reduced(j));
      double found = -1.0;
      for (int k = pattern.column_begin()[column]; k < pattern.column_begin()[column + 1]; ++k) {
        if (pattern.rows()[static_cast<std::size_t>(k)] == row) {
          found = values[static_cast<std::size_t>(k)];
        }
      }
      EXPECT_EQ(found, local(i, j)) << i << ", " << j;
    }
  }
}

}  // namespace
}  // namespace tetraction
