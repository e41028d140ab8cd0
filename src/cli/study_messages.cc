#include "study_messages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "cli/console.h"
#include "cli/study_arguments.h"
#include "io/results/result_folders.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"

namespace tetraction {
namespace {

// The number of steps of a run. Round-off makes no further one.
double step_count(const StudyPlan& plan, const PlannedRun& run) {
  return std::ceil(plan.end / run.step * (1.0 - 1e-9));
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
      second = fmt::format("; and one with {:.4g} s for its error, which makes {:.9g} steps",
                           run.step, count(run));
    }
    return fmt::format("{}: {} with steps of {:.4g} s, which makes {:.9g} steps{}", name, rule,
                       finest.step, count(finest), second);
  }
  std::vector<std::string> steps;
  double sum = 0.0;
  for (const std::size_t i : reference.runs) {
    steps.push_back(fmt::format("{:.4g}", plan.runs[i].step));
    sum += count(plan.runs[i]);
  }
  return fmt::format(
      "{}: Richardson extrapolation of {} with steps of {} s, which makes {:.9g} steps together",
      name, rule, fmt::join(steps, ", "), sum);
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

std::string text_of_plan(const StudyPlan& plan, const TetMesh& mesh, const StudyMemory& memory) {
  std::vector<PlanLine> lines;
  for (const PlannedRun& run : plan.runs) {
    if (run.is_left_out) continue;
    PlanLine line{run_text(plan, run), run.step};
    if (run.role == StudyRole::kTrial) line.run += " (trial)";
    if (run.role == StudyRole::kReference) line.run += " (reference)";
    line.steps = static_cast<Index>(step_count(plan, run));
    line.is_kept = memory.kept && memory.kept(run);
    if (!line.is_kept) line.seconds = estimated_seconds(plan, run, mesh);
    lines.push_back(std::move(line));
  }
  return plan_text(lines);
}

}  // namespace tetraction
