// Files that are broken on purpose or by accident: each is read, or refused with one short message
// that names the file and the place. The small files are those from which the fuzzers begin.
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <regex>

#include "io/text/csv_table.h"
#include "support/folder_test.h"
#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/mesh/mesh_checks.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

constexpr const char* kAccepted = "accepted";

class HostileFiles : public FolderTest {
 protected:
  // A file of the corpus with the ending by which its reader is chosen.
  std::string corpus(const std::string& reader, const std::string& name,
                     const std::string& ending) const {
    const fs::path from = fs::path(TETRACTION_TEST_DATA) / "../fuzz/corpus" / reader / name;
    EXPECT_TRUE(fs::exists(from)) << from;
    return file("file" + ending, contents(from));
  }
  template <class Read>
  static std::string answer(const Read& read) {
    try {
      read();
    } catch (const FileError& error) {
      return error.what();
    } catch (const InputError& error) {
      return error.what();
    }
    return kAccepted;
  }
  static std::string answer_of_mesh(const std::string& name) {
    return answer([&] { EXPECT_GT(read_mesh(name).total_volume(), 0.0); });
  }
  static std::string answer_of_scene(const std::string& name) {
    return answer([&] { read_scene(name); });
  }
  static std::string answer_of_table(const std::string& name) {
    return answer([&] { read_csv(name); });
  }
};

void expect_part(const std::string& message, const std::string& part) {
  if (part == kAccepted) {
    EXPECT_EQ(message, kAccepted);
  } else {
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n does not say: " << part;
  }
  EXPECT_LT(message.size(), 700U);
  // The name of the temporary folder has six characters that are drawn by chance.
  EXPECT_FALSE(std::regex_search(message, std::regex("0x[0-9a-f]{7}")))
      << "the address of an object: " << message;
  EXPECT_TRUE(std::all_of(message.begin(), message.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20;
  })) << message;
}

struct Kind {
  const char* name;
  const char* answer;  // a part of the message
};

TEST_F(HostileFiles, Gmsh) {
  for (const auto& [name, part] : std::initializer_list<Kind>{
           {"empty.msh", "is not a Gmsh mesh"},
           {"version1.msh", kAccepted},
           {"version20_names.msh", kAccepted},
           {"version40.msh", "MSH format 4.0, which is not read"},
           {"22_ascii.msh", kAccepted},
           {"blocks41.msh", kAccepted},
           {"blocks41_crlf.msh", kAccepted},
           {"binary22_little.msh", kAccepted},
           {"binary22_big.msh", kAccepted},
           {"41_binary.msh", kAccepted},
           {"binary41_big.msh", kAccepted},
           {"tags_from_zero.msh", kAccepted},
           {"tags_sparse.msh", kAccepted},
           {"mixed.msh", kAccepted},
           {"twice.msh", kAccepted},
           {"element_data.msh", kAccepted},
           {"entity_repeated.msh", "in $Entities: entity 1 of dimension 3 is given a second time"},
           {"many_physicals.msh", "an entity has 101 physical tags"},
           {"vertex_twice.msh", "element 1 has vertex 3 twice"},
           {"flat.msh", "element 1 has no volume"},
           {"nearly_flat.msh", "element 1 has no volume"},
           {"thin.msh", kAccepted},
           {"huge_count.msh", ":5: in $Nodes: the number of nodes is 99999999999, which"},
           {"negative_count.msh", ":5: in $Nodes: the number of nodes is -4, which"},
           {"count_too_small.msh", "\"2\" where $EndElements is expected"},
           {"count_too_large.msh", "\"$EndElements\" is not an element number"},
           {"nan.msh", "vertex 3 (of element 1) has a coordinate that is not finite"},
           {"index_out_of_range.msh", "element 1 refers to vertex 9, which the file does not"},
           {"index_negative.msh", "element 1 refers to vertex -4"},
           {"vertex_defined_twice.msh", "vertex 2 is defined twice"},
           {"no_tetrahedra.msh", "the mesh holds no tetrahedra (only 1 of type triangle)"},
           {"no_cells.msh", "the mesh holds no tetrahedra (no cells at all)"},
           {"escapes.msh", "\"\\x1b[31mred\\x07\\x00\\xff\" is not a coordinate"}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("gmsh", name, ".msh")), part);
  }
}

