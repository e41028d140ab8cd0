#include "tetraction/io/mesh_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "support/folder_test.h"
#include "support/messages.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

class MeshWriter : public FolderTest, public testing::WithParamInterface<const char*> {};

// A block whose coordinates need all their digits.
TetMesh awkward_block() {
  TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 1});
  for (Vector3& x : mesh.vertices.own()) {
    x = Vector3(x.x() / 3.0 + 1e-17, std::sqrt(2.0) * x.y() + 1e5 / 7.0, -x.z() * 1e-9 / 3.0);
  }
  for (auto& t : mesh.tetrahedra.own()) std::swap(t[2], t[3]);  // the third axis was turned round
  return mesh;
}

void set_regions(TetMesh& mesh) {
  for (std::size_t e = 0; e < mesh.regions.size(); ++e)
    mesh.regions[e] = 1 + static_cast<int>(e % 3);
}

void expect_same_geometry(const TetMesh& read, const TetMesh& written) {
  ASSERT_EQ(read.vertices.size(), written.vertices.size());
  for (std::size_t v = 0; v < read.vertices.size(); ++v) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(read.vertices[v][c], written.vertices[v][c]) << "vertex " << v;
    }
  }
  EXPECT_EQ(read.report.reoriented, 0);
}

// Tetrahedra by their vertices; the order may change where a format sorts by region.
std::multiset<std::pair<std::array<Index, 4>, int>> elements_of(const TetMesh& mesh) {
  std::multiset<std::pair<std::array<Index, 4>, int>> result;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    result.insert({mesh.tetrahedra[e], mesh.regions[e]});
  }
  return result;
}

TEST_P(MeshWriter, RoundTripIsExact) {
  TetMesh mesh = awkward_block();
  set_regions(mesh);
  const std::string file = path(std::string("block") + GetParam());
  write_mesh(mesh, file);
  const TetMesh read = read_mesh(file);
  expect_same_geometry(read, mesh);
  EXPECT_EQ(elements_of(read), elements_of(mesh));
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".part") << "a temporary file was left";
  }
}

TEST_P(MeshWriter, RewritesAnExistingFile) {
  const std::string file = path(std::string("again") + GetParam());
  write_mesh(generate_box({1, 1, 1}, {3, 3, 3}), file);
  const TetMesh small = generate_tetrahedron();
  write_mesh(small, file);
  EXPECT_EQ(read_mesh(file).tetrahedron_count(), 1);
}

TEST_P(MeshWriter, ImpossiblePlaceIsAnOutputError) {
  const TetMesh mesh = generate_tetrahedron();
  const std::string blocker = path("a_file");
  std::ofstream(blocker) << "not a directory";
  for (const std::string& place :
       {blocker + "/m" + GetParam(), path("no_such_directory") + "/m" + GetParam()}) {
    expect_error<OutputError>([&] { write_mesh(mesh, place); }, {"/m."});
  }
  EXPECT_EQ(contents(blocker), "not a directory");
}

TEST_P(MeshWriter, OneRegionStaysZero) {
  const TetMesh mesh = generate_box({1, 2, 3}, {1, 1, 2});
  const std::string file = path(std::string("plain") + GetParam());
  write_mesh(mesh, file);
  const TetMesh read = read_mesh(file);
  for (const int region : read.regions) EXPECT_EQ(region, 0);
  EXPECT_TRUE(read.groups.empty());
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshWriter,
                         ::testing::Values(".vtu", ".vtk", ".msh", ".node", ".ele", ".veg",
                                           ".VTU"));

using MeshWriterDetails = MeshWriter;

