// Files that are broken on purpose or by accident: each is read, or refused with one short message
// that names the file and the place. The small files are those from which the fuzzers begin.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/text/csv_table.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/mesh/mesh_checks.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAccepted = "accepted";

std::string contents(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class HostileFiles : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (temporary_.path() / name).string(); }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }
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

  testing_support::TemporaryFolder temporary_;
};

void expect_part(const std::string& message, const std::string& part) {
  if (part == kAccepted) {
    EXPECT_EQ(message, kAccepted);
  } else {
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n does not say: " << part;
  }
  EXPECT_LT(message.size(), 700U);
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
           {"zlib_bad", "the file cannot be read as a VTK unstructured grid"},
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

// Of tetrahedra with the same vertices the first is taken, for the groups of both: Gmsh's version 2
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
  expect_part(answer_of_table(temporary_.path().string()), "not a regular file");
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

}  // namespace
}  // namespace tetraction
