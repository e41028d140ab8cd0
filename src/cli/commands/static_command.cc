// tetraction static: the equilibrium of a scene.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>

#include "cli/console.h"
#include "commands.h"
#include "recorded_session.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

void print_equilibrium(const Session& session, const std::string& directory) {
  const MechanicalSystem& system = session.system();
  const LoadPath& path = *session.load_path();
  const Energies& energies = session.balance().energies();
  print_result("equilibrium: {} load step{} to load factor {:.6g} in {:.3g} s\n", path.steps,
               path.steps == 1 ? "" : "s", path.factor,
               session.times().stepping + session.times().stability);
  print_result(
      "mesh: {} vertices, {} tetrahedra; mass {:.6g} kg; {} of {} degrees of freedom free\n",
      system.vertex_count(), system.mesh().tetrahedron_count(), system.total_mass(),
      system.coordinates().count(), system.dof_count());
  const Displacement largest = largest_displacement(system, session.state().position);
  print_result("largest displacement: {:.6g} m at vertex {}\n", largest.length,
               system.mesh().vertex_id(largest.vertex));
  print_result("energy [J]: elastic {:.6g}, environment {:.6g}\n", energies.elastic(),
               energies.environment());
  const Vector3 reaction = resultant(session.reaction_force());
  print_result("reactions [N]: sum ({:.6g}, {:.6g}, {:.6g})\n", reaction.x(), reaction.y(),
               reaction.z());
  print_result("{}{}{}: {} iterations", session.solver_settings().kind,
               session.linear_solver().empty() ? "" : ", ", session.linear_solver(),
               session.total_iterations());
  if (session.total_cg_iterations() > 0) {
    print_result(" and {} of conjugate gradients", session.total_cg_iterations());
  }
  print_result("; force residual {:.3g} N\n", path.residual);
  print_result("results: {0}/history.csv, {0}/frames.pvd, {0}/final.vtu, {0}/summary.json\n",
               directory);
}

}  // namespace

void add_static_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SessionArguments>();
  CLI::App* command =
      app.add_subcommand("static", "Find the equilibrium of a scene under its loads at t = 0");
  add_session_options(*command, *arguments);
  auto steps = std::make_shared<int>(1);
  command
      ->add_option("--steps", *steps,
                   "At least so many load steps, to trace how the body gives way (default: 1)")
      ->check(CLI::Range(1, 1000));
  auto no_stability = std::make_shared<bool>(false);
  command->add_flag(
      "--no-stability", *no_stability,
      "Do not examine equilibria under a pressure on a free rim for motions that grow");
  command->callback([arguments, steps, no_stability, &exit_code] {
    const auto make = [&](const Scene& scene, TetMesh mesh) {
      return std::make_unique<Session>(scene, std::move(mesh), Analysis::kEquilibrium, 1.0 / *steps,
                                       !*no_stability);
    };
    exit_code = run_recorded(*arguments, make, "loading", print_equilibrium);
  });
}

}  // namespace tetraction