TEST_F(MeshWriterDetails, VtkFormatsKeepIdsNegativeRegionsAndArrays) {
  TetMesh mesh = awkward_block();
  for (std::size_t v = 0; v < mesh.vertex_ids.size(); ++v) {
    mesh.vertex_ids[v] = (std::int64_t{1} << 60) + 7 * static_cast<std::int64_t>(v);
  }
  for (std::size_t e = 0; e < mesh.tetrahedron_ids.size(); ++e) {
    mesh.tetrahedron_ids[e] = 500 - static_cast<std::int64_t>(e);
    mesh.regions[e] = static_cast<int>(e) - 3;
  }
  Matrix displacement(3, mesh.vertex_count());
  Matrix weight(1, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const double s = static_cast<double>(v);
    displacement.col(v) << s / 3.0, -s / 7.0, 1e-300 * s;
    weight(0, v) = std::exp(s);
  }
  mesh.point_arrays["displacement"] = displacement;
  mesh.point_arrays["weight"] = weight;
  Matrix modulus(1, mesh.tetrahedron_count());
  for (Index e = 0; e < modulus.cols(); ++e) modulus(0, e) = 1e6 / (1.0 + static_cast<double>(e));
  mesh.cell_arrays["E"] = modulus;
  for (const char* name : {"own.vtu", "own.vtk"}) {
    write_mesh(mesh, path(name));
    const TetMesh read = read_mesh(path(name));
    expect_same_geometry(read, mesh);
    EXPECT_EQ(read.tetrahedra, mesh.tetrahedra);
    EXPECT_EQ(read.vertex_ids, mesh.vertex_ids);
    EXPECT_EQ(read.tetrahedron_ids, mesh.tetrahedron_ids);
    EXPECT_EQ(read.regions, mesh.regions);
    ASSERT_EQ(read.point_arrays.size(), 2u) << name;
    EXPECT_EQ(read.point_arrays.at("displacement"), displacement);
    EXPECT_EQ(read.point_arrays.at("weight"), weight);
    ASSERT_EQ(read.cell_arrays.size(), 1u) << name;
    EXPECT_EQ(read.cell_arrays.at("E"), modulus);
  }
}

TEST_F(MeshWriterDetails, GmshKeepsTagsAndNamesOfVolumes) {
  TetMesh mesh = generate_box({1, 1, 1}, {2, 1, 1});
  for (auto& id : mesh.vertex_ids) id = 3 * id + 5;
  for (auto& id : mesh.tetrahedron_ids) id = 2 * id + 11;
  set_regions(mesh);
  Group bone{"hard \"bone\"", 3, 2, {}, {}};
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    if (mesh.region(e) == 2) bone.tetrahedra.push_back(e);
  }
  Group skin{"skin", 2, 3, {0, 1, 2}, {}};
  mesh.groups = {bone, skin};
  EXPECT_EQ(write_mesh(mesh, path("tags.msh")).names_with_quotes,
            std::vector<std::string>{"hard \"bone\""});
  const TetMesh read = read_mesh(path("tags.msh"));
  EXPECT_EQ(read.vertex_ids, mesh.vertex_ids);
  ASSERT_EQ(read.tetrahedron_ids.size(), mesh.tetrahedron_ids.size());
  for (std::size_t e = 0; e < read.tetrahedra.size(); ++e) {
    const auto same = std::find(mesh.tetrahedron_ids.begin(), mesh.tetrahedron_ids.end(),
                                read.tetrahedron_ids[e]);
    ASSERT_NE(same, mesh.tetrahedron_ids.end());
    const auto i = static_cast<std::size_t>(same - mesh.tetrahedron_ids.begin());
    EXPECT_EQ(read.tetrahedra[e], mesh.tetrahedra[i]);
    EXPECT_EQ(read.regions[e], mesh.regions[i]);
  }
  const auto named = std::find_if(read.groups.begin(), read.groups.end(),
                                  [](const Group& g) { return g.name == "hard \"bone\""; });
  ASSERT_NE(named, read.groups.end());
  EXPECT_EQ(named->dimension, 3);
  EXPECT_EQ(named->tag, 2);
  EXPECT_EQ(named->tetrahedra.size(), mesh.tetrahedra.size() / 3);
  for (const Group& group : read.groups) EXPECT_NE(group.name, "skin");
}

