// The readers of Gmsh, TetGen and Vega files (VTK's are in vtk_reader_test.cc).
#include "tetraction/io/mesh_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::string shipped(const std::string& name) {
  return TETRACTION_TEST_DATA "/meshes/" + name;
}

std::string read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// A folder of its own for each test case.
std::string scratch(const std::string& name) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder = std::filesystem::path(testing::TempDir()) / "tetraction_mesh_reader" /
                      test->test_suite_name() / test->name();
  std::filesystem::create_directories(folder);
  return (folder / name).string();
}

std::string written(const std::string& name, const std::string& text) {
  const std::string path = scratch(name);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string refusal(const std::string& path) {
  try {
    read_mesh(path);
  } catch (const FileError& error) {
    return error.what();
  }
  return "accepted";
}

using IdTetrahedron = std::array<std::int64_t, 4>;

// Tetrahedra as sorted vertex ids, sorted: the same for the same mesh in another order.
std::vector<IdTetrahedron> canonical(const TetMesh& mesh) {
  std::vector<IdTetrahedron> result;
  for (const auto& t : mesh.tetrahedra) {
    IdTetrahedron ids{};
    for (std::size_t a = 0; a < 4; ++a) ids[a] = mesh.vertex_ids[static_cast<std::size_t>(t[a])];
    std::sort(ids.begin(), ids.end());
    result.push_back(ids);
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::map<std::int64_t, Vector3> by_id(const TetMesh& mesh) {
  std::map<std::int64_t, Vector3> result;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    result[mesh.vertex_ids[v]] = mesh.vertices[v];
  }
  return result;
}

void expect_same(const TetMesh& a, const TetMesh& b) {
  EXPECT_EQ(canonical(a), canonical(b));
  EXPECT_EQ(by_id(a), by_id(b));
  std::map<int, int> regions_a;
  std::map<int, int> regions_b;
  for (const int r : a.regions) ++regions_a[r];
  for (const int r : b.regions) ++regions_b[r];
  EXPECT_EQ(regions_a, regions_b);
}

TEST(GmshReader, OneMeshInThreeFormats) {
  const TetMesh v22 = read_mesh(shipped("22_ascii.msh"));
  EXPECT_EQ(v22.vertex_count(), 8);
  EXPECT_EQ(v22.tetrahedron_count(), 5);
  expect_same(v22, read_mesh(shipped("41_ascii.msh")));
  expect_same(v22, read_mesh(shipped("41_binary.msh")));
}

TEST(GmshReader, LargerPair) {
  const TetMesh v22 = read_mesh(shipped("cubes_v22.msh"));
  EXPECT_EQ(v22.vertex_count(), 7714);
  EXPECT_EQ(v22.tetrahedron_count(), 32981);
  const TetMesh v41 = read_mesh(shipped("cubes_v41.msh"));
  EXPECT_EQ(v41.tetrahedron_count(), 32981);
  EXPECT_NEAR(v22.total_volume(), v41.total_volume(), 1e-12);
  std::map<int, int> regions22;
  std::map<int, int> regions41;
  for (const int r : v22.regions) ++regions22[r];
  for (const int r : v41.regions) ++regions41[r];
  EXPECT_EQ(regions22, regions41);
  EXPECT_EQ(regions22.size(), 3U);
}

TEST(GmshReader, CountsAndVolumes) {
  const TetMesh bar = read_mesh(shipped("bar-14114.msh"));
  EXPECT_EQ(bar.vertex_count(), 3842);
  EXPECT_EQ(bar.tetrahedron_count(), 14114);
  EXPECT_NEAR(bar.total_volume(), 5.0, 1e-12);
  const TetMesh rod = read_mesh(shipped("rod300x33.msh"));
  EXPECT_EQ(rod.vertex_count(), 13333);
  EXPECT_EQ(rod.tetrahedron_count(), 50511);
}

TEST(GmshReader, NamedPhysicalGroupsOfAShippedPart) {
  const TetMesh spring = read_mesh(TETRACTION_DATA "/serpentine_spring.msh");
  std::map<std::string, int> dimension;
  for (const Group& group : spring.groups) {
    dimension[group.name] = group.dimension;
    EXPECT_FALSE(group.vertices.empty());
  }
  EXPECT_EQ(dimension, (std::map<std::string, int>{{"body", 3}, {"clamp", 2}, {"tip", 2}}));
  EXPECT_GT(spring.report.skipped_cells.at(CellType::kTriangle), 0);
}

TEST(GmshReader, QuadraticTetrahedraAreRefusedForNow) {
  EXPECT_NE(refusal(shipped("sphere_p2.msh")).find("quadratic"), std::string::npos);
}

TEST(GmshReader, BinaryOfEitherByteOrder) {
  // Format 2.2, big-endian: one tetrahedron.
  std::string text = "$MeshFormat\n2.2 1 8\n";
  const auto put = [&text](auto value) {
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    text.append(std::reverse_iterator(bytes + sizeof(value)), std::reverse_iterator(bytes));
  };
  put(std::int32_t{1});
  text += "\n$EndMeshFormat\n$Nodes\n4\n";
  const double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 3}};
  for (std::int32_t i = 0; i < 4; ++i) {
    put(i + 1);
    for (const double c : x[i]) put(c);
  }
  text += "\n$EndNodes\n$Elements\n1\n";
  for (const std::int32_t value : {4, 1, 2, 9, 6, 6, 1, 2, 3, 4}) put(value);
  text += "\n$EndElements\n";
  const TetMesh mesh = read_mesh(written("big.msh", text));
  EXPECT_NEAR(mesh.total_volume(), 0.5, 1e-15);
  EXPECT_EQ(mesh.regions, std::vector<int>{6});
  EXPECT_EQ(mesh.tetrahedron_ids, std::vector<std::int64_t>{9});
}

