#include "tetraction/io/frame_writer.h"

#include <sys/resource.h>
#include <sys/wait.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/folder_test.h"
#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/obstacle_surface.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

class FrameWriterTest : public FolderTest {
 protected:
  void SetUp() override {
    mesh_ = generate_box({2, 1, 1}, {2, 1, 1});
    for (auto& id : mesh_.vertex_ids) id += 100;
    for (auto& id : mesh_.tetrahedron_ids) id = 900 - id;
  }

  Frame frame(Index step, double time) const {
    Frame result;
    result.step = step;
    result.time = time;
    const double s = static_cast<double>(step + 1);
    result.point_fields.push_back(
        {"displacement", s / 3.0 * Matrix::Random(3, mesh_.vertex_count()), false});
    result.point_fields.push_back({"fixed", Matrix::Ones(1, mesh_.vertex_count()), true});
    result.cell_fields.push_back(
        {"cauchy_stress", s * Matrix::Random(6, mesh_.tetrahedron_count()), false});
    result.cell_fields.push_back(
        {"region", Matrix::Constant(1, mesh_.tetrahedron_count(), 4.0), true});
    return result;
  }

  // The value of the n-th attribute of that name in an XML text.
  static std::string attribute(const std::string& text, const std::string& name, int n) {
    std::size_t at = 0;
    for (int i = 0; i <= n; ++i) {
      at = text.find(" " + name + "=\"", at);
      if (at == std::string::npos) return "";
      at += name.size() + 3;
    }
    return text.substr(at, text.find('"', at) - at);
  }
  TetMesh mesh_;
};

TEST_F(FrameWriterTest, FramesReadBackExactlyWithTheFilesIds) {
  FrameWriter writer(mesh_, folder_.string());
  const Frame written = frame(20, 0.1);
  writer.write(written);
  const fs::path file = folder_ / "frames/frame_000020.vtu";
  const TetMesh read = read_mesh(file.string());
  EXPECT_EQ(read.tetrahedra, mesh_.tetrahedra);
  EXPECT_EQ(read.vertex_ids, mesh_.vertex_ids);
  EXPECT_EQ(read.tetrahedron_ids, mesh_.tetrahedron_ids);
  EXPECT_EQ(read.regions, std::vector<int>(mesh_.tetrahedra.size(), 4));
  for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
    EXPECT_EQ(read.vertices[v], mesh_.vertices[v]);
  }
  ASSERT_EQ(read.point_arrays.count("displacement"), 1u);
  EXPECT_EQ(read.point_arrays.at("displacement"), written.point_fields[0].values);
  EXPECT_EQ(read.point_arrays.count("fixed"), 0u) << "an integer array came back as real numbers";
}