TEST_F(HostileFiles, VtuAndVtk) {
  for (const auto& [name, part] : std::initializer_list<Kind>{
           {"empty", "is not a VTU file"},
           {"text", kAccepted},
           {"text_crlf", kAccepted},
           {"base64_little", kAccepted},
           {"base64_big", kAccepted},
           {"base64_ids64", kAccepted},
           {"base64_bad", "the file cannot be read as a VTK unstructured grid"},
           {"zlib", kAccepted},
           {"zlib_bad", "has fewer bytes than it announces, or some that are not base64"},
           {"appended", kAccepted},
           {"huge_counts", "NumberOfPoints is \"99999999999\""}}) {
    SCOPED_TRACE(name);
    const std::string vtu = corpus("vtu", name, ".vtu");
    expect_part(answer_of_mesh(vtu), part);
    expect_part(answer([&] { read_frame(vtu, {"displacement"}); }), part);
  }
  for (const auto& [name, part] :
       std::initializer_list<Kind>{{"empty", "is not a legacy VTK file"},
                                   {"text", kAccepted},
                                   {"crlf", kAccepted},
                                   {"version5", kAccepted},
                                   {"binary", kAccepted},
                                   {"other_data_set", "holds a data set of type \"POLYDATA\""}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("vtk", name, ".vtk")), part);
  }
}

TEST_F(HostileFiles, VegaScenesAndTables) {
  for (const auto& [name, part] :
       std::initializer_list<Kind>{{"empty", "the file has no *VERTICES section"},
                                   {"plain", kAccepted},
                                   {"sets", "there is a second set \"low\" with other elements"},
                                   {"crlf", kAccepted},
                                   {"include", "*INCLUDE is not read"},
                                   {"cubes", "only 1 of type hexahedron"}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("vega", name, ".veg")), part);
  }
  for (const auto& [name, part] :
       std::initializer_list<Kind>{{"empty", "is missing"},
                                   {"deep", "nested"},
                                   {"loads", kAccepted},
                                   {"escapes", "\"be\\x1b[31mam\\x07\" is unknown"}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_scene(corpus("scene", name, ".toml")), part);
  }
  for (const auto& [name, part] :
       std::initializer_list<Kind>{{"empty", "the file has no line of numbers"},
                                   {"amplitude", kAccepted},
                                   {"field", kAccepted},
                                   {"spaces", kAccepted},
                                   {"semicolons", kAccepted},
                                   {"decimal_commas", "has semicolons and commas"},
                                   {"nan", ":1: \"nan\" is not a finite number"}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_table(corpus("table", name, ".csv")), part);
  }
}

