// Measures the figures that the documents state in one run: conservation, energy, and the cost of
// whole steps as ratios to the explicit step of the same mesh.
#include <fmt/format.h>

#include <numeric>

#include "tetraction/core/blas.h"
#include "tetraction/core/parallel.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

namespace {

using namespace tetraction;

Scene spinning(Integrator integrator, double step, Index steps, const std::array<int, 3>& cells) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {2, 1, 1}, cells};
  scene.material.youngs_modulus = 1e5;
  scene.material.poissons_ratio = 0.3;
  scene.time = {integrator, step, false, step * static_cast<double>(steps)};
  scene.initial.velocity = {0.3, -0.2, 0.1};
  scene.initial.angular_velocity = {1.0, 2.0, 0.5};
  scene.initial.stretch = {1.1, 0.95, 1.0};
  return scene;
}

double stable_step(const Scene& scene) {
  return Session(scene, generate_mesh(*scene.mesh.generate)).initial_limit().critical_step;
}

void conservation(Integrator integrator, double fraction, Index steps,
                  const std::array<int, 3>& cells) {
  const double step = fraction * stable_step(spinning(integrator, 1e-6, 1, cells));
  const Scene scene = spinning(integrator, step, steps, cells);
  Session session(scene, generate_mesh(*scene.mesh.generate));
  double first = 0.0;
  double last = 0.0;
  while (session.step()) {
    const Index k = session.state().step;
    if (10 * k <= steps) first += session.balance().energies().total();
    if (10 * k > 9 * steps) last += session.balance().energies().total();
  }
  const Balance& balance = session.balance();
  fmt::print(
      "{:<10} {:>6} steps of {:.2f} h_crit, {:>4} tetrahedra: {}  linear {:.1e}  angular "
      "{:.1e} (allowed {:.1e})  energy error {:.1e}  mean of last tenth / first tenth - 1 = "
      "{:.1e}\n",
      to_string(integrator), steps, fraction, session.system().mesh().tetrahedron_count(),
      to_string(session.status()), balance.linear_momentum_drift(),
      balance.angular_momentum_drift(), balance.allowed_angular_momentum_drift(),
      balance.max_relative_energy_drift(), last / first - 1.0);
}

Scene beam(Integrator integrator, int n) {
  Scene scene;
  scene.mesh.generate =
      GeneratorSettings{GeneratorKind::kBeam, {4, 1, 1}, {n == 4 ? 20 : 40, n, n}};
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.4;
  scene.time = {integrator, 0.01, false, 0.2};
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings clamp;
  clamp.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(clamp);
  return scene;
}

// Clamped beam: 20 implicit steps of 0.01 s, and as many explicit ones of half the limit.
void cost(int n) {
  const TetMesh mesh = generate_mesh(*beam(Integrator::kVerlet, n).mesh.generate);
  double unit = 0.0;
  for (const Integrator integrator :
       {Integrator::kVerlet, Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    Scene scene = beam(integrator, n);
    if (!is_implicit(integrator)) scene.time.automatic = true;
    Session session(scene, mesh);
    const RunStatus status = session.run();
    const double seconds = session.times().stepping / static_cast<double>(session.state().step);
    if (unit == 0.0) unit = seconds;
    double tip = 0.0;
    const std::vector<Index> end = select_vertices(mesh, SelectPlane{0, 4.0, {}});
    for (const Index v : end) {
      tip += session.state().position[3 * v + 1] - mesh.vertices[static_cast<std::size_t>(v)].y();
    }
    fmt::print(
        "{:<15} {:>6} tetrahedra: {}  {:.3g} ms a step = {:.4g} explicit steps = {:.4g} ns a "
        "tetrahedron; {:.2f} iterations a step; tip {:.10f} m\n",
        to_string(integrator), mesh.tetrahedron_count(), to_string(status), 1e3 * seconds,
        seconds / unit, 1e9 * seconds / static_cast<double>(mesh.tetrahedron_count()),
        static_cast<double>(session.total_iterations()) / static_cast<double>(session.state().step),
        tip / static_cast<double>(end.size()));
  }
}

}  // namespace

int main() {
  const BlasInfo blas = blas_info();
  fmt::print("{} threads, BLAS {} {}\n", thread_count(), blas.library, blas.core);
  conservation(Integrator::kExplicit, 0.3, 10000, {6, 3, 3});
  conservation(Integrator::kVerlet, 0.3, 10000, {6, 3, 3});
  conservation(Integrator::kMidpoint, 1.0, 10000, {2, 1, 1});
  conservation(Integrator::kMidpoint, 1.0, 1000, {6, 3, 3});
  conservation(Integrator::kVerlet, 0.1, 100000, {2, 1, 1});
  cost(4);
  cost(9);
  return 0;
}
