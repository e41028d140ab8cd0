// What the search of steps found for each rule, in sentences and as JSON, and what a finer mesh and the variants tell.
#include <fmt/format.h>
#include <fmt/ranges.h>

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

using VariantSentences = std::vector<std::string>;

// Which reference the variants have.
std::string references(const StudyResult& result, const std::string& first) {
  if (result.references.size() < 2) {
    return fmt::format(
        "All variants are compared with the reference of {0}, because they differ only in keys "
        "that leave the exact motion as it is. The other sentences are about {0}.",
        first);
  }
  return fmt::format(
      "The study has {} references, because the variants have different exact motions. Sentences "
      "that name no variant are about {}.",
      result.references.size(), first);
}

// Empty if no variant meets the target.
std::string cheapest_rules(const StudyAnswer& answer) {
  VariantSentences rules;
  double target = 0.0;
  for (const VariantAnswer& variant : answer.variants) {
    const RuleAnswer* best = variant.answer.best();
    if (best == nullptr) continue;
    target = variant.answer.target;
    if (std::find(rules.begin(), rules.end(), best->rule) == rules.end()) {
      rules.push_back(best->rule);
    }
  }
  if (rules.empty()) return {};
  return fmt::format(
      "For {} of {} the cheapest rule of {} is {}.", with_article(answer.error), percent(target),
      rules.size() == 1 ? "all variants that reach it" : "each variant", fmt::join(rules, " or "));
}

// The same for all variants, or the smallest and the largest one.
std::string stability_limits(const StudyAnswer& answer) {
  std::vector<const VariantAnswer*> known;
  for (const VariantAnswer& variant : answer.variants) {
    if (std::isfinite(variant.stable_step)) known.push_back(&variant);
  }
  if (known.size() < 2) return {};
  const auto [low, high] = std::minmax_element(known.begin(), known.end(),
                                               [](const VariantAnswer* a, const VariantAnswer* b) {
                                                 return a->stable_step < b->stable_step;
                                               });
  const double least = (*low)->stable_step;
  const double most = (*high)->stable_step;
  if (most - least <= 1e-3 * most) {
    return fmt::format("The stability limit is {} s for all variants.", short_number(least));
  }
  return fmt::format("The stability limit lies between {} s ({}) and {} s ({}).",
                     short_number(least), (*low)->name, short_number(most), (*high)->name);
}

std::string wall_times(const VariantAnswer& variant, const std::string& first) {
  const std::string least = two_digits(variant.least_cost_ratio);
  const std::string most = two_digits(variant.most_cost_ratio);
  return fmt::format("With equal rules and steps {} takes {} times the wall time of {}.",
                     variant.name, least == most ? least : least + " to " + most, first);
}

// How far the motion of the variants is from that of the first one. Empty if it is not known.
std::string farthest(const StudyResult& result, const StudyAnswer& answer,
                     const std::string& motion) {
  const auto far =
      std::max_element(answer.variants.begin(), answer.variants.end(),
                       [](const VariantAnswer& a, const VariantAnswer& b) {
                         return !std::isnan(b.difference) && !(a.difference >= b.difference);
                       });
  if (std::isfinite(far->difference)) {
    return fmt::format("The {} differs from that of {} by up to {} ({}).", motion,
                       answer.variants.front().name, percent(far->difference), far->name);
  }
  if (result.references.size() < 2 || !result.error_probe.empty()) return {};
  return "Positions on different meshes are not compared: --error probe.NAME compares the values "
         "of a probe.";
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
  return {fmt::format(
      "On a mesh with half the edge length ({} tetrahedra) the same run gives a result that "
      "differs by {}, so that the error of this mesh is about {} where the motion is smooth: time "
      "steps with a much smaller error gain nothing on it.",
      check->tetrahedra, percent(check->difference), percent(check->estimated_error()))};
}

std::vector<std::string> variant_sentences(const StudyResult& result, const StudyAnswer& answer) {
  if (answer.variants.size() < 2) return {};
  const std::string& first = answer.variants.front().name;
  const std::string motion = result.error_probe.empty() ? "motion" : quantity_name(result);
  VariantSentences sentences{references(result, first)};
  if (result.references.size() > 1) sentences.push_back(cheapest_rules(answer));
  sentences.push_back(stability_limits(answer));
  for (std::size_t i = 1; i < answer.variants.size() && answer.variants.size() <= kMostNamed; ++i) {
    if (std::isfinite(answer.variants[i].least_cost_ratio)) {
      sentences.push_back(wall_times(answer.variants[i], first));
    }
  }
  sentences.push_back(farthest(result, answer, motion));
  for (const auto& [key, variant, value] : answer.sensitivities) {
    sentences.push_back(answer.has_signed_changes
                            ? fmt::format("{} by 1 % changes the {} by about {}{} ({}).",
                                          capitalised("an increase of " + key),
                                          quantity_name(result), value < 0.0 ? "−" : "+",
                                          percent(0.01 * std::abs(value)), variant)
                            : fmt::format("A change of {} by 1 % changes the {} by about {} ({}).",
                                          key, motion, percent(0.01 * value), variant));
  }
  std::erase(sentences, "");
  return sentences;
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
