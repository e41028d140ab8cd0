//                       Tetraction example: a million tetrahedra of your own
//
// Sample runs:  large_mesh                      55 cells across: 998,250 tetrahedra
//               large_mesh 8                    3,072 tetrahedra
//               large_mesh 55 1000              1000 explicit steps; Ctrl-C ends them
//
// Description:  A program that has its mesh in arrays of its own (coordinates and connectivity) has the
//               library work on these very arrays, without a file or a copy in between, and steps the
//               body: 100 explicit steps, then 3 of the implicit midpoint rule, which are much longer.
//               Ctrl-C ends the run after the step that is under way, with the state kept. The example
//               prints the time of each phase, the memory used and how well the energy was kept.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "tetraction/core/parallel.h"
#include "tetraction/core/process.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/steppers/stepper.h"
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
  std::vector<int> connectivity;    // four vertices a tetrahedron, of positive volume
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
    for (std::size_t p = 0; p < kPaths.size(); ++p) {
      int vertex = corner;
      arrays.connectivity.push_back(vertex);
      for (const std::size_t axis : kPaths[p])
        arrays.connectivity.push_back(vertex += stride[axis]);
      // The last three paths are mirror images of the first three.
      if (p >= 3) std::swap(*(arrays.connectivity.end() - 1), *(arrays.connectivity.end() - 2));
    }
  }
  return arrays;
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
bool run(Stepper& stepper, State& state, Balance& balance, double h, Index steps,
         const char* name) {
  State next;  // two states in turn: stepper.step(state, h) would copy the result
  for (Index k = 1; k <= steps && !stop_asked; ++k) {
    const StepOutcome outcome = stepper.advance(state, next, h, state.time + h);
    if (!outcome.ok()) {
      std::fprintf(stderr, "step %lld failed: %s\n", static_cast<long long>(state.step) + 1,
                   outcome.message.c_str());
      return false;
    }
    std::swap(state, next);
    balance.enter(state, outcome);
    if (k % (steps > 10 ? steps / 10 : 1) == 0) {
      std::printf("  %s %lld/%lld  t = %.5f s  kinetic %.3e J  energy error %.1e J\n", name,
                  static_cast<long long>(k), static_cast<long long>(steps), state.time,
                  balance.energies().kinetic(), balance.energy_error());
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

  // 3. The library's view of the arrays, which must live as long as the body. Positive volumes and
  //    every vertex used: that is checked. 64-bit connectivity would do as well.
  const Arrays arrays = make_arrays(cells);
  clock.print("the user's arrays");
  const TetMesh mesh = view_mesh(arrays.coordinates, arrays.connectivity);
  clock.print("check of the mesh");
  std::printf("%lld tetrahedra, %lld vertices, %d threads\n",
              static_cast<long long>(mesh.tetrahedron_count()),
              static_cast<long long>(mesh.vertex_count()), thread_count());

  // 4. The body, clamped at its foot.
  const LameParameters lame = lame_from_young(1.0e6, 0.4);
  MechanicalSystem body(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
  ConstraintList clamp;
  clamp.held.push_back(prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{1, 0.0, {}})));
  body.set_constraints(Constraints(clamp, mesh, body.mass()));
  body.set_environment(Environment::uniform({9.81, 0.0, 0.0}));
  const auto explicit_rule = make_verlet_stepper(body);
  clock.print("set-up");

  // 5. Explicit steps, a third of what a wave needs to cross a cell's shortest height.
  State state = body.rest_state();
  Balance balance(body, state);
  const double h = 0.33 / std::sqrt(3.0) / cells / wave_speed(lame, body.density(0));
  if (!run(*explicit_rule, state, balance, h, explicit_steps, "verlet")) return 1;
  clock.print("explicit steps");

  // 6. Implicit steps from where the explicit ones ended, twenty times as long.
  const auto implicit_rule = make_midpoint_stepper(body, make_newton_minimizer(body, {}));
  if (!run(*implicit_rule, state, balance, 20.0 * h, 3, "midpoint")) return 1;
  clock.print("implicit steps");

  // 7. The state is whole, however the run ended: it could be written or gone on with.
  std::printf("%s at t = %.5f s after %lld steps\n", stop_asked ? "stopped" : "finished",
              state.time, static_cast<long long>(state.step));
  std::printf("energy kept within %.2e of what entered the body\npeak memory %.0f MB\n",
              balance.max_relative_energy_drift(), static_cast<double>(peak_memory_bytes()) / 1e6);
  return stop_asked ? 130 : 0;
}