// A block with groups of all dimensions, some of which overlap; vertex 900 is in no tetrahedron.
RawMesh grouped_block() {
  RawMesh raw;
  raw.source = "block";
  const TetMesh block = generate_box({1, 1, 1}, {1, 1, 2});
  for (Index v = 0; v < block.vertex_count(); ++v) {
    raw.vertices.push_back(block.vertices[static_cast<std::size_t>(v)]);
    raw.vertex_ids.push_back(10 + 3 * v);
  }
  raw.vertices.emplace_back(9, 9, 9);
  raw.vertex_ids.push_back(900);
  raw.groups = {{"corner", 0, 1}, {"edge", 1, 1},  {"floor", 2, 1}, {"wet", 2, 2},
                {"body", 3, 1},   {"upper", 3, 4}, {"stray", 2, 3}};
  const auto id = [](Index v) { return 10 + 3 * v; };
  raw.cells.push_back({CellType::kVertex, 1, {id(0)}, 0, {0}});
  raw.cells.push_back({CellType::kLine, 2, {id(0), id(1)}, 0, {1}});
  raw.cells.push_back({CellType::kTriangle, 3, {id(0), id(1), id(2)}, 0, {2, 3}});
  raw.cells.push_back({CellType::kTriangle, 4, {id(1), id(3), id(2)}, 0, {2}});
  // The same triangle once more, as version 2 of the format has it.
  raw.cells.push_back({CellType::kTriangle, 5, {id(3), id(2), id(1)}, 0, {3}});
  raw.cells.push_back({CellType::kTriangle, 6, {id(3), id(2), 900}, 0, {6}});
  raw.cells.push_back({CellType::kTriangle, 7, {id(4), id(5), id(6)}, 0, {}});
  for (Index e = 0; e < block.tetrahedron_count(); ++e) {
    RawCell cell{CellType::kTetrahedron, 20 + e, {}, 1, {4}};
    for (const Index v : block.tetrahedra[static_cast<std::size_t>(e)]) {
      cell.vertices.push_back(id(v));
    }
    if (e >= 6) {
      cell.groups.push_back(5);
      cell.region = 4;
    }
    raw.cells.push_back(cell);
  }
  return raw;
}

// The triangles without the order of their vertices.
std::set<std::set<Index>> as_set(const std::vector<std::array<Index, 3>>& triangles) {
  std::set<std::set<Index>> set;
  for (const auto& triangle : triangles) set.insert({triangle.begin(), triangle.end()});
  return set;
}

TEST_F(MeshWriterDetails, GmshKeepsTrianglesOfGroupsWithoutTheCells) {
  const TetMesh mesh = read_mesh(TETRACTION_DATA "/serpentine_spring.msh");
  EXPECT_TRUE(write_mesh(mesh, path("triangles.msh")).lost_groups.empty());
  const TetMesh read = read_mesh(path("triangles.msh"));
  EXPECT_EQ(read.vertex_ids, mesh.vertex_ids);
  for (const char* name : {"clamp", "tip"}) {
    const auto triangles = select_triangles(mesh, SelectGroup{name});
    EXPECT_GT(triangles.size(), 10U);
    EXPECT_EQ(as_set(select_triangles(read, SelectGroup{name})), as_set(triangles));
  }
}

TEST_F(MeshWriterDetails, GmshKeepsGroupsOfAllDimensions) {
  const RawMesh raw = grouped_block();
  const TetMesh mesh = build_mesh(raw);
  const MeshWriteReport report = write_mesh(mesh, path("groups.msh"), group_cells(raw));
  EXPECT_EQ(report.lost_groups, std::vector<std::string>{"stray"});
  // One triangle of the file belongs to no group.
  EXPECT_EQ(mesh.report.skipped_cells, (std::map<CellType, Index>{{CellType::kTriangle, 1}}));

  const RawMesh again = read_raw_mesh(path("groups.msh"));
  std::map<std::pair<std::string, int>, std::multiset<std::set<std::int64_t>>> cells;
  std::set<std::int64_t> numbers;
  for (const RawCell& cell : again.cells) {
    EXPECT_TRUE(numbers.insert(cell.id).second) << "element " << cell.id << " is there twice";
    if (cell.type == CellType::kTetrahedron) continue;
    for (const int g : cell.groups) {
      const RawGroup& group = again.groups[static_cast<std::size_t>(g)];
      cells[{group.name, group.dimension}].insert({cell.vertices.begin(), cell.vertices.end()});
    }
  }
  using Cells = std::multiset<std::set<std::int64_t>>;
  EXPECT_EQ(cells.size(), 4U);
  EXPECT_EQ((cells[{"corner", 0}]), (Cells{{10}}));
  EXPECT_EQ((cells[{"edge", 1}]), (Cells{{10, 13}}));
  EXPECT_EQ((cells[{"floor", 2}]), (Cells{{10, 13, 16}, {13, 16, 19}}));
  EXPECT_EQ((cells[{"wet", 2}]), (Cells{{10, 13, 16}, {13, 16, 19}}));

  const TetMesh read = build_mesh(again);
  expect_same_geometry(read, mesh);
  EXPECT_EQ(elements_of(read), elements_of(mesh));
  for (const Group& group : mesh.groups) {
    if (group.name == "stray") continue;
    const auto same = std::find_if(read.groups.begin(), read.groups.end(), [&](const Group& g) {
      return g.name == group.name && g.dimension == group.dimension;
    });
    ASSERT_NE(same, read.groups.end()) << group.name;
    EXPECT_EQ(same->tag, group.tag) << group.name;
    EXPECT_EQ(same->vertices, group.vertices) << group.name;
    EXPECT_EQ(as_set(same->triangles), as_set(group.triangles)) << group.name;
    std::set<std::int64_t> ids;
    std::set<std::int64_t> read_ids;
    for (const Index e : group.tetrahedra) ids.insert(mesh.tetrahedron_id(e));
    for (const Index e : same->tetrahedra) read_ids.insert(read.tetrahedron_id(e));
    EXPECT_EQ(read_ids, ids) << group.name;
  }
  EXPECT_EQ(read.tetrahedron_ids, mesh.tetrahedron_ids);
}