TEST_F(FrameWriterTest, FilesNameComponentsTimeAndCompression) {
  FrameWriter writer(mesh_, folder_.string());
  writer.write(frame(0, 0.0));
  const std::string text = contents(folder_ / "frames/frame_000000.vtu");
  for (const char* part : {"Name=\"TimeValue\"", "Name=\"cauchy_stress\" NumberOfComponents=\"6\"",
                           R"(ComponentName0="XX" ComponentName1="YY" ComponentName2="ZZ")",
                           R"(ComponentName3="XY" ComponentName4="YZ" ComponentName5="XZ")",
                           "vtkLZ4DataCompressor", "encoding=\"raw\"", "Name=\"vertex_id\"",
                           "Name=\"element_id\"", "type=\"Int32\" Name=\"fixed\""}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

// VTK's usual blocks of 32 KiB would leave a page of the system's cache of files half filled after each of them.
TEST_F(FrameWriterTest, ArraysAreCompressedInBlocksOfOneMebibyte) {
  mesh_ = generate_box({1, 1, 1}, {20, 20, 20});
  FrameWriter writer(mesh_, folder_.string());
  writer.write(frame(0, 0.0));
  const std::string text = contents(folder_ / "frames/frame_000000.vtu");
  // The numbers before the blocks of an array: how many blocks, their length, and that of the last one.
  const std::size_t begin = text.find('_', text.find("<AppendedData")) + 1;
  const std::size_t name = text.find("Name=\"cauchy_stress\"");
  const std::size_t offset = std::stoull(attribute(text.substr(name), "offset", 0));
  std::array<std::uint64_t, 3> head{};
  ASSERT_LE(begin + offset + sizeof(head), text.size());
  std::memcpy(head.data(), text.data() + begin + offset, sizeof(head));
  const std::size_t bytes = sizeof(double) * 6 * mesh_.tetrahedra.size();
  EXPECT_EQ(head[0], 3u);
  EXPECT_EQ(head[1], 1u << 20);
  EXPECT_EQ(head[2], bytes - (2u << 20));
}

TEST_F(FrameWriterTest, CollectionListsEveryFrameAfterEveryWrite) {
  FrameWriter writer(mesh_, folder_.string());
  EXPECT_EQ(writer.frame_count(), 0);
  const double times[] = {0.0, 0.1, 1.0 / 3.0};
  for (int i = 0; i < 3; ++i) {
    writer.write(frame(10 * i, times[i]));
    EXPECT_EQ(writer.frame_count(), i + 1);
    const std::string pvd = contents(folder_ / "frames.pvd");
    EXPECT_NE(pvd.find("type=\"Collection\""), std::string::npos);
    EXPECT_NE(pvd.find("</VTKFile>"), std::string::npos);
    for (int k = 0; k <= i; ++k) {
      EXPECT_EQ(std::strtod(attribute(pvd, "timestep", k).c_str(), nullptr), times[k]);
      const std::string file = attribute(pvd, "file", k);
      EXPECT_FALSE(fs::path(file).is_absolute());
      EXPECT_TRUE(fs::exists(folder_ / file)) << file;
    }
    EXPECT_EQ(attribute(pvd, "timestep", i + 1), "");
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".part");
  }
}

// A floor that is at rest in the first two frames and higher in the third.
TEST_F(FrameWriterTest, ObstaclesAreAPartOfTheCollectionAndAFileForEachPlace) {
  std::string kept;
  std::vector<std::uint64_t> sizes;
  const auto frame_with_floor = [&](int i) {
    Frame result = frame(10 * i, 0.1 * i);
    auto floor = std::make_shared<ObstacleSurface>();
    ObstacleFrame place;
    place.shift.y() = i < 2 ? 0.0 : 0.5;
    add_obstacle_surface(PlaneShape{}, place, {}, 0, *floor);
    result.obstacles = floor;
    return result;
  };
  const auto files = [&] {
    const std::string pvd = contents(folder_ / "frames.pvd");
    std::vector<std::string> entries;
    for (int k = 0; !attribute(pvd, "file", k).empty(); ++k) {
      entries.push_back(attribute(pvd, "part", k) + " " + attribute(pvd, "file", k));
    }
    return entries;
  };
  const std::vector<std::string> expected{
      "0 frames/frame_000000.vtu", "1 frames/obstacles_000000.vtu",
      "0 frames/frame_000010.vtu", "1 frames/obstacles_000000.vtu",
      "0 frames/frame_000020.vtu", "1 frames/obstacles_000020.vtu"};
  {
    FrameWriter writer(mesh_, folder_.string());
    for (int i = 0; i < 2; ++i) writer.write(frame_with_floor(i));
    sizes = writer.frame_sizes();
    std::istringstream lines(contents(folder_ / "frames.pvd"));
    for (std::string line; std::getline(lines, line);) {
      if (line.find("<DataSet") != std::string::npos) kept += line + "\n";
    }
    writer.write(frame_with_floor(2));
  }
  EXPECT_EQ(files(), expected);
  EXPECT_FALSE(fs::exists(folder_ / "frames/obstacles_000010.vtu"));
  EXPECT_EQ(sizes[0], fs::file_size(folder_ / "frames/frame_000000.vtu"));
  const std::string floor = contents(folder_ / "frames/obstacles_000020.vtu");

  // A writer that goes on after the second frame writes the same files.
  {
    FrameWriter writer(
        mesh_, folder_.string(), {}, kept,
        {"frame_000000.vtu", "obstacles_000000.vtu", "frame_000010.vtu", "obstacles_000000.vtu"},
        sizes);
    EXPECT_FALSE(fs::exists(folder_ / "frames/obstacles_000020.vtu"));
    EXPECT_TRUE(fs::exists(folder_ / "frames/obstacles_000000.vtu"));
    writer.write(frame_with_floor(1));
    EXPECT_EQ(files().back(), "1 frames/obstacles_000000.vtu");
    writer.write(frame_with_floor(2));
    EXPECT_EQ(contents(folder_ / "frames/obstacles_000020.vtu"), floor);
  }
  FrameWriter anew(mesh_, folder_.string());
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
}

TEST_F(FrameWriterTest, ArraysOfOneFrameDoNotStayInTheNext) {
  FrameWriter writer(mesh_, folder_.string());
  writer.write(frame(1, 0.1));
  Frame bare;
  bare.step = 2;
  bare.time = 0.2;
  writer.write(bare);
  const RawMesh read = read_raw_mesh((folder_ / "frames/frame_000002.vtu").string());
  EXPECT_TRUE(read.point_arrays.empty());
  EXPECT_EQ(read.vertex_ids, mesh_.vertex_ids);
}

TEST_F(FrameWriterTest, ANewWriterRemovesFramesOfAnEarlierRunAndNothingElse) {
  {
    FrameWriter writer(mesh_, folder_.string());
    writer.write(frame(0, 0.0));
    writer.write(frame(1, 0.1));
  }
  const fs::path note = folder_ / "frames/frame_notes.txt";
  std::ofstream(note) << "mine";
  std::ofstream(folder_ / "history.csv") << "t\n";
  FrameWriter writer(mesh_, folder_.string());
  EXPECT_FALSE(fs::exists(folder_ / "frames.pvd"));
  EXPECT_FALSE(fs::exists(folder_ / "frames/frame_000000.vtu"));
  EXPECT_FALSE(fs::exists(folder_ / "frames/frame_000001.vtu"));
  EXPECT_EQ(contents(note), "mine");
  EXPECT_TRUE(fs::exists(folder_ / "history.csv"));
}

TEST_F(FrameWriterTest, SingleFileIsNoFrame) {
  FrameWriter writer(mesh_, folder_.string());
  const Frame last = frame(7, 0.7);
  writer.write_single(last, (folder_ / "final.vtu").string());
  EXPECT_EQ(writer.frame_count(), 0);
  EXPECT_FALSE(fs::exists(folder_ / "frames.pvd"));
  const RawMesh read = read_raw_mesh((folder_ / "final.vtu").string());
  EXPECT_EQ(read.point_arrays.at("displacement"), last.point_fields[0].values);
}

TEST_F(FrameWriterTest, PlacesThatCannotBeWrittenAreOutputErrors) {
  const fs::path blocker = folder_ / "blocker";
  std::ofstream(blocker) << "a file";
  EXPECT_THROW(FrameWriter(mesh_, (blocker / "out").string()), OutputError);
  EXPECT_THROW(FrameWriter(mesh_, blocker.string()), OutputError);
  FrameWriter writer(mesh_, (folder_ / "run").string());
  EXPECT_THROW(writer.write_single(frame(0, 0.0), (blocker / "final.vtu").string()), OutputError);
  fs::remove_all(folder_ / "run");
  EXPECT_THROW(writer.write(frame(0, 0.0)), OutputError);
  EXPECT_EQ(writer.frame_count(), 0);
}

TEST_F(FrameWriterTest, AFullDiskIsAnOutputErrorAndLeavesNoPart) {
  FrameWriter writer(mesh_, folder_.string());
  writer.write(frame(0, 0.0));
  const std::string before = contents(folder_ / "frames.pvd");
  const std::size_t whole = fs::file_size(folder_ / "frames/frame_000000.vtu");
  // A limit on the size of files stands for the full disk: at the first bytes, in the middle, and
  // in what leaves the buffer last. In a child, for the limit cannot be raised again for sure.
  for (const std::size_t room : {std::size_t{10}, whole / 2, whole - 30, whole - 1}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{room, room};
      setrlimit(RLIMIT_FSIZE, &limit);
      int code = 1;
      try {
        writer.write(frame(1, 0.0));
      } catch (const OutputError&) {
        code = 0;
      } catch (...) {
        code = 2;
      }
      _exit(code);
    }
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << "room for " << room << " of " << whole << " bytes";
    EXPECT_FALSE(fs::exists(folder_ / "frames/frame_000001.vtu"));
    EXPECT_FALSE(fs::exists(folder_ / "frames/frame_000001.vtu.part"));
    EXPECT_EQ(contents(folder_ / "frames.pvd"), before);
  }
}

