// Loops over elements and vertices on the beam of 4 × 1 × 1 m, one thread: time per tetrahedron.
// Argument: cells through the thickness (4: 1,920 tetrahedra; 9: 19,440; 18: 155,520).
#include <benchmark/benchmark.h>

#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/derivative_check.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/mesh/generate.h"

namespace {

using namespace tetraction;

struct Body {
  explicit Body(int n)
      : mesh(generate_box({4, 1, 1}, {n == 4 ? 20 : n * 40 / 9, n, n})),
        rest(mesh),
        potential(rest, material()),
        q(strained_state(potential, mesh.rest_positions())) {
    set_thread_count(1);
  }
  static NeoHookean material() {
    const LameParameters lame = lame_from_young(1e6, 0.4);
    return {lame.mu, lame.lambda};
  }
  void report(benchmark::State& state) const {
    state.counters["s/tetrahedron"] = benchmark::Counter(
        static_cast<double>(mesh.tetrahedron_count()),
        benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  }
  TetMesh mesh;
  RestState rest;
  ElasticPotential potential;
  Vector q;
};

void gradient(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  double energy = 0.0;
  Vector g;
  for (auto _ : state) {
    benchmark::DoNotOptimize(body.potential.value_and_gradient(body.q, energy, g));
  }
  body.report(state);
}
BENCHMARK(gradient)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

void hessian(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  const FreeCoordinates free(body.rest.vertex_count());
  const SparsityPattern pattern(body.rest, free);
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(body.potential.add_hessian(body.q, pattern, values.data()));
  }
  body.report(state);
}
BENCHMARK(hessian)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

void energy(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  double value = 0.0;
  for (auto _ : state) benchmark::DoNotOptimize(body.potential.value(body.q, value));
  body.report(state);
}
BENCHMARK(energy)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// The tangent stiffness times a vector, as the public interface has it: for any material, linearised
// anew in every call. (What matrix-free CG does is in the implicit rows of `steps`.)
void product(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  Vector y;
  for (auto _ : state) body.potential.product(body.q, body.q, y);
  body.report(state);
}
BENCHMARK(product)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// One pass over the vertices: energies and momenta for the books.
void vertex_books(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  MechanicalSystem system(body.mesh, Body::material(), 1000.0);
  system.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
  State now = system.rest_state();
  now.momentum = system.momentum_of(body.q);
  Energies energies;
  Momenta momenta;
  for (auto _ : state) {
    system.vertex_books(now, energies, momenta);
    benchmark::DoNotOptimize(momenta);
  }
  body.report(state);
}
BENCHMARK(vertex_books)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// v = M⁻¹p, another one.
void velocities(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  const MechanicalSystem system(body.mesh, Body::material(), 1000.0);
  for (auto _ : state) benchmark::DoNotOptimize(system.velocity_of(body.q));
  body.report(state);
}
BENCHMARK(velocities)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

}  // namespace
