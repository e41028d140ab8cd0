#include "tetraction/simulation/study_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "core/quoting.h"
#include "core/spelling.h"
#include "simulation/scene/setting_keys.h"
#include "simulation/stepping/step_count.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The number at the beginning of a text, and what follows it. Nothing if there is no finite number.
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  if (text.find_first_of(" \t\nxXiInN") == 0) return {};  // strtod takes blanks, inf and nan
  char* rest = nullptr;
  const double value = std::strtod(text.c_str(), &rest);
  if (rest == text.c_str() || !std::isfinite(value)) return {};
  return std::pair(value, std::string(rest));
}

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = text.find(',', begin);
    parts.push_back(text.substr(begin, comma - begin));
    if (comma == std::string::npos) return parts;
    begin = comma + 1;
  }
}

StepRequest read_step_request(const std::string& text) {
  if (text == "auto") return {StepUnit::kAuto, 0.0, text};
  const auto number = number_and_unit(text);
  const std::string unit = number ? number->second : "?";
  if (!number || (unit != "" && unit != "s" && unit != "x" && unit != "T")) {
    throw InputError(fmt::format(
        "--steps: {} is no step. Write a number of seconds (1e-3), a multiple of h_crit (4x), a "
        "part of the excited period (0.02T), or auto.",
        in_quotes(text)));
  }
  if (!(number->first > 0.0)) {
    throw InputError(fmt::format("--steps: {} is not positive. Steps are.", in_quotes(text)));
  }
  if (unit == "x") return {StepUnit::kStableSteps, number->first, text};
  return {unit == "T" ? StepUnit::kPeriods : StepUnit::kSeconds, number->first, text};
}

// Rules may have a sign of equality in their names, steps have none.
std::pair<std::string, std::string> rule_and_list(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) return {"", text};
  if (equals == 0) {
    throw InputError(
        fmt::format("--steps {}: the name of the rule is missing before the sign of "
                    "equality. Write --steps verlet=1e-5,auto.",
                    in_quotes(text)));
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

// The step in s, before it is made to divide the end.
double seconds_of(const StepRequest& request, const StudyRule& rule, double rule_limit,
                  const StepScales& scales) {
  if (request.unit == StepUnit::kPeriods) return request.value * scales.period();
  const bool is_auto = request.unit == StepUnit::kAuto;
  const double limit = is_auto ? rule_limit : scales.stable_step;
  if (!std::isfinite(limit)) {
    throw InputError(fmt::format(
        "--steps: {} of {} needs h_crit, but nothing in this scene limits the explicit rules. Give "
        "the step in s.",
        request.text, rule.name));
  }
  return (is_auto ? 0.5 : request.value) * limit;
}

double resolve_step(const StepRequest& request, const StudyRule& rule, double rule_limit,
                    const StepScales& scales) {
  const bool is_in_seconds = request.unit == StepUnit::kSeconds;
  double step = is_in_seconds ? request.value : seconds_of(request, rule, rule_limit, scales);
  // Half of h_crit may be longer than the study, which then is one step.
  if (request.unit == StepUnit::kAuto) step = std::min(step, scales.end);
  const std::string name = is_in_seconds ? fmt::format("The step {} s of {}", step, rule.name)
                                         : fmt::format("The step {} of {}, which is {:.6g} s,",
                                                       request.text, rule.name, step);
  if (step > scales.end * (1.0 + 1e-12)) {
    throw InputError(fmt::format(
        "{} must be at most the end time {} s. Ask for a shorter one, or make time.end larger.",
        name, scales.end));
  }
  if (scales.end / step > kMostSteps) {
    throw InputError(fmt::format(
        "{} makes more steps up to the end at {} s than can be counted: make it larger.", name,
        scales.end));
  }
  return is_in_seconds ? step
                       : scales.end / std::max(1.0, std::ceil(scales.end / step * (1.0 - 1e-9)));
}

const NameList& keys_of_rules() {
  static const NameList keys{"solver.kind",           "solver.linear", "solver.tolerance",
                             "solver.max_iterations", "time.adapt",    "time.tolerance",
                             "time.min_step",         "time.max_step", "time.retry"};
  return keys;
}

}  // namespace

