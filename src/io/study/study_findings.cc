// What the search of steps found for each rule, in sentences and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "study_answer.h"
#include "study_names.h"
#include "study_row_json.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr std::array kWords{"met", "met, and only stability limits the step", "not met",
                            "not resolved within the budget", "error not known"};

TargetOutcome outcome_of(const std::string& word) {
  const auto found = std::find(kWords.begin(), kWords.end(), word);
  if (found == kWords.end()) throw InputError(word);
  return static_cast<TargetOutcome>(found - kWords.begin());
}

// A whole number from `least` that is less than `most`.
Index whole_number(double value, double least, double most) {
  if (!(value >= least && value < most)) throw InputError("no number of steps or runs");
  return static_cast<Index>(value);
}

// The number of steps of that length, or 0 without one.
Index count_of_steps(const nlohmann::json& step, double end) {
  return step.is_null() ? 0 : whole_number(std::round(end / step.get<double>()), 1.0, 1e15);
}

int count_of_runs(const nlohmann::json& runs) {
  return static_cast<int>(whole_number(runs.get<double>(), 0.0, 1e4));
}

// What the search of steps found beyond the table of the answer.
void say_target(const std::string& target, const RuleFinding& finding, SharedSentences& said) {
  const std::string rule = rule_name(finding);
  const TargetStep& found = *finding.target;
  if (found.outcome == TargetOutcome::kStability) {
    said.add("Only stability limits the steps of ", rule, ": all stable ones meet " + target + ".");
  } else if (found.n > 0 && found.outcome == TargetOutcome::kNoBudget) {
    said.add("The budget was too small to try larger steps of ", rule, ".");
  } else if (found.n > 0 && !found.is_monotone) {
    said.add("Larger steps of ", rule,
             " may meet " + target + " as well, because the errors do not grow steadily.");
  } else if (found.n == 0) {
    const bool is_cut = found.outcome == TargetOutcome::kNoBudget;
    const bool is_unknown = found.outcome == TargetOutcome::kNoError;
    said.add("The search found no step of ", rule,
             fmt::format(" that meets {}{}.", target,
                         is_cut       ? " within the budget"
                         : is_unknown ? ", because the errors are not known"
                                      : ""));
  }
}

std::string stable_sentence(const StudyResult& result, const RuleFinding& finding) {
  const auto text = [&](Index n) {
    StudyRow row;
    row.step = result.end / static_cast<double>(n);
    const auto same =
        std::find_if(result.rows.begin(), result.rows.end(),
                     [&](const StudyRow& other) { return other.integrator == finding.rule; });
    row.stable_step = same == result.rows.end() ? result.stable_step : same->stable_step;
    return step_text(row);
  };
  const std::string rule = rule_name(finding);
  const auto [stable, unstable, runs] = *finding.stable;
  if (stable == 0) {
    return fmt::format("{} does not reach the end with h = {}.", capitalised(rule), text(unstable));
  }
  if (unstable == 0) {
    return fmt::format("{} is stable at least up to h = {}.", capitalised(rule), text(stable));
  }
  return fmt::format("The largest stable step of {} is {}; it becomes unstable with {}.", rule,
                     text(stable), text(unstable));
}

bool has_stable_step(const RuleFinding& finding) {
  return finding.stable && finding.stable->runs > 0;
}

}  // namespace

std::vector<std::string> finding_sentences(const StudyResult& result) {
  SharedSentences said;
  for (const RuleFinding& finding : result.findings) {
    if (finding.target && result.target) say_target(percent(*result.target), finding, said);
  }
  std::vector<std::string> sentences = said.all();
  for (const RuleFinding& finding : result.findings) {
    if (has_stable_step(finding)) sentences.push_back(stable_sentence(result, finding));
  }
  return sentences;
}

std::vector<std::string> trouble_sentences(const StudyResult& result, const StudyAnswer& answer) {
  SharedSentences said;
  for (const RuleTrouble& trouble : answer.troubles) {
    const bool is_said = std::any_of(
        result.findings.begin(), result.findings.end(), [&](const RuleFinding& finding) {
          return has_stable_step(finding) && rule_name(finding) == trouble.rule;
        });
    if (trouble.run.empty() && is_said) continue;
    said.add("Runs with ", trouble.rule + (trouble.run.empty() ? "" : " (" + trouble.run + ")"),
             " " + trouble.reason + ".");
  }
  return said.all();
}

std::vector<std::string> mesh_sentences(const StudyResult& result) {
  const auto& check = result.mesh_check;
  if (!check) return {};
  if (check->status != RunStatus::kFinished) {
    return {fmt::format(
        "The run on the finer mesh with {} tetrahedra did not reach the end ({}), so that the "
        "error of the mesh is not known.",
        check->tetrahedra, to_string(check->status))};
  }
  if (!std::isfinite(check->difference)) return {};
  return {
      fmt::format("On a mesh with half the edge length ({} tetrahedra) the same run gives a result "
                  "that differs "
                  "by {}: time steps with a much smaller error gain nothing on this mesh.",
                  check->tetrahedra, percent(check->difference))};
}

nlohmann::ordered_json findings_json(const StudyResult& result) {
  const auto step_of = [&](Index n) {
    return json_number(n > 0 ? result.end / static_cast<double>(n) : std::nan(""));
  };
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& [rule, target, stable, settings] : result.findings) {
    nlohmann::ordered_json json{{"rule", to_string(StudyRule(rule, settings))}};
    if (target && result.target) {
      json["target"] = {{"target", *result.target},
                        {"is_met", target->n > 0},
                        {"outcome", kWords[static_cast<std::size_t>(target->outcome)]},
                        {"step", step_of(target->n)},
                        {"error", json_number(target->trial.error)},
                        {"runs", target->runs.size()},
                        {"is_monotone", target->is_monotone}};
    }
    if (stable) {
      json["stability"] = {{"stable_step", step_of(stable->stable)},
                           {"unstable_step", step_of(stable->unstable)},
                           {"runs", stable->runs}};
    }
    list.push_back(std::move(json));
  }
  return list;
}

std::vector<RuleFinding> findings_from_json(const nlohmann::json& list, double end) {
  std::vector<RuleFinding> findings;
  for (const nlohmann::json& json : list) {
    const auto name = json.at("rule").get<std::string>();
    const bool has_settings = name.find(':') != std::string::npos;
    const StudyRule rule =
        has_settings ? read_study_rule(name) : StudyRule(integrator_from_string(name));
    RuleFinding finding{rule.integrator, {}, {}, rule.settings};
    if (json.contains("target")) {
      const nlohmann::json& found = json["target"];
      TargetStep& target = finding.target.emplace();
      target.outcome = outcome_of(found.at("outcome").get<std::string>());
      target.n = count_of_steps(found.at("step"), end);
      const nlohmann::json& error = found.at("error");
      target.trial.error = error.is_null() ? std::nan("") : error.get<double>();
      target.runs.resize(static_cast<std::size_t>(count_of_runs(found.at("runs"))));
      target.is_monotone = found.at("is_monotone").get<bool>();
    }
    if (json.contains("stability")) {
      const nlohmann::json& found = json["stability"];
      finding.stable = StableStep{count_of_steps(found.at("stable_step"), end),
                                  count_of_steps(found.at("unstable_step"), end),
                                  count_of_runs(found.at("runs"))};
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace tetraction
