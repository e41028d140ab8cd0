// Parts of a mesh: together they are the mesh, and neighbours agree on what they share.
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cstring>
#include <iterator>
#include <map>
#include <set>
#include <thread>

#include "petsc/part_data.h"
#include "tetraction/mesh/generate.h"

namespace tetraction::petsc {
namespace {

// Some processes that are threads of the test.
class ThreadProcesses {
 public:
  explicit ThreadProcesses(int count)
      : count_(count), barrier_(count), sent_(static_cast<std::size_t>(count)) {}

  class Process : public AllToAll {
   public:
    Process(ThreadProcesses& all, int rank) : all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int count() const override { return all_.count_; }

   private:
    std::vector<std::size_t> exchange_sizes(const std::vector<std::size_t>& sent) const override {
      std::vector<Block<const void*>> blocks;
      for (const std::size_t& size : sent) blocks.push_back({&size, sizeof size});
      std::vector<std::size_t> received(sent.size());
      std::vector<Block<void*>> places;
      for (std::size_t& size : received) places.push_back({&size, sizeof size});
      exchange_bytes(blocks, places);
      return received;
    }
    void exchange_bytes(const std::vector<Block<const void*>>& sent,
                        const std::vector<Block<void*>>& received) const override {
      std::vector<const void*>& own = all_.sent_[static_cast<std::size_t>(rank_)];
      own.clear();
      for (const auto& block : sent) own.push_back(block.data);
      all_.barrier_.arrive_and_wait();
      for (std::size_t p = 0; p < received.size(); ++p) {
        const void* from = all_.sent_[p][static_cast<std::size_t>(rank_)];
        if (received[p].size > 0) std::memcpy(received[p].data, from, received[p].size);
      }
      all_.barrier_.arrive_and_wait();
    }
    ThreadProcesses& all_;
    int rank_;
  };

  // work(process) in all of them.
  template <class Work>
  void run(const Work& work) {
    std::vector<std::thread> threads;
    for (int p = 0; p < count_; ++p) {
      threads.emplace_back([&, p] { work(Process(*this, p)); });
    }
    for (std::thread& thread : threads) thread.join();
  }

 private:
  int count_;
  std::barrier<> barrier_;
  std::vector<std::vector<const void*>> sent_;  // by every process to every other one
};

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
    Group edge{"edge", 1, 3, {}, {}};
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.vertices[static_cast<std::size_t>(v)].tail<2>().norm() == 0.0) {
        edge.vertices.push_back(v);
        if (edge.vertices.size() > 1) edge.lines.push_back({edge.vertices.end()[-2], v});
      }
    }
    mesh.groups = {volume, surface, edge};
    mesh.point_arrays["number"] = Matrix(1, mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      mesh.point_arrays["number"](0, v) = static_cast<double>(mesh.vertex_id(v));
    }
    data.resize(static_cast<std::size_t>(count));
    matches.resize(data.size());
    const MeshPart::Whole whole = whole_of(mesh);
    ThreadProcesses(count).run([&](const AllToAll& processes) {
      const int p = processes.rank();
      MeshChunk chunk = unpacked_chunk(packed(chunk_of(mesh, whole, p, count)));
      FaceMatches& faces = matches[static_cast<std::size_t>(p)];
      faces = match_faces(chunk, processes);
      const auto first = part_of.begin() + chunk.first_tetrahedron;
      const std::vector<int> part(first, first + chunk.mesh.tetrahedron_count());
      data[static_cast<std::size_t>(p)] = collect_part(std::move(chunk), part, faces, processes);
    });
  }

  int parts;
  TetMesh mesh;
  std::vector<int> part_of;
  std::vector<PartData> data;
  std::vector<FaceMatches> matches;
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

// Otherwise the groups of vertices of the coarse level would be scattered at the borders of parts.
TEST_P(MeshDivision, VerticesWithTheSameSharersHaveTheSameOwner) {
  const Divided divided(GetParam());
  std::map<std::set<int>, int> owners;
  for (int p = 0; p < divided.parts; ++p) {
    const PartData& part = divided.data[static_cast<std::size_t>(p)];
    std::map<Index, std::set<int>> sharers;
    for (const Neighbor& neighbor : part.neighbors) {
      for (const Index v : neighbor.shared) sharers[v].insert({p, neighbor.rank});
    }
    for (const auto& [v, all] : sharers) {
      if (v < part.owned_vertices) {
        EXPECT_EQ(owners.emplace(all, p).first->second, p);
      }
    }
  }
  EXPECT_EQ(owners.empty(), divided.parts == 1);
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
    ASSERT_EQ(part.mesh.groups.size(), 3U);
    for (const Index e : part.mesh.groups[0].tetrahedra) {
      EXPECT_EQ(part.mesh.tetrahedron_id(e) % 2, 0);
      ++tetrahedra;
    }
    // Every copy of a vertex of the edge x is in the group, and every line is where both ends are.
    std::vector<Index> on_edge;
    for (Index v = 0; v < part.mesh.vertex_count(); ++v) {
      if (part.mesh.vertices[static_cast<std::size_t>(v)].tail<2>().norm() == 0.0) {
        on_edge.push_back(v);
      }
    }
    EXPECT_EQ(part.mesh.groups[2].vertices, on_edge);
    EXPECT_EQ(part.mesh.groups[2].lines.size() + 1, on_edge.size());
    for (const auto& line : part.mesh.groups[2].lines) {
      const Vector3 along = part.mesh.vertices[static_cast<std::size_t>(line[1])] -
                            part.mesh.vertices[static_cast<std::size_t>(line[0])];
      EXPECT_NEAR(along.x(), 0.5, 1e-14);
    }
    EXPECT_EQ(part.whole.vertices, divided.mesh.vertex_count());
    EXPECT_EQ(part.whole.tetrahedra, divided.mesh.tetrahedron_count());
    EXPECT_NEAR(part.whole.volume, 3.0, 1e-14);
    EXPECT_EQ(part.whole.high, Vector3(3.0, 1.0, 1.0));
    EXPECT_EQ(part.whole.vertex_ids.first, 1000);
    EXPECT_EQ(part.whole.vertex_ids.second, 1000 + 3 * (divided.mesh.vertex_count() - 1));
  }
  EXPECT_EQ(tetrahedra, divided.mesh.groups[0].tetrahedra.size());
}

TEST_P(MeshDivision, TetrahedraKnowTheirNeighbours) {
  const Divided divided(GetParam());
  const auto corners = [&](Index e) {
    auto t = divided.mesh.tetrahedra[static_cast<std::size_t>(e)];
    std::sort(t.begin(), t.end());
    return t;
  };
  Index e = 0;
  std::size_t faces = 0;
  for (const FaceMatches& matches : divided.matches) {
    for (const auto& row : matches.neighbors) {
      std::vector<std::int32_t> expected;
      for (Index other = 0; other < divided.mesh.tetrahedron_count(); ++other) {
        std::vector<Index> common;
        const auto a = corners(e);
        const auto b = corners(other);
        std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
        if (common.size() == 3) expected.push_back(static_cast<std::int32_t>(other));
      }
      expected.resize(4, -1);
      EXPECT_TRUE(std::equal(row.begin(), row.end(), expected.begin())) << e;
      ++e;
    }
    faces += matches.boundary.size();
  }
  EXPECT_EQ(e, divided.mesh.tetrahedron_count());
  EXPECT_EQ(faces, boundary_faces(divided.mesh).size());
}

INSTANTIATE_TEST_SUITE_P(Parts, MeshDivision, testing::Values(1, 2, 3, 5));

}  // namespace
}  // namespace tetraction::petsc
