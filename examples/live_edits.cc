//                       Tetraction example: everything changeable while it runs
//
// Sample runs:  live_edits              300 steps
//               live_edits 2000
//
// Description:  A beam sags in its clamp, gets a push, a softer material and a brake, and is let go:
//               all by Session::apply between two steps, which is also what the events of a scene and
//               the viewer use. The balance stays closed: what an edit does to the energy is its work.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

using namespace tetraction;

int main(int argc, char** argv) {
  // 1. The scene at the start: a clamped beam under gravity.
  const Index steps = argc > 1 ? std::atoi(argv[1]) : 300;
  Scene scene;
  scene.material.youngs_modulus = 5.0e6;
  scene.material.poissons_ratio = 0.4;
  scene.time.integrator = Integrator::kMidpoint;
  scene.time.step = 5.0e-3;
  scene.time.end = static_cast<double>(steps) * scene.time.step;
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings clamp;
  clamp.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(clamp);
  Session session(scene, generate_box({4.0, 1.0, 1.0}, {12, 3, 3}));

  // 2. What happens when, in steps.
  ForceSettings push;  // 20 N on each vertex of the free end, for half a second
  push.select = SelectPlane{0, 4.0, {}};
  push.vector = {0.0, 0.0, 20.0};
  push.from = 0.1 * scene.time.end;
  push.until = push.from + 0.5;
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 2.0e6;
  const auto edit_at = [&](Index step) {
    if (step == steps / 10) session.apply(SetForce{std::nullopt, push});
    if (step == 3 * steps / 10) session.apply(SetMaterial{0, softer});
    if (step == 5 * steps / 10) session.apply(SetDamping{{0.0, 0.0, 2000.0}});  // viscosity, Pa s
    if (step == 8 * steps / 10) session.apply(Unfix{});                         // all of it
  };

  // 3. Edit, step, read.
  std::printf("%8s %14s %14s %14s %14s %14s\n", "time", "total [J]", "ext. work", "dissipated",
              "edit work", "energy error");
  double largest = 0.0;
  while (true) {
    edit_at(session.state().step);
    if (!session.step()) break;
    const Balance& balance = session.balance();
    largest = std::fmax(largest, std::abs(balance.energies().total()));
    if (session.state().step % (steps / 10 > 0 ? steps / 10 : 1) != 0) continue;
    std::printf("%8.3f %14.4f %14.4f %14.4f %14.4f %14.4f\n", session.state().time,
                balance.energies().total(), balance.external_work(), balance.dissipated_energy(),
                balance.edit_work(), balance.energy_error());
  }
  if (session.status() != RunStatus::kFinished) {
    std::fprintf(stderr, "%s\n", session.message().c_str());
    return 1;
  }

  // 4. What is left is the integrator's own error.
  std::printf("%zu edits; the balance closes to %.2g of the largest total energy\n",
              session.edits().size(), std::abs(session.balance().energy_error()) / largest);
  return 0;
}