// Arrays of points and of tetrahedra, with numbers that are missing, in files with large numbers of vertices.
TEST_F(MeshWriterDetails, GmshKeepsArraysOfOneThreeAndNineNumbers) {
  TetMesh mesh = generate_box({1, 1, 1}, {2, 1, 1});
  for (auto& id : mesh.vertex_ids) id = (std::int64_t{1} << 40) + 3 * id;
  const auto filled = [](Index rows, Index cols, double seed) {
    Matrix values(rows, cols);
    for (Index i = 0; i < values.size(); ++i) {
      values.data()[i] = std::sin(seed + static_cast<double>(i)) / 3.0;
    }
    return values;
  };
  for (const Index rows : {1, 3, 9}) {
    const auto seed = static_cast<double>(rows);
    mesh.point_arrays[fmt::format("u{}", rows)] = filled(rows, mesh.vertex_count(), seed);
    mesh.cell_arrays[fmt::format("s{}", rows)] = filled(rows, mesh.tetrahedron_count(), -seed);
  }
  mesh.point_arrays["u \"3\""] = filled(3, mesh.vertex_count(), 8.0);
  mesh.point_arrays["u3"].col(4).setConstant(std::nan(""));
  mesh.point_arrays["u2"] = filled(2, mesh.vertex_count(), 1.0);
  mesh.cell_arrays["s6"] = filled(6, mesh.tetrahedron_count(), 1.0);
  const MeshWriteReport report = write_mesh(mesh, path("arrays.msh"));
  EXPECT_EQ(report.lost_arrays, (std::vector<std::string>{"s6", "u2"}));
  const TetMesh read = read_mesh(path("arrays.msh"));
  ASSERT_EQ(read.point_arrays.size(), 4U);
  ASSERT_EQ(read.cell_arrays.size(), 3U);
  for (const auto& [name, values] : read.point_arrays) {
    const Matrix& expected = mesh.point_arrays.at(name);
    for (Index v = 0; v < values.cols(); ++v) {
      EXPECT_TRUE(values.col(v) == expected.col(v) ||
                  (values.col(v).array().isNaN().all() && expected.col(v).array().isNaN().all()))
          << name << " at " << v;
    }
  }
  for (const auto& [name, values] : read.cell_arrays) {
    EXPECT_EQ(values, mesh.cell_arrays.at(name)) << name;
  }
}

