
#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "support/folder_test.h"
#include "support/messages.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

// Two tetrahedra, a triangle and a lone point in plain text, with parts to be put in.
struct VtuText {
  std::string type = "UnstructuredGrid";
  std::string points = "5";
  std::string cells = "3";
  std::string coordinates = "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1";
  std::string connectivity = "0 1 2 3  1 2 3 4  0 1 2";
  std::string offsets = "4 8 11";
  std::string types = "10 10 5";
  std::string point_data;
  std::string cell_data;

  std::string text() const {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
           "\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
           "<Piece NumberOfPoints=\"" +
           points + "\" NumberOfCells=\"" + cells + "\">\n<PointData>" + point_data +
           "</PointData>\n<CellData>" + cell_data +
           "</CellData>\n<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
           "format=\"ascii\">" +
           coordinates +
           "</DataArray></Points>\n<Cells>\n"
           "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">" +
           connectivity +
           "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">" + offsets +
           "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">" + types +
           "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  }
};

std::string array(const std::string& type, const std::string& name, const std::string& values,
                  int components = 1) {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"ascii\">" + values + "</DataArray>";
}

constexpr const char* kLegacyText =
    "# vtk DataFile Version 3.0\n"
    "points of two tetrahedra\n"
    "ASCII\n"
    "DATASET UNSTRUCTURED_GRID\n"
    "POINTS 5 double\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n"
    "CELLS 3 14\n"
    "4 0 1 2 3\n4 1 2 3 4\n3 0 1 2\n"
    "CELL_TYPES 3\n"
    "10\n10\n5\n"
    "CELL_DATA 3\n"
    "SCALARS region int 1\n"
    "LOOKUP_TABLE default\n"
    "7 8 9\n"
    "POINT_DATA 5\n"
    "SCALARS heat double 1\n"
    "LOOKUP_TABLE default\n"
    "1 2 3 4 5.5\n"
    "VECTORS displacement double\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1.25\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the test's text has no " + from);
  return text.replace(at, from.size(), to);
}

class VtkReader : public FolderTest {
 protected:
  RawMesh read(const std::string& name, const std::string& text) const {
    return read_raw_mesh(file(name, text));
  }
  // The message with which a file is refused.
  std::string refusal(const std::string& name, const std::string& text) const {
    try {
      read_mesh(file(name, text));
    } catch (const FileError& error) {
      EXPECT_EQ(std::string(error.what()).find(path(name)), 0u) << "the file is not named";
      return error.what();
    }
    return "(accepted)";
  }
};

void expect_refused(const std::string& message, const std::string& part) {
  EXPECT_NE(message, "(accepted)");
  EXPECT_NE(message.find(part), std::string::npos) << message << "\n does not say: " << part;
}

void expect_same(const TetMesh& a, const TetMesh& b) {
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (std::size_t v = 0; v < a.vertices.size(); ++v) EXPECT_EQ(a.vertices[v], b.vertices[v]);
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
  EXPECT_EQ(a.vertex_ids, b.vertex_ids);
  EXPECT_EQ(a.tetrahedron_ids, b.tetrahedron_ids);
  EXPECT_EQ(a.regions, b.regions);
}

TEST_F(VtkReader, PlainVtuKeepsEverything) {
  VtuText vtu;
  vtu.point_data = array("Float32", "heat", "1 2 3 4 5.5") +
                   array("Float64", "displacement", "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1.25", 3) +
                   array("Int32", "flag", "1 0 1 0 1");
  vtu.cell_data = array("Int32", "region", "7 8 9");
  const RawMesh mesh = read("plain.vtu", vtu.text());
  ASSERT_EQ(mesh.vertices.size(), 5u);
  EXPECT_EQ(mesh.vertices[4], Vector3(1, 1, 1));
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  ASSERT_EQ(mesh.cells.size(), 3u);
  EXPECT_EQ(mesh.cells[1].type, CellType::kTetrahedron);
  EXPECT_EQ(mesh.cells[1].id, 1);
  EXPECT_EQ(mesh.cells[1].vertices, (std::vector<std::int64_t>{1, 2, 3, 4}));
  EXPECT_EQ(mesh.cells[2].type, CellType::kTriangle);
  EXPECT_EQ(mesh.cells[2].region, 9);
  ASSERT_EQ(mesh.point_arrays.size(), 2u);
  EXPECT_EQ(mesh.point_arrays.at("heat")(0, 4), 5.5);
  EXPECT_EQ(mesh.point_arrays.at("displacement").col(4), Vector3(1, 1, 1.25));
}

