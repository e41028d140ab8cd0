// The readers of Gmsh, TetGen and Vega files (VTK's are in vtk_reader_test.cc).
#include "tetraction/io/mesh_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include "support/folder_test.h"
#include "support/messages.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {
namespace {

using namespace testing_support;

std::string shipped(const std::string& name) {
  return TETRACTION_TEST_DATA "/meshes/" + name;
}

// A file in a folder of this run.
std::string scratch(const std::string& name) {
  static const testing_support::TemporaryFolder temporary;
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder = temporary.path() / test->test_suite_name() / test->name();
  std::filesystem::create_directories(folder);
  return (folder / name).string();
}

std::string written(const std::string& name, const std::string& text) {
  const std::string path = scratch(name);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string refusal(const std::string& path) {
  return message_of<FileError>([&] { read_mesh(path); });
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
  // The two files number the vertices differently, but list them in the same order.
  EXPECT_EQ(v22.vertices, v41.vertices);
  EXPECT_EQ(v22.tetrahedra, v41.tetrahedra);
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
  EXPECT_TRUE(spring.report.skipped_cells.empty());
}

// The groups of the shipped part have the triangles of the file, with outward normals.
TEST(GmshReader, GroupsOfTrianglesInAllVersions) {
  const TetMesh spring = read_mesh(TETRACTION_DATA "/serpentine_spring.msh");
  std::size_t triangles = 0;
  for (const Group& group : spring.groups) {
    EXPECT_EQ(group.triangles.empty(), group.dimension != 2) << group.name;
    EXPECT_TRUE(group.detached_triangles.empty());
    triangles += group.triangles.size();
  }
  EXPECT_EQ(triangles, 96U);
  const auto boundary = boundary_faces(spring);
  for (const auto& triangle : select_triangles(spring, SelectGroup{"tip"})) {
    EXPECT_EQ(std::count(boundary.begin(), boundary.end(), triangle), 1);
  }

  const std::string body = "$Elements\n2\n1 2 2 7 1 1 2 3\n2 4 2 1 1 1 2 3 4\n$EndElements\n";
  const std::string nodes = "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  const std::vector<std::string> files{
      "$NOD\n" + nodes + "$ENDNOD\n$ELM\n2\n1 2 7 1 3 1 2 3\n2 4 1 1 4 1 2 3 4\n$ENDELM\n",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "$EndNodes\n" + body};
  for (const std::string& file : files) {
    const TetMesh mesh = read_mesh(written("triangles.msh", file));
    EXPECT_EQ(select_triangles(mesh, SelectGroup{"7"}),
              (std::vector<std::array<Index, 3>>{{0, 2, 1}}))
        << file;
  }
}

// The mesh of 22_ascii.msh, with another version in the header.
std::string with_header(const std::string& version) {
  std::string text = contents(shipped("22_ascii.msh"));
  const std::string header = "2.2 0 8";
  text.replace(text.find(header), header.size(), version + " 0 8");
  return text;
}

TEST(GmshReader, HeadersOfVersionTwo) {
  const TetMesh v22 = read_mesh(shipped("22_ascii.msh"));
  for (const char* version : {"2", "2.0", "2.1", "2.2"}) {
    expect_same(v22, read_mesh(written("two.msh", with_header(version))));
  }
}

TEST(GmshReader, OtherVersionsAreNamed) {
  const std::string four = refusal(written("four.msh", with_header("4")));
  EXPECT_NE(four.find("MSH format 4.0,"), std::string::npos) << four;
  EXPECT_NE(four.find("msh41"), std::string::npos) << four;
  expect_part(refusal(written("three.msh", with_header("3"))), "MSH format 3.0,");
  expect_part(refusal(written("much.msh", with_header("1e300"))), "MSH format 1e+300,");
}

TEST(GmshReader, PhysicalNamesOfVersionTwoPointZeroHaveNoDimension) {
  const TetMesh mesh = read_mesh(
      written("names.msh",
              "$MeshFormat\n2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n7 \"left face\"\n9 \"core\"\n"
              "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
              "$Elements\n2\n1 2 2 7 1 1 2 3\n2 4 2 9 1 1 2 3 4\n$EndElements\n"));
  ASSERT_EQ(mesh.groups.size(), 2U);
  EXPECT_EQ(mesh.groups[0].name, "left face");
  EXPECT_EQ(mesh.groups[0].dimension, 2);
  EXPECT_EQ(mesh.groups[1].name, "core");
  EXPECT_EQ(mesh.groups[1].dimension, 3);
}

constexpr const char* kVersionOne =
    "$NOD\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n9 1 1 1\n$ENDNOD\n"
    "$ELM\n3\n1 2 7 1 3 1 2 3\n2 4 5 1 4 1 2 3 4\n3 4 0 1 4 2 3 4 9\n$ENDELM\n";

TEST(GmshReader, VersionOne) {
  const TetMesh mesh = read_mesh(written("one.msh", kVersionOne));
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{1, 2, 3, 4, 9}));
  EXPECT_EQ(mesh.tetrahedron_ids, (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ(mesh.regions, (std::vector<int>{5, 0}));
  EXPECT_NEAR(mesh.total_volume(), 0.5, 1e-15);
  ASSERT_EQ(mesh.groups.size(), 2U);
  EXPECT_EQ(mesh.groups[0].name, "7");
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(mesh.groups[1].tetrahedra, std::vector<Index>{0});

  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = kVersionOne;
    text.replace(text.find(from), from.size(), to);
    return refusal(written("wrong.msh", text));
  };
  expect_part(changed("4 5 1 4 1", "4 5 1 3 1"), "wrong.msh:12: in $ELM: element 2 of type 4 has");
  EXPECT_NE(changed("4 5 1 4", "4 5000000000 1 4").find("not a physical tag"), std::string::npos);
  EXPECT_NE(changed("$ENDNOD", "7").find("\"7\" where $ENDNOD"), std::string::npos);
  const std::string text = kVersionOne;
  for (std::size_t size = 0; size + 1 < text.size(); ++size) {
    EXPECT_NE(refusal(written("cut.msh", text.substr(0, size))), "accepted") << size;
  }
}

