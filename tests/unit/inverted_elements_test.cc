#include "fem/inverted_elements.h"

#include <Eigen/LU>

#include "support/bodies.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

Index count_one_by_one(const MechanicalSystem& system, const Vector& q, Index& first) {
  Index count = 0;
  first = -1;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const auto nodes = system.rest().gather(q, e);
    if (Matrix3(nodes.rightCols<3>().colwise() - nodes.col(0)).determinant() >= 0.0) continue;
    if (first < 0) first = e;
    ++count;
  }
  return count;
}

TEST(InversionCounter, CountsAsTheDeterminantsSay) {
  // More than one block, and one that is not full.
  for (const auto& cells : {std::array{2, 1, 1}, std::array{10, 7, 6}}) {
    const MechanicalSystem system(small_block(cells), all_materials()[0], 1000.0);
    InversionCounter counter(system.elastic());
    const Vector rest = system.rest_state().position;
    for (const double amplitude : {0.0, 0.02, 0.3, 3.0}) {
      const Vector q = jiggled(rest, amplitude);
      Index first = -1;
      const Index count = count_one_by_one(system, q, first);
      EXPECT_EQ(counter.count(q), count) << amplitude;
      EXPECT_EQ(counter.first(q), first) << amplitude;
      EXPECT_TRUE(amplitude > 0.02 || count == 0);
      EXPECT_TRUE(amplitude < 1.0 || count > 0);
    }
    Vector mirrored = rest;
    for (Index i = 0; i < mirrored.size(); i += 3) mirrored[i] *= -1.0;
    EXPECT_EQ(counter.count(mirrored), system.rest().element_count());
  }
}

TEST(InvertedAtNodes, FindsCornersThatThePointsDoNotSee) {
  const TetMesh linear = small_block({2, 1, 1});
  EXPECT_EQ(inverted_at_nodes(RestState(linear), TetMesh(linear).rest_positions()).count, 0);
  const TetMesh mesh = with_edge_vertices(linear);
  const RestState rest(mesh);
  Vector q = mesh.rest_positions();
  EXPECT_EQ(inverted_at_nodes(rest, q).count, 0);
  // J of a corner changes its sign where the middle of an edge is nearer than a quarter of the edge.
  const Index e = 7;
  const ElementNodes nodes = rest.nodes(e);
  const Vector3 corner = vertex_block(std::as_const(q), nodes[0]);
  const Vector3 way = vertex_block(std::as_const(q), nodes[1]) - corner;
  for (const double place : {0.26, 0.24}) {
    vertex_block(q, nodes[4]) = corner + place * way;
    const InvertedAtNodes found = inverted_at_nodes(rest, q);
    EXPECT_EQ(found.count > 0, place < 0.25) << place;
    EXPECT_EQ(found.first >= 0, place < 0.25);
    for (Index p = 4 * e; p < 4 * e + 4; ++p) {
      const auto edges = rest.gather(q, p);
      EXPECT_GT(Matrix3(edges.rightCols<3>().colwise() - edges.col(0)).determinant(), 0.0);
    }
  }
}

// One vertex is pushed through its neighbours in small steps: found at the step at which it happens, by
// those that may look away, too.
TEST(InversionCounter, FindsAfterSmallStepsWhatBecomesInverted) {
  const MechanicalSystem system(small_block({10, 7, 6}), all_materials()[0], 1000.0);
  InversionCounter counter(system.elastic());
  InversionCounter other(system.elastic());
  Vector q = system.rest_state().position;
  ASSERT_EQ(counter.count(q), 0);
  Index first = -1;
  for (int k = 0; k < 1000 && first < 0; ++k) {
    const Vector before = q;
    q[q.size() - 3] -= 0.0005;
    double energy = 0.0;
    ASSERT_TRUE(system.elastic().value(q, energy).ok());
    const Index count = count_one_by_one(system, q, first);
    EXPECT_EQ(counter.count_after_step(before, q, energy), count) << k;
    // Energies that are not those of q are of no use, and are not used.
    EXPECT_EQ(other.count_after_step(before, q, energy + 1.0), count) << k;
  }
  EXPECT_GE(first, 0);
}

// A step that is too large mirrors elements, of which a Saint Venant-Kirchhoff material knows nothing.
TEST(InversionCounter, FindsWhatALargeStepMirrors) {
  const MechanicalSystem system(small_block({10, 7, 6}), all_materials()[0], 1000.0);
  InversionCounter counter(system.elastic());
  const Vector rest = system.rest_state().position;
  ASSERT_EQ(counter.count(rest), 0);
  Vector mirrored = rest;
  for (Index i = 0; i < mirrored.size(); i += 3) mirrored[i] *= -1.0;
  double energy = 0.0;
  ASSERT_TRUE(system.elastic().value(mirrored, energy).ok());
  EXPECT_EQ(counter.count_after_step(rest, mirrored, energy), system.rest().element_count());
}

}  // namespace
}  // namespace tetraction
