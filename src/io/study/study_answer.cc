#include "study_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "study_names.h"
#include "study_row_json.h"

namespace tetraction {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kTargets{0.1, 0.01, 0.001};
// Differences of positions above this are mostly differences of phase in motions of many periods.
constexpr double kLargeError = 0.3;
// Errors that differ by less are taken as equal, and costs that vary by less, too.
constexpr double kScatter = 0.1;
// Chance decides on shorter times, s.
constexpr double kShortestCompared = 0.05;

// Wall time over processor time of a run with one thread, above which the machine was busy.
constexpr double kBusy = 1.2;

class Facts {
 public:
  explicit Facts(const StudyResult& result) : result_(result) {
    std::size_t asked = 0;
    for (const StudyRow& row : result.rows) {
      if (row.variant != result.rows.front().variant) continue;
      if (row.role == StudyRole::kReference) continue;  // nobody asked for it
      rows_.push_back(&row);
      if (row.role == StudyRole::kVariant) continue;
      if (std::find(rules_.begin(), rules_.end(), rule_name(row)) == rules_.end()) {
        rules_.push_back(rule_name(row));
      }
      if (row.status == RunStatus::kFinished && !row.is_reference && std::isfinite(error_of(row))) {
        compared_.push_back(&row);
        asked += row.role == StudyRole::kRun ? 1U : 0U;
      }
    }
    answer_.has_comparable_costs =
        std::all_of(rows_.begin(), rows_.end(),
                    [&](const StudyRow* row) {
                      return row->processor == rows_.front()->processor &&
                             row->threads == rows_.front()->threads;
                    }) &&
        !rows_.empty();
    answer_.compared = compared_.size();
    answer_.asked = asked;
    answer_.shared = static_cast<std::size_t>(
        std::count_if(compared_.begin(), compared_.end(),
                      [](const StudyRow* row) { return row->shares_machine; }));
    // Other programs had the machine for a good part of the time of a run with one thread.
    const bool is_busy = std::any_of(compared_.begin(), compared_.end(), [](const StudyRow* row) {
      return row->threads == 1 && row->wall_seconds > kShortestCompared &&
             row->wall_seconds > kBusy * row->processor_seconds;
    });
    answer_.uses_processor_time =
        (answer_.shared > 0 || is_busy) &&
        std::all_of(compared_.begin(), compared_.end(),
                    [](const StudyRow* row) { return row->processor_seconds > 0.0; });
  }

  StudyAnswer all() {
    answer_.error = error_name(result_);
    answer_.reference_error = result_.reference_error;
    if (!compared_.empty()) {
      if (result_.target) {
        answer_.targets.push_back(for_target(*result_.target));
      } else {
        for (const double target : kTargets) answer_.targets.push_back(for_target(target));
      }
    }
    for (const std::string& rule : rules_) {
      if (auto trouble = trouble_of(rule)) answer_.troubles.push_back(std::move(*trouble));
    }
    judge_rules();
    return answer_;
  }

  TargetAnswer for_target(double target) const {
    TargetAnswer answer;
    answer.target = target;
    double least = kNoNumber;
    for (const std::string& rule : rules_) {
      answer.rules.push_back(of_rule(rule, target));
      const RuleAnswer& found = answer.rules.back();
      if (found.verdict == StudyVerdict::kMet) least = std::fmin(least, found.cost);
    }
    // A rule of which no run but the reference reached the end has nothing to be compared.
    std::erase_if(answer.rules,
                  [&](const RuleAnswer& rule) { return rule.run == nullptr && rule.note.empty(); });
    for (RuleAnswer& rule : answer.rules) {
      rule.relative_cost = rule.verdict == StudyVerdict::kMet ? rule.cost / least : kNoNumber;
    }
    return answer;
  }

 private:
  // The difference of the reference from itself, which may be one of the planned runs, is no error.
  double error_of(const StudyRow& row) const {
    const double error = result_.error_probe.empty() ? row.position_error : row.probe_error;
    const bool is_reference = error == 0.0 && row.directory == result_.reference_directory;
    return is_reference ? result_.reference_error : error;
  }

  double cost_of(const StudyRow& row) const {
    const double seconds = answer_.uses_processor_time ? row.processor_seconds
                           : row.shares_machine        ? kNoNumber
                                                       : row.wall_seconds;
    return answer_.has_comparable_costs && seconds > 0.0 ? seconds : kNoNumber;
  }

  double error_of_reference() const {
    return std::isfinite(result_.reference_error) ? result_.reference_error : 0.0;
  }