TEST(GmshReader, CommentsBeforeTheHeader) {
  const std::string text = "$Comments\nmade by hand: $MeshFormat\n$EndComments\n";
  expect_same(read_mesh(shipped("22_ascii.msh")),
              read_mesh(written("comments.msh", text + with_header("2.2"))));
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
  const std::string good = contents(shipped("41_ascii.msh"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return refusal(written("changed.msh", text));
  };
  EXPECT_NE(changed("4.1 0 8", "4.0 0 8").find("MSH format 4"), std::string::npos);
  EXPECT_NE(changed("3 8 1 8", "3 9 1 8").find("announces 9 nodes and holds 8"), std::string::npos);
  EXPECT_NE(changed("3 8 1 8", "3 99999999999 1 8").find("cannot hold"), std::string::npos);
  expect_part(changed("1 2 1 5 7", "1 2 1 5 77"), "element 1 refers to vertex 77");
  EXPECT_NE(changed("-1.5", "x1.5").find("changed.msh:14: "), std::string::npos);
  EXPECT_NE(changed("-1.5000000000000000e+00", "nan").find("not finite"), std::string::npos);
  EXPECT_NE(changed("$MeshFormat", "$MeshFromat").find("not a Gmsh mesh"), std::string::npos);
}

// Format 4.1 with what the shipped meshes lack: node tags with gaps and out of order, in two blocks,
// one with parameters; a triangle and two bodies; sections that mean nothing here.
constexpr const char* kBlocks =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n2\n2 5 \"the \"\"face\"\n3 9 \"core\"\n$EndPhysicalNames\n"
    "$Entities\n1 0 1 2\n7 0 0 0 0\n2 0 0 0 1 1 0 1 -5 0\n"
    "1 0 0 0 1 1 1 2 4 9 1 2\n3 0 0 0 1 1 1 0 0\n$EndEntities\n"
    "$Nodes\n2 5 3 90\n2 2 1 3\n40\n3\n90\n0 0 0 0.5 0.5\n1 0 0 1 0\n0 1 0 0 1\n"
    "3 1 0 2\n12\n8\n0 0 1\n1 1 1\n$EndNodes\n"
    "$Periodic\n0\n$EndPeriodic\n"
    "$Elements\n3 3 1 6\n2 2 2 1\n6 40 3 90\n3 1 4 1\n1 40 3 90 12\n3 3 4 1\n"
    "5 3 90 12 8\n$EndElements\n$Comments\nends here\n$EndComments\n";

TEST(GmshReader, BlocksTagsGroupsAndForeignSections) {
  const TetMesh mesh = read_mesh(written("blocks.msh", kBlocks));
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{40, 3, 90, 12, 8}));
  EXPECT_EQ(mesh.vertices[2], Vector3(0, 1, 0));
  EXPECT_EQ(mesh.tetrahedron_ids, (std::vector<std::int64_t>{1, 5}));
  EXPECT_NEAR(mesh.total_volume(), 0.5, 1e-15);
  EXPECT_EQ(mesh.regions, (std::vector<int>{9, 0}));
  ASSERT_EQ(mesh.groups.size(), 3U);
  // The face belongs to its group with the orientation turned round: tag -5.
  EXPECT_EQ(mesh.groups[0].name, "the \"\"face");
  EXPECT_EQ(mesh.groups[0].tag, 5);
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(mesh.groups[1].name, "4") << "a group without a name goes by its number";
  EXPECT_EQ(mesh.groups[2].name, "core");
  EXPECT_EQ(mesh.groups[2].tetrahedra, std::vector<Index>{0});
}