TEST_F(VtkReader, LegacyTextKeepsEverything) {
  for (const std::string& text :
       {std::string(kLegacyText),
        replaced(replaced(kLegacyText, "DATASET UNSTRUCTURED_GRID", "dataset unstructured_grid"),
                 "CELL_TYPES", "cell_types")}) {
    const RawMesh mesh = read("plain.vtk", text);
    ASSERT_EQ(mesh.vertices.size(), 5u);
    ASSERT_EQ(mesh.cells.size(), 3u);
    EXPECT_EQ(mesh.cells[1].region, 8);
    EXPECT_EQ(mesh.point_arrays.at("heat")(0, 4), 5.5);
    EXPECT_EQ(mesh.point_arrays.at("displacement").col(4), Vector3(1, 1, 1.25));
  }
}

TEST_F(VtkReader, NoComponentsAreOne) {
  VtuText vtu;
  vtu.cell_data = array("Float64", "E", "7 8 9", 0);
  EXPECT_EQ(read("none.vtu", vtu.text()).cell_arrays.at("E")(0, 2), 9.0);
}

TEST_F(VtkReader, PiecesAreAddedUp) {
  const std::string one = VtuText{}.text();
  const auto begin = one.find("<Piece");
  const auto end = one.find("</Piece>") + 8;
  const std::string piece = one.substr(begin, end - begin);
  std::string two = one;
  two.insert(end, "<!-- <Piece NumberOfPoints=\"99\" > -->" + piece);
  const RawMesh mesh = read("pieces.vtu", two);
  EXPECT_EQ(mesh.vertices.size(), 10u);
  ASSERT_EQ(mesh.cells.size(), 6u);
  EXPECT_EQ(mesh.cells[3].vertices, (std::vector<std::int64_t>{5, 6, 7, 8}));
}

TEST_F(VtkReader, OwnNumbersCountOnlyIfTheyAreNumbers) {
  VtuText vtu;
  vtu.point_data = array("Int64", "vertex_id", "10 20 30 40 9007199254740993");
  vtu.cell_data = array("Int32", "element_id", "5 4 3");
  RawMesh mesh = read("ids.vtu", vtu.text());
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{10, 20, 30, 40, 9007199254740993}));
  EXPECT_EQ(mesh.cells[0].id, 5);
  EXPECT_EQ(mesh.cells[0].vertices, (std::vector<std::int64_t>{10, 20, 30, 40}));

  vtu.point_data.clear();
  vtu.cell_data = array("Float64", "element_id", "5 4 3");  // not integers
  std::vector<std::string> unused;
  mesh = read_raw_mesh(file("ids.vtu", vtu.text()), unused);
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(mesh.cells[0].id, 0);
  EXPECT_EQ(unused, std::vector<std::string>{"the cell data \"element_id\""});
}

TEST_F(VtkReader, CellTypesHaveTheirNames) {
  VtuText vtu;
  vtu.points = "10";
  vtu.coordinates = "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1 2 0 0 2 1 0 2 0 1 2 2 2 3 3 3";
  vtu.cells = "7";
  vtu.connectivity =
      "0  0 1  0 1 2 3  0 1 2 3 4 5 6 7  0 1 2 3 4 5  0 1 2 3 4  0 1 2 3 4 5 6 7 8 9";
  vtu.offsets = "1 3 7 15 21 26 36";
  vtu.types = "1 3 9 12 13 14 24";
  const RawMesh mesh = read("types.vtu", vtu.text());
  const std::vector<CellType> expected{
      CellType::kVertex, CellType::kLine,    CellType::kQuadrilateral,       CellType::kHexahedron,
      CellType::kWedge,  CellType::kPyramid, CellType::kQuadraticTetrahedron};
  ASSERT_EQ(mesh.cells.size(), expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) EXPECT_EQ(mesh.cells[c].type, expected[c]);
}