  RuleAnswer of_rule(const std::string& rule, double target) const {
    RuleAnswer answer;
    answer.rule = rule;
    if (const auto trouble = trouble_of(rule)) {
      answer.note = trouble->reason + (trouble->run.empty() ? "" : " (" + trouble->run + ")");
    }
    for (const StudyRow* row : compared_) {
      if (rule_name(*row) != rule) continue;
      const double error = error_of(*row);
      const StudyVerdict verdict = error + error_of_reference() <= target ? StudyVerdict::kMet
                                   : error <= target ? StudyVerdict::kNotResolved
                                                     : StudyVerdict::kNotMet;
      if (answer.run != nullptr && verdict > answer.verdict) continue;
      const bool is_better =
          answer.run == nullptr || verdict < answer.verdict ||
          (verdict == StudyVerdict::kMet ? is_larger(*row, *answer.run) : error < answer.error);
      if (is_better) {
        answer.verdict = verdict;
        answer.run = row;
        answer.error = error;
        answer.cost = cost_of(*row);
      }
    }
    if (answer.run == nullptr) answer.error = answer.cost = kNoNumber;
    return answer;
  }

  // A run whose cost is not known cannot be compared with those of other rules.
  bool is_larger(const StudyRow& a, const StudyRow& b) const {
    const bool is_known = std::isfinite(cost_of(a));
    return is_known == std::isfinite(cost_of(b)) ? a.step > b.step : is_known;
  }

  std::optional<RuleTrouble> trouble_of(const std::string& rule) const {
    const StudyRow* longest = nullptr;   // that reached the end
    const StudyRow* shortest = nullptr;  // that became unstable
    const StudyRow* failed = nullptr;
    for (const StudyRow* row : rows_) {
      if (rule_name(*row) != rule) continue;
      if (row->status == RunStatus::kFinished) {
        if (longest == nullptr || row->step > longest->step) longest = row;
      } else if (row->status == RunStatus::kUnstable) {
        if (shortest == nullptr || row->step < shortest->step) shortest = row;
      } else if (row->status == RunStatus::kNotConverged && failed == nullptr) {
        failed = row;
      }
    }
    if (shortest != nullptr && longest != nullptr && longest->step < shortest->step) {
      return RuleTrouble{rule, "", "are unstable above " + step_text(*longest)};
    }
    const StudyRow* row = shortest != nullptr ? shortest : failed;
    if (row == nullptr) return {};
    const bool is_above = !is_implicit(row->integrator) && is_above_stability_limit(*row);
    std::string reason = row == shortest ? "became unstable" : "failed";
    if (row == shortest && is_above) {
      reason += " above the stability limit";
    } else if (!reason_of(*row).empty()) {
      reason += ": " + reason_of(*row);
    }
    return RuleTrouble{rule,
                       fmt::format("h = {} s, at t = {} s", short_number(row->step),
                                   short_number(row->step * static_cast<double>(row->steps))),
                       reason};
  }

  // Orders, and whether errors fall with the step as those of a converging rule.
  void judge_rules() {
    for (const std::string& rule : rules_) {
      const StudyRow* finer = nullptr;  // of all runs
      const StudyRow* finer_with_error = nullptr;
      std::size_t place = 0;
      for (const StudyRow* row : rows_) {
        const bool is_other = row->role == StudyRole::kVariant || row->role == StudyRole::kTrial;
        if (rule_name(*row) != rule || is_other) continue;
        if (finer != nullptr && std::isfinite(row->observed_order) && !compared_.empty()) {
          answer_.orders.push_back({finer, row});
        }
        finer = row;
        if (std::find(compared_.begin(), compared_.end(), row) == compared_.end()) continue;
        const double error = error_of(*row);
        answer_.large_errors += error > kLargeError ? 1U : 0U;
        if (finer_with_error != nullptr) {
          const double before = error_of(*finer_with_error);
          const bool falls = error < (1.0 - kScatter) * before && before > 0.01;
          answer_.is_monotone = answer_.is_monotone && !falls;
          // The two finest runs have errors of their own that differ by the factor of their steps at least.
          const bool agree = row->step > 1.5 * finer_with_error->step &&
                             std::abs(error - before) < kScatter * before && error < kLargeError &&
                             before > 1e3 * round_off_level(*row);
          const bool is_own = row->integrator == result_.reference_integrator;
          // The largest samples of two steps may agree by chance.
          const bool may_tell =
              result_.error_kind != ErrorKind::kPeak && (!is_own || is_extrapolated(result_));
          if (place == 1 && agree && may_tell) {
            answer_.rule_beside_reference = rule;
          }
        }
        finer_with_error = row;
        ++place;
      }
    }
    answer_.compares_phase = result_.error_kind == ErrorKind::kProbe &&
                             (!answer_.is_monotone || 3 * answer_.large_errors > answer_.asked);
  }

