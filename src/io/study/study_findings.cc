// What the search of steps found for each rule, in sentences and in numbers.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "study_answer.h"
#include "study_names.h"
#include "study_row_json.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr std::array kWords{"met", "met, and only stability limits the step", "not met",
                            "not resolved within the budget", "error not known"};

std::string word_of(TargetOutcome outcome) {
  return kWords[static_cast<std::size_t>(outcome)];
}

TargetOutcome outcome_of(const std::string& word) {
  const auto found = std::find(kWords.begin(), kWords.end(), word);
  if (found == kWords.end()) throw InputError(word);
  return static_cast<TargetOutcome>(found - kWords.begin());
}

// The number of steps of that length, or 0 without one.
Index count_of_steps(const nlohmann::json& step, double end) {
  if (step.is_null()) return 0;
  const double count = std::round(end / step.get<double>());
  if (!(count >= 1.0 && count < 1e15)) throw InputError("no step");
  return static_cast<Index>(count);
}

// A number of runs, which are few.
int count_of_runs(const nlohmann::json& runs) {
  const double count = runs.get<double>();
  if (!(count >= 0.0 && count < 1e4)) throw InputError("no number of runs");
  return static_cast<int>(count);
}

double step_of(const StudyResult& result, Index n) {
  return n > 0 ? result.end / static_cast<double>(n) : std::numeric_limits<double>::quiet_NaN();
}

// "1.2e-3 s (16 h_crit)".
std::string step_text(const StudyResult& result, Integrator rule, Index n) {
  StudyRow row;
  row.step = step_of(result, n);
  row.stable_step = result.stable_step;
  for (const StudyRow& other : result.rows) {
    if (other.integrator == rule) {
      row.stable_step = other.stable_step;
      break;
    }
  }
  return short_number(row.step) + " s" + in_limits(row);
}

std::string target_sentence(const StudyResult& result, const RuleFinding& finding) {
  const TargetStep& found = *finding.target;
  const Integrator rule = finding.rule;
  const std::string name = capitalised(to_string(StudyRule(rule, finding.settings)));
  const std::string target = short_number(100.0 * *result.target) + " %";
  const std::string runs =
      fmt::format("{} run{}", found.runs.size(), found.runs.size() == 1 ? "" : "s");
  if (found.n == 0) {
    std::string text =
        fmt::format("{}: {} is {} after {}", name, target, word_of(found.outcome), runs);
    if (std::isfinite(found.trial.error)) {
      text += fmt::format("; the smallest error is {}", short_number(found.trial.error));
    }
    return text + ".";
  }
  const bool is_limit = found.outcome == TargetOutcome::kStability;
  std::string text =
      fmt::format("{} meets {} with h = {}, where its error is {}, found in {}{}.", name, target,
                  step_text(result, rule, found.n), short_number(found.trial.error), runs,
                  is_limit ? "; only stability limits the step" : "");
  if (found.outcome == TargetOutcome::kNoBudget) {
    text += " The budget was too small to try larger steps.";
  } else if (!found.is_monotone) {
    text += " Larger steps may meet it as well, because the errors do not grow steadily.";
  }
  return text;
}

std::string stable_sentence(const StudyResult& result, Integrator rule, const StableStep& found) {
  const std::string runs = fmt::format("{} run{}", found.runs, found.runs == 1 ? "" : "s");
  const auto text = [&](Index n) { return step_text(result, rule, n); };
  const std::string name = to_string(rule);
  if (found.stable == 0) {
    return fmt::format("{} does not reach the end with h = {}, as {} showed.", capitalised(name),
                       text(found.unstable), runs);
  }
  if (found.unstable == 0) {
    return fmt::format("{} is stable at least up to h = {}, as {} showed.", capitalised(name),
                       text(found.stable), runs);
  }
  return fmt::format("The largest stable step of {} is {}, and {} is too long, as {} showed.", name,
                     text(found.stable), text(found.unstable), runs);
}

}  // namespace

