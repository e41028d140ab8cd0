#include "study_messages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "cli/console.h"
#include "io/results/result_folders.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"

namespace tetraction {
namespace {

// "0.35 s", "12 s", "4 min", "3.1 h".
std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 120.0) return fmt::format("{:.2g} s", seconds);
  if (seconds < 7200.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

// What a run is made for that was not asked for, in parentheses.
std::string purpose_of(const StudyPlan& plan, const PlannedRun& run) {
  if (run.role == StudyRole::kTrial) return " (trial)";
  if (run.role != StudyRole::kReference) return {};
  const bool is_reference = std::any_of(
      plan.references.begin(), plan.references.end(), [&](const PlannedReference& reference) {
        return std::any_of(reference.runs.begin(), reference.runs.end(),
                           [&](std::size_t i) { return plan.runs[i].directory == run.directory; });
      });
  return is_reference ? " (reference)" : " (second run of the reference, for its error)";
}

}  // namespace

std::string reference_message(const StudyPlan& plan) {
  const PlannedReference& reference = plan.references.front();
  const auto count = [&](const PlannedRun& run) { return step_count(plan, run); };
  const std::string name = plan.references.size() == 1
                               ? "reference"
                               : fmt::format("each of the {} references", plan.references.size());
  const PlannedRun& finest = plan.finest_run(reference);
  const std::string rule = to_string(finest.integrator);
  if (reference.runs.size() == 1) {
    std::string second;
    for (const PlannedRun& run : plan.runs) {
      if (run.role != StudyRole::kReference || run.variant != finest.variant ||
          run.step == finest.step) {
        continue;
      }
      second = fmt::format("; and one with {:.4g} s for its error, which makes {} steps", run.step,
                           count(run));
    }
    return fmt::format("{}: {} with steps of {:.4g} s, which makes {} steps{}", name, rule,
                       finest.step, count(finest), second);
  }
  std::vector<std::string> steps;
  Index sum = 0;
  for (const std::size_t i : reference.runs) {
    steps.push_back(fmt::format("{:.4g}", plan.runs[i].step));
    sum += count(plan.runs[i]);
  }
  return fmt::format(
      "{}: Richardson extrapolation of {} with steps of {} s, which makes {} steps together", name,
      rule, fmt::join(steps, ", "), sum);
}

std::string jobs_message(int jobs) {
  const int threads = thread_count();
  const int cores = this_machine().cores;
  if (jobs * threads <= cores) return {};
  if (jobs == 1) {
    return fmt::format(
        "{} threads are more than the {} core{} of this machine: the wall times of the runs do not "
        "count. With --threads {} they would.",
        threads, cores, cores == 1 ? "" : "s", cores);
  }
  return fmt::format(
      "{} runs at a time with {} thread{} each need more than the {} core{} of this machine: the "
      "wall times of runs that share them do not count{}",
      jobs, threads, threads == 1 ? "" : "s", cores, cores == 1 ? "" : "s",
      jobs <= cores ? fmt::format(". With --threads {} they would.", cores / jobs) : "");
}

void tell_of_lost_runs(const std::string& directory, const StudyPlan& plan) {
  std::set<std::string> lost = lost_runs(directory);
  const std::set<std::string> asked = run_names(plan);
  std::erase_if(lost, [&](const std::string& run) { return !asked.contains(run); });
  if (lost.empty()) return;
  constexpr std::size_t kMost = 5;
  std::vector<std::string> some;
  for (const std::string& run : lost) {
    if (some.size() < kMost) some.push_back(run);
  }
  const std::string names =
      fmt::format("{}{}", fmt::join(some, ", "), lost.size() > kMost ? ", …" : "");
  print_note(
      lost.size() == 1
          ? fmt::format("{}: the folder of a complete run is no longer there, and the run is "
                        "made again: {}",
                        directory, names)
          : fmt::format("{}: the folders of {} complete runs are no longer there, and the "
                        "runs are made again: {}",
                        directory, lost.size(), names));
}

std::string run_text(const StudyPlan& plan, const PlannedRun& run) {
  const std::string& variant = plan.variants[run.variant].name;
  return fmt::format("{}{}{}{}", to_string(run.rule()), run.compares_solver ? " " : "",
                     run.compares_solver ? run.solver : "",
                     variant.empty() ? "" : " (" + variant + ")");
}

std::string text_of_plan(const StudyPlan& plan, const std::vector<PlannedTime>& runs) {
  std::vector<std::string> names;
  std::size_t width = 4;
  for (const PlannedTime& each : runs) {
    names.push_back(run_text(plan, each.run) + purpose_of(plan, each.run));
    width = std::max(width, names.back().size());
  }
  const char* row = "{:<{}}  {:>12}  {:>11}  {:>10}\n";
  std::string text = fmt::format(fmt::runtime(row), "rule", width, "step [s]", "steps", "about");
  double sum = 0.0;
  Index count = 0;
  bool is_known = true;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PlannedTime& each = runs[i];
    text += fmt::format(fmt::runtime(row), names[i], width, fmt::format("{:.6g}", each.run.step),
                        each.steps, each.is_kept ? "kept" : duration_text(each.seconds));
    if (each.is_kept) continue;
    ++count;
    is_known = is_known && std::isfinite(each.seconds);
    if (std::isfinite(each.seconds)) sum += each.seconds;
  }
  return text + fmt::format("{} run{} to make, which take {}{}\n", count, count == 1 ? "" : "s",
                            is_known ? "about " : "at least ", duration_text(sum));
}

}  // namespace tetraction