  const StudyResult& result_;
  std::vector<const StudyRow*> rows_;      // of the first variant
  std::vector<const StudyRow*> compared_;  // those of them with an error
  std::vector<std::string> rules_;
  StudyAnswer answer_;
};

// The range of the ratio of the wall times of runs with the rule and step of one of the first variant.
void compare_costs(const StudyResult& result, VariantAnswer& variant) {
  variant.least_cost_ratio = variant.most_cost_ratio = kNoNumber;
  for (const StudyRow& row : result.rows) {
    if (row.variant != variant.name || row.status != RunStatus::kFinished) continue;
    for (const StudyRow& first : result.rows) {
      if (first.variant != result.rows.front().variant || first.step != row.step ||
          rule_name(first) != rule_name(row) || first.status != RunStatus::kFinished ||
          row.shares_machine || first.shares_machine || first.processor != row.processor ||
          first.threads != row.threads ||
          std::min(row.wall_seconds, first.wall_seconds) < kShortestCompared) {
        continue;
      }
      const double ratio = row.wall_seconds / first.wall_seconds;
      variant.least_cost_ratio = std::fmin(variant.least_cost_ratio, ratio);
      variant.most_cost_ratio = std::fmax(variant.most_cost_ratio, ratio);
    }
  }
}

double stable_step_of(const StudyResult& result, const std::string& variant) {
  for (const StudyRow& row : result.rows) {
    if (row.variant == variant) return row.stable_step;
  }
  return kNoNumber;
}

// The peak or the frequency in a run; NaN if it is not known.
double value_in(const StudyResult& result, const std::string& directory) {
  for (const StudyRow& row : result.rows) {
    if (row.directory == directory) return row.probe_value;
  }
  return kNoNumber;
}

// One line for each variant. Those that share a reference have no answer of their own.
void add_variants(const StudyResult& result, StudyAnswer& answer) {
  double target = kTargets[1];
  for (const TargetAnswer& each : answer.targets) {
    if (each.best() != nullptr && (each.target >= target || target == kTargets[0])) {
      target = each.target;
    }
  }
  answer.has_signed_changes = !value_name(result).empty();
  const std::vector<StudyResult> parts = parts_of_study(result);
  const auto places = references_of_variants(result);
  for (const VariantValues& values : result.variants) {
    VariantAnswer variant;
    variant.name = values.name;
    variant.values = values.values;
    variant.stable_step = stable_step_of(result, variant.name);
    variant.difference = variant.change = variant.reference_error = kNoNumber;
    compare_costs(result, variant);
    const auto place = places.find(values.name);
    if (place != places.end()) {
      const VariantReference& reference = result.references[place->second];
      const ReferenceDifference& difference = reference.difference;
      variant.difference = result.error_probe.empty() ? difference.position : difference.probe;
      variant.change = answer.has_signed_changes
                           ? std::log(value_in(result, reference.directory) /
                                      value_in(result, result.references.front().directory))
                           : variant.difference;
      variant.reference_error = reference.error;
      if (reference.variant == values.name) {
        const StudyResult& part = parts[place->second];
        variant.answer = Facts(part).for_target(target);
        // The rows of the whole study live longer than those of its part.
        for (RuleAnswer& rule : variant.answer.rules) {
          if (rule.run == nullptr) continue;
          rule.run = &*std::find_if(
              result.rows.begin(), result.rows.end(),
              [&](const StudyRow& row) { return row.directory == rule.run->directory; });
        }
      }
    }
    answer.variants.push_back(std::move(variant));
  }
}

std::optional<double> varied_number(const std::string& text) {
  double value = 0.0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() || !(value > 0.0)) return {};
  return value;
}

