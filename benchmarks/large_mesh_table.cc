#include <cstdlib>
#include <filesystem>
#include <utility>

#include "tables.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "timing.h"

namespace tetraction::benchmarks {
namespace {

// A folder for temporary files, which is deleted together with them.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "steps-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw OutputError("Cannot make " + pattern + ".");
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

// One row: a mesh is written, read and set up, and the first steps are made.
void time_phases(const BeamSize& size, const std::string& format, Report& report) {
  const TemporaryFolder folder;
  const std::string path = folder.file("beam." + format);
  TetMesh mesh;
  const double generate = seconds_of([&] { mesh = size.mesh(); });
  const double write = seconds_of([&] { write_mesh(mesh, path); });
  RawMesh raw;
  const double read = seconds_of([&] { raw = read_raw_mesh(path); });
  const double check = seconds_of([&] { mesh = build_mesh(std::move(raw)); });
  std::unique_ptr<MechanicalSystem> beam;
  std::unique_ptr<Stepper> stepper;
  State state;
  const double set_up = seconds_of([&] {
    beam = make_beam(std::move(mesh));
    stepper = make_explicit_stepper(*beam);
    state = beam->rest_state();
  });
  const double h = size.explicit_step();
  State next;
  const auto step = [&] {
    require(stepper->advance(state, next, h, state.time + h));
    std::swap(state, next);
  };
  const double first = seconds_of(step);
  std::vector<double> later;
  for (int k = 0; k < 9; ++k) {
    later.push_back(seconds_of(step));
  }
  const double megabytes = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
  report.row({format, size.tetrahedra(), megabytes, generate, write, read, check, set_up, first,
              read + check + set_up + first, median(later)});
}

}  // namespace

void large_mesh_table(const Settings& settings, Report& report) {
  const BeamSize size = beam_size(settings.quick ? "M" : "XL");
  use_threads(settings.threads.back());
  report.table("From a file to the first explicit step: seconds, one repetition",
               {{"format", 6},
                {"tetrahedra", 10},
                {"MB", 6},
                {"generate", 8},
                {"write", 8},
                {"read", 8},
                {"check", 8},
                {"set-up", 8},
                {"first step", 10},
                {"file to step", 12},
                {"later step", 10}},
               {"file to step: read + check + set-up + first step; later step: median of nine"});
  for (const char* format : {"vtu", "msh"}) time_phases(size, format, report);
}

}  // namespace tetraction::benchmarks