TEST_F(VtkReader, RegionsMayBeRealButMustBeWhole) {
  VtuText vtu;
  vtu.cell_data = array("Float32", "region", "2 -3 4");
  EXPECT_EQ(read("region.vtu", vtu.text()).cells[1].region, -3);
  vtu.cell_data = array("Float32", "region", "2 2.5 4");
  expect_refused(refusal("region.vtu", vtu.text()), "region 2.5 of cell 1");
  vtu.cell_data = array("Float64", "region", "2 nan 4");
  expect_refused(refusal("region.vtu", vtu.text()), "region nan of cell 1");
  vtu.cell_data = array("Int64", "region", "2 99999999999 4");
  expect_refused(refusal("region.vtu", vtu.text()), "of cell 1");
  vtu.cell_data = array("Int32", "region", "1 1 2 2 3 3", 2);
  expect_refused(refusal("region.vtu", vtu.text()), "\"region\"");
}

TEST_F(VtkReader, OtherDataSetsAreNamed) {
  expect_refused(refusal("poly.vtk",
                         "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
                         "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n"),
                 "POLYDATA");
  expect_refused(refusal("grid.vtk",
                         "# vtk DataFile Version 3.0\nt\nASCII\n"
                         "DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"),
                 "STRUCTURED_POINTS");
  VtuText vtu;
  vtu.type = "PolyData";
  expect_refused(refusal("poly.vtu", vtu.text()), "PolyData");
  expect_refused(refusal("none.vtu", ""), "not a VTU file");
  expect_refused(refusal("none.vtk", ""), "not a legacy VTK file");
  expect_refused(refusal("text.vtu", "This is no mesh at all.\n"), "not a VTU file");
  expect_refused(refusal("short.vtk", "# vtk DataFile Version 3.0"), "data set");
}

TEST_F(VtkReader, MissingFileAndDirectoryAreFileErrors) {
  EXPECT_THROW(read_raw_mesh(path("missing.vtu")), FileError);
  EXPECT_THROW(read_raw_mesh(path("missing.vtk")), FileError);
  fs::create_directories(path("directory.vtu"));
  EXPECT_THROW(read_raw_mesh(path("directory.vtu")), FileError);
}

TEST_F(VtkReader, CountsThatCannotBeAreRefused) {
  for (const std::string count :
       {"-5", "99999999999", "18446744073709551615", "3.5", "", "4", "6"}) {
    VtuText points;
    points.points = count;
    EXPECT_NE(refusal("points.vtu", points.text()), "(accepted)") << count;
    VtuText cells;
    cells.cells = count;
    EXPECT_NE(refusal("cells.vtu", cells.text()), "(accepted)") << count;
  }
  expect_refused(refusal("negative.vtu", replaced(VtuText{}.text(), "\"5\"", "\"-5\"")),
                 "NumberOfPoints is \"-5\"");
  for (const std::string count : {"-5", "99999999999", "18446744073709551615", "x", "4", "6"}) {
    EXPECT_NE(refusal("points.vtk", replaced(kLegacyText, "POINTS 5", "POINTS " + count)),
              "(accepted)")
        << count;
    EXPECT_NE(refusal("types.vtk", replaced(kLegacyText, "CELL_TYPES 3", "CELL_TYPES " + count)),
              "(accepted)")
        << count;
    EXPECT_NE(refusal("cells.vtk", replaced(kLegacyText, "CELLS 3 14", "CELLS " + count + " 14")),
              "(accepted)")
        << count;
    EXPECT_NE(refusal("size.vtk", replaced(kLegacyText, "CELLS 3 14", "CELLS 3 " + count)),
              "(accepted)")
        << count;
  }
}

