#include "study_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands/commands.h"
#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// "0.35 s", "12 s", "4 min", "3.1 h".
std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 120.0) return fmt::format("{:.2g} s", seconds);
  if (seconds < 7200.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

std::vector<StudyRule> read_rules(const StudyArguments& arguments) {
  std::vector<std::string> names = arguments.integrators;
  if (names.empty() && arguments.rules.empty()) names = rules_with_steps(arguments.steps);
  if (names.empty()) {
    for (const Integrator integrator : all_integrators()) names.push_back(to_string(integrator));
  }
  names.insert(names.end(), arguments.rules.begin(), arguments.rules.end());
  std::vector<StudyRule> rules;
  for (const std::string& name : names) {
    if (std::any_of(rules.begin(), rules.end(),
                    [&](const StudyRule& rule) { return rule.name == name; })) {
      const bool is_integrator = name.find(':') == std::string::npos;
      throw InputError(
          fmt::format("{}: {} is there twice.", is_integrator ? "--integrators" : "--rule", name));
    }
    rules.push_back(read_study_rule(name));
  }
  return rules;
}

}  // namespace

StudyRequests study_requests(const StudyArguments& arguments) {
  StudyRequests requests;
  requests.rules = read_rules(arguments);
  requests.steps = assign_steps(arguments.steps, requests.rules);
  requests.error = read_error_measure(arguments.error);
  requests.budget = read_duration(arguments.budget, "--budget");
  if (!arguments.target.empty()) requests.target = read_share(arguments.target, "--target");
  if (!arguments.part.empty()) requests.part = read_part(arguments.part, "--part");
  if (requests.target && !arguments.steps.empty()) {
    throw InputError(
        "--target searches for the steps itself: leave --steps out, or --target if these steps are "
        "meant.");
  }
  if (arguments.resume && arguments.fresh) {
    throw InputError(
        "--resume keeps the runs that are there, and --fresh makes all anew: leave one of them "
        "out.");
  }
  return requests;
}

std::string plan_text(const std::vector<PlanLine>& lines) {
  std::size_t width = 4;
  for (const PlanLine& line : lines) width = std::max(width, line.run.size());
  const char* row = "{:<{}}  {:>12}  {:>11}  {:>10}\n";
  std::string text = fmt::format(fmt::runtime(row), "rule", width, "step [s]", "steps", "about");
  double sum = 0.0;
  Index count = 0;
  bool is_known = true;
  for (const PlanLine& line : lines) {
    const bool has_time = line.is_kept || std::isfinite(line.seconds);
    text += fmt::format(fmt::runtime(row), line.run, width, fmt::format("{:.6g}", line.step),
                        line.steps, line.is_kept ? "kept" : duration_text(line.seconds));
    if (line.is_kept) continue;
    ++count;
    is_known = is_known && has_time;
    if (has_time) sum += line.seconds;
  }
  return text + fmt::format("{} run{} to make, which take {}{}\n", count, count == 1 ? "" : "s",
                            is_known ? "about " : "at least ", duration_text(sum));
}

std::shared_ptr<StudyArguments> add_study_options(CLI::App& command) {
  auto arguments = std::make_shared<StudyArguments>();
  const auto list = [&](const char* name, std::vector<std::string>& value, const char* help) {
    return command.add_option(name, value, help)->allow_extra_args(false);
  };
  const auto text = [&](const char* name, std::string& value, const char* help) {
    return command.add_option(name, value, help)->check(not_empty("it has no value"));
  };
  command.add_option("scene", arguments->scene,
                     "Scene file (TOML). Write ./diff, ./merge or ./open for a file of that name.");
  list("--integrators", arguments->integrators,
       "Comma-separated: explicit,verlet,midpoint,backward-euler,energy-momentum (default: all)")
      ->delimiter(',');
  list("--rule", arguments->rules,
       "A further rule with settings of its own, such as midpoint:solver.tolerance=1e-6 or "
       "midpoint:time.adapt=error")
      ->take_all();
  list("--steps", arguments->steps,
       "Comma-separated steps of all rules, or of one: verlet=5e-6,auto. In s, in h_crit (4x), in "
       "the excited period (0.02T), or auto (default: steps with errors of 0.1 to 10 %)")
      ->take_all();
  text("--budget", arguments->budget,
       "Time for what the program chooses itself: 10s, 2min, 1h (default: 1min). Steps that are "
       "given are always run.");
  text("--target", arguments->target,
       "Find the largest step of each rule whose error is at most this, such as 1%");
  command.add_flag("--plan", arguments->plan, "Print the runs and their estimated times, and stop");
  text("--reference", arguments->reference,
       "run: the reference is one run (default). richardson: it is extrapolated from three.");
  command.add_option("--reference-step", arguments->reference_step,
                     "Step of the reference (default: the finest of the study)");
  command.add_option("--reference-integrator", arguments->reference_integrator,
                     "Rule of the reference (default: midpoint)");
  list("--vary", arguments->vary,
       "KEY=V1,V2,...: the whole study with each value of a scene key. Several --vary give all "
       "combinations.")
      ->check(not_empty("it names no key"))
      ->take_all();
  list("--also-solver", arguments->also_solvers,
       "Comma-separated SOLVER@STEP, such as ceres@1e-3: further runs with another solver")
      ->delimiter(',');
  list("--frames", arguments->frames,
       "Runs that write frames: all, none, or a comma-separated list of their folders (default: "
       "the run nearest to the scene's own)")
      ->delimiter(',');
  text("--error", arguments->error,
       "What is compared: positions (default), probe.NAME, peak.probe.NAME, frequency.probe.NAME, "
       "energy.COLUMN");
  command.add_option("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  list("--set", arguments->overrides, "KEY=VALUE: overrides a scene key")->take_all();
  command
      .add_option("--jobs", arguments->jobs,
                  "Number of runs at the same time (default: 1), each with --threads threads")
      ->check(CLI::Range(1, 1024));
  text("--part", arguments->part, "k/n: only part k of n of the runs, to be merged later");
  command.add_flag("--resume", arguments->resume, "Go on with a study that was stopped");
  command.add_flag("--fresh", arguments->fresh, "Make all runs anew");
  command.add_flag("--all", arguments->all, "Print the table of all runs");
  text("--table", arguments->table, "Print the table for papers: markdown or latex")
      ->check(CLI::IsMember({"markdown", "latex"}));
  command.add_flag("--no-plots", arguments->no_plots, "Do not draw plots");
  command.add_flag("--quiet", arguments->quiet, "Only warnings and errors");
  command.add_flag("--json", arguments->json, "Print study.json to stdout");
  return arguments;
}

}  // namespace tetraction
