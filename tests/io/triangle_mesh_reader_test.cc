// The readers of surfaces of triangles, also with broken files.
#include "io/mesh/triangle_mesh_reader.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "dynamics/contact/mesh/triangle_mesh.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

std::string surface_file(const std::string& name, const std::string& text) {
  static const testing_support::TemporaryFolder folder;
  const std::string path = (folder.path() / name).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string surface_refusal(const std::string& path) {
  try {
    read_triangle_file(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// A tetrahedron.
constexpr double kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

std::string stl_text() {
  std::string text = "solid a name with spaces\n";
  for (const auto& face : kFaces) {
    text += "  facet normal nan 0 0\n    outer loop\n";
    for (const int i : face) {
      text += "      vertex";
      for (const double x : kCorners[i]) text += " " + std::to_string(x);
      text += "\n";
    }
    text += "    ENDLOOP\n  endfacet\n";
  }
  return text + "endsolid a name with spaces\n";
}

std::string stl_bytes() {
  std::string bytes = "solid that is none: binary files begin as they like";
  bytes.resize(80, ' ');
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(std::uint32_t{4});
  for (const auto& face : kFaces) {
    for (int k = 0; k < 3; ++k) put(0.0F);
    for (const int i : face) {
      for (const double x : kCorners[i]) put(static_cast<float>(x));
    }
    put(std::uint16_t{0});
  }
  return bytes;
}

std::string obj_text() {
  return "# a comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nv 0 0 1 0.5 0.5 0.5\n"
         "vn 0 0 1\nvt 0 0\ng side\ns off\nf 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1 # here\n"
         "f -3 -2 -1\nf 1 4 3\n";
}

std::string vtp_text(const std::string& connectivity = "0 2 1 0 1 3 1 2 3 0 3 2") {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<PolyData><Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\" "
         "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"4\"><Points>"
         "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
         "0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Polys>"
         "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">" +
         connectivity +
         "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3 6 9 12"
         "</DataArray></Polys></Piece></PolyData>\n</VTKFile>\n";
}

std::string msh_text() {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n7 0 1 0\n4 0 0 1\n"
         "$EndNodes\n$Elements\n4\n1 2 2 0 1 1 7 2\n2 2 2 0 1 1 2 4\n3 2 2 0 1 2 7 4\n"
         "4 2 2 0 1 1 4 7\n$EndElements\n";
}

TEST(TriangleMeshReader, AllFormatsGiveTheSameSurface) {
  const std::pair<std::string, std::string> files[] = {{"text.stl", stl_text()},
                                                       {"bytes.STL", stl_bytes()},
                                                       {"a.obj", obj_text()},
                                                       {"a.vtp", vtp_text()},
                                                       {"a.msh", msh_text()}};
  for (const auto& [name, text] : files) {
    const TriangleFile file = read_triangle_file(surface_file(name, text));
    ASSERT_EQ(file.triangles.size(), 4U) << name;
    for (std::size_t t = 0; t < 4; ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3& x = file.points[static_cast<std::size_t>(file.triangles[t][k])];
        const auto& expected = kCorners[kFaces[t][k]];
        EXPECT_EQ(x, Vector3(expected[0], expected[1], expected[2])) << name << t << k;
      }
    }
    const TriangleMesh mesh(file.points, file.triangles);
    EXPECT_TRUE(mesh.watertight()) << name;
    EXPECT_EQ(mesh.points().size(), 4U) << name;
  }
}

TEST(TriangleMeshReader, TetrahedraGiveTheirBoundary) {
  const TetMesh box = generate_box({1.0, 1.5, 1.0}, {2, 3, 2});
  for (const std::string name : {"box.vtu", "box.vtk", "box.msh"}) {
    const std::string path = surface_file(name, "");
    write_mesh(box, path);
    const TriangleFile file = read_triangle_file(path);
    EXPECT_EQ(file.triangles.size(), 64U) << name;
    const TriangleMesh mesh(file.points, file.triangles);
    EXPECT_TRUE(mesh.watertight()) << name;
    EXPECT_EQ(mesh.sharp_edges().size(), 28U) << name;
  }
}

TEST(TriangleMeshReader, PolygonsBecomeTriangles) {
  const TriangleFile quad = read_triangle_file(
      surface_file("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  ASSERT_EQ(quad.triangles.size(), 2U);
  EXPECT_EQ(quad.triangles[1], (std::array<Index, 3>{0, 2, 3}));
}

TEST(TriangleMeshReader, RefusesBrokenFilesWithOneMessage) {
  const std::pair<std::string, std::string> files[] = {
      {"nothing.stl", ""},
      {"page.stl", "<html></html>"},
      {"empty.stl", "solid x\nendsolid x\n"},
      {"cut.stl", stl_text().substr(0, 200)},
      {"word.stl", "solid x\nfacet normel 0 0 1\n"},
      {"number.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\nvertex 1 0 0\nvertex 0 1 0\n"},
      {"infinite.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 inf\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid\n"},
      {"short.stl", stl_bytes().substr(0, 150)},
      {"long.stl", stl_bytes() + "x"},
      {"few.stl", "x"},
      {"far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"},
      {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"},
      {"back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n"},
      {"two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n"},
      {"letter.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3x\n"},
      {"point.obj", "v 0 0\n"},
      {"unknown.obj", "curv 1 2 3\n"},
      {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
      {"stl.obj", stl_text()},
      {"far.vtp", vtp_text("0 2 1 0 1 3 1 2 3 0 3 4")},
      {"few.vtp", vtp_text("0 2 1")},
      {"cut.vtp", vtp_text().substr(0, 500)},
      {"other.vtp", "<VTKFile type=\"UnstructuredGrid\"></VTKFile>"},
      {"none.vtp", "hello"},
      {"cut.msh", msh_text().substr(0, 100)},
      {"a.ply", "ply\n"},
      {"noending", "solid\n"},
  };
  for (const auto& [name, text] : files) {
    const std::string path = surface_file(name, text);
    const std::string message = surface_refusal(path);
    EXPECT_FALSE(message.empty()) << name;
    EXPECT_NE(message.find(name), std::string::npos) << name << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_NE(surface_refusal("/nowhere/x.stl").find("no such file"), std::string::npos);
  EXPECT_THROW(read_triangle_file("/nowhere/x.ply"), InputError);
  EXPECT_THROW(read_triangle_file("/nowhere/x.obj"), FileError);
}

// Each file cut and with changed bytes: read or refused, never a crash, and no number out of range.
TEST(TriangleMeshReader, SurvivesDamage) {
  std::mt19937 random(51);
  const std::pair<std::string, std::string> files[] = {
      {"d.stl", stl_text()}, {"e.stl", stl_bytes()}, {"d.obj", obj_text()}, {"d.msh", msh_text()}};
  int refused = 0;
  for (const auto& [name, text] : files) {
    for (int trial = 0; trial < 300; ++trial) {
      std::string damaged = text;
      if (trial % 2 == 0) damaged.resize(random() % text.size());
      for (int k = 0; k < 3 && !damaged.empty(); ++k) {
        damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
      }
      const std::string path = surface_file(name, damaged);
      try {
        const TriangleFile file = read_triangle_file(path);
        for (const auto& t : file.triangles) {
          for (const Index i : t) {
            ASSERT_GE(i, 0);
            ASSERT_LT(i, static_cast<Index>(file.points.size()));
          }
        }
      } catch (const FileError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 400);
  for (int trial = 0; trial < 12; ++trial) {
    std::string damaged = vtp_text();
    damaged[200 + random() % (damaged.size() - 220)] = static_cast<char>('0' + random() % 70);
    const std::string path = surface_file("d.vtp", damaged);
    try {
      read_triangle_file(path);
    } catch (const FileError&) {
    }
  }
}

}  // namespace
}  // namespace tetraction