// VTK would fill the memory with an array of so many components before it looks for their values.
TEST_F(VtkReader, ArraysThatCannotBeAreRefused) {
  const std::string text = VtuText{}.text();
  for (const char* count : {"2147483648", "-1", "1000000", "x"}) {
    expect_refused(
        refusal("components.vtu", replaced(text, "NumberOfComponents=\"3\"",
                                           "NumberOfComponents=\"" + std::string(count) + "\"")),
        "NumberOfComponents is \"" + std::string(count) + "\"");
  }
}

TEST_F(VtkReader, ConnectivityMustFit) {
  VtuText vtu;
  vtu.connectivity = "0 1 2 3  1 2 3 99  0 1 2";
  expect_refused(refusal("far.vtu", vtu.text()), "cell 1 refers to point 99");
  vtu.connectivity = "0 1 2 3  1 2 3 -4  0 1 2";
  expect_refused(refusal("negative.vtu", vtu.text()), "point -4");
  expect_refused(refusal("far.vtk", replaced(kLegacyText, "4 1 2 3 4", "4 1 2 3 5")), "point 5");
  for (const std::string offsets : {"4 8 1000000", "4 8 12", "8 4 11", "-4 8 11", "4 8 10",
                                    "4 8 -11", "4 800000000 11", "4 8"}) {
    VtuText wrong;
    wrong.offsets = offsets;
    EXPECT_NE(refusal("offsets.vtu", wrong.text()), "(accepted)") << offsets;
  }
  for (const std::string types : {"10 10", "10 10 10", "200 10 10"}) {
    VtuText wrong;
    wrong.types = types;
    EXPECT_NE(refusal("types.vtu", wrong.text()), "(accepted)") << types;
  }
  VtuText longer;
  longer.offsets = "4 8 11 11";
  expect_refused(refusal("longer.vtu", longer.text()),
                 "array \"offsets\" has 4 numbers, but there are 3 cells");
}

TEST_F(VtkReader, CoordinatesThatAreNotFiniteAreRefused) {
  VtuText vtu;
  vtu.coordinates = "0 0 0  1 0 0  0 nan 0  0 0 1  1 1 1";
  EXPECT_NE(refusal("nan.vtu", vtu.text()), "(accepted)");
  // In binary, where VTK does not look at them.
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    TetMesh mesh = generate_tetrahedron();
    mesh.vertices.own()[2].y() = bad;
    for (const char* name : {"bad.vtu", "bad.vtk"}) {
      write_mesh(mesh, path(name));
      expect_refused(refusal(name, contents(path(name))), "vertex 2");
    }
  }
}