bool StudyRule::has_adaptive_steps() const {
  return std::any_of(values.begin(), values.end(), [](const auto& value) {
    return value.first == "time.adapt" && value.second != "none";
  });
}

std::string to_string(const ErrorMeasure& measure) {
  const std::string kind = EnumNames<ErrorKind>::names[static_cast<std::size_t>(measure.kind)];
  return measure.kind == ErrorKind::kPositions ? kind : kind + "." + measure.name;
}

StudyRule read_study_rule(const std::string& text) {
  const std::size_t colon = text.find(':');
  StudyRule rule{text, integrator_from_string(text.substr(0, colon))};
  if (colon == std::string::npos) return rule;
  for (const std::string& entry : split_at_commas(text.substr(colon + 1))) {
    const std::size_t equals = entry.find('=');
    const std::string key = entry.substr(0, equals);
    if (equals == std::string::npos || equals + 1 == entry.size()) {
      throw InputError(
          fmt::format("--rule {}: {} is no setting. Write RULE:KEY=VALUE, for instance "
                      "midpoint:solver.tolerance=1e-6.",
                      in_quotes(text), in_quotes(entry)));
    }
    const NameList& keys = keys_of_rules();
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
      throw InputError(fmt::format(
          "--rule {}: {} is no setting of a rule: {}. Other keys can be compared with --vary.",
          in_quotes(text), in_quotes(key), advice(key, keys)));
    }
    rule.values.emplace_back(key, entry.substr(equals + 1));
  }
  return rule;
}

void apply_rule(const StudyRule& rule, Scene& scene) {
  scene.time.integrator = rule.integrator;
  for (const auto& [name, text] : rule.values) {
    const std::string place = fmt::format("--rule {}: {}", in_quotes(rule.name), name);
    const bool is_solver = name.starts_with("solver.");
    const SceneSection& section =
        is_solver ? section_of<SolverSettings>() : section_of<TimeSettings>();
    const SceneKey& key = *section.find(name.substr(name.find('.') + 1));
    Json value = Json::parse(text, nullptr, false);
    if (!value.is_number() && !value.is_boolean()) value = text;
    void* settings = is_solver ? static_cast<void*>(&scene.solver) : &scene.time;
    key.value->read(value, key.info.range, Refusal{[&] { return place; }}, settings);
  }
  check_settings(scene.solver);
  check_settings(scene.time);
}

std::vector<StepRequest> read_step_requests(const std::string& text) {
  std::vector<StepRequest> requests;
  for (const std::string& part : split_at_commas(text)) requests.push_back(read_step_request(part));
  return requests;
}

std::vector<std::string> rules_with_steps(const std::vector<std::string>& texts) {
  std::vector<std::string> names;
  for (const std::string& text : texts) {
    const std::string name = rule_and_list(text).first;
    if (name.empty()) return {};
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<std::vector<StepRequest>> assign_steps(const std::vector<std::string>& texts,
                                                   const std::vector<StudyRule>& rules) {
  std::vector<std::vector<StepRequest>> assigned(rules.size());
  NameList names;
  for (const StudyRule& rule : rules) names.emplace_back(rule.name);
  for (const std::string& text : texts) {
    const auto [name, list] = rule_and_list(text);
    const std::vector<StepRequest> requests = read_step_requests(list);
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
      throw InputError(fmt::format("--steps {}: {} is no rule of this study: {}", in_quotes(text),
                                   in_quotes(name), advice(name, names)));
    }
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (!name.empty() && name != rules[i].name) continue;
      assigned[i].insert(assigned[i].end(), requests.begin(), requests.end());
    }
  }
  return assigned;
}

ErrorMeasure read_error_measure(const std::string& text) {
  if (text.empty() || text == "position" || text == "positions") return {};
  for (const ErrorKind kind :
       {ErrorKind::kProbe, ErrorKind::kPeak, ErrorKind::kFrequency, ErrorKind::kEnergy}) {
    const std::string prefix = to_string(ErrorMeasure{kind});
    if (text.size() > prefix.size() && text.starts_with(prefix)) {
      return {kind, text.substr(prefix.size())};
    }
  }
  throw InputError(fmt::format(
      "--error {}: write positions, probe.NAME, peak.probe.NAME or frequency.probe.NAME with the "
      "name of a [[probe]] of the scene, or energy.COLUMN with a column of history.csv.",
      in_quotes(text)));
}