// Variants that differ from the first one in a single number.
void add_sensitivities(StudyAnswer& answer) {
  std::map<std::string, double> nearest;  // the logarithm of the ratio of the numbers
  for (const VariantAnswer& variant : answer.variants) {
    const VariedValue* varied = nullptr;
    const VariedValue* before = nullptr;
    int changes = 0;
    if (variant.values.size() != answer.variants.front().values.size()) continue;
    for (std::size_t i = 0; i < variant.values.size(); ++i) {
      if (variant.values[i].value == answer.variants.front().values[i].value) continue;
      varied = &variant.values[i];
      before = &answer.variants.front().values[i];
      ++changes;
    }
    if (changes != 1 || !std::isfinite(variant.change)) continue;
    const auto value = varied_number(varied->value);
    const auto first = varied_number(before->value);
    if (!value || !first) continue;
    const double ratio = std::log(*value / *first);
    const auto known = nearest.find(varied->key);
    if (known != nearest.end() && known->second <= std::abs(ratio)) continue;
    nearest[varied->key] = std::abs(ratio);
    std::erase_if(answer.sensitivities,
                  [&](const Sensitivity& other) { return other.key == varied->key; });
    answer.sensitivities.push_back(
        {varied->key, variant.name,
         variant.change / (answer.has_signed_changes ? ratio : std::abs(ratio))});
  }
}

nlohmann::ordered_json json_of(const RuleAnswer& rule) {
  nlohmann::ordered_json json{{"rule", rule.rule},
                              {"verdict", to_string(rule.verdict)},
                              {"error", json_number(rule.error)},
                              {"cost_seconds", json_number(rule.cost)},
                              {"relative_cost", json_number(rule.relative_cost)},
                              {"note", rule.note}};
  if (rule.run != nullptr) {
    json["step"] = rule.run->step;
    json["step_over_stable_step"] = json_number(rule.run->step / rule.run->stable_step);
    json["max_relative_energy_drift"] = json_number(rule.run->max_relative_energy_drift);
    json["time_scatter"] = json_number(rule.run->time_scatter);
    json["directory"] = rule.run->directory;
    json["value"] = json_number(rule.run->probe_value);
  }
  return json;
}

}  // namespace

std::string to_string(StudyVerdict verdict) {
  constexpr std::array kWords{"met", "not resolved", "not met", "failed"};
  return kWords[static_cast<std::size_t>(verdict)];
}

const RuleAnswer* TargetAnswer::best() const {
  const RuleAnswer* best = nullptr;
  for (const RuleAnswer& rule : rules) {
    if (rule.verdict != StudyVerdict::kMet || !std::isfinite(rule.cost)) continue;
    if (best == nullptr || rule.cost < best->cost) best = &rule;
  }
  return best;
}

StudyAnswer study_answer(const StudyResult& result) {
  if (result.rows.empty()) return {};
  StudyAnswer answer = Facts(result).all();
  add_variants(result, answer);
  if (answer.variants.size() > 1) add_sensitivities(answer);
  return answer;
}

nlohmann::ordered_json answer_json(const StudyAnswer& answer) {
  const auto target_json = [&](const TargetAnswer& target) {
    nlohmann::ordered_json json{{"target", target.target}};
    const RuleAnswer* best = target.best();
    json["cheapest"] = best != nullptr ? nlohmann::ordered_json(best->rule) : nullptr;
    json["rules"] = nlohmann::ordered_json::array();
    for (const RuleAnswer& rule : target.rules) json["rules"].push_back(json_of(rule));
    return json;
  };
  nlohmann::ordered_json json{{"error", answer.error},
                              {"reference_error", json_number(answer.reference_error)},
                              {"reference_is_the_error", !answer.rule_beside_reference.empty()},
                              {"compares_phase", answer.compares_phase},
                              {"cost", answer.uses_processor_time ? "processor" : "wall"},
                              {"targets", nlohmann::ordered_json::array()},
                              {"orders", nlohmann::ordered_json::array()}};
  for (const TargetAnswer& target : answer.targets) json["targets"].push_back(target_json(target));
  for (const auto& [finer, coarser] : answer.orders) {
    json["orders"].push_back({{"rule", rule_name(*coarser)},
                              {"steps", {finer->step, coarser->step}},
                              {"order", coarser->observed_order}});
  }
  if (answer.variants.empty()) return json;
  json["variants"] = nlohmann::ordered_json::array();
  for (const VariantAnswer& variant : answer.variants) {
    json["variants"].push_back({{"name", variant.name},
                                {"stable_step", json_number(variant.stable_step)},
                                {"difference", json_number(variant.difference)},
                                {"reference_error", json_number(variant.reference_error)},
                                {"answer", target_json(variant.answer)}});
  }
  json["sensitivities"] = nlohmann::ordered_json::array();
  for (const Sensitivity& each : answer.sensitivities) {
    json["sensitivities"].push_back({{"key", each.key},
                                     {"variant", each.variant},
                                     {"value", json_number(each.value)},
                                     {"has_sign", answer.has_signed_changes}});
  }
  return json;
}

}  // namespace tetraction