// A file cut off anywhere is refused, or nothing is lost.
void expect_cuts_refused(const std::string& whole_path, const std::string& cut_path, int cuts) {
  const TetMesh whole = read_mesh(whole_path);
  const std::string text = contents(whole_path);
  int refused = 0;
  for (int i = 0; i < cuts; ++i) {
    // Evenly, and each of the last bytes.
    const std::size_t size =
        i < 8 ? text.size() - 1 - static_cast<std::size_t>(i)
              : text.size() * static_cast<std::size_t>(i - 8) / static_cast<std::size_t>(cuts - 8);
    std::ofstream(cut_path, std::ios::binary) << text.substr(0, size);
    try {
      expect_same(read_mesh(cut_path), whole);
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GE(refused, cuts - 8);
}

TEST_F(VtkReader, TruncatedFilesAreRefused) {
  TetMesh mesh = generate_box({1, 1, 1}, {3, 2, 2});
  for (auto& id : mesh.vertex_ids) id += 50;
  for (std::size_t e = 0; e < mesh.regions.size(); ++e) mesh.regions[e] = static_cast<int>(e % 4);
  write_mesh(mesh, path("whole.vtu"));
  expect_cuts_refused(path("whole.vtu"), path("cut.vtu"), 40);
  write_mesh(mesh, path("whole.vtk"));
  expect_cuts_refused(path("whole.vtk"), path("cut.vtk"), 40);
  file("text.vtu", VtuText{}.text());
  expect_cuts_refused(path("text.vtu"), path("cut.vtu"), 30);
}

// The checked bytes are those that VTK reads, also while another program replaces the file again and again.
TEST_F(VtkReader, AFileThatIsReplacedIsReadAsOneOrTheOther) {
  write_mesh(generate_box({1, 1, 1}, {1, 1, 1}), path("small.vtu"));
  write_mesh(generate_box({1, 1, 1}, {2, 2, 2}), path("large.vtu"));
  const std::array<std::string, 2> texts{contents(path("small.vtu")), contents(path("large.vtu"))};
  file("mesh.vtu", texts[0]);
  std::atomic<bool> done = false;
  std::thread replacing([&] {
    for (std::size_t i = 0; !done; ++i) {
      file("next", texts[i % 2]);
      fs::rename(path("next"), path("mesh.vtu"));
    }
  });
  std::string message;
  for (int i = 0; i < 40 && message.empty(); ++i) {
    try {
      const Index count = read_mesh(path("mesh.vtu")).tetrahedron_count();
      if (count != 6 && count != 48) message = std::to_string(count) + " tetrahedra";
    } catch (const FileError& error) {
      message = error.what();
    }
  }
  done = true;
  replacing.join();
  EXPECT_EQ(message, "");
}

TEST_F(VtkReader, OwnLegacyFileCutBetweenSectionsIsRefused) {
  write_mesh(generate_tetrahedron(), path("whole.vtk"));
  const std::string text = contents(path("whole.vtk"));
  for (const char* section : {"CELL_DATA", "POINT_DATA"}) {
    const auto at = text.find(section);
    ASSERT_NE(at, std::string::npos);
    expect_refused(refusal("cut.vtk", text.substr(0, at)), "lacks the data");
  }
}

TEST_F(VtkReader, DamagedBytesNeverCrashOrHang) {
  TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  int refused = 0;
  unsigned state = 12345;
  const auto random = [&state] { return state = state * 1664525u + 1013904223u, state >> 8; };
  for (const char* name : {"damaged.vtu", "damaged.vtk"}) {
    write_mesh(mesh, path(name));
    const std::string whole = contents(path(name));
    for (int i = 0; i < 40; ++i) {
      std::string text = whole;
      for (int k = 0; k < 4; ++k) text[random() % text.size()] = static_cast<char>(random());
      file(name, text);
      try {
        const TetMesh read = read_mesh(path(name));
        EXPECT_GT(read.tetrahedron_count(), 0);
      } catch (const FileError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 20);
}

// Triangles are groups by the numbers in cell data of other programs, or else in `region`.
TEST_F(VtkReader, TrianglesWithNumbersAreGroups) {
  const TetMesh legacy = build_mesh(read("legacy.vtk", kLegacyText));
  ASSERT_EQ(legacy.groups.size(), 1U);
  EXPECT_EQ(legacy.groups[0].name, "9");
  EXPECT_EQ(legacy.groups[0].dimension, 2);
  ASSERT_EQ(legacy.groups[0].triangles.size(), 1U);
  EXPECT_EQ(legacy.regions, (std::vector<int>{7, 8}));

  VtuText vtu;
  vtu.cell_data = array("Int32", "region", "7 8 9") + array("Int32", "gmsh:physical", "1 1 4");
  const TetMesh mesh = build_mesh(read("named.vtu", vtu.text()));
  ASSERT_EQ(mesh.groups.size(), 1U);
  EXPECT_EQ(mesh.groups[0].name, "4");
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2}));

  vtu.cell_data = array("Int32", "region", "7 8 0");
  EXPECT_TRUE(build_mesh(read("none.vtu", vtu.text())).groups.empty());
  vtu.cell_data = array("Float64", "medit:ref", "7 8 0.5");
  expect_part(refusal("half.vtu", vtu.text()), "the number 0.5 of triangle 2");

  VtuText quadratic;
  quadratic.points = "10";
  quadratic.cells = "2";
  quadratic.coordinates =
      "0 0 0  1 0 0  0 1 0  0 0 1  .5 0 0  .5 .5 0  0 .5 0  0 0 .5  .5 0 .5  0 .5 .5";
  quadratic.connectivity = "0 1 2 3 4 5 6 7 8 9  0 1 2 4 5 6";
  quadratic.offsets = "10 16";
  quadratic.types = "24 22";
  quadratic.cell_data = array("Int32", "gmsh:physical", "1 4");
  const TetMesh curved = build_mesh(read("quadratic.vtu", quadratic.text()));
  ASSERT_EQ(curved.groups.size(), 1U);
  EXPECT_EQ(curved.groups[0].name, "4");
  EXPECT_EQ(curved.groups[0].triangles.size(), 1U);
  EXPECT_EQ(curved.groups[0].vertices, (std::vector<Index>{0, 1, 2, 4, 5, 6}));
}

// VTK stops inside such words, reads them as two, or keeps their lowest bits.
TEST_F(VtkReader, WordsOfTextArraysAreNumbersOfTheirType) {
  const auto with_data = [&](const char* type, const char* values) {
    VtuText vtu;
    vtu.cell_data = array(type, "E", values);
    return refusal("data.vtu", vtu.text());
  };
  expect_refused(with_data("Float64", "1e6 1.0-101 5e6"), "\"1.0-101\" in its array \"E\" is not");
  expect_refused(with_data("Float64", "1 2 9,5e6"), "\"9,5e6\" in its array \"E\" is not a number");
  expect_refused(with_data("Float32", "1 2 1e39"), "\"1e39\" in its array \"E\" is not a number");
  expect_refused(with_data("Int32", "1 2 2.9"), "\"2.9\" in its array \"E\" is not a number from");
  expect_refused(with_data("UInt16", "1 2 -1"), "\"-1\" in its array \"E\" is not a number from 0");
  expect_refused(with_data("UInt32", "1 2 -1"), "not a number from 0 to 4294967295");
  expect_refused(with_data("UInt64", "-1 1 2"), "not a number from 0 to 18446744073709551615");
  expect_refused(with_data("Int16", "1 2 32768"), "not a number from -32768 to 32767");
  expect_refused(with_data("&#85;Int8", "1 2 257"), "could read them in two ways");
  EXPECT_EQ(with_data("Float64", "+1e6 .5 1e-400"), "(accepted)");
  EXPECT_EQ(with_data("Float64", "nan 1 2"), "(accepted)");
  EXPECT_EQ(with_data("Int64", "-9223372036854775808 +1 9223372036854775807"), "(accepted)");

  VtuText vtu;
  const VtuText good = vtu;
  vtu.coordinates = "0 0 0  1.0-101 0 0  1 0 0  0 1  1 1 1";
  expect_refused(refusal("points.vtu", vtu.text()), "\"1.0-101\" in its array \"Points\"");
  vtu = good;
  vtu.connectivity = "0 1 2 3  1 2 3 4  0 1 2e5";
  expect_refused(refusal("cells.vtu", vtu.text()), "\"2e5\" in its array \"connectivity\"");
  vtu = good;
  vtu.offsets = "4 8 11.5";
  expect_refused(refusal("offsets.vtu", vtu.text()), "\"11.5\" in its array \"offsets\"");
  vtu = good;
  vtu.types = "10 10 5.9";
  expect_refused(refusal("types.vtu", vtu.text()), "\"5.9\" in its array \"types\"");
  const std::string hidden = replaced(good.text(), "\"connectivity\"", "\"connectivit&#121;\"");
  expect_refused(refusal("hidden.vtu", hidden), "could read them in two ways");
}

// VTK leaves the rest of its memory as it is where bytes are missing, and does not see what is left over.
TEST_F(VtkReader, BinaryArraysHaveExactlyTheirBytes) {
  const auto in_base64 = [&](const std::string& bytes) {
    VtuText vtu;
    vtu.cells = "1";
    vtu.connectivity = "0 1 2 3";
    vtu.offsets = "4";
    vtu.types = "10";
    vtu.cell_data =
        "<DataArray type=\"Float64\" Name=\"E\" format=\"binary\">" + bytes + "</DataArray>";
    return refusal("binary.vtu", vtu.text());
  };
  EXPECT_EQ(in_base64("\n  CAAAAAAAAAAAABRA\n"), "(accepted)");  // 8 bytes, the number 5
  expect_refused(in_base64("CAAAAAAAAAA="), "\"E\" has fewer bytes than it announces");
  expect_refused(in_base64("CAAAAAAA!AAAABRA"), "or some that are not base64");
  expect_refused(in_base64("CAA"), "\"E\" is cut in its header");
  expect_refused(in_base64("CAAAAAAAAAAAABRACAAAAAAAAAAAABRA"), "\"E\" has more behind the bytes");
  expect_refused(in_base64("CAAAAAAAAAAAABRA!!!!"), "\"E\" has more behind the bytes");
  expect_refused(in_base64("BwAAAAAAAAAAABQ="), "\"E\" announces bytes that are no whole numbers");
  expect_refused(in_base64("AAAAAA=="), "\"E\"");
}

TEST_F(VtkReader, AppendedArraysHaveExactlyTheirBytes) {
  using namespace std::string_literals;
  const std::string block = "\x08\0\0\0\0\0\0\0\0\0\x14\x40"s;  // the number 5
  const auto appended = [&](const std::string& bytes, const std::string& behind = "",
                            const std::string& second = "") {
    VtuText vtu;
    vtu.cells = "1";
    vtu.connectivity = "0 1 2 3";
    vtu.offsets = "4";
    vtu.types = "10";
    vtu.cell_data = "<DataArray type=\"Float64\" Name=\"E\" format=\"appended\" offset=\"0\"/>";
    if (!second.empty()) {
      vtu.cell_data +=
          "<DataArray type=\"Float64\" Name=\"F\" format=\"appended\" offset=\"" + second + "\"/>";
    }
    return refusal("appended.vtu", replaced(vtu.text(), "</VTKFile>",
                                            "<AppendedData encoding=\"raw\">\n _" + bytes +
                                                "\n</AppendedData>" + behind + "\n</VTKFile>"));
  };
  EXPECT_EQ(appended(block), "(accepted)");
  EXPECT_EQ(appended(block + block, "", "12"), "(accepted)");
  expect_refused(appended(block.substr(0, 9)), "does not end after the last of its arrays");
  expect_refused(appended(block + "more"), "does not end after the last of its arrays");
  expect_refused(appended(block, "<AppendedData encoding=\"raw\">_" + block + "</AppendedData>"),
                 "something follows it");
  expect_refused(appended(block, "<UnstructuredGrid></UnstructuredGrid>"), "something follows it");
  expect_refused(appended(block + block, "", "11"), "\"F\" begins within another array");
  expect_refused(appended(block, "", "0"), "begins within another array");
  expect_refused(appended(block, "", "99999"), "\"F\"");
}

// VTK does not fill an array that belongs to another time than the first one.
TEST_F(VtkReader, SeriesInTimeAreRefused) {
  VtuText vtu;
  vtu.cell_data = replaced(array("Float64", "E", "1 2 3"), "Name", "TimeStep=\"1\" Name");
  expect_refused(refusal("step.vtu", vtu.text()), "the attribute TimeStep");
  const std::string values =
      replaced(vtu.text(), "<UnstructuredGrid>", "<UnstructuredGrid TimeValues=\"0 1\">");
  expect_refused(refusal("values.vtu", values), "the attribute TimeValues");
  const std::string defined =
      replaced(VtuText().text(), "<VTKFile", "<!DOCTYPE VTKFile>\n<VTKFile");
  expect_refused(refusal("defined.vtu", defined), "has a <!DOCTYPE>");
}

// VTK takes words for keywords that only begin with one, and decodes names, so that the last of two holds.
TEST_F(VtkReader, LegacyKeywordsAreWholeAndNamesDifferWhenDecoded) {
  const std::string text = kLegacyText;
  const std::string points = "POINTS_deformed 5 double\n0 0 0 2 0 0 0 2 0 0 0 2 2 2 2\n";
  expect_refused(refusal("points.vtk", replaced(text, "CELLS", points + "CELLS")),
                 "its section \"points_deformed\" is not known");
  expect_refused(refusal("data.vtk", replaced(text, "CELL_DATA", "CELL_DATAX")), "\"cell_datax\"");
  expect_refused(
      refusal("cells.vtk", replaced(text, "CELL_TYPES", "CELLS_old 1 5\n4 0 1 2 4\nCELL_TYPES")),
      "\"cells_old\"");
  const std::string twice = "FIELD f 2\nE 1 3 double\n1 1 1\n%45 1 3 double\n2 2 2\nPOINT_DATA";
  expect_refused(refusal("name.vtk", replaced(text, "POINT_DATA", twice)),
                 "the array \"E\" of its CELL_DATA is given twice");
  const std::string words =
      "FIELD f 3\nNULL_ARRAY\ns 1 3 string\none%20text\n\nthree\nb 1 3 bit\n0 1 1\nPOINT_DATA";
  EXPECT_EQ(refusal("words.vtk", replaced(text, "POINT_DATA", words)), "(accepted)");
}

// VTK keeps the lowest bits of numbers that their type does not hold.
TEST_F(VtkReader, LegacyTextHasNumbersOfItsTypes) {
  const auto with_data = [&](const std::string& type, const std::string& values) {
    return refusal("data.vtk",
                   replaced(kLegacyText, "POINT_DATA",
                            "FIELD f 1\nE 1 3 " + type + "\n" + values + "\nPOINT_DATA"));
  };
  expect_refused(with_data("unsigned_char", "1 257 2"),
                 "\"257\" in its array \"E\" is not a number from 0 to 255");
  expect_refused(with_data("char", "1 -129 2"), "not a number from -128 to 127");
  expect_refused(with_data("unsigned_short", "1 2 -1"), "not a number from 0 to 65535");
  expect_refused(with_data("unsigned_int", "-1 2 1"), "not a number from 0 to 4294967295");
  expect_refused(with_data("int", "1 2 3.5"), "\"3.5\" in its array \"E\"");
  EXPECT_EQ(with_data("unsigned_char", "0 255 1"), "(accepted)");
  EXPECT_EQ(with_data("double", "1e6 .5 -3"), "(accepted)");
}

// Texts and bits in binary files, behind which arrays are found that are given twice.
TEST_F(VtkReader, LegacyBinaryTextsAndBitsAreFollowed) {
  using namespace std::string_literals;
  const std::string head =
      "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n";
  const std::string one = "\x3f\x80\0\0"s;
  const std::string zero(4, '\0');
  std::string mesh =
      head + zero + zero + zero + one + zero + zero + zero + one + zero + zero + zero + one;
  mesh += "\nCELLS 1 5\n"s + "\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3"s;
  mesh += "\nCELL_TYPES 1\n"s + "\0\0\0\x0a"s + "\nCELL_DATA 1\n";
  const std::string number = " 1 1 float\n" + one + "\n";
  const std::string bits = "b 1 1 bit\n\x80\n";
  const std::string words = "s 1 1 string\n\xc3\nE \n"s;
  EXPECT_EQ(refusal("good.vtk", mesh + "FIELD f 3\n" + bits + words + "E" + number), "(accepted)");
  expect_refused(refusal("bits.vtk", mesh + "FIELD f 3\n" + bits + "E" + number + "E" + number),
                 "\"E\" of its CELL_DATA is given twice");
  expect_refused(refusal("words.vtk", mesh + "FIELD f 3\n" + words + "E" + number + "E" + number),
                 "\"E\" of its CELL_DATA is given twice");
}

TEST_F(VtkReader, RealNumbersOfElementsAreNoArray) {
  VtuText vtu;
  vtu.cell_data = array("Float64", "element_id", "7 8 9");
  vtu.point_data = array("Float64", "vertex_id", "1 2 3 4 5");
  const RawMesh mesh = read("real.vtu", vtu.text());
  EXPECT_EQ(mesh.cell_arrays.count("element_id"), 0U);
  EXPECT_EQ(mesh.point_arrays.count("vertex_id"), 0U);
}

}  // namespace
}  // namespace tetraction
