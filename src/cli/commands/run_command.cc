// tetraction run: one scene, one trajectory.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "cli/console.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "recorded_session.h"
#include "simulation/stepping/adaptations.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// A report of time.retry and time.adapt, or an empty text.
std::string step_control_text(const Session& session) {
  const StepControl& control = session.step_control();
  const TimeSettings& time = session.time_settings();
  if (adapts(time)) {
    return fmt::format("step control: {}\n", adaptation(time.adapt).report(control, time));
  }
  if (time.retry == 0) return {};
  return fmt::format("step control: {} steps were made in smaller ones; {} attempts failed\n",
                     control.retried, control.failed);
}

void print_outcome(const Session& session, const std::string& directory) {
  const Balance& balance = session.balance();
  const Energies& e = balance.energies();
  const StepRange& taken = session.steps();
  std::string lengths = fmt::format("{:.6g} s", session.time_step());
  if (taken.changes > 0) {
    lengths = fmt::format("{:.6g} to {:.6g} s, changed {} times", taken.smallest, taken.largest,
                          taken.changes);
  } else if (taken.last < (1.0 - 1e-9) * session.time_step() && taken.last > 0.0) {
    lengths += fmt::format(", the last of {:.6g} s", taken.last);
  }
  print_result("{}: {} steps of {} to t = {:.6g} s in {:.3g} s\n",
               to_string(session.time_settings().integrator), session.step_number(), lengths,
               session.time(), session.times().stepping);
  write_result(step_control_text(session));
  print_result(
      "mesh: {} vertices, {} tetrahedra; mass {:.6g} kg; {} of {} degrees of freedom free\n",
      global_vertex_count(session.system()), global_tetrahedron_count(session.system()),
      session.system().total_mass(), global_freedom_count(session.system()),
      3 * global_vertex_count(session.system()));
  const StabilityLimit& limit = session.initial_limit();
  print_result("stability limit of the explicit rules: {}{}\n",
               std::isfinite(limit.critical_step)
                   ? fmt::format("h_crit = {:.6g} s", limit.critical_step)
                   : "none, because every vertex is held",
               damping_of_limit(limit));
  print_result(
      "energy [J]: kinetic {:.6g}, elastic {:.6g}, environment {:.6g}, total {:.6g}; largest error "
      "{:.3g} of what entered\n",
      e.kinetic(), e.elastic(), e.environment(), e.total(), balance.max_relative_energy_drift());
  print_result("work [J]: user forces {:.6g}, dissipated {:.6g}, constraints {:.6g}",
               balance.external_work(), balance.dissipated_energy(), balance.constraint_work());
  if (session.system().contact() != nullptr) {
    print_result(", friction {:.6g}", balance.friction_dissipation());
  }
  if (session.edits().empty()) {
    write_result("\n");
  } else {
    print_result("; {} event{} {:.6g}\n", session.edits().size(),
                 session.edits().size() == 1 ? "" : "s", balance.edit_work());
  }
  print_result("momentum drift: linear {:.3g}, angular {:.3g}", balance.linear_momentum_drift(),
               balance.angular_momentum_drift());
  if (is_implicit(session.time_settings().integrator)) {
    const auto steps = static_cast<double>(std::max<Index>(1, session.step_number()));
    const std::string& linear = session.linear_solver();
    print_result(" (the solver's residuals allow {:.3g})\n{}{}{}: {:.3g} iterations a step",
                 balance.allowed_angular_momentum_drift(), session.solver_settings().kind,
                 linear.empty() ? "" : ", ", linear,
                 static_cast<double>(session.total_iterations()) / steps);
    if (session.total_cg_iterations() > 0) {
      print_result(" and {:.3g} of conjugate gradients",
                   static_cast<double>(session.total_cg_iterations()) / steps);
    }
    print_result("; last one: {}\n", session.solver_message());
  } else {
    write_result("\n");
  }
  print_result("results: {0}/history.csv, {1}{0}/frames.pvd, {0}/final.{2}, {0}/summary.json\n",
               directory, session.scene().probe.empty() ? "" : directory + "/probes.csv, ",
               session.system().part() != nullptr ? "pvtu" : "vtu");
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SessionArguments>();
  CLI::App* command = app.add_subcommand("run", "Run a scene and write its results");
  add_session_options(*command, *arguments);
  arguments->has_checkpoints = true;
  arguments->may_be_parallel = true;
  CLI::Option* resume =
      command->add_flag("--resume", arguments->resume,
                        "Go on with the run in the output directory from its newest checkpoint");
  command
      ->add_flag("--force", arguments->force,
                 "With --resume: go on although scene or mesh have changed")
      ->needs(resume);
  command->callback([arguments, &exit_code] {
    const auto make = [](const Scene& scene, TetMesh mesh) {
      return std::make_unique<Session>(scene, std::move(mesh));
    };
    exit_code = run_recorded(*arguments, make, "running", print_outcome);
  });
}

}  // namespace tetraction