TEST(GmshReader, TakesOneSectionOfNodesAndOneOfElements) {
  const std::string format = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  const std::string nodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
  const std::string more_nodes = "$Nodes\n1\n5 1 1 1\n$EndNodes\n";
  const std::string elements = "$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
  const std::string more_elements = "$Elements\n1\n2 4 2 0 1 2 3 4 5\n$EndElements\n";
  EXPECT_EQ(refusal(written("one.msh", format + nodes + elements)), "accepted");
  expect_part(refusal(written("two.msh", format + nodes + more_nodes + elements)),
              "two.msh:11: in $Nodes: there is a second $Nodes section");
  expect_part(refusal(written("two.msh", format + nodes + elements + more_elements)),
              "there is a second $Elements section");
}

TEST(GmshReader, NamesTheSectionThatIsCutOff) {
  const std::string text = kBlocks;
  const auto cut_before = [&](const std::string& place) {
    return refusal(written("cut.msh", text.substr(0, text.find(place))));
  };
  EXPECT_NE(cut_before("3 9 \"core").find("cut.msh:7: in $PhysicalNames: "), std::string::npos);
  EXPECT_NE(cut_before(" -5 0").find("in $Entities: "), std::string::npos);
  expect_part(cut_before("1 0 0 1 0"), "cut.msh:23: in $Nodes: the file ends where a coordinate");
  EXPECT_NE(cut_before("90 12 8").find("in $Elements: "), std::string::npos);
  expect_part(cut_before("$EndComments"), "in $Comments: the section does not end");

  const std::string binary = contents(shipped("41_binary.msh"));
  const std::size_t size = binary.find("$EndNodes") - 20;
  const std::string found = refusal(written("cut.msh", binary.substr(0, size)));
  EXPECT_NE(found.find("in $Nodes: the file ends where a coordinate"), std::string::npos) << found;
  EXPECT_NE(found.find("cut.msh: byte "), std::string::npos) << found;
}

TEST(GmshReader, RefusesTagsOutOfRangeAndTooManyGroups) {
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = kBlocks;
    text.replace(text.find(from), from.size(), to);
    return refusal(written("tags.msh", text));
  };
  expect_part(changed("1 -5 0", "1 4294967301 0"), "4294967301 is not a physical tag");
  std::string many = "1 1 1 2000";
  for (int i = 0; i < 2000; ++i) many += " 4";
  EXPECT_NE(changed("1 1 1 2 4 9", many).find("2000 physical tags"), std::string::npos);
}

