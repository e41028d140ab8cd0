#include "solver/linear/vertex_groups.h"

#include "support/bodies.h"
#include "support/lone_part.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(VertexGroups, EveryVertexHasOnePlaceAndOneGroup) {
  for (const std::array<int, 3>& cells :
       {std::array<int, 3>{1, 1, 1}, std::array<int, 3>{4, 2, 2}, std::array<int, 3>{16, 9, 7}}) {
    const TetMesh mesh = small_block(cells);
    const RestState rest(mesh);
    const VertexGroups groups(rest);
    std::vector<int> seen(mesh.vertices.size(), 0);
    Index places = 0;
    for (Index g = 0; g < groups.count(); ++g) {
      EXPECT_LT(groups.begin(g), groups.end(g));
      EXPECT_EQ(groups.begin(g), places);
      for (Index i = groups.begin(g); i < groups.end(g); ++i, ++places) {
        ++seen[static_cast<std::size_t>(groups.vertex(i))];
        EXPECT_EQ(groups.group(i), g);
      }
    }
    EXPECT_EQ(places, rest.vertex_count());
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), rest.vertex_count());
  }
}

TEST(VertexGroups, CopiesComeLast) {
  const TetMesh mesh = small_block({8, 6, 6});
  const RestState rest(mesh);
  const Index owned = rest.vertex_count() - 100;
  const LonePart part(owned);  // the other vertices are copies
  const VertexGroups groups(rest, &part);
  EXPECT_EQ(groups.end(groups.count() - 1), owned);
  ASSERT_GT(groups.count_with_copies(), groups.count());
  EXPECT_EQ(groups.begin(groups.count()), owned);
  EXPECT_EQ(groups.end(groups.count_with_copies() - 1), rest.vertex_count());
  for (Index i = 0; i < rest.vertex_count(); ++i) EXPECT_EQ(groups.vertex(i) < owned, i < owned);
  // Without own vertices there are copies only.
  const LonePart empty(0);
  const VertexGroups copies(rest, &empty);
  EXPECT_EQ(copies.count(), 0);
  EXPECT_EQ(copies.end(copies.count_with_copies() - 1), rest.vertex_count());
}

TEST(VertexGroups, AreCompact) {
  const TetMesh mesh = small_block({24, 12, 12});
  const RestState rest(mesh);
  const VertexGroups groups(rest);
  ASSERT_GT(groups.count(), 10);
  for (Index g = 0; g < groups.count(); ++g) {
    Vector3 low = rest.position(groups.vertex(groups.begin(g)));
    Vector3 high = low;
    for (Index i = groups.begin(g); i < groups.end(g); ++i) {
      low = low.cwiseMin(rest.position(groups.vertex(i)));
      high = high.cwiseMax(rest.position(groups.vertex(i)));
    }
    // A cube of the group's share of the body has this side; the body's own longest side is 2.
    const double side = std::cbrt(2.0 / static_cast<double>(groups.count()));
    EXPECT_LT((high - low).maxCoeff(), 3.0 * side);
  }
}

}  // namespace
}  // namespace tetraction
