//                       Tetraction example: a million tetrahedra of your own
//
// Sample runs:  large_mesh                      55 cells across: 998,250 tetrahedra
//               large_mesh 8                    3,072 tetrahedra
//               large_mesh 55 1000              1000 explicit steps; Ctrl-C ends them
//
// Description:  A program that has its mesh in arrays of its own (coordinates and connectivity) makes
//               the library's objects from them, without a file in between, and steps the body: 100
//               explicit steps, then 3 of the implicit midpoint rule, which are much longer. Ctrl-C
//               ends the run after the step that is under way, with the state kept. The example
//               prints the time of each phase, the memory used and how well the energy was kept.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/process.h"
#include "tetraction/dynamics/books.h"
#include "tetraction/dynamics/stepper.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/solver/newton_minimizer.h"

using namespace tetraction;

// 1. Ctrl-C sets a flag, and that is all that a signal handler may do.
std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);
void ask_to_stop(int) {
  stop_asked = true;
}

// 2. The user's own arrays: a cube of n³ cells of six tetrahedra, as plain numbers.
struct Arrays {
  std::vector<double> coordinates;  // x y z x y z …, m
  std::vector<int> connectivity;    // four vertices a tetrahedron, any orientation
};

Arrays make_arrays(int n) {
  Arrays arrays;
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        for (const int x : {i, j, k}) arrays.coordinates.push_back(static_cast<double>(x) / n);
      }
    }
  }
  // From a cell's corner to the opposite one, along the axes in any order.
  const std::array<int, 3> stride{1, n + 1, (n + 1) * (n + 1)};
  constexpr std::array<std::array<std::size_t, 3>, 6> kPaths{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};
  for (int cell = 0; cell < n * n * n; ++cell) {
    const int corner = cell % n + stride[1] * (cell / n % n) + stride[2] * (cell / n / n);
    for (const auto& path : kPaths) {
      int vertex = corner;
      arrays.connectivity.push_back(vertex);
      for (const std::size_t axis : path) arrays.connectivity.push_back(vertex += stride[axis]);
    }
  }
  return arrays;
}

// 3. The library's mesh of them. It wants positive volumes and every vertex used; ids are what
//    selections by number and files speak of.
TetMesh make_mesh(const Arrays& arrays) {
  TetMesh mesh;
  mesh.source = "arrays of the example";
  mesh.vertices.resize(arrays.coordinates.size() / 3);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    mesh.vertices[v] = Eigen::Map<const Vector3>(arrays.coordinates.data() + 3 * v);
  }
  mesh.tetrahedra.resize(arrays.connectivity.size() / 4);
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    for (std::size_t a = 0; a < 4; ++a) mesh.tetrahedra[e][a] = arrays.connectivity[4 * e + a];
    const double volume = mesh.volume(static_cast<Index>(e));
    if (volume < 0.0) std::swap(mesh.tetrahedra[e][2], mesh.tetrahedra[e][3]);
    if (volume == 0.0) throw InputError("Tetrahedron " + std::to_string(e) + " is flat.");
  }
  mesh.vertex_ids.resize(mesh.vertices.size());
  std::iota(mesh.vertex_ids.begin(), mesh.vertex_ids.end(), 0);
  mesh.tetrahedron_ids.resize(mesh.tetrahedra.size());
  std::iota(mesh.tetrahedron_ids.begin(), mesh.tetrahedron_ids.end(), 0);
  mesh.regions.assign(mesh.tetrahedra.size(), 0);
  return mesh;
}

// Prints what was done since the last call, and how long it took.
class PhaseClock {
 public:
  void print(const char* phase) {
    const auto now = std::chrono::steady_clock::now();
    std::printf("%-24s %9.3f s\n", phase, std::chrono::duration<double>(now - last_).count());
    std::fflush(stdout);
    last_ = now;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Steps until the end, a failure or Ctrl-C; returns false after a failure.
bool run(Stepper& stepper, State& state, Books& books, double h, Index steps, const char* name) {
  for (Index k = 1; k <= steps && !stop_asked; ++k) {
    const StepOutcome outcome = stepper.step(state, h);
    if (!outcome.ok()) {
      std::fprintf(stderr, "step %lld failed: %s\n", static_cast<long long>(state.step + 1),
                   outcome.message.c_str());
      return false;
    }
    books.enter(state, outcome);
    if (k % (steps > 10 ? steps / 10 : 1) == 0) {
      std::printf("  %s %lld/%lld  t = %.5f s  kinetic %.3e J  energy error %.1e J\n", name,
                  static_cast<long long>(k), static_cast<long long>(steps), state.time,
                  books.energies().kinetic, books.energy_error());
      std::fflush(stdout);
    }
  }
  return true;
}

int main(int argc, char** argv) {
  const int cells = argc > 1 ? std::atoi(argv[1]) : 55;
  const Index explicit_steps = argc > 2 ? std::atoll(argv[2]) : 100;
  if (cells < 1 || explicit_steps < 1) {
    std::fprintf(stderr, "usage: large_mesh [cells across] [explicit steps]\n");
    return 2;
  }
  std::signal(SIGINT, ask_to_stop);
  PhaseClock clock;

  // 4. Arrays, then the mesh. The arrays are no longer needed then.
  TetMesh mesh;
  {
    const Arrays arrays = make_arrays(cells);
    clock.print("the user's arrays");
    mesh = make_mesh(arrays);
  }
  clock.print("mesh");
  std::printf("%lld tetrahedra, %lld vertices, %d threads\n",
              static_cast<long long>(mesh.tetrahedron_count()),
              static_cast<long long>(mesh.vertex_count()), thread_count());

  // 5. The body gets the mesh; from here on it is body.mesh().
  const LameParameters lame = lame_from_young(1.0e6, 0.4);
  MechanicalSystem body(std::move(mesh), NeoHookean(lame.mu, lame.lambda), 1000.0);
  ConstraintList clamp;
  clamp.held.push_back(
      hold_at_rest(body.mesh(), select_vertices(body.mesh(), SelectPlane{1, 0.0, {}})));
  body.set_constraints(Constraints(clamp, body.mesh(), body.mass()));
  body.set_environment(Environment::uniform({9.81, 0.0, 0.0}));
  const auto explicit_rule = make_verlet_stepper(body);
  clock.print("set-up");

  // 6. Explicit steps, a third of what a wave needs to cross a cell's shortest height.
  State state = body.rest_state();
  Books books(body, state);
  const double h = 0.33 / std::sqrt(3.0) / cells / wave_speed(lame, body.density());
  if (!run(*explicit_rule, state, books, h, explicit_steps, "verlet")) return 1;
  clock.print("explicit steps");

  // 7. Implicit steps from where the explicit ones ended, twenty times as long.
  const auto implicit_rule = make_midpoint_stepper(body, make_newton_minimizer(body, {}));
  if (!run(*implicit_rule, state, books, 20.0 * h, 3, "midpoint")) return 1;
  clock.print("implicit steps");

  // 8. The state is whole, however the run ended: it could be written or gone on with.
  std::printf("%s at t = %.5f s after %lld steps\n", stop_asked ? "stopped" : "finished",
              state.time, static_cast<long long>(state.step));
  std::printf("energy kept within %.2e of what entered the body\npeak memory %.0f MB\n",
              books.max_relative_energy_drift(), static_cast<double>(peak_memory_bytes()) / 1e6);
  return stop_asked ? 130 : 0;
}