TEST(GmshReader, RefusesABinaryBlockOfMoreThanAnnounced) {
  std::string text = "$MeshFormat\n2.2 1 8\n";
  const auto put = [&text](auto value) {
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    text.append(bytes, sizeof(value));
  };
  put(std::int32_t{1});
  text += "\n$EndMeshFormat\n$Nodes\n4\n";
  for (std::int32_t i = 0; i < 4; ++i) {
    put(i + 1);
    for (std::int32_t c = 1; c < 4; ++c) put(i == c ? 1.0 : 0.0);
  }
  text += "\n$EndNodes\n$Elements\n1\n";
  for (const std::int32_t value : {4, 2, 0, 1, 1, 2, 3, 4, 2, 1, 2, 3, 4}) put(value);
  text += "\n$EndElements\n";
  expect_part(refusal(written("more.msh", text)), "announces 1 elements and holds more");
}

TEST(GmshReader, ReadsNumbersOfAnySizeThatDoublesHold) {
  std::string text = kBlocks;
  text.replace(text.find("0 0 1\n1 1 1"), 5, "4.9e-324 +1e-310 1.0E+00");
  EXPECT_NEAR(read_mesh(written("small.msh", text)).total_volume(), 0.5, 1e-15);
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

constexpr const char* kVega =
    "# a comment\n*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
    "*ELEMENTS\nTET\n2 4 1\n1 1 2 3 4 0.5\n2 2 3 4 5 0.5\n";

TEST(VegaReader, SetsBecomeGroupsAndRegionsCountFromOne) {
  const TetMesh mesh = read_mesh(written(
      "sets.veg", std::string(kVega) + "*SET low\n1,\n*SET high\n2\n*SET low\n 1\n"
                                       "*MATERIAL soft\nENU, 1000, 1000, 0.4\n"
                                       "*REGION\nallElements, soft\n*REGION\nhigh, soft\n"));
  EXPECT_EQ(mesh.regions, (std::vector<int>{1, 2}));
  ASSERT_EQ(mesh.groups.size(), 2U);
  EXPECT_EQ(mesh.groups[0].name, "low");
  EXPECT_EQ(mesh.groups[1].name, "high");
  EXPECT_EQ(mesh.groups[1].tetrahedra, std::vector<Index>{1});
  EXPECT_EQ(mesh.groups[1].vertices, (std::vector<Index>{1, 2, 3, 4}));
}

TEST(VegaReader, OfTwoRegionsOfOneSetTheLastCounts) {
  const TetMesh mesh = read_mesh(
      written("last.veg", std::string(kVega) + "*SET a\n1\n*REGION\na, m\n*REGION\nallElements, m\n"
                                               "*REGION\na, m\n"));
  EXPECT_EQ(mesh.regions, (std::vector<int>{3, 2}));
}

TEST(VegaReader, SaysWhatIsWrong) {
  const auto with = [](const std::string& more) {
    return refusal(written("wrong.veg", kVega + more));
  };
  EXPECT_NE(with("*INCLUDE other.veg\n").find("*INCLUDE is not read"), std::string::npos);
  EXPECT_NE(with("*SET a\n3\n").find("set \"a\" names element 3"), std::string::npos);
  EXPECT_NE(with("*SET a\nx\n").find("no number"), std::string::npos);
  expect_part(with("*SET a\n1\n*SET a\n1, 2\n"), "a second set \"a\" with other elements");
  expect_part(with("*REGION\nb, m\n*REGION\nallElements, m\n"), "names set \"b\"");
  EXPECT_NE(with("*REGION\nb\n").find("separated by a comma"), std::string::npos);
  EXPECT_NE(with("stray\n").find("wrong.veg:14: \"stray\""), std::string::npos);
  const std::string cube =
      "*VERTICES\n1 3 0 0\n1 0 0 0\n*ELEMENTS\nCUBIC\n1 8 0\n1 1 1 1 1 1 1 1 1\n";
  expect_part(refusal(written("cube.veg", cube)), "only 1 of type hexahedron");
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

TEST(TetgenReader, NumbersFromOneEndingsInCapitalsAndQuadraticElements) {
  const std::string nodes = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  const std::string node = written("ONE.NODE", nodes);
  written("ONE.ELE", "1 4 0\n1 1 2 3 4\n");
  const TetMesh mesh = read_mesh(node);
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{1, 2, 3, 4}));
  EXPECT_EQ(mesh.tetrahedron_ids, std::vector<std::int64_t>{1});
  EXPECT_EQ(mesh.regions, std::vector<int>{0});

  // The nodes in the middles of the edges 23, 01, 02, 03, 12 and 13, in an order of its own.
  const std::string ten =
      "10 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 .5 .5\n6 .5 0 0\n"
      "7 0 .5 0\n8 0 0 .5\n9 .5 .5 0\n10 .5 0 .5\n";
  const std::string quadratic = written("ten.node", ten);
  written("ten.ele", "1 10 0\n1 1 2 3 4 5 6 7 8 9 10\n");
  const TetMesh read = read_mesh(quadratic);
  ASSERT_TRUE(read.is_quadratic());
  EXPECT_EQ(read.edge_vertices[0], (std::array<Index, 6>{5, 8, 6, 7, 9, 4}));
  written("ten.ele", "1 10 0\n1 1 2 3 4 1 1 1 1 1 1\n");
  EXPECT_NE(refusal(quadratic).find("twice"), std::string::npos);
}