// Ambiguous files are refused, in text and in binary, with the word that names the trouble.
TEST_F(HostileFiles, AmbiguousGmsh) {
  for (const auto& [name, part] : std::initializer_list<Kind>{
           {"element_twice.msh", "element 1 is defined twice, with different vertices"},
           {"binary22_element_twice.msh", "element 1 is defined twice, with different vertices"},
           {"element_data_several_times.msh", "there are several arrays \"E\""},
           {"binary22_data_several_times.msh", "there are several arrays \"E\""},
           {"element_data_row_twice.msh", "the array \"E\" has element 1 twice"},
           {"binary22_data_row_twice.msh", "the array \"E\" has element 1 twice"},
           {"node_data_row_twice.msh", "the array \"u\" has node 1 twice"},
           {"number_of_two_kinds.msh", "element 1, but several elements have this number"},
           {"named_twice.msh", "in $PhysicalNames: physical group 1 has two names"},
           {"names_twice.msh", "there is a second $PhysicalNames section, and twice is ambiguous"},
           {"parametric_twice.msh", "there is a second $ParametricNodes section"},
           {"version1_twice.msh", "there is a second $NOD section, and twice is ambiguous"},
           {"ghost22.msh", "in $Elements: element 2 is a ghost in partition 2"},
           {"binary22_ghost.msh", "in $Elements: element 2 is a ghost in partition 2"},
           {"ghost41.msh", "in $GhostElements: the file has 1 ghost elements"},
           {"binary41_ghost.msh", "in $GhostElements: the file has 1 ghost elements"},
           {"ghost_entities41.msh", "in $PartitionedEntities: the file has 1 entities of ghost"},
           {"element_twice41.msh", "in $Elements: tetrahedron 1 is given twice"},
           {"other_dimension41.msh",
            "elements of dimension 3 stand under an entity of dimension 2"},
           {"entity_missing41.msh", "entity 7 of dimension 3 has elements and is not among"},
           {"entities_last41.msh", "in $Entities: it must come before $Elements"},
           {"partitions22.msh", kAccepted},
           {"partitioned41.msh", kAccepted},
           {"binary41_partitioned.msh", kAccepted},
           {"same_name.msh", kAccepted},
           {"names_last.msh", kAccepted},
           {"node_data.msh", kAccepted},
           {"binary22_node_data.msh", kAccepted},
           {"parametric22.msh", kAccepted},
           {"byte_order_mark.msh", kAccepted}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("gmsh", name, ".msh")), part);
  }
}

TEST_F(HostileFiles, AmbiguousVtu) {
  for (const std::string mode : {"ascii", "base64", "raw", "zlib", "zlibraw"}) {
    SCOPED_TRACE(mode);
    const auto answer_of = [&](const std::string& name) {
      return answer_of_mesh(corpus("vtu", name + mode, ".vtu"));
    };
    const bool in_text = mode == "ascii";
    expect_part(answer_of("exact_"), kAccepted);
    expect_part(answer_of("array_long_"),
                in_text ? "its array \"E\" has 3 numbers, but there are 2 cells"
                        : "its array \"E\" has more than the 2 numbers");
    expect_part(answer_of("points_long_"),
                in_text ? "\"Points\" has 16 numbers, but there are 5 points of 3 numbers"
                        : "its array \"Points\" has more than the 15 numbers");
    expect_part(answer_of("types_long_"), in_text ? "its array \"types\" has 3 numbers"
                                                  : "its array \"types\" has more than the 2");
    expect_part(answer_of("connectivity_long_"),
                in_text ? "\"connectivity\" has 9 numbers, but its offsets"
                        : "\"connectivity\" has more than the 8");
    expect_part(answer_of("type_266_"),
                in_text ? "\"266\" in its array \"types\" is not a number from 0"
                        : "the type 266 of cell 1 is not a number from 0");
  }
  for (const std::string mode : {"ascii", "raw"}) {
    SCOPED_TRACE(mode);
    for (const auto& [name, part] : std::initializer_list<Kind>{
             {"array_twice_", "the array \"E\" of its <CellData> is given twice"},
             {"vertex_id_twice_", "its point data \"vertex_id\" have the number 2 twice"},
             {"element_id_twice_", "its cell data \"element_id\" have the number 7 twice"},
             {"ghost_", "cell 1 is marked as a ghost or as hidden by its array \"vtkGhostType\""},
             {"ghost_points_", "point 3 is marked as a ghost"},
             {"ghost_none_", kAccepted},
             {"pieces_differ_", "its pieces have different arrays"},
             {"pieces_alike_", kAccepted},
             {"lagrange_", kAccepted}}) {
      SCOPED_TRACE(name);
      expect_part(answer_of_mesh(corpus("vtu", name + mode, ".vtu")), part);
    }
  }
  for (const auto& [name, part] : std::initializer_list<Kind>{
           {"type_266_byte", "\"266\" in its array \"types\" is not a number from 0 to 255"},
           {"region_300_byte", "\"300\" in its array \"region\" is not a number from 0 to 255"},
           {"section_twice", "the section <CellData> is given twice"},
           {"no_cells", "VTK: A piece is missing its Cells element"},
           {"bezier_order_2", "cell 0 is a Bezier tetrahedron of order 2 or more"},
           {"lagrange_order_2", kAccepted},
           {"comments", kAccepted}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("vtu", name, ".vtu")), part);
  }
}

