// The search for near features of a surface against a search through all of them.
#include "dynamics/contact/near_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "dynamics/contact/pairs/pair_distance.h"
#include "support/contact_surfaces.h"

namespace tetraction {
namespace {

constexpr double kReach = 0.05;

// A row of cubes, each a body.
struct Cubes {
  explicit Cubes(int count) {
    Triangles all;
    for (int k = 0; k < count; ++k) {
      const Triangles cube = cube_surface(2, 1.0);
      const auto first = static_cast<Index>(all.points.size());
      for (const Vector3& p : cube.points) all.points.push_back(p + 1.02 * k * Vector3::UnitX());
      for (const auto& [a, b, c] : cube.triangles) {
        all.triangles.push_back({first + a, first + b, first + c});
      }
      body_of.resize(all.points.size(), k);
    }
    surface = contact_surface(all);
  }
  ContactSurface surface;
  std::vector<Index> body_of;
};

double distance_of(const ContactSurface& surface, const Vector& x, PairKind kind, Index i,
                   Index j) {
  PairPoints p = PairPoints::Zero();
  const auto set = [&](int column, Index v) { p.col(column) = vertex_block(x, v); };
  if (kind == PairKind::kPointTriangle) {
    set(0, i);
    for (int k = 0; k < 3; ++k) set(k + 1, surface.triangles[std::size_t(j)][std::size_t(k)]);
  } else {
    for (int k = 0; k < 2; ++k) {
      set(k, surface.edges[std::size_t(i)][std::size_t(k)]);
      set(k + 2, surface.edges[std::size_t(j)][std::size_t(k)]);
    }
  }
  return std::sqrt(pair_distance(kind, p).squared);
}

bool has(const NearFeatures::Pairs& pairs, Index i, Index j) {
  return std::ranges::count(pairs, std::array<Index, 2>{i, j}) == 1;
}

void expect_all_near(const Cubes& cubes, const NearFeatures::Found& found, const Vector& x) {
  const ContactSurface& surface = cubes.surface;
  const auto body = [&](Index v) { return cubes.body_of[std::size_t(v)]; };
  for (Index i = 0; i < Index(surface.vertices.size()); ++i) {
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
      const bool same = body(i) == body(surface.triangles[std::size_t(t)][0]);
      if (same) {
        EXPECT_FALSE(has(found.vertex_faces, i, t));
      } else if (distance_of(surface, x, PairKind::kPointTriangle, i, t) < kReach) {
        EXPECT_TRUE(has(found.vertex_faces, i, t)) << i << " " << t;
      }
    }
  }
  for (Index e = 0; e < Index(surface.edges.size()); ++e) {
    for (Index f = e + 1; f < Index(surface.edges.size()); ++f) {
      if (body(surface.edges[std::size_t(e)][0]) == body(surface.edges[std::size_t(f)][0]))
        continue;
      if (distance_of(surface, x, PairKind::kEdgeEdge, e, f) < kReach) {
        EXPECT_TRUE(has(found.edge_edges, e, f)) << e << " " << f;
      }
    }
  }
}

TEST(NearFeatures, FindsAllThatIsNearWhateverItHasKept) {
  const Cubes cubes(3);
  const NearFeatures kept(cubes.surface, cubes.body_of, false, kReach);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Vector x = cubes.surface.rest;
  for (int step = 0; step < 40; ++step) {
    const Vector from = x;
    for (double& each : x) each += 0.004 * uniform(random);
    if (step % 8 == 7) x.array() += 100.0;  // all of them together
    for (const auto& [a, b] : {std::pair{x, x}, std::pair{from, x}}) {
      const NearFeatures fresh(cubes.surface, cubes.body_of, false, kReach);
      const NearFeatures::Found found = kept.on_way(a, b, kReach);
      const NearFeatures::Found expected = fresh.on_way(a, b, kReach);
      EXPECT_EQ(found.vertex_faces, expected.vertex_faces);
      EXPECT_EQ(found.edge_edges, expected.edge_edges);
      EXPECT_EQ(kept.edge_faces(x), fresh.edge_faces(x));
      if (step % 4 == 0) expect_all_near(cubes, found, b);
    }
  }
}

TEST(NearFeatures, ACommonMotionBringsNothingNearer) {
  const Cubes cubes(20);
  const NearFeatures near(cubes.surface, cubes.body_of, false, kReach);
  const Vector& rest = cubes.surface.rest;
  const Vector far = rest.array() + 1e6;
  const auto at_rest = near.on_way(rest, rest, kReach);
  const auto on_way = near.on_way(rest, far, kReach);
  EXPECT_GT(at_rest.vertex_faces.size(), 100u);
  EXPECT_EQ(on_way.vertex_faces, at_rest.vertex_faces);
  EXPECT_EQ(on_way.edge_edges, at_rest.edge_edges);
}

TEST(NearFeatures, PositionsThatAreNotFiniteAreNearNothing) {
  const Cubes cubes(2);
  const NearFeatures near(cubes.surface, cubes.body_of, false, kReach);
  Vector x = cubes.surface.rest;
  x[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(near.on_way(cubes.surface.rest, x, kReach).vertex_faces.empty());
  EXPECT_TRUE(near.edge_faces(x).empty());
}

}  // namespace
}  // namespace tetraction
