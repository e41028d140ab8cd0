#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <limits>
#include <utility>

#include "tables.h"
#include "tetraction/core/process.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction::benchmarks {
namespace {

enum class Kind { kExplicit, kMatrixFree, kFactor };

std::unique_ptr<Stepper> make_stepper(const MechanicalSystem& beam, Kind kind) {
  if (kind == Kind::kExplicit) return make_verlet_stepper(beam);
  NewtonOptions options;
  options.linear = kind == Kind::kFactor ? LinearSolver::kFactor : LinearSolver::kMatrixFree;
  return make_backward_euler_stepper(beam, make_newton_minimizer(beam, options));
}

// The peak of a whole run minus the memory that the process held before its mesh was made. The mesh
// is included.
double growth_of_run(const BeamSize& size, Kind kind) {
  const std::int64_t before = peak_memory_bytes();
  const auto beam = make_beam(size.mesh());
  const auto stepper = make_stepper(*beam, kind);
  State state = beam->rest_state();
  for (int k = 0; k < 3; ++k) {
    require(stepper->step(state, kind == Kind::kExplicit ? size.explicit_step() : 0.01));
  }
  return static_cast<double>(peak_memory_bytes() - before);
}

// Runs f() in a child process, so that the peak of memory is that of f() alone. NaN if that fails.
template <class F>
double in_child(const F& f) {
  double result = std::numeric_limits<double>::quiet_NaN();
  int ends[2];
  std::fflush(stdout);
  if (pipe(ends) != 0) return result;
  const pid_t child = fork();
  if (child == 0) {
    try {
      const double value = f();
      const bool written = write(ends[1], &value, sizeof value) == sizeof value;
      _exit(written ? 0 : 1);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  double value = 0.0;
  if (child > 0 && read(ends[0], &value, sizeof value) == sizeof value) result = value;
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  return result;
}

}  // namespace

void memory_table(const Settings& settings, Report& report) {
  report.table("Memory: peak of a run of three steps in a process of its own, mesh included",
               {{"size", 4}, {"tetrahedra", 10}, {"run", 26}, {"MiB", 8}, {"bytes/tet", 9, 4}},
               {"resident memory; small meshes show what libraries and threads take"});
  for (const BeamSize& size : settings.sizes) {
    for (const auto& [kind, name] : {std::pair{Kind::kExplicit, "verlet"},
                                     std::pair{Kind::kMatrixFree, "backward-euler matrix-free"},
                                     std::pair{Kind::kFactor, "backward-euler factor"}}) {
      if (kind == Kind::kFactor && size.name == "XL") continue;
      const double bytes = in_child([&size, kind = kind] {
        use_threads(1);
        return growth_of_run(size, kind);
      });
      report.row({size.name, size.tetrahedra(), name, bytes / 1048576.0,
                  bytes / static_cast<double>(size.tetrahedra())});
    }
  }
}

}  // namespace tetraction::benchmarks