TEST_F(MeshWriterDetails, FormatsSayWhatElseTheyLose) {
  TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  mesh.point_arrays["heat"] = Matrix::Ones(1, mesh.vertex_count());
  mesh.cell_arrays["E"] = Matrix::Ones(1, mesh.tetrahedron_count());
  const auto report = [&](const char* ending) { return write_mesh(mesh, path("lost") + ending); };
  const std::vector<std::string> all{"heat", "E"};
  for (const char* ending : {".node", ".ele", ".veg"}) EXPECT_EQ(report(ending).lost_arrays, all);
  for (const char* ending : {".vtu", ".vtk", ".msh"}) {
    EXPECT_TRUE(report(ending).lost_arrays.empty()) << ending;
    EXPECT_FALSE(report(ending).changed_regions) << ending;
  }
  // Names that VTK files have for something else.
  mesh.cell_arrays["region"] = Matrix::Constant(1, mesh.tetrahedron_count(), 0.5);
  mesh.point_arrays["vertex_id"] = Matrix::Constant(1, mesh.vertex_count(), 0.5);
  for (const char* ending : {".vtu", ".vtk"}) {
    EXPECT_EQ(report(ending).lost_arrays, (std::vector<std::string>{"vertex_id", "region"}));
    EXPECT_EQ(read_mesh(path("lost") + ending).regions, mesh.regions);
  }
  // Two sets of Vega may not have the same name.
  mesh.groups = {{"half", 3, 1, {}, {0, 1}}, {"half", 3, 2, {}, {2, 3}}};
  report(".veg");
  const TetMesh halves = read_mesh(path("lost.veg"));
  ASSERT_EQ(halves.groups.size(), 2U);
  EXPECT_EQ(halves.groups[1].name, "half (tag 2)");
  mesh.groups.clear();
  mesh.regions = {-2, 1, 1, 1, 1, 1};
  EXPECT_TRUE(report(".msh").changed_regions);
  EXPECT_TRUE(report(".veg").changed_regions);
  EXPECT_FALSE(report(".node").changed_regions);
  mesh.regions = {2, 1, 1, 1, 1, 1};
  EXPECT_FALSE(report(".msh").changed_regions);
  EXPECT_FALSE(report(".veg").changed_regions);
}

// The faces of TetGen's file are linear here although the tetrahedra are quadratic.
TEST_F(MeshWriterDetails, LinearTrianglesOfQuadraticMeshesGetTheirMiddles) {
  std::ofstream(path("ten.node"))
      << "10 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 .5 .5\n6 .5 0 0\n7 0 .5 0\n8 0 0 .5\n"
         "9 .5 .5 0\n10 .5 0 .5\n";
  std::ofstream(path("ten.ele")) << "1 10 0\n1 1 2 3 4 5 6 7 8 9 10\n";
  std::ofstream(path("ten.face")) << "1 1\n1 1 3 2 9 6 7 4\n";
  const RawMesh raw = read_raw_mesh(path("ten.node"));
  const TetMesh mesh = build_mesh(raw);
  // The corners 1, 2, 3 and the vertices 6, 7, 9 between them, as numbers from 0.
  ASSERT_EQ(mesh.groups.size(), 1U);
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2, 5, 6, 8}));
  EXPECT_TRUE(write_mesh(mesh, path("ten.msh"), group_cells(raw)).lost_groups.empty());
  const TetMesh read = read_mesh(path("ten.msh"));
  ASSERT_EQ(read.groups.size(), 1U);
  EXPECT_EQ(read.groups[0].vertices, mesh.groups[0].vertices);
  EXPECT_EQ(read.groups[0].triangles, mesh.groups[0].triangles);
}

TEST_F(MeshWriterDetails, GmshTagsOfSetsDoNotMixWithRegions) {
  TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  mesh.regions = {1, 1, 1, 2, 2, 2};
  mesh.groups = {{"even", 3, 1, {}, {0, 2, 4}}, {"zero", 3, 0, {}, {1}}};  // as Vega has them
  write_mesh(mesh, path("sets.msh"));
  const TetMesh read = read_mesh(path("sets.msh"));
  EXPECT_EQ(elements_of(read), elements_of(mesh));
  std::map<std::string, std::size_t> sizes;
  for (const Group& group : read.groups) sizes[group.name] = group.tetrahedra.size();
  EXPECT_EQ(sizes,
            (std::map<std::string, std::size_t>{{"1", 3}, {"2", 3}, {"even", 3}, {"zero", 1}}));
}

TEST_F(MeshWriterDetails, FormatsSayWhichGroupsTheyLose) {
  const RawMesh raw = grouped_block();
  const TetMesh mesh = build_mesh(raw);
  const std::vector<std::string> all{"corner", "edge", "floor", "wet", "body", "upper", "stray"};
  const std::vector<std::string> lower{"corner", "edge", "floor", "wet", "stray"};
  for (const char* ending : {".vtu", ".vtk", ".node", ".ele"}) {
    EXPECT_EQ(write_mesh(mesh, path("lost") + ending, group_cells(raw)).lost_groups, all) << ending;
  }
  EXPECT_EQ(write_mesh(mesh, path("lost.veg"), group_cells(raw)).lost_groups, lower);
  EXPECT_EQ(write_mesh(mesh, path("lost.msh")).lost_groups,
            (std::vector<std::string>{"corner", "stray"}))
      << "without the cells";
}