// The faces of each boundary marker but 0 are a group.
TEST(TetgenReader, BoundaryMarkersOfFacesAreGroups) {
  const std::string node = written("marked.node", kNodes);
  written("marked.ele", kElements);
  // As TetGen writes them with -nn: the tetrahedra on both sides at the end.
  written("marked.face",
          "4 1 # faces\n0 2 1 0 3 0 -1\n1 0 1 3 3 0 -1\n2 4 3 2 -7 1 -1\n3 1 2 3 0 0 1\n");
  const TetMesh mesh = read_mesh(node);
  ASSERT_EQ(mesh.groups.size(), 2U);
  EXPECT_EQ(mesh.groups[0].name, "3");
  EXPECT_EQ(mesh.groups[0].dimension, 2);
  EXPECT_EQ(mesh.groups[0].triangles.size(), 2U);
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.groups[1].name, "-7");
  EXPECT_EQ(select_triangles(mesh, SelectGroup{"-7"}).size(), 1U);

  written("marked.face", "1 0\n0 0 1 2\n");
  EXPECT_TRUE(read_mesh(node).groups.empty());
  written("marked.face", "2 1\n0 0 1 2 3\n1 0 1 9 3\n");
  EXPECT_NE(refusal(node).find("marked.face:3: face 1 refers to point 9"), std::string::npos);
  written("marked.face", "2 1\n0 0 1 2 3\n1 0 3 3 3\n");
  EXPECT_NE(refusal(node).find("marked.face:3: face 1 has a point twice"), std::string::npos);
  for (const std::string marker : {"2147483648", "-2147483649", "4294967297"}) {
    written("marked.face", "1 1\n0 0 1 2 " + marker + "\n");
    expect_part(refusal(node), "marked.face:2: " + marker + " is not a boundary marker");
  }
  written("marked.face", "2 1\n0 0 1 2 3\n");
  EXPECT_NE(refusal(node).find("truncated"), std::string::npos);
}

TEST(TetgenReader, SaysWhatIsWrongAndWhere) {
  const auto with = [](const std::string& elements) {
    const std::string node = written("wrong.node", kNodes);
    written("wrong.ele", elements);
    return refusal(node);
  };
  expect_part(with("1 4 1\n0 0 1 2 3 0.5\n"), "0.5 of element 0 is not an integer");
  EXPECT_NE(with("1 4 0\n0 0 1 2 9\n").find("element 0 refers to vertex 9"), std::string::npos);
  EXPECT_NE(with("1 5 0\n0 0 1 2 3 4\n").find("neither 4 nor 10"), std::string::npos);
  expect_part(with("# no count\n-1 4 0\n"), "wrong.ele:2: the number of tetrahedra is -1");
  EXPECT_NE(with("999999999999 4 0\n").find("cannot hold"), std::string::npos);
  expect_part(with("1 4 0\n0 0 1 2 3\n1 1 2 3 4\n"), "wrong.ele:3: there is more");
}