TEST_F(FrameWriterTest, FieldsOfTheWrongSizeAreRefused) {
  FrameWriter writer(mesh_, folder_.string());
  Frame wrong;
  wrong.point_fields.push_back({"short", Matrix::Zero(3, mesh_.vertex_count() - 1), false});
  EXPECT_THROW(writer.write(wrong), InputError);
  wrong.point_fields.clear();
  wrong.cell_fields.push_back({"empty", Matrix(0, mesh_.tetrahedron_count()), false});
  EXPECT_THROW(writer.write(wrong), InputError);
  EXPECT_EQ(writer.frame_count(), 0);
}

TEST_F(FrameWriterTest, FramesAreReadBack) {
  FrameWriter writer(mesh_, folder_.string());
  const Frame written = frame(3, 0.5);
  writer.write(written);
  const std::string path = (folder_ / "frames/frame_000003.vtu").string();
  const StoredFrame read =
      read_frame(path, {"displacement", "no_such_array", "fixed"}, {"cauchy_stress"});
  EXPECT_EQ(read.vertex_count, mesh_.vertex_count());
  EXPECT_EQ(read.tetrahedron_count, mesh_.tetrahedron_count());
  ASSERT_EQ(read.point_arrays.size(), 3U);
  EXPECT_LT((read.point_arrays[0] - written.point_fields[0].values).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(read.point_arrays[1].size(), 0);
  EXPECT_EQ(read.point_arrays[2], written.point_fields[1].values);
  EXPECT_LT((read.cell_arrays.at(0) - written.cell_fields[0].values).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_THROW(read_frame((folder_ / "none.vtu").string(), {}), FileError);
  std::ofstream(path) << "<VTKFile>";
  EXPECT_THROW(read_frame(path, {}), FileError);
}

}  // namespace
}  // namespace tetraction