TEST_F(HostileFiles, AmbiguousLegacyVtk) {
  for (const std::string mode : {"text_", "binary_"}) {
    SCOPED_TRACE(mode);
    for (const auto& [name, part] : std::initializer_list<Kind>{
             {"points_twice", "POINTS is given twice"},
             {"cells_twice", "CELLS is given twice"},
             {"array_twice", "the array \"E\" of its CELL_DATA is given twice"},
             {"field_twice", "the array \"E\" of its CELL_DATA is given twice"},
             {"type_266", "the type 266 of cell 1 is not a number from 0 to 255"},
             {"fields", kAccepted}}) {
      SCOPED_TRACE(name);
      expect_part(answer_of_mesh(corpus("vtk", mode + name, ".vtk")), part);
    }
  }
}

TEST_F(HostileFiles, AmbiguousVegaAndTetgen) {
  for (const auto& [name, part] : std::initializer_list<Kind>{
           {"vertices_twice", "there is a second *VERTICES section, and twice"},
           {"element_twice", "element 1 is defined twice"},
           {"byte_order_mark", kAccepted}}) {
    SCOPED_TRACE(name);
    expect_part(answer_of_mesh(corpus("vega", name, ".veg")), part);
  }
  const auto tetgen = [&](const std::string& name) {
    std::string text = contents(fs::path(TETRACTION_TEST_DATA) / "../fuzz/corpus/tetgen" / name);
    for (const char* ending : {".node", ".ele", ".face"}) {
      const std::string between = "\n%\n";
      const std::string part = text.substr(0, text.find(between));
      text.erase(0, std::min(text.size(), part.size() + between.size()));
      if (!part.empty()) file(name + ending, part);
    }
    return path(name + ".node");
  };
  expect_part(answer_of_mesh(tetgen("element_twice")), "element 1 is defined twice");
  const std::string marked = tetgen("byte_order_mark");
  std::vector<std::string> unused;
  EXPECT_EQ(read_mesh(marked, 1.0, unused).groups.at(0).name, "5");
  EXPECT_EQ(unused, (std::vector<std::string>{"1 attributes of each point",
                                              "the boundary markers of the points",
                                              "all attributes of the tetrahedra but the first"}));
}

// A partition has the groups of what it was cut from; the border between two of them has none.
TEST_F(HostileFiles, PartitionedMeshesKeepTheirGroups) {
  for (const char* name : {"partitioned41.msh", "binary41_partitioned.msh"}) {
    SCOPED_TRACE(name);
    std::vector<std::string> unused;
    const TetMesh mesh = read_mesh(corpus("gmsh", name, ".msh"), 1.0, unused);
    ASSERT_EQ(mesh.groups.size(), 2U);
    EXPECT_EQ(mesh.groups[0].name, "clamp");
    EXPECT_EQ(select_triangles(mesh, SelectGroup{"clamp"}).size(), 1U);
    EXPECT_EQ(mesh.groups[1].name, "body");
    EXPECT_EQ(mesh.groups[1].tetrahedra, (std::vector<Index>{0, 1}));
    EXPECT_EQ(mesh.regions, (std::vector<int>{9, 9}));
    EXPECT_EQ(mesh.report.skipped_cells, (std::map<CellType, Index>{{CellType::kTriangle, 1}}));
    EXPECT_EQ(unused, std::vector<std::string>{"the groups \"border\", which have no elements"});
  }
}

