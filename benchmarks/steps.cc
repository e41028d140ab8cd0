#include <fmt/format.h>
#include <hwy/highway.h>
#include <chrono>
#include <cstdlib>
#include <string>
#include "tetraction/core/blas.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/stepper.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
using namespace tetraction;
namespace {
double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
}  // namespace
int main(int argc, char** argv) {
  if (std::getenv("NO512") != nullptr) {
    hwy::SetSupportedTargetsForTest(HWY_AVX2);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  const std::string size = argc > 1 ? argv[1] : "M";
  const std::string what = argc > 2 ? argv[2] : "newton";
  const double E = argc > 3 ? std::atof(argv[3]) : 1e6;
  const int threads = argc > 4 ? std::atoi(argv[4]) : 1;
  const std::string rule = argc > 5 ? argv[5] : "be";
  const double h = argc > 6 ? std::atof(argv[6]) : 0.01;
  set_thread_count(threads);
  std::array<int, 3> cells = size == "S"   ? std::array<int, 3>{20, 4, 4}
                             : size == "M" ? std::array<int, 3>{40, 9, 9}
                             : size == "L" ? std::array<int, 3>{76, 18, 18}
                                           : std::array<int, 3>{152, 36, 36};
  double t0 = now();
  const TetMesh mesh = generate_box({4, 1, 1}, cells);
  double t1 = now();
  const LameParameters lame = lame_from_young(E, 0.4);
  MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
  system.set_environment(Environment::uniform({0, -9.81, 0}));
  double t2 = now();
  ConstraintList list;
  list.held.push_back(hold_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}})));
  system.set_constraints(Constraints(list, mesh, system.mass()));
  fmt::print("{} tets, generate {:.3f} s, system {:.3f} s, constraints {:.3f}\n",
             mesh.tetrahedron_count(), t1 - t0, t2 - t1, now() - t2);
  State state = system.rest_state();
  const double n = mesh.tetrahedron_count();
  if (what == "explicit" || what == "verlet") {
    auto s = what == "explicit" ? make_explicit_stepper(system) : make_verlet_stepper(system);
    double step = 2e-4 * 4 / cells[1] / std::sqrt(E / 1e6);
    s->step(state, step);
    for (int r = 0; r < 5; ++r) {
      const int k = (int)(3e7 / n) + 1;
      double t = now();
      for (int i = 0; i < k; ++i)
        if (!s->step(state, step).ok()) {
          fmt::print("fail\n");
          return 1;
        }
      t = now() - t;
      fmt::print("{} {:.2f} ns per tet and step\n", what, 1e9 * t / k / n);
    }
    return 0;
  }
  MinimizerOptions o;
  NewtonOptions no;
  if (what == "mf") no.linear = LinearSolver::kMatrixFree;
  if (what == "cg") no.linear = LinearSolver::kCg;
  if (what == "factor" || what == "refactor") no.linear = LinearSolver::kFactor;
  if (what == "refactor") no.keep_factor = false;
  std::shared_ptr<Minimizer> m =
      what == "ceres" ? make_ceres_minimizer(system, o) : make_newton_minimizer(system, no);
  auto s = rule == "be" ? make_backward_euler_stepper(system, m) : make_midpoint_stepper(system, m);
  int it = 0, cg = 0, f = 0;
  double t = now();
  const int steps = 20;
  double worst = 0;
  for (int i = 0; i < steps; ++i) {
    double tt = now();
    auto out = s->step(state, h);
    tt = now() - tt;
    worst = std::max(worst, tt);
    if (!out.ok()) {
      fmt::print("fail {} {} res {} lim {}\n", i, out.message, out.minimizer.residual,
                 out.minimizer.residual_limit);
      return 1;
    }
    it += out.minimizer.iterations;
    cg += out.minimizer.cg_iterations;
    f += out.minimizer.factorizations;
    if (i < 3 || i == 19)
      fmt::print("  step {}: {:.2f} ms it {} cg {} {}\n", i, 1e3 * tt, out.minimizer.iterations,
                 out.minimizer.cg_iterations, out.minimizer.linear);
  }
  t = now() - t;
  auto end = select_vertices(mesh, SelectPlane{0, 4.0, {}});
  double tip = 0;
  for (auto v : end) tip += state.position[3 * v + 1] - mesh.vertices[v].y();
  fmt::print("{} {} {}: {:.2f} ms a step (worst {:.2f}), it {:.2f} cg {:.1f} fact {} tip {:.10f}\n",
             size, rule, what, 1e3 * t / steps, 1e3 * worst, it / 20.0, cg / 20.0, f,
             tip / end.size());
}
