#include "study_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "commands/commands.h"

namespace tetraction {

std::shared_ptr<StudyArguments> add_study_options(CLI::App& command) {
  auto arguments = std::make_shared<StudyArguments>();
  StudyOptions& study = arguments->study;
  const auto list = [&](const char* name, std::vector<std::string>& value,
                        const std::string& help) {
    return command.add_option(name, value, help)->take_all()->allow_extra_args(false);
  };
  const auto text = [&](const char* name, std::string& value, const char* help) {
    return command.add_option(name, value, help);
  };
  command.add_option(
      "scene", arguments->scene,
      "Scene file (TOML). Write ./diff for a file whose name is diff, open or merge.");
  list("--integrators", study.integrators,
       fmt::format("Comma-separated: {} (default: all, or those that --steps names)",
                   fmt::join(integrator_names(), ",")))
      ->delimiter(',');
  list("--rule", study.rules,
       "INTEGRATOR:KEY=VALUE,...: one more rule, with settings of its own of [solver] or [time], "
       "e.g. midpoint:solver.tolerance=1e-6 or midpoint:time.adapt=error. It has the steps of its "
       "integrator.")
      ->check(not_empty("it names no rule"));
  list("--steps", study.steps,
       "Comma-separated steps of all rules, or of one: verlet=5e-6,auto. In s, in h_crit (4x), in "
       "the excited period (0.02T), or auto (default: steps with errors of 0.1 to 10 %)")
      ->check(not_empty("it names no step"));
  text("--budget", study.budget,
       "Time for what the program chooses itself: 10s, 2min, 1h (default: 1min). Steps that are "
       "given are always run.");
  text("--target", study.target,
       "Find the largest step of each rule whose error is at most this, such as 1%")
      ->check(not_empty("it names no error"));
  text("--part", study.part,
       "K/N: make only every N-th run, as job K of N. study merge joins the parts")
      ->check(not_empty("it names no part"));
  command.add_flag("--plan", study.plan,
                   "Print the runs and their estimated times, and write nothing");
  text("--reference", study.reference,
       "run: the reference is one run (default). richardson: it is extrapolated from "
       "runs with twice, once and half the reference step, and its error is estimated.")
      ->check(not_empty("it names no kind of reference"));
  command
      .add_option("--reference-step", study.reference_step,
                  "Step of the reference run (default: the finest of the study, or chosen with "
                  "the steps)")
      ->check([](const std::string& number) {
        return number.find_first_of("xX") == std::string::npos
                   ? std::string()
                   : "it is no decimal number of seconds, such as 1e-3";
      });
  text("--reference-integrator", study.reference_integrator,
       "Integrator of the reference run (default: midpoint, or chosen with the steps)")
      ->check(not_empty("it names no integrator"));
  list("--vary", study.vary,
       "KEY=V1,V2,...: makes the whole study with each value of a scene key, e.g. "
       "fix.0.mode=exact,penalty. Several --vary give all combinations. Each variant is "
       "compared with a reference of its own; those that differ in solver keys only share one.")
      ->check(not_empty("it names no key"));
  list("--also-solver", study.also_solvers,
       "Comma-separated SOLVER@STEP, e.g. ceres@1e-3: each adds a run with another "
       "solver than the scene's and the first implicit integrator of the study")
      ->delimiter(',');
  list("--frames", arguments->frames,
       "Runs that write frames for ParaView and the viewer: all, none, or a comma-separated list "
       "of their folders, e.g. midpoint-0.01 (default: the scene's integrator at the step "
       "nearest to the scene's)")
      ->delimiter(',');
  text("--error", study.error,
       "probe.NAME, peak.probe.NAME or frequency.probe.NAME: orders, steps and plots use the "
       "error of this probe over time, of its peak or of its frequency instead of that of the "
       "final positions. energy.COLUMN: the error of an energy of history.csv over time, such as "
       "energy.kinetic_energy")
      ->check(not_empty("it names no error"));
  text("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  list("--set", arguments->overrides, "KEY=VALUE: overrides a scene key");
  command
      .add_option("--jobs", study.jobs,
                  "Number of runs that are made at the same time (default: 1), each with --threads "
                  "threads. Wall times count only where the machine has a core for each thread of "
                  "all these runs.")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--repeats", study.repeats,
                  "How often short runs are made again, to see how much their times vary (default: "
                  "2; 0: never). This takes at most a tenth of --budget.")
      ->check(CLI::Range(0, 100));
  command.add_flag("--mesh-check", study.mesh_check,
                   "Make one run on a mesh with half the edges, too, which tells the error of the "
                   "mesh (of the first variant)");
  command.add_flag("--fresh", study.fresh,
                   "Delete what an earlier study has left in the directory, and make all runs anew "
                   "(default: runs that compute the same are kept)");
  command.add_flag("--resume", arguments->resume, "Nothing: runs are always kept without --fresh")
      ->excludes("--fresh");
  add_view_options(command, arguments->view);
  add_drawing_options(command, arguments->drawing);
  return arguments;
}

}  // namespace tetraction