TEST_F(HostileFiles, ReadersSayWhatTheyDoNotUse) {
  const auto unused_of = [&](const char* reader, const char* name, const char* ending) {
    std::vector<std::string> unused;
    read_mesh(corpus(reader, name, ending), 1.0, unused);
    return unused;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(unused_of("gmsh", "names_last.msh", ".msh"),
            (Texts{"the groups \"none\", which have no elements", "the sections \"$Periodic\""}));
  EXPECT_EQ(unused_of("gmsh", "node_data.msh", ".msh"),
            Texts{"1 values of the array \"heat\", of nodes that the file does not have"});
  EXPECT_EQ(unused_of("vega", "byte_order_mark", ".veg"),
            Texts{"the materials (a scene has its own)"});
  EXPECT_EQ(unused_of("vtu", "exact_raw", ".vtu"), Texts{});
  // Names may come after the elements, and may have quotation marks.
  const TetMesh named = read_mesh(corpus("gmsh", "names_last.msh", ".msh"));
  EXPECT_EQ(named.groups.at(0).name, "soft");
  EXPECT_EQ(named.groups.at(1).name, "a \"b\" c");
  const TetMesh warm = read_mesh(corpus("gmsh", "node_data.msh", ".msh"));
  EXPECT_DOUBLE_EQ(warm.point_arrays.at("u")(0, 2), 0.3);
  EXPECT_EQ(warm.point_arrays.at("heat")(0, 0), 20.5);
  EXPECT_TRUE(std::isnan(warm.point_arrays.at("heat")(0, 1)));
}

// A name that several groups have: surfaces and volumes are told apart where only one of them can be meant.
TEST_F(HostileFiles, NamesOfSeveralGroups) {
  const TetMesh mesh = read_mesh(corpus("gmsh", "same_name.msh", ".msh"));
  EXPECT_EQ(select_tetrahedra(mesh, SelectGroup{"part"}), std::vector<Index>{0});
  EXPECT_EQ(select_triangles(mesh, SelectGroup{"part"}).size(), 1U);
  expect_part(answer([&] { select_vertices(mesh, SelectGroup{"part"}); }),
              "the group \"part\" is ambiguous, because the mesh has several of this name: \"part "
              "(dimension 2)\", \"part (dimension 3)\"");
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"part (dimension 2)"}),
            (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"part (dimension 3, tag 1)"}),
            (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(select_triangles(mesh, SelectGroup{"part (dimension 2)"}).size(), 1U);
  expect_part(answer([&] { select_vertices(mesh, SelectGroup{"part (dimension 1)"}); }),
              "the mesh has no group \"part (dimension 1)\"");

  TetMesh same = mesh;
  same.groups = {
      {"half", 3, 1, {0}, {0}}, {"half", 3, 2, {1}, {1}}, {"half (dimension 3)", 3, 9, {4}, {1}}};
  expect_part(answer([&] { select_tetrahedra(same, SelectGroup{"half"}); }),
              "\"half (dimension 3, tag 1)\", \"half (dimension 3, tag 2)\"");
  EXPECT_EQ(select_tetrahedra(same, SelectGroup{"half (dimension 3, tag 2)"}),
            std::vector<Index>{1});
  // A group of just that name comes first.
  EXPECT_EQ(select_vertices(same, SelectGroup{"half (dimension 3)"}), std::vector<Index>{4});
}

TEST_F(HostileFiles, FilesOfAnotherKindAreNamed) {
  const std::string legacy = contents(corpus("vtk", "text", ".vtk"));
  const std::string xml = contents(corpus("vtu", "text", ".vtu"));
  const std::string gmsh = contents(corpus("gmsh", "22_ascii.msh", ".msh"));
  const std::string lfs = contents(corpus("gmsh", "git_lfs.msh", ".msh"));
  for (const char* ending : {"msh", "vtu", "vtk", "veg", "node"}) {
    SCOPED_TRACE(ending);
    const std::string name = std::string("other.") + ending;
    expect_part(answer_of_mesh(file(name, lfs)), "It is a Git LFS pointer");
    expect_part(answer_of_mesh(file(name, std::string("\x1f\x8b\x08\0", 4))), "packed with gzip");
    expect_part(answer_of_mesh(file(name, "<!DOCTYPE html><html></html>")), "a web page");
  }
  expect_part(answer_of_table(file("table.csv", lfs)),
              "is not a table of numbers. It is a Git LFS");
  expect_part(answer_of_mesh(file("a.vtu", legacy)),
              "is not a VTK file in XML (.vtu). It is a legacy VTK file (.vtk).");
  expect_part(answer_of_mesh(file("a.vtk", xml)),
              "is not a legacy VTK file (.vtk). It is a VTK file in XML (.vtu).");
  expect_part(answer_of_mesh(file("a.veg", gmsh)), "It is a Gmsh mesh (.msh).");
  expect_part(answer_of_mesh(file("a.msh", std::string("\xff\xfe$\0M\0", 6))), "UTF-16");
}