std::vector<std::string> finding_sentences(const StudyResult& result) {
  std::vector<std::string> sentences;
  for (const RuleFinding& finding : result.findings) {
    if (finding.target && result.target) {
      sentences.push_back(target_sentence(result, finding));
    }
    if (finding.stable && finding.stable->runs > 0) {
      sentences.push_back(stable_sentence(result, finding.rule, *finding.stable));
    }
  }
  return sentences;
}

std::vector<std::string> mesh_sentences(const StudyResult& result) {
  std::vector<std::string> sentences;
  if (!result.mesh_check) return sentences;
  const MeshCheck& check = *result.mesh_check;
  if (check.status != RunStatus::kFinished) {
    sentences.push_back(
        fmt::format("The run on the finer mesh with {} tetrahedra did not reach the end ({}), so "
                    "that the error of the mesh is not known.",
                    check.tetrahedra, to_string(check.status)));
  } else if (std::isfinite(check.difference)) {
    sentences.push_back(
        fmt::format("The finer mesh with {} tetrahedra differs by {}: steps whose error is much "
                    "below that gain nothing on this mesh.",
                    check.tetrahedra, short_number(100.0 * check.difference) + " %"));
  }
  return sentences;
}

std::vector<std::string> trouble_sentences(const StudyAnswer& answer) {
  std::vector<std::pair<std::string, std::vector<std::string>>> rules_with;
  for (const RuleTrouble& trouble : answer.troubles) {
    auto same = std::find_if(rules_with.begin(), rules_with.end(),
                             [&](const auto& each) { return each.first == trouble.reason; });
    if (same == rules_with.end()) {
      rules_with.emplace_back(trouble.reason, std::vector<std::string>{});
      same = std::prev(rules_with.end());
    }
    same->second.push_back(trouble.rule + (trouble.run.empty() ? "" : " (" + trouble.run + ")"));
  }
  std::vector<std::string> sentences;
  for (const auto& [reason, rules] : rules_with) {
    sentences.push_back(fmt::format("Runs with {} {}.", enumeration(rules), reason));
  }
  return sentences;
}

nlohmann::ordered_json findings_json(const StudyResult& result) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RuleFinding& finding : result.findings) {
    nlohmann::ordered_json json{{"rule", to_string(StudyRule(finding.rule, finding.settings))}};
    if (finding.target && result.target) {
      const TargetStep& found = *finding.target;
      json["target"] = {{"target", *result.target},
                        {"is_met", found.n > 0},
                        {"outcome", word_of(found.outcome)},
                        {"step", json_number(step_of(result, found.n))},
                        {"error", json_number(found.trial.error)},
                        {"runs", found.runs.size()},
                        {"is_monotone", found.is_monotone}};
    }
    if (finding.stable) {
      json["stability"] = {
          {"stable_step", json_number(step_of(result, finding.stable->stable))},
          {"unstable_step", json_number(step_of(result, finding.stable->unstable))},
          {"runs", finding.stable->runs}};
    }
    list.push_back(std::move(json));
  }
  return list;
}

std::vector<RuleFinding> findings_from_json(const nlohmann::json& list, double end) {
  std::vector<RuleFinding> findings;
  for (const nlohmann::json& json : list) {
    RuleFinding finding{integrator_from_string(json.at("rule").get<std::string>()), {}, {}};
    if (json.contains("target")) {
      const nlohmann::json& found = json["target"];
      TargetStep target;
      target.outcome = outcome_of(found.at("outcome").get<std::string>());
      target.n = count_of_steps(found.at("step"), end);
      const nlohmann::json& error = found.at("error");
      target.trial.error = error.is_null() ? std::nan("") : error.get<double>();
      target.runs.resize(static_cast<std::size_t>(count_of_runs(found.at("runs"))));
      target.is_monotone = found.at("is_monotone").get<bool>();
      finding.target = std::move(target);
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
