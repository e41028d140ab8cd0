#include "study_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <tuple>

#include "core/spelling.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Whether `name` is the run's directory. The step may be written in another way: midpoint-2.4e-4
// for midpoint-0.00024.
bool is_name_of(const std::string& name, const PlannedRun& run) {
  const std::string step = fmt::format("{:.10g}", run.step);
  const std::size_t place = run.directory.rfind(step);
  const std::string before = run.directory.substr(0, place);
  const std::string after = run.directory.substr(place + step.size());
  if (name.size() <= before.size() + after.size() || name.rfind(before, 0) != 0 ||
      name.substr(name.size() - after.size()) != after) {
    return false;
  }
  const std::string number = name.substr(before.size(), name.size() - before.size() - after.size());
  char* end = nullptr;
  const double value = std::strtod(number.c_str(), &end);
  return *end == '\0' && fmt::format("{:.10g}", value) == step;
}

}  // namespace

const PlannedRun& run_to_look_at(const StudyPlan& plan) {
  const TimeSettings& time = plan.variants.front().scene.time;
  const double step = time.automatic ? 0.5 * plan.stable_step : time.step;
  const auto distance = [&](const PlannedRun& run) {
    const double of_step = std::abs(std::log(run.step / step));
    const bool is_the_scenes =
        run.rule() == time.integrator && run.variant == 0 && !run.compares_solver;
    return std::make_tuple(run.role == StudyRole::kReference || run.role == StudyRole::kTrial,
                           !is_the_scenes, of_step);
  };
  return *std::min_element(
      plan.runs.begin(), plan.runs.end(),
      [&](const PlannedRun& a, const PlannedRun& b) { return distance(a) < distance(b); });
}

std::vector<std::string> runs_with_frames(const std::vector<std::string>& wanted,
                                          const StudyPlan& plan) {
  const std::string first = run_to_look_at(plan).directory;
  if (wanted.empty()) return {first};
  const std::vector<PlannedRun>& runs = plan.runs;
  std::vector<std::string> found;
  for (const std::string& name : wanted) {
    if (name == "all" || name == "none") {
      if (wanted.size() > 1) {
        throw InputError(
            fmt::format("--frames: \"{}\" cannot be combined with the names of runs: leave one or "
                        "the other out.",
                        name));
      }
      if (name == "none") return {};
      found.push_back(first);
      for (const PlannedRun& run : runs) {
        if (run.directory != first) found.push_back(run.directory);
      }
      return found;
    }
    const auto run = std::find_if(runs.begin(), runs.end(),
                                  [&](const PlannedRun& r) { return is_name_of(name, r); });
    if (run == runs.end()) {
      NameList names{"all", "none"};
      for (const PlannedRun& r : runs) names.push_back(r.directory);
      throw InputError(fmt::format("--frames {}: the study has no such run. Valid are {}.", name,
                                   listing(names)));
    }
    if (std::count(found.begin(), found.end(), run->directory) > 0) {
      throw InputError(fmt::format("--frames: {} is there twice.", name));
    }
    found.push_back(run->directory);
  }
  return found;
}

}  // namespace tetraction