TEST(GmshReader, SaysWhatIsWrongAndWhere) {
  const std::string good = read_all(shipped("41_ascii.msh"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return refusal(written("changed.msh", text));
  };
  EXPECT_NE(changed("4.1 0 8", "4.0 0 8").find("MSH format 4"), std::string::npos);
  EXPECT_NE(changed("3 8 1 8", "3 9 1 8").find("announces 9 nodes and holds 8"), std::string::npos);
  EXPECT_NE(changed("3 8 1 8", "3 99999999999 1 8").find("cannot hold"), std::string::npos);
  EXPECT_NE(changed("1 2 1 5 7", "1 2 1 5 77").find("element 1 refers to vertex 77"),
            std::string::npos);
  EXPECT_NE(changed("-1.5", "x1.5").find("changed.msh:14: "), std::string::npos);
  EXPECT_NE(changed("-1.5000000000000000e+00", "nan").find("not finite"), std::string::npos);
  EXPECT_NE(changed("$MeshFormat", "$MeshFromat").find("not a Gmsh mesh"), std::string::npos);
}

TEST(VegaReader, ShippedMeshes) {
  const TetMesh turtle = read_mesh(shipped("turtle.veg"));
  EXPECT_EQ(turtle.vertex_count(), 347);
  EXPECT_EQ(turtle.tetrahedron_count(), 1185);
  EXPECT_EQ(turtle.vertex_ids.front(), 1);
  const TetMesh beam = read_mesh(shipped("beam3_tet.veg"));
  EXPECT_EQ(beam.vertex_count(), 208);
  EXPECT_EQ(beam.tetrahedron_count(), 450);
  EXPECT_NEAR(beam.total_volume(), 0.0048, 1e-12);
}

constexpr const char* kNodes =
    "# points\n5 3 1 1\n0 0 0 0 7.5 1\n1 1 0 0 7.5 1 # corner\n"
    "2 0 1 0 7.5 0\n3 0 0 1 7.5 0\n4 1 1 1 7.5 0\n";
constexpr const char* kElements = "2 4 1\n0 0 1 2 3 5\n1 1 2 3 4 6\n";

TEST(TetgenReader, EitherFileOfThePair) {
  const std::string node = written("pair.node", kNodes);
  const std::string ele = written("pair.ele", kElements);
  for (const std::string& path : {node, ele}) {
    const TetMesh mesh = read_mesh(path);
    EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
    EXPECT_EQ(mesh.regions, (std::vector<int>{5, 6}));
    EXPECT_NEAR(mesh.total_volume(), 0.5, 1e-15);
  }
}

TEST(TetgenReader, SaysWhatIsMissing) {
  const std::string alone = written("alone.node", kNodes);
  EXPECT_NE(refusal(alone).find("alone.ele: no such file"), std::string::npos);
  const std::string node = written("short.node", kNodes);
  written("short.ele", "2 4 1\n0 0 1 2 3 5\n1 1 2 3\n");
  EXPECT_NE(refusal(node).find("truncated"), std::string::npos);
}

TEST(MeshReader, RefusesUnknownEndingsAndMissingFiles) {
  EXPECT_NE(refusal(shipped("SOURCES.md")).find("\".md\""), std::string::npos);
  EXPECT_NE(refusal("/nowhere/mesh.msh").find("no such file"), std::string::npos);
  EXPECT_NE(refusal(TETRACTION_TEST_DATA "/meshes").find("ending"), std::string::npos);
}

class BrokenFiles : public testing::TestWithParam<const char*> {};

// Every cut of the file is refused, except at its very end.
TEST_P(BrokenFiles, TruncatedAtEveryPlace) {
  const std::string good = read_all(shipped(GetParam()));
  const std::size_t step = std::max<std::size_t>(1, good.size() / 400);
  const std::size_t end = good.find_last_not_of("\r\n") + 1;
  int refused = 0;
  for (std::size_t size = 0; size + 12 < end; size += step) {
    const std::string path = written(std::string("cut-") + GetParam(), good.substr(0, size));
    try {
      const TetMesh mesh = read_mesh(path);
      // A Vega file may end after its elements: the mesh is then whole.
      EXPECT_NE(std::string(GetParam()).find(".veg"), std::string::npos) << "cut at " << size;
      EXPECT_EQ(mesh.tetrahedron_count(), read_mesh(shipped(GetParam())).tetrahedron_count());
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

// Changed bytes give a mesh or a FileError, nothing else.
TEST_P(BrokenFiles, RandomBytesChanged) {
  const std::string good = read_all(shipped(GetParam()));
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> place(0, good.size() - 1);
  std::uniform_int_distribution<int> byte(0, 255);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 4; ++k) text[place(random)] = static_cast<char>(byte(random));
    const std::string path = written(std::string("changed-") + GetParam(), text);
    try {
      const TetMesh mesh = read_mesh(path);
      EXPECT_GT(mesh.total_volume(), 0.0);
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

INSTANTIATE_TEST_SUITE_P(Formats, BrokenFiles,
                         testing::Values("22_ascii.msh", "41_ascii.msh", "41_binary.msh",
                                         "beam3_tet.veg"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); },
                               '_');
                           return name;
                         });

}  // namespace
}  // namespace tetraction
