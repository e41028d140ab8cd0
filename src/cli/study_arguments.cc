#include "study_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

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

// Those with settings follow their integrator.
std::vector<StudyRule> read_rules(const StudyArguments& arguments) {
  std::vector<std::string> names = arguments.integrators;
  if (names.empty()) names = rules_with_steps(arguments.steps);
  std::vector<StudyRule> rules;
  for (const std::string& name : names) {
    const Integrator rule = integrator_from_string(name);
    if (std::count(rules.begin(), rules.end(), StudyRule(rule)) > 0) {
      throw InputError(fmt::format("--integrators: {} is there twice.", name));
    }
    rules.emplace_back(rule);
  }
  if (names.empty()) rules.assign(all_integrators().begin(), all_integrators().end());
  for (const std::string& text : arguments.rules) {
    const StudyRule rule = read_study_rule(text);
    if (std::count(rules.begin(), rules.end(), rule) > 0) {
      throw InputError(fmt::format("--rule: {} is there twice.", to_string(rule)));
    }
    const auto last = std::find_if(rules.rbegin(), rules.rend(), [&](const StudyRule& other) {
      return other.integrator == rule.integrator;
    });
    rules.insert(last == rules.rend() ? rules.end() : last.base(), rule);
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
  if (!arguments.reference_integrator.empty()) {
    requests.reference_integrator = integrator_from_string(arguments.reference_integrator);
  }
  if (requests.target && !arguments.steps.empty()) {
    throw InputError(
        "--target searches for the steps itself: leave --steps out, or --target if these steps are "
        "meant.");
  }
  return requests;
}

StudyPart read_part(const std::string& text) {
  if (text.empty()) return {};
  const auto number = [](std::string_view digits) {
    std::size_t value = 0;
    const auto [end, problem] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc() && end == digits.data() + digits.size() ? value : 0;
  };
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::size_t part = number(std::string_view(text).substr(0, slash));
  const std::size_t count = number(std::string_view(text).substr(std::min(slash + 1, text.size())));
  if (part < 1 || part > count) {
    throw InputError(fmt::format(
        "--part {}: write K/N with K from 1 to N, such as --part 2/3 for the second of three jobs.",
        in_quotes(text)));
  }
  return {part - 1, count};
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
  list("--integrators", arguments->integrators,
       fmt::format("Comma-separated: {} (default: all, or those that --steps names)",
                   fmt::join(integrator_names(), ",")))
      ->delimiter(',');
  list("--rule", arguments->rules,
       "INTEGRATOR:KEY=VALUE,...: one more rule, with settings of its own of [solver] or [time], "
       "e.g. midpoint:solver.tolerance=1e-6 or midpoint:time.adapt=error. It has the steps of its "
       "integrator.")
      ->check(not_empty("it names no rule"));
  list("--steps", arguments->steps,
       "Comma-separated steps of all rules, or of one: verlet=5e-6,auto. In s, in h_crit (4x), in "
       "the excited period (0.02T), or auto (default: steps with errors of 0.1 to 10 %)")
      ->check(not_empty("it names no step"));
  text("--budget", arguments->budget,
       "Time for what the program chooses itself: 10s, 2min, 1h (default: 1min). Steps that are "
       "given are always run.");
  text("--target", arguments->target,
       "Find the largest step of each rule whose error is at most this, such as 1%")
      ->check(not_empty("it names no error"));
  text("--part", arguments->part,
       "K/N: make only every N-th run, as job K of N. study merge joins the parts")
      ->check(not_empty("it names no part"));
  command.add_flag("--plan", arguments->plan,
                   "Print the runs and their estimated times, and write nothing");
  text("--reference", arguments->reference,
       "run: the reference is one run (default). richardson: it is extrapolated from "
       "runs with twice, once and half the reference step, and its error is estimated.")
      ->check(not_empty("it names no kind of reference"));
  command.add_option("--reference-step", arguments->reference_step,
                     "Step of the reference run (default: the finest of the study, or chosen with "
                     "the steps)");
  text("--reference-integrator", arguments->reference_integrator,
       "Integrator of the reference run (default: midpoint, or chosen with the steps)")
      ->check(not_empty("it names no integrator"));
  list("--vary", arguments->vary,
       "KEY=V1,V2,...: makes the whole study with each value of a scene key, e.g. "
       "fix.0.mode=exact,penalty. Several --vary give all combinations. Each variant is "
       "compared with a reference of its own; those that differ in solver keys only share one.")
      ->check(not_empty("it names no key"));
  list("--also-solver", arguments->also_solvers,
       "Comma-separated SOLVER@STEP, e.g. ceres@1e-3: each adds a run with another "
       "solver than the scene's and the first implicit integrator of the study")
      ->delimiter(',');
  list("--frames", arguments->frames,
       "Runs that write frames for ParaView and the viewer: all, none, or a comma-separated list "
       "of their folders, e.g. midpoint-0.01 (default: the scene's integrator at the step "
       "nearest to the scene's)")
      ->delimiter(',');
  text("--error", arguments->error,
       "probe.NAME, peak.probe.NAME or frequency.probe.NAME: orders, steps and plots use the "
       "error of this probe over time, of its peak or of its frequency instead of that of the "
       "final positions. energy.COLUMN: the error of an energy of history.csv over time, such as "
       "energy.kinetic_energy")
      ->check(not_empty("it names no error"));
  text("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  list("--set", arguments->overrides, "KEY=VALUE: overrides a scene key");
  command
      .add_option("--jobs", arguments->jobs,
                  "Number of runs that are made at the same time (default: 1), each with --threads "
                  "threads. Wall times count only where the machine has a core for each thread of "
                  "all these runs.")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--repeats", arguments->repeats,
                  "How often short runs are made again, to see how much their times vary (default: "
                  "2; 0: never). This takes at most a tenth of --budget.")
      ->check(CLI::Range(0, 100));
  command.add_flag("--mesh-check", arguments->mesh_check,
                   "Make one run on a mesh with half the edges, too, which tells the error of the "
                   "mesh (of the first variant)");
  command.add_flag("--fresh", arguments->fresh,
                   "Delete what an earlier study has left in the directory, and make all runs anew "
                   "(default: runs that compute the same are kept)");
  command.add_flag("--resume", arguments->resume, "Nothing: runs are always kept without --fresh")
      ->excludes("--fresh");
  add_view_options(command, arguments->view);
  add_drawing_options(command, arguments->drawing);
  return arguments;
}

}  // namespace tetraction
