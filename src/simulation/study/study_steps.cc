#include "tetraction/simulation/study_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/quoting.h"
#include "core/spelling.h"
#include "simulation/stepping/step_count.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The number at the beginning of a text, and what follows it. Nothing if there is no finite number.
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  double value = 0.0;
  const auto [rest, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || !std::isfinite(value)) return {};
  return std::pair(value, std::string(rest, text.data() + text.size()));
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

// A list of steps and the rule that it is for, which is empty if it is for all of them. Rules with settings have signs
// of equality in their names.
std::pair<std::string, std::string> rule_and_list(const std::string& text,
                                                  const std::vector<StudyRule>& rules) {
  for (const StudyRule& rule : rules) {
    const std::string name = to_string(rule);
    if (text.starts_with(name + "=")) return {name, text.substr(name.size() + 1)};
  }
  const std::size_t equals = text.find('=');
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
double seconds_of(const StepRequest& request, Integrator rule, double rule_limit,
                  const StepScales& scales) {
  if (request.unit == StepUnit::kPeriods) return request.value * scales.period();
  const bool is_auto = request.unit == StepUnit::kAuto;
  const double limit = is_auto ? rule_limit : scales.stable_step;
  if (!std::isfinite(limit)) {
    throw InputError(fmt::format(
        "--steps: {} of {} needs h_crit, but nothing in this scene limits the explicit rules. Give "
        "the step in s.",
        request.text, to_string(rule)));
  }
  return (is_auto ? 0.5 : request.value) * limit;
}

double resolve_step(const StepRequest& request, Integrator rule, double rule_limit,
                    const StepScales& scales) {
  const bool is_in_seconds = request.unit == StepUnit::kSeconds;
  double step = is_in_seconds ? request.value : seconds_of(request, rule, rule_limit, scales);
  // Half of h_crit may be longer than the study, which then is one step.
  if (request.unit == StepUnit::kAuto) step = std::min(step, scales.end);
  const std::string name = is_in_seconds ? fmt::format("The step {} s of {}", step, to_string(rule))
                                         : fmt::format("The step {} of {}, which is {:.6g} s,",
                                                       request.text, to_string(rule), step);
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

}  // namespace

bool chooses_steps(const StudyRequests& requests) {
  bool chooses = requests.target.has_value();
  for (std::size_t i = 0; i < requests.rules.size(); ++i) {
    const std::vector<StepRequest>& steps = requests.steps[i];
    const bool has_auto = is_implicit(requests.rules[i].integrator) &&
                          std::any_of(steps.begin(), steps.end(), [](const StepRequest& step) {
                            return step.unit == StepUnit::kAuto;
                          });
    chooses = chooses || steps.empty() || has_auto;
  }
  return chooses;
}

std::string to_string(const std::vector<VariedValue>& settings) {
  std::string text;
  for (const VariedValue& setting : settings) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ", ", setting.key, setting.value);
  }
  return text;
}

std::string to_string(const StudyRule& rule) {
  std::string text = to_string(rule.integrator);
  for (std::size_t i = 0; i < rule.settings.size(); ++i) {
    text +=
        fmt::format("{}{}={}", i == 0 ? ":" : ",", rule.settings[i].key, rule.settings[i].value);
  }
  return text;
}

StudyRule read_study_rule(const std::string& text) {
  const std::size_t colon = text.find(':');
  StudyRule rule(integrator_from_string(text.substr(0, colon)));
  const std::string settings = colon == std::string::npos ? "" : text.substr(colon + 1);
  for (const std::string& part : split_at_commas(settings)) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == part.size()) {
      throw InputError(
          fmt::format("--rule {}: write INTEGRATOR:KEY=VALUE, with commas between several "
                      "settings, for instance --rule midpoint:solver.tolerance=1e-6.",
                      in_quotes(text)));
    }
    rule.settings.push_back({part.substr(0, equals), part.substr(equals + 1)});
  }
  std::sort(rule.settings.begin(), rule.settings.end());
  check_settings_of(rule);
  return rule;
}

std::string to_string(const ErrorMeasure& measure) {
  const std::string kind = EnumNames<ErrorKind>::names[static_cast<std::size_t>(measure.kind)];
  return measure.kind == ErrorKind::kPositions ? kind : kind + "." + measure.name;
}

std::vector<StepRequest> read_step_requests(const std::string& text) {
  std::vector<StepRequest> requests;
  for (const std::string& part : split_at_commas(text)) requests.push_back(read_step_request(part));
  return requests;
}

std::vector<std::string> rules_with_steps(const std::vector<std::string>& texts) {
  std::vector<std::string> names;
  for (const std::string& text : texts) {
    const std::string name = rule_and_list(text, {}).first;
    if (name.empty()) return {};
    const bool has_settings = name.find(':') != std::string::npos;
    if (!has_settings && std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
  }
  return names;
}

std::vector<std::vector<StepRequest>> assign_steps(const std::vector<std::string>& texts,
                                                   const std::vector<StudyRule>& rules) {
  std::map<std::string, std::vector<StepRequest>> lists;  // by rule; that for all has no name
  std::vector<std::string> names;
  for (const StudyRule& rule : rules) {
    names.push_back(to_string(rule.integrator));
    names.push_back(to_string(rule));
  }
  for (const std::string& text : texts) {
    const auto [name, list] = rule_and_list(text, rules);
    const std::vector<StepRequest> requests = read_step_requests(list);
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
      throw InputError(fmt::format("--steps {}: {} is no rule of this study: {}", in_quotes(text),
                                   in_quotes(name),
                                   advice(name, NameList(names.begin(), names.end()))));
    }
    std::vector<StepRequest>& all = lists[name];
    all.insert(all.end(), requests.begin(), requests.end());
  }
  std::vector<std::vector<StepRequest>> assigned;
  for (const StudyRule& rule : rules) {
    const bool is_named = lists.contains(to_string(rule));
    assigned.push_back(lists[is_named ? to_string(rule) : to_string(rule.integrator)]);
    const std::vector<StepRequest>& of_all = lists[""];
    assigned.back().insert(assigned.back().end(), of_all.begin(), of_all.end());
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

ResolvedSteps resolve_steps(const std::vector<StepRequest>& requests, Integrator rule,
                            double stable_step, const StepScales& scales) {
  ResolvedSteps resolved;
  resolved.has_ladder = requests.empty();
  for (const StepRequest& request : requests) {
    if (request.unit == StepUnit::kAuto && is_implicit(rule)) {
      resolved.has_ladder = true;
    } else {
      resolved.steps.push_back(resolve_step(request, rule, stable_step, scales));
    }
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