// Changed bytes and cuts of either file give a mesh or a FileError, nothing else.
TEST(TetgenReader, BrokenPairs) {
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 800; ++i) {
    std::array<std::string, 2> text{kNodes, kElements};
    std::string& broken = text[static_cast<std::size_t>(i % 2)];
    std::uniform_int_distribution<std::size_t> place(0, broken.size() - 1);
    std::uniform_int_distribution<int> byte(0, 255);
    if (i % 8 == 0) broken.resize(place(random));
    for (int k = 0; k < 1 + i % 3 && !broken.empty(); ++k) {
      broken[place(random) % broken.size()] = static_cast<char>(byte(random));
    }
    const std::string node = written("broken.node", text[0]);
    written("broken.ele", text[1]);
    try {
      EXPECT_GT(read_mesh(node).total_volume(), 0.0);
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(MeshReader, RefusesUnknownEndingsAndMissingFiles) {
  // A name that cannot be that of a mesh is wrong input; the file plays no part.
  for (const auto& [name, part] : {std::pair{shipped("SOURCES.md"), "\".md\""},
                                   std::pair{std::string("/nowhere/mesh.stl"), "\".stl\""},
                                   std::pair{shipped(""), "ending"}}) {
    expect_error([&] { read_mesh(name); }, {part});
  }
  const std::string missing = refusal("/nowhere/mesh.msh");
  EXPECT_NE(missing.find("no such file"), std::string::npos);
  EXPECT_EQ(missing.find("scene"), std::string::npos) << missing;
  const std::string loop = scratch("loop.msh");
  std::filesystem::remove(loop);
  std::filesystem::create_symlink("loop.msh", loop);
  EXPECT_NE(refusal(loop).find("cannot be read"), std::string::npos) << refusal(loop);
  const std::string folder = scratch("folder.msh");
  std::filesystem::create_directories(folder);
  EXPECT_NE(refusal(folder).find("not a regular file"), std::string::npos);
}

class BrokenFiles : public testing::TestWithParam<const char*> {};

// Every cut of the file is refused, except at its very end.
TEST_P(BrokenFiles, TruncatedAtEveryPlace) {
  const std::string good = contents(shipped(GetParam()));
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
  const std::string good = contents(shipped(GetParam()));
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

TEST(TetgenReader, NumbersAndFacesThatAreGivenTwiceAreRefused) {
  const auto answer = [](const std::string& elements, const std::string& faces) {
    const std::string node = written("twice.node", kNodes);
    written("twice.ele", elements);
    written("twice.face", faces);
    return message_of<FileError>([&] { read_mesh(node); });
  };
  const std::string one = "1 4 0\n1 1 2 3 4\n";
  EXPECT_EQ(answer(one, "2 1\n1 1 2 3 5 1 -1\n2 1 2 4 6\n"), "accepted");
  expect_part(answer("2 4 1\n1 1 2 3 4 1\n1 1 2 3 4 2\n", "0 1\n"), "element 1 is defined twice");
  expect_part(answer(one, "2 1\n1 1 2 3 5\n1 1 2 4 6\n"), "face 1 is defined twice");
  expect_part(answer(one, "2 1\n1 1 2 3 5\n2 3 1 2 6\n"), "face 2 is there already with another");
  expect_part(answer(one, "1 1\n1 1 2 3 5 hello\n"), "\"hello\" after face 1 is not one of the");
}

TEST(VegaReader, ASetMayNotHideAllElements) {
  const std::string regions = "*SET b\n2\n*REGION\nallElements, m\n*REGION\nb, m\n";
  expect_part(refusal(written("all.veg", std::string(kVega) + "*SET allElements\n1\n" + regions)),
              "there is a set of that name with other elements");
  EXPECT_EQ(
      read_mesh(written("same.veg", std::string(kVega) + "*SET allElements\n1, 2\n" + regions))
          .regions,
      (std::vector<int>{1, 2}));
}

}  // namespace
}  // namespace tetraction