// Cut at every byte, a file is refused, or it still holds the whole mesh.
TEST_F(HostileFiles, CutAtEveryByte) {
  struct Cut {
    const char* reader;
    const char* name;
    const char* ending;
  };
  for (const auto& [reader, name, ending] :
       std::initializer_list<Cut>{{"gmsh", "22_ascii.msh", ".msh"},
                                  {"gmsh", "blocks41.msh", ".msh"},
                                  {"gmsh", "41_binary.msh", ".msh"},
                                  {"gmsh", "binary22_big.msh", ".msh"},
                                  {"vega", "plain", ".veg"},
                                  {"vtu", "base64_little", ".vtu"},
                                  {"vtk", "text", ".vtk"}}) {
    SCOPED_TRACE(name);
    const std::string whole_path = corpus(reader, name, ending);
    const std::string text = contents(whole_path);
    const TetMesh whole = read_mesh(whole_path);
    std::size_t refused = 0;
    for (std::size_t size = 0; size < text.size(); ++size) {
      const std::string cut = file(std::string("cut") + ending, text.substr(0, size));
      const std::string message = answer([&] {
        const TetMesh mesh = read_mesh(cut);
        EXPECT_EQ(mesh.tetrahedra, whole.tetrahedra) << "cut at " << size;
      });
      if (message == kAccepted) continue;
      EXPECT_EQ(message.find(cut), 0U) << message;
      ++refused;
    }
    EXPECT_GT(refused, text.size() / 4);
  }
}

TEST_F(HostileFiles, EveryOrderOfTheVerticesGivesAPositiveVolume) {
  std::array<int, 4> order{1, 2, 3, 4};
  Index reoriented = 0;
  do {
    std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "$EndNodes\n$Elements\n1\n1 4 0";
    for (const int v : order) text += fmt::format(" {}", v);
    const TetMesh mesh = read_mesh(file("order.msh", text + "\n$EndElements\n"));
    EXPECT_NEAR(mesh.volume(0), 1.0 / 6.0, 1e-15);
    reoriented += mesh.report.reoriented;
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(reoriented, 12);
}

// The first of several tetrahedra with the same vertices is taken, for the groups of all: Gmsh's version 2
// writes an element once for each of its groups.
TEST_F(HostileFiles, RepeatedTetrahedraAreTakenOnce) {
  const TetMesh mesh = read_mesh(corpus("gmsh", "twice.msh", ".msh"));
  EXPECT_EQ(mesh.tetrahedron_ids, std::vector<std::int64_t>{1});
  EXPECT_EQ(mesh.report.skipped_cells.at(CellType::kTetrahedron), 1);
  ASSERT_EQ(mesh.groups.size(), 2U);
  EXPECT_EQ(mesh.groups[0].tetrahedra, std::vector<Index>{0});
  EXPECT_EQ(mesh.groups[1].tetrahedra, std::vector<Index>{0});
  EXPECT_EQ(mesh.regions, std::vector<int>{5});
}

// Thousands of parts, each in a group of its own; a part that is there twice is noticed.
TEST_F(HostileFiles, ThousandsOfParts) {
  constexpr int kParts = 3000;
  std::string nodes;
  std::string elements;
  for (int p = 0; p < kParts; ++p) {
    const int x = 2 * std::min(p, kParts - 2);  // the last part is where the one before is
    for (int v = 0; v < 4; ++v) {
      nodes += std::to_string(4 * p + v + 1) + " " + std::to_string(x + (v == 1 ? 1 : 0)) + " " +
               (v == 2 ? "1 " : "0 ") + (v == 3 ? "1\n" : "0\n");
    }
    elements += std::to_string(p + 1) + " 4 2 " + std::to_string(p + 1) + " 1";
    for (int v = 0; v < 4; ++v) elements += fmt::format(" {}", 4 * p + v + 1);
    elements += "\n";
  }
  const TetMesh mesh = read_mesh(
      file("parts.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" +
                            std::to_string(4 * kParts) + "\n" + nodes + "$EndNodes\n$Elements\n" +
                            std::to_string(kParts) + "\n" + elements + "$EndElements\n"));
  EXPECT_EQ(mesh.tetrahedron_count(), kParts);
  EXPECT_EQ(mesh.groups.size(), static_cast<std::size_t>(kParts));
  EXPECT_EQ(coincident_vertices(mesh), 4);
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"2000"}).size(), 4U);
  expect_part(answer([&] { select_vertices(mesh, SelectGroup{"no such group"}); }),
              "it has \"1\", \"2\"");
}

