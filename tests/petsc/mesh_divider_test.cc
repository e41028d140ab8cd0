// Parts of a mesh: together they are the mesh, and neighbours agree on what they share.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "petsc/mesh_distribution.h"
#include "tetraction/mesh/generate.h"

namespace tetraction::petsc {
namespace {

// A box whose tetrahedra are dealt out in slabs along x, with a group of each dimension.
struct Divided {
  explicit Divided(int count) : parts(count) {
    mesh = generate_box({3.0, 1.0, 1.0}, {6, 2, 2});
    mesh.vertex_ids.clear();
    mesh.tetrahedron_ids.clear();
    mesh.regions.clear();
    for (Index v = 0; v < mesh.vertex_count(); ++v) mesh.vertex_ids.push_back(1000 + 3 * v);
    Group volume{"volume", 3, 1, {}, {}};
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      mesh.tetrahedron_ids.push_back(50 + e);
      mesh.regions.push_back(static_cast<int>(e % 3));
      double x = 0.0;
      for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
        x += 0.25 * mesh.vertices[static_cast<std::size_t>(v)].x();
      }
      part_of.push_back(std::min(count - 1, static_cast<int>(x / 3.0 * count)));
      if (e % 2 == 0) volume.tetrahedra.push_back(e);
    }
    Group surface{"surface", 2, 2, {}, {}};
    for (const auto& face : boundary_faces(mesh)) {
      surface.triangles.push_back(face);
      surface.vertices.insert(surface.vertices.end(), face.begin(), face.end());
    }
    std::sort(surface.vertices.begin(), surface.vertices.end());
    surface.vertices.erase(std::unique(surface.vertices.begin(), surface.vertices.end()),
                           surface.vertices.end());
    mesh.groups = {volume, surface};
    mesh.point_arrays["number"] = Matrix(1, mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      mesh.point_arrays["number"](0, v) = static_cast<double>(mesh.vertex_id(v));
    }
    const MeshDivider divider(mesh, part_of, count);
    for (int p = 0; p < count; ++p) data.push_back(divider.part(p));
  }

  int parts;
  TetMesh mesh;
  std::vector<int> part_of;
  std::vector<PartData> data;
};

std::array<std::int64_t, 3> ids_of(const TetMesh& mesh, const std::array<Index, 3>& face) {
  std::array<std::int64_t, 3> ids{mesh.vertex_id(face[0]), mesh.vertex_id(face[1]),
                                  mesh.vertex_id(face[2])};
  // The first one rotates; the sense stays.
  std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  return ids;
}

class MeshDivision : public testing::TestWithParam<int> {};

TEST_P(MeshDivision, PartsHaveEveryTetrahedronOnce) {
  const Divided divided(GetParam());
  std::map<std::int64_t, std::set<std::int64_t>> corners;
  for (const PartData& part : divided.data) {
    for (Index e = 0; e < part.mesh.tetrahedron_count(); ++e) {
      std::set<std::int64_t>& own = corners[part.mesh.tetrahedron_id(e)];
      EXPECT_TRUE(own.empty()) << "twice";
      for (const Index v : part.mesh.tetrahedra[static_cast<std::size_t>(e)]) {
        own.insert(part.mesh.vertex_id(v));
      }
      EXPECT_EQ(part.mesh.region(e), static_cast<int>((part.mesh.tetrahedron_id(e) - 50) % 3));
      EXPECT_GT(part.mesh.volume(e), 0.0);
    }
  }
  ASSERT_EQ(static_cast<Index>(corners.size()), divided.mesh.tetrahedron_count());
  for (Index e = 0; e < divided.mesh.tetrahedron_count(); ++e) {
    std::set<std::int64_t> expected;
    for (const Index v : divided.mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      expected.insert(divided.mesh.vertex_id(v));
    }
    EXPECT_EQ(corners[divided.mesh.tetrahedron_id(e)], expected);
  }
}