TEST_F(MeshWriterDetails, NumbersBelowOneAreShiftedForGmsh) {
  const TetMesh mesh = generate_tetrahedron();
  ASSERT_EQ(mesh.vertex_ids.front(), 0);
  write_mesh(mesh, path("zero.msh"));
  const TetMesh read = read_mesh(path("zero.msh"));
  EXPECT_EQ(read.vertex_ids, (std::vector<std::int64_t>{1, 2, 3, 4}));
}

TEST_F(MeshWriterDetails, TetgenCountsFromWhereTheMeshDoes) {
  TetMesh mesh = generate_tetrahedron();
  write_mesh(mesh, path("zero.node"));
  EXPECT_EQ(read_mesh(path("zero.ele")).vertex_ids, (std::vector<std::int64_t>{0, 1, 2, 3}));
  mesh.vertex_ids = {0, 2, 1, 3};  // begins at 0 but is not a row
  write_mesh(mesh, path("mixed.ele"));
  EXPECT_EQ(read_mesh(path("mixed.node")).vertex_ids, (std::vector<std::int64_t>{1, 2, 3, 4}));
}

TEST_F(MeshWriterDetails, VegaKeepsVolumeGroupsAsSets) {
  TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 2});
  Group core{"core", 3, 1, {}, {0, 2, 3, 4, 5, 6, 8, 9, 10, 11}};
  mesh.groups = {core};
  write_mesh(mesh, path("sets.veg"));
  const TetMesh read = read_mesh(path("sets.veg"));
  ASSERT_EQ(read.groups.size(), 1u);
  EXPECT_EQ(read.groups[0].name, "core");
  EXPECT_EQ(read.groups[0].tetrahedra, core.tetrahedra);
}

TEST_F(MeshWriterDetails, VegaNumbersRegionsInAscendingOrder) {
  TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  mesh.regions = {9, 4, 4, 7, 9, 7};
  write_mesh(mesh, path("regions.veg"));
  EXPECT_EQ(read_mesh(path("regions.veg")).regions, (std::vector<int>{3, 1, 1, 2, 3, 2}));
}

TEST_F(MeshWriterDetails, UnknownEndingAndEmptyMeshAreInputErrors) {
  const TetMesh mesh = generate_tetrahedron();
  EXPECT_THROW(write_mesh(mesh, path("mesh.stl")), InputError);
  EXPECT_THROW(write_mesh(mesh, path("mesh")), InputError);
  EXPECT_THROW(write_mesh(TetMesh{}, path("mesh.vtu")), InputError);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(MeshWriterDetails, AFailedWriteLeavesTheOldFile) {
  const TetMesh mesh = generate_tetrahedron();
  for (const char* name : {"kept.vtu", "kept.vtk", "kept.msh"}) {
    const std::string file = path(name);
    write_mesh(mesh, file);
    const std::string before = contents(file);
    fs::create_directories(file + ".part/in_the_way");  // the temporary file cannot be made
    EXPECT_THROW(write_mesh(generate_box({1, 1, 1}, {2, 2, 2}), file), OutputError) << name;
    EXPECT_EQ(contents(file), before) << name;
  }
}

// The faces of another mesh would become groups of this one, and a pair of two meshes is none.
TEST(TetgenWriter, TetgenPairsAreWrittenTogetherAndBesideNoFaces) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  const auto contents = [&](const char* name) {
    std::stringstream text;
    text << std::ifstream(path(name)).rdbuf();
    return text.str();
  };
  const TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  std::ofstream(path("b.face")) << "0 1\n";
  EXPECT_THROW(write_mesh(mesh, path("b.node")), OutputError);
  EXPECT_FALSE(std::filesystem::exists(path("b.node")));
  std::ofstream(path("c.node")) << "old";
  std::filesystem::create_directory(path("c.ele.part"));  // nothing can be written there
  EXPECT_THROW(write_mesh(mesh, path("c.node")), OutputError);
  EXPECT_EQ(contents("c.node"), "old");
  std::filesystem::remove(path("c.ele.part"));
  write_mesh(mesh, path("c.node"));
  EXPECT_EQ(read_mesh(path("c.node")).tetrahedron_count(), mesh.tetrahedron_count());
}

}  // namespace
}  // namespace tetraction
