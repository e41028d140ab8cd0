// Loops over elements and vertices on the beam of 4 × 1 × 1 m, one thread: time per tetrahedron.
// Argument: cells through the thickness (4: 1,920 tetrahedra; 9: 19,440; 18: 155,520).
#include <benchmark/benchmark.h>

#include "solver/linear/single_precision_factor.h"
#include "solver/linear/sparse_cholesky.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"

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

// The tangent stiffness times a vector by the public interface, which takes any material and
// linearises in every call. (The matrix-free solver is in the implicit rows of `steps`.)
void product(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  Vector y;
  for (auto _ : state) body.potential.product(body.q, body.q, y);
  body.report(state);
}
BENCHMARK(product)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// One pass over the vertices: energies and momenta for the balance.
void vertex_balance(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  MechanicalSystem system(body.mesh, Body::material(), 1000.0);
  system.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
  State now = system.rest_state();
  now.momentum = system.momentum_of(body.q);
  Energies energies;
  Momenta momenta;
  double springs = 0.0;
  for (auto _ : state) {
    vertex_balance(system, now, energies, momenta, springs);
    benchmark::DoNotOptimize(momenta);
  }
  body.report(state);
}
BENCHMARK(vertex_balance)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// v = M⁻¹p, another one.
void velocities(benchmark::State& state) {
  const Body body(static_cast<int>(state.range(0)));
  const MechanicalSystem system(body.mesh, Body::material(), 1000.0);
  for (auto _ : state) benchmark::DoNotOptimize(system.velocity_of(body.q));
  body.report(state);
}
BENCHMARK(velocities)->Arg(4)->Arg(9)->Unit(benchmark::kMillisecond);

// A solve with CHOLMOD's factor of the stiffness and one with its copy in single precision; the
// argument 18 has 147,744 tetrahedra here. B/s: of the numbers below the diagonal, which a solve reads
// twice.
class Factored {
 public:
  explicit Factored(int n)
      : mesh_(generate_box({4, 1, 1}, {n == 18 ? 76 : n * 40 / 9, n, n})),
        rest_(mesh_),
        coordinates_(clamped(mesh_)),
        pattern_(rest_, coordinates_),
        cholesky_(pattern_) {
    set_thread_count(1);
    std::vector<double> values(static_cast<std::size_t>(pattern_.nonzeros()), 0.0);
    const ElasticPotential potential(rest_, Body::material());
    if (!potential.add_hessian(mesh_.rest_positions(), pattern_, values.data()).ok() ||
        !cholesky_.factorize(values)) {
      throw Error("The stiffness at rest has no factor.");
    }
    cholesky_.copy_to(single_);
  }
  Vector right() const { return Vector::LinSpaced(pattern_.size(), -1.0, 1.0); }
  SparseCholesky& cholesky() { return cholesky_; }
  SinglePrecisionFactor& single_precision_cg() { return single_; }
  void report(benchmark::State& state, std::size_t bytes_per_number) const {
    state.SetBytesProcessed(state.iterations() *
                            static_cast<std::int64_t>(2 * bytes_per_number * single_.nonzeros()));
  }

 private:
  static FreeCoordinates clamped(const TetMesh& mesh) {
    ConstraintList list;
    list.held.push_back(prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}})));
    return Constraints(list, mesh, Vector::Ones(mesh.vertex_count())).coordinates();
  }

  TetMesh mesh_;
  RestState rest_;
  FreeCoordinates coordinates_;
  SparsityPattern pattern_;
  SparseCholesky cholesky_;
  SinglePrecisionFactor single_;
};

void back_solve(benchmark::State& state) {
  Factored factored(static_cast<int>(state.range(0)));
  const Vector b = factored.right();
  for (auto _ : state) benchmark::DoNotOptimize(factored.cholesky().solve(b));
  factored.report(state, sizeof(double));
}
BENCHMARK(back_solve)->Arg(9)->Arg(18)->Unit(benchmark::kMillisecond);

void back_solve_single(benchmark::State& state) {
  Factored factored(static_cast<int>(state.range(0)));
  set_thread_count(static_cast<int>(state.range(1)));
  const Vector b = factored.right();
  Vector x(b.size());
  for (auto _ : state) factored.single_precision_cg().solve(b, x);
  factored.report(state, sizeof(float));
}
BENCHMARK(back_solve_single)
    ->ArgsProduct({{9, 18}, {1, 2}})
    ->ArgNames({"", "threads"})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Copies the factor as after every factorisation, into the memory of the copy before.
void copy_factor(benchmark::State& state) {
  Factored factored(static_cast<int>(state.range(0)));
  for (auto _ : state) factored.cholesky().copy_to(factored.single_precision_cg());
}
BENCHMARK(copy_factor)->Arg(9)->Arg(18)->Unit(benchmark::kMillisecond);

}  // namespace