TEST_P(MeshDivision, EveryVertexHasOneOwnerAndTheSamePositionEverywhere) {
  const Divided divided(GetParam());
  std::map<std::int64_t, Index> index_of;
  for (Index v = 0; v < divided.mesh.vertex_count(); ++v) index_of[divided.mesh.vertex_id(v)] = v;
  std::set<std::int64_t> owned;
  for (const PartData& part : divided.data) {
    for (Index v = 0; v < part.mesh.vertex_count(); ++v) {
      const auto index = static_cast<std::size_t>(index_of.at(part.mesh.vertex_id(v)));
      EXPECT_EQ(Vector3(part.mesh.vertices[static_cast<std::size_t>(v)]),
                Vector3(divided.mesh.vertices[index]));
      EXPECT_EQ(part.mesh.point_arrays.at("number")(0, v),
                static_cast<double>(part.mesh.vertex_id(v)));
      if (v >= part.owned_vertices) continue;
      EXPECT_TRUE(owned.insert(part.mesh.vertex_id(v)).second);
    }
  }
  EXPECT_EQ(static_cast<Index>(owned.size()), divided.mesh.vertex_count());
}

TEST_P(MeshDivision, NeighboursListTheSameVerticesInTheSameOrder) {
  const Divided divided(GetParam());
  for (int p = 0; p < divided.parts; ++p) {
    const PartData& part = divided.data[static_cast<std::size_t>(p)];
    for (const Neighbor& neighbor : part.neighbors) {
      const PartData& other = divided.data[static_cast<std::size_t>(neighbor.rank)];
      const auto back = std::find_if(other.neighbors.begin(), other.neighbors.end(),
                                     [&](const Neighbor& n) { return n.rank == p; });
      ASSERT_NE(back, other.neighbors.end());
      ASSERT_EQ(back->shared.size(), neighbor.shared.size());
      EXPECT_FALSE(neighbor.shared.empty());
      for (std::size_t i = 0; i < neighbor.shared.size(); ++i) {
        EXPECT_EQ(part.mesh.vertex_id(neighbor.shared[i]), other.mesh.vertex_id(back->shared[i]));
      }
    }
  }
}

TEST_P(MeshDivision, TheBoundaryIsThatOfTheWholeMesh) {
  const Divided divided(GetParam());
  std::set<std::array<std::int64_t, 3>> expected;
  std::set<std::int64_t> on_boundary;
  for (const auto& face : boundary_faces(divided.mesh)) {
    expected.insert(ids_of(divided.mesh, face));
    for (const Index v : face) on_boundary.insert(divided.mesh.vertex_id(v));
  }
  std::set<std::array<std::int64_t, 3>> found;
  std::size_t triangles = 0;
  for (const PartData& part : divided.data) {
    for (const auto& face : part.boundary_faces) {
      EXPECT_TRUE(found.insert(ids_of(part.mesh, face)).second);
    }
    std::set<std::int64_t> own;
    for (Index v = 0; v < part.mesh.vertex_count(); ++v) {
      if (on_boundary.contains(part.mesh.vertex_id(v))) own.insert(part.mesh.vertex_id(v));
    }
    std::set<std::int64_t> listed;
    for (const Index v : part.boundary_vertices) listed.insert(part.mesh.vertex_id(v));
    EXPECT_EQ(listed, own);
    triangles += part.mesh.groups[1].triangles.size();
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(triangles, expected.size()) << "triangles of groups";
}

TEST_P(MeshDivision, GroupsAndTheWholeAreKnownInAllParts) {
  const Divided divided(GetParam());
  std::size_t tetrahedra = 0;
  for (const PartData& part : divided.data) {
    ASSERT_EQ(part.mesh.groups.size(), 2U);
    tetrahedra += part.mesh.groups[0].tetrahedra.size();
    EXPECT_EQ(part.whole.vertices, divided.mesh.vertex_count());
    EXPECT_EQ(part.whole.tetrahedra, divided.mesh.tetrahedron_count());
    EXPECT_NEAR(part.whole.volume, 3.0, 1e-14);
    EXPECT_EQ(part.whole.high, Vector3(3.0, 1.0, 1.0));
    EXPECT_EQ(part.whole.vertex_ids.first, 1000);
    EXPECT_EQ(part.whole.vertex_ids.second, 1000 + 3 * (divided.mesh.vertex_count() - 1));
  }
  EXPECT_EQ(tetrahedra, divided.mesh.groups[0].tetrahedra.size());
}

INSTANTIATE_TEST_SUITE_P(Parts, MeshDivision, testing::Values(1, 2, 3, 5));

}  // namespace
}  // namespace tetraction::petsc