TEST_F(HostileFiles, LongInputIsQuotedInPart) {
  const std::string word(1'000'000, 'w');
  const std::string start =
      "[mesh]\ngenerate = { kind = \"beam\", size = [1, 1, 1], cells = [1, 1, 1] }\n";
  const std::vector<std::string> messages{
      answer_of_mesh(file("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + word)),
      answer_of_mesh(file("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + word)),
      answer_of_mesh(file("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$" + word)),
      answer_of_mesh(file("a.veg", word)),
      answer_of_mesh(file("a.veg", "*ELEMENTS\n" + word)),
      answer_of_mesh(file("a.node", word)),
      answer_of_mesh(file("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET " + word)),
      answer_of_mesh(file("a.vtu", "<VTKFile type=\"" + word + "\">")),
      answer_of_mesh(path("a." + word)),
      answer_of_table(file("a.csv", "0,0\n1," + word)),
      answer_of_scene(file("a.toml", word + " = 1\n")),
      answer_of_scene(file("a.toml", word)),
      answer_of_scene(file("a.toml", fmt::format("[{0}]\n[{0}]\n", word))),
      answer_of_scene(file("a.toml", "[material]\nmodel = \"" + word + "\"\n" + start)),
      answer_of_scene(file("a.toml", "[time]\nstep = \"" + word + "\"\n" + start)),
      answer_of_scene(file("a.toml", "[[fix]]\nselect = \"" + word + "\"\n" + start)),
      answer_of_scene(file("a.toml", "[initial]\nvelocity = { formula = [\"" + word +
                                         "\", \"0\", \"0\"] }\n" + start)),
      answer([&] { read_scene(file("a.toml", start), {"time.step=" + word}); }),
      answer([&] { read_scene(file("a.toml", start), {word + "=1"}); }),
      answer([&] { read_scene(file("a.toml", start), {word}); })};
  for (const std::string& message : messages) {
    EXPECT_NE(message, kAccepted);
    EXPECT_LT(message.size(), 1500U) << message.substr(0, 2000);
  }
}

TEST_F(HostileFiles, ScenesHaveNoCharacterZero) {
  expect_part(answer_of_scene(file("zero.toml", "[mesh]\nfile = \"a\\u0000b.msh\"\n")),
              "zero.toml:2: there is a character with the code zero");
  expect_part(answer_of_scene(file("zero.toml", std::string("a = \"\0\"\n", 8))), "not valid TOML");
}

// A pipe, a device or a folder is refused at once: opening a pipe would wait for a writer.
TEST_F(HostileFiles, OnlyRegularFilesAreRead) {
  const auto pipe = [&](const std::string& name) {
    EXPECT_EQ(mkfifo(path(name).c_str(), 0600), 0);
    return path(name);
  };
  const auto link = [&](const std::string& name) {
    fs::create_symlink("/dev/zero", path(name));
    return path(name);
  };
  for (const char* ending : {"msh", "vtu", "vtk", "veg", "node"}) {
    const std::string name = std::string("pipe.") + ending;
    expect_part(answer_of_mesh(pipe(name)), "not a regular file");
    fs::remove(path(name));
    expect_part(answer_of_mesh(link(std::string("device.") + ending)), "not a regular file");
  }
  file("half.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
  pipe("half.ele");
  expect_part(answer_of_mesh(path("half.node")), "half.ele: is not a regular file");
  expect_part(answer_of_scene(pipe("scene.toml")), "not a regular file");
  expect_part(answer_of_scene(link("device.toml")), "not a regular file");
  expect_part(answer_of_table(pipe("table.csv")), "not a regular file");
  expect_part(answer_of_table(folder_.string()), "not a regular file");
  expect_part(answer([&] { read_frame(pipe("frame.vtu"), {}); }), "not a regular file");
}

// A hundred gigabytes of holes: the size is looked at before anything is allocated.
TEST_F(HostileFiles, FilesThatAreTooLargeAreNotRead) {
  for (const char* name : {"sparse.msh", "sparse.vtu", "sparse.vtk", "sparse.veg", "sparse.node"}) {
    file(name, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n");
    fs::resize_file(path(name), 100'000'000'000U);
    expect_part(answer_of_mesh(path(name)), "has 1e+05 MB, and at most ");
    fs::remove(path(name));
  }
  file("sparse.csv", "0,0\n");
  fs::resize_file(path("sparse.csv"), 1'000'000'000U);
  expect_part(answer_of_table(path("sparse.csv")), "has 1000 MB");
  file("sparse.toml", "");
  fs::resize_file(path("sparse.toml"), 100'000'000'000U);
  expect_part(answer_of_scene(path("sparse.toml")), "larger than 64 MiB");
}

// Paths of meshes, amplitudes and fields start at the scene's folder, not at the working directory.
TEST_F(HostileFiles, PathsStartAtTheScenesFolder) {
  fs::create_directories(path("inner"));
  file("part.msh",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
       "$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n");
  file("load.csv", "0,0\n1,2\n");
  file("inner/start.csv", "1,2,3\n1,2,3\n1,2,3\n1,2,3\n");
  const std::string scene_path = file("inner/scene.toml",
                                      "[mesh]\nfile = \"../part.msh\"\n"
                                      "[material]\nyoungs_modulus = 1e5\npoissons_ratio = 0.3\n"
                                      "[time]\nstep = 1e-3\nend = 1e-2\n"
                                      "[initial]\nvelocity = { file = \"start.csv\" }\n"
                                      "[[amplitude]]\nname = \"load\"\nfile = \"../load.csv\"\n");
  const fs::path before = fs::current_path();
  fs::current_path("/");
  const Scene scene = read_scene(scene_path);
  fs::current_path(before);
  EXPECT_EQ(fs::weakly_canonical(scene.mesh.file), fs::weakly_canonical(path("part.msh")));
  EXPECT_EQ(scene.amplitude.at(0).points.back().second, 2.0);
  EXPECT_EQ(read_scene_mesh(scene).point_arrays.at(kInitialVelocity).col(3), Vector3(1, 2, 3));
}

// A first line with a number in it is no header, so that no row is lost.
TEST_F(HostileFiles, OnlyALineWithoutNumbersIsAHeader) {
  expect_part(answer_of_table(file("a.csv", "O,5\n0.01,1\n1,1\n")),
              ":1: \"O\" is not a finite number");
  expect_part(answer_of_table(file("b.csv", "1e400,1\n0,3\n")), ":1: \"1e400\" is not a finite");
  expect_part(answer_of_table(file("c.csv", "t,value\n0,3\n")), kAccepted);
}

}  // namespace
}  // namespace tetraction