double read_duration(const std::string& text, const std::string& where) {
  const auto number = number_and_unit(text);
  const std::string unit = number ? number->second : "?";
  const double factor = unit == "s" ? 1.0 : unit == "min" ? 60.0 : unit == "h" ? 3600.0 : 0.0;
  if (factor == 0.0 || !(number->first > 0.0)) {
    throw InputError(fmt::format("{} {}: write a time with its unit, such as 10s, 2min or 1h.",
                                 where, in_quotes(text)));
  }
  return factor * number->first;
}

double read_share(const std::string& text, const std::string& where) {
  const auto number = number_and_unit(text);
  const bool is_percent = number && number->second == "%";
  const double share = number ? number->first * (is_percent ? 0.01 : 1.0) : 0.0;
  if (!number || (!is_percent && !number->second.empty()) || !(share > 0.0 && share < 1.0)) {
    throw InputError(
        fmt::format("{} {}: write a relative error between 0 and 100 %, such as 1% or 0.01.", where,
                    in_quotes(text)));
  }
  return share;
}

std::pair<int, int> read_part(const std::string& text, const std::string& where) {
  const auto first = number_and_unit(text);
  const bool has_slash = first && first->second.starts_with("/");
  const auto second = has_slash ? number_and_unit(first->second.substr(1)) : std::nullopt;
  const auto is_count = [](double value) {
    return value >= 1.0 && value <= 1e6 && value == std::floor(value);
  };
  if (!second || !second->second.empty() || !is_count(first->first) || !is_count(second->first) ||
      first->first > second->first) {
    throw InputError(fmt::format("{} {}: write k/n, such as 2/5 for the second of five parts.",
                                 where, in_quotes(text)));
  }
  return {static_cast<int>(first->first), static_cast<int>(second->first)};
}

ResolvedSteps resolve_steps(const std::vector<StepRequest>& requests, const StudyRule& rule,
                            double stable_step, const StepScales& scales) {
  ResolvedSteps resolved;
  const bool has_auto = is_implicit(rule.integrator) && !rule.has_adaptive_steps();
  resolved.has_ladder = requests.empty() && !rule.has_adaptive_steps();
  for (const StepRequest& request : requests) {
    if (request.unit == StepUnit::kAuto && has_auto) {
      resolved.has_ladder = true;
    } else {
      resolved.steps.push_back(resolve_step(request, rule, stable_step, scales));
    }
  }
  if (requests.empty() && rule.has_adaptive_steps()) {
    resolved.steps.push_back(
        resolve_step({StepUnit::kAuto, 0.0, "auto"}, rule, stable_step, scales));
  }
  std::vector<double>& steps = resolved.steps;
  std::sort(steps.begin(), steps.end());
  // Folders of runs have ten digits of the step.
  const auto same = [](double a, double b) { return b - a <= 1e-9 * a; };
  steps.erase(std::unique(steps.begin(), steps.end(), same), steps.end());
  return resolved;
}

Index series_above(double n) {
  if (!(n > 1.0)) return 1;
  n = std::min(n, kMostSteps);
  Index decade = 1;
  while (true) {
    for (const Index factor : {1, 2, 5}) {
      if (static_cast<double>(factor * decade) >= n * (1.0 - 1e-9)) return factor * decade;
    }
    decade *= 10;
  }
}

Index series_below(double n) {
  if (!(n > 1.0)) return 1;
  n = std::min(n, kMostSteps);
  Index decade = 1;
  while (static_cast<double>(10 * decade) <= n * (1.0 + 1e-9)) decade *= 10;
  Index below = decade;
  for (const Index factor : {2, 5}) {
    if (static_cast<double>(factor * decade) <= n * (1.0 + 1e-9)) below = factor * decade;
  }
  return below;
}

}  // namespace tetraction
