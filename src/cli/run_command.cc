// tetraction run: one scene, one trajectory.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "console.h"
#include "progress_bar.h"
#include "result_folders.h"
#include "scene_source.h"
#include "tetraction/core/blas.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"

namespace tetraction {
namespace {

struct RunArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  bool quiet = false;
  bool json = false;
};

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
  print_result(
      "mesh: {} vertices, {} tetrahedra; mass {:.6g} kg; {} of {} degrees of freedom free\n",
      session.system().vertex_count(), session.system().mesh().tetrahedron_count(),
      session.system().total_mass(), session.system().coordinates().count(),
      session.system().dof_count());
  print_result("stability limit of the explicit rules: h_crit = {:.6g} s\n",
               session.initial_limit().critical_step);
  print_result(
      "energy [J]: kinetic {:.6g}, elastic {:.6g}, environment {:.6g}, total {:.6g}; largest error "
      "{:.3g} of what entered\n",
      e.kinetic(), e.elastic(), e.environment(), e.total(), balance.max_relative_energy_drift());
  print_result("work [J]: user forces {:.6g}, dissipated {:.6g}, constraints {:.6g}",
               balance.external_work(), balance.dissipated_energy(), balance.constraint_work());
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
  print_result("results: {0}/history.csv, {1}{0}/frames.pvd, {0}/final.vtu, {0}/summary.json\n",
               directory, session.scene().probe.empty() ? "" : directory + "/probes.csv, ");
}

int run(const RunArguments& arguments) {
  const Scene scene = read_scene(arguments.scene, arguments.overrides);
  const std::string directory = arguments.out.empty() ? scene.output.directory : arguments.out;
  check_folder_of_run(scene, directory);
  const auto start = std::chrono::steady_clock::now();
  TetMesh mesh = load_mesh(scene);
  const std::chrono::duration<double> mesh_time = std::chrono::steady_clock::now() - start;
  if (!arguments.quiet) {
    if (const std::string remarks = mesh_remarks(mesh); !remarks.empty()) print_note(remarks);
  }
  make_output_directory(directory);
  Session session(scene, std::move(mesh));
  session.add_mesh_time(mesh_time.count());
  // A slow BLAS affects only the time. --quiet leaves this warning out; summary.json has it.
  const std::string slow_blas = arguments.quiet ? blas_warning() : "";
  for (const std::string& warning : session.warnings()) {
    if (warning != slow_blas || slow_blas.empty()) print_warning(warning);
  }
  const std::size_t told = session.warnings().size();

  RunRecorder recorder(directory, scene.output.every);
  InterruptGuard interrupt;
  ProgressBar bar("running");
  std::vector<Observer*> observers{&recorder, &interrupt};
  if (!arguments.quiet && ProgressBar::possible()) observers.push_back(&bar);
  const RunStatus status = session.run(observers);

  if (arguments.json) {
    write_result(recorder.summary());
  } else if (!arguments.quiet) {
    print_outcome(session, directory);
  }
  for (std::size_t i = told; i < session.warnings().size(); ++i) {
    print_warning(session.warnings()[i]);
  }
  for (const AppliedEdit& edit : session.edits()) {
    if (!edit.warning.empty()) {
      print_warning(fmt::format("after the event at {:.6g} s: {}", edit.at, edit.warning));
    }
  }
  if (!session.message().empty()) print_message(session.message());
  return tetraction::exit_code(status);
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Run a scene and write its results");
  command->add_option("scene", arguments->scene, "Scene file (TOML)")->required();
  command->add_option("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  command
      ->add_option("--set", arguments->overrides,
                   "KEY=VALUE: overrides a scene key, e.g. time.step=1e-4")
      ->take_all()
      ->allow_extra_args(false);
  command->add_flag("--quiet", arguments->quiet, "Only warnings and errors");
  command->add_flag("--json", arguments->json, "Print summary.json to stdout");
  command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace tetraction
