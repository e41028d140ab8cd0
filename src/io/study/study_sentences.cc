// The facts of a study in plain sentences.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "study_answer.h"
#include "study_names.h"

namespace tetraction {
namespace {

using Sentences = std::vector<std::string>;

// An observed order that differs by less agrees with the theoretical one.
constexpr double kOrderTolerance = 0.2;
// Shorter times vary much from one measurement to the next, s.
constexpr double kShortTime = 0.05;
// Runs or variants that are named one by one.
constexpr std::size_t kMostNamed = 5;
constexpr const char* kProcessorTimes =
    "Costs are processor times, because runs shared the cores of the machine with others.";

void append(Sentences& sentences, const Sentences& more) {
  sentences.insert(sentences.end(), more.begin(), more.end());
}

// "verlet with h = 7.2e-5 s (0.9 h_crit)".
std::string named_run(const StudyRow& row) {
  return fmt::format("{} with h = {}", run_label(row), step_text(row));
}

// Two digits are as many as single measurements have.
std::string two_digits(double ratio) {
  const double unit = std::pow(10.0, std::floor(std::log10(ratio)) - 1.0);
  return short_number(std::round(ratio / unit) * unit);
}

std::string with_article(const std::string& error) {
  return (error.front() == 'e' ? "an " : "a ") + error;
}

std::string percent(double share) {
  return short_number(100.0 * share) + " %";
}

// Wall times that count, or processor times.
std::string missing_times(const StudyAnswer& answer) {
  if (answer.shared == 0 || answer.uses_processor_time) return {};
  const std::string advice =
      "Make these runs again with --jobs 1, or with so many --jobs and --threads that their "
      "product "
      "is at most the number of cores.";
  if (answer.shared == answer.compared) {
    return "Nothing is said of cost, because timings are missing: all runs shared the cores of the "
           "machine with others, or had more threads than cores. " +
           advice;
  }
  return fmt::format(
      "The wall times of {} of {} runs do not count, because these runs shared the "
      "cores of the machine with others, or had more threads than cores. {}",
      answer.shared, answer.compared, advice);
}

bool has_equal_choice(const TargetAnswer& a, const TargetAnswer& b) {
  return a.best() != nullptr && b.best() != nullptr && a.best()->run == b.best()->run;
}

// The rule with the least cost after the best one, if its cost is known.
const RuleAnswer* second_of(const TargetAnswer& target) {
  const RuleAnswer* second = nullptr;
  for (const RuleAnswer& rule : target.rules) {
    if (&rule == target.best() || !std::isfinite(rule.relative_cost)) continue;
    if (second == nullptr || rule.relative_cost < second->relative_cost) second = &rule;
  }
  return second;
}

std::string not_met(const StudyAnswer& answer, const TargetAnswer& target) {
  const auto closest = std::min_element(
      target.rules.begin(), target.rules.end(), [](const RuleAnswer& a, const RuleAnswer& b) {
        return a.run != nullptr && (b.run == nullptr || a.error < b.error);
      });
  if (closest->verdict == StudyVerdict::kNotResolved) {
    return fmt::format(
        "No run is certain to reach {} of {}: the reference's own error is estimated at {}, and "
        "the smallest difference from it is {} ({}).",
        with_article(answer.error), percent(target.target), short_number(answer.reference_error),
        short_number(closest->error), named_run(*closest->run));
  }
  return fmt::format("No run reaches {} of {}: the smallest is {} ({}).",
                     with_article(answer.error), percent(target.target),
                     short_number(closest->error), named_run(*closest->run));
}

// Of the second rule beside the best one. A known scatter decides whether their costs differ.
std::string compared_cost(const RuleAnswer& best, const RuleAnswer& second) {
  const double scatter =
      std::fmax(best.run->time_scatter * best.cost, second.run->time_scatter * second.cost);
  if (second.cost - best.cost <= scatter) {
    return fmt::format(" costs the same within the scatter of {}.", percent(scatter / best.cost));
  }
  if (std::isnan(scatter) && second.relative_cost < 1.2) return " takes about the same time.";
  return fmt::format(" takes {} times as long.", two_digits(second.relative_cost));
}

// One sentence for each group of targets with the same cheapest run.
Sentences cost(const StudyAnswer& answer) {
  Sentences sentences;
  if (answer.compared == 0 || !answer.has_comparable_costs) return sentences;
  const std::string missing = missing_times(answer);
  if (answer.shared == answer.compared && !missing.empty()) return {missing};
  bool has_short_times = false;
  for (std::size_t i = 0; i < answer.targets.size(); ++i) {
    const TargetAnswer& target = answer.targets[i];
    const RuleAnswer* best = target.best();
    if (best == nullptr) {
      const bool is_met =
          std::any_of(target.rules.begin(), target.rules.end(),
                      [](const RuleAnswer& rule) { return rule.verdict == StudyVerdict::kMet; });
      if (is_met) continue;  // by runs whose cost is not known
      sentences.push_back(not_met(answer, target));
      break;
    }
    Sentences targets{percent(target.target)};
    while (i + 1 < answer.targets.size() && has_equal_choice(answer.targets[i + 1], target)) {
      targets.push_back(percent(answer.targets[++i].target));
    }
    const double scatter = best->run->time_scatter;
    has_short_times = has_short_times || (best->cost < kShortTime && !std::isfinite(scatter));
    std::string text = fmt::format(
        "For {} of {} the cheapest run is {}: its error is {}, and its time steps take {} s{}{}.",
        with_article(answer.error), enumeration(targets), named_run(*best->run),
        short_number(best->error), short_number(best->cost),
        answer.uses_processor_time ? " of processor time" : "",
        std::isfinite(scatter) ? ", with a scatter of " + percent(scatter) : "");
    if (const RuleAnswer* second = second_of(target)) {
      text += ' ' + capitalised(named_run(*second->run)) + compared_cost(*best, *second);
    }
    sentences.push_back(text);
  }
  if (answer.uses_processor_time) {
    sentences.emplace_back(kProcessorTimes);
  }
  if (has_short_times) {
    sentences.push_back(fmt::format(
        "Times below {} s vary much from one measurement to the next; a longer end time or a finer "
        "mesh gives a surer comparison.",
        kShortTime));
  }
  if (!missing.empty()) sentences.push_back(missing);
  return sentences;
}

// Explicit runs above their limit, which is why they became unstable, make one sentence for each rule.
Sentences failures(const StudyResult& result) {
  std::vector<std::pair<std::string, Sentences>> above;
  Sentences others;
  for (const StudyRow& row : result.rows) {
    if (row.role == StudyRole::kTrial) continue;
    const bool is_explicit_above = !is_implicit(row.integrator) && is_above_stability_limit(row);
    if (row.status == RunStatus::kCancelled || row.status == RunStatus::kRunning) {
      others.push_back(capitalised(named_run(row)) + " was interrupted.");
    } else if (row.status == RunStatus::kFinished) {
      if (!is_explicit_above) continue;
      others.push_back(capitalised(named_run(row)) +
                       " reached the end although its step is above the stability limit, which is "
                       "that of the initial state.");
    } else if (row.status == RunStatus::kUnstable && is_explicit_above) {
      const std::string name = run_label(row);
      if (above.empty() || above.back().first != name) above.push_back({name, {}});
      above.back().second.push_back(step_text(row));
    } else {
      others.push_back(
          fmt::format("{} {}: {}{}", capitalised(named_run(row)),
                      row.status == RunStatus::kUnstable ? "became unstable" : "failed",
                      row.message.empty() ? "no reason was given" : row.message,
                      row.message.empty() || row.message.back() != '.' ? "." : ""));
    }
  }
  Sentences sentences;
  for (const auto& [name, steps] : above) {
    sentences.push_back(fmt::format("{} became unstable above its stability limit, with h = {}.",
                                    capitalised(name), enumeration(steps)));
  }
  sentences.insert(sentences.end(), others.begin(), others.end());
  if (sentences.size() > kMostNamed) {
    const std::size_t more = sentences.size() - kMostNamed;
    sentences.resize(kMostNamed);
    sentences.push_back(fmt::format("The table of all runs has {} more.", more));
  }
  return sentences;
}

// Orders are named only where they can be seen.
Sentences orders(const StudyAnswer& answer) {
  Sentences sentences;
  for (std::size_t i = 0; i < answer.orders.size();) {
    const std::string rule = rule_name(*answer.orders[i].coarser);
    const int theory = order(answer.orders[i].coarser->integrator);
    Sentences numbers;
    bool agrees = true;
    for (; i < answer.orders.size() && rule_name(*answer.orders[i].coarser) == rule; ++i) {
      const auto& [finer, coarser] = answer.orders[i];
      agrees = agrees && std::abs(coarser->observed_order - theory) <= kOrderTolerance;
      numbers.push_back(fmt::format("{:.2f} between {} s and {} s", coarser->observed_order,
                                    short_number(finer->step), short_number(coarser->step)));
    }
    sentences.push_back(fmt::format("{} has the observed order {}; the theoretical order is {}{}.",
                                    capitalised(rule), enumeration(numbers), theory,
                                    agrees ? "" : ", which these errors do not show"));
  }
  return sentences;
}

// Where the error of the reference comes from, and whether that is certain.
std::string source_of_error(const StudyResult& result, const StudyAnswer& answer) {
  const int theory = order(result.reference_integrator);
  const bool has_probe = !result.error_probe.empty();
  if (is_extrapolated(result)) {
    const ReferenceExtrapolation& found = *result.extrapolation;
    return fmt::format(
        "from the extrapolation with twice the steps. The three runs show the order "
        "{:.2f}, and the theoretical order is {}.",
        has_probe ? found.order_of_probe : found.order_at_end, theory);
  }
  if (result.extrapolation &&
      (has_probe ? result.extrapolation->probe_is_exact : result.extrapolation->is_exact)) {
    return "from its difference from the run with twice its step.";
  }
  const std::string source =
      "from the finest other run of its integrator and the theoretical order";
  if (result.extrapolation) {
    return source + ". The three runs do not show that order, so that the estimate is uncertain.";
  }
  const auto seen =
      std::find_if(answer.orders.begin(), answer.orders.end(), [&](const OrderSeen& each) {
        return each.coarser->integrator == result.reference_integrator;
      });
  if (seen == answer.orders.end()) {
    return fmt::format("{} {}. No order was observed that could confirm the estimate.", source,
                       theory);
  }
  const double found = seen->coarser->observed_order;
  if (std::abs(found - theory) <= 2 * kOrderTolerance) return source + ".";
  return fmt::format(
      "{} {}. The runs of this integrator show the order {:.2f} instead, so that "
      "the estimate is uncertain.",
      source, theory, found);
}

// How sure the errors are, in one sentence.
std::string certainty(const StudyResult& result, const StudyAnswer& answer) {
  const std::string reference = reference_name(result);
  if (result.reference_status != RunStatus::kFinished) {
    const bool is_elsewhere =
        result.left_out > 0 && result.reference_status == RunStatus::kCancelled;
    return fmt::format("The reference, {}, {}. Therefore there are no errors.", reference,
                       is_elsewhere ? "is a run of another part" : "did not reach the end");
  }
  if (!answer.rule_beside_reference.empty()) {
    return fmt::format(
        "The two finest runs of {} agree better with each other than with the reference, {}: the "
        "reference is the error. A finer --reference-step gives smaller ones.",
        answer.rule_beside_reference, reference);
  }
  const std::string start = fmt::format("All errors are differences from the reference, {}{}",
                                        is_extrapolated(result) ? "the " : "", reference);
  return std::isfinite(result.reference_error)
             ? fmt::format("{}, whose own error is estimated at {}.", start,
                           short_number(result.reference_error))
             : start +
                   ". Its own error is not known, because no other run of its integrator gives "
                   "an estimate.";
}

std::string phase_caution(const StudyAnswer& answer) {
  return fmt::format(
      "{} Over many periods such errors compare little but the phase of the motion: --error "
      "frequency.probe.NAME or peak.probe.NAME, or a shorter --set time.end, says more.",
      answer.is_monotone
          ? fmt::format("{} of {} errors exceed 30 %.", answer.large_errors, answer.compared)
          : "The errors do not grow steadily with the step.");
}

Sentences limits(const StudyResult& result, const StudyAnswer& answer) {
  Sentences sentences;
  if (result.is_interrupted) {
    sentences.emplace_back(
        "The study was interrupted: these statements are about the runs before that.");
  }
  if (result.extrapolation) {
    const ReferenceExtrapolation& found = *result.extrapolation;
    const auto say = [&](const std::string& of, const std::string& reason) {
      sentences.push_back(fmt::format(
          "The reference{} is not extrapolated, because {}. It is the run with the smallest of the "
          "three steps.",
          of, reason));
    };
    if (!found.is_valid) say("", found.reason);
    if (!found.probe_is_valid && found.probe_reason != found.reason) {
      say(" of the " + series_name(result), found.probe_reason);
    }
  }
  sentences.push_back(certainty(result, answer));
  if (result.reference_status == RunStatus::kFinished && std::isfinite(result.reference_error)) {
    sentences.push_back("The estimate comes " + source_of_error(result, answer));
  }
  append(sentences, mesh_sentences(result));
  if (answer.compares_phase) sentences.push_back(phase_caution(answer));
  if (!answer.has_comparable_costs) {
    sentences.emplace_back(
        "The runs were made on different machines or with different numbers of threads. Their wall "
        "times cannot be compared.");
  }
  return sentences;
}

// A number that is the same for all variants, or its smallest and largest value.
void say_range(const StudyAnswer& answer, const std::string& name, const std::string& unit,
               const std::function<double(const VariantAnswer&)>& value, Sentences& sentences) {
  const VariantAnswer* low = nullptr;
  const VariantAnswer* high = nullptr;
  std::size_t known = 0;
  for (const VariantAnswer& variant : answer.variants) {
    if (!std::isfinite(value(variant))) continue;
    ++known;
    if (low == nullptr || value(variant) < value(*low)) low = &variant;
    if (high == nullptr || value(variant) > value(*high)) high = &variant;
  }
  if (known < 2) return;
  const bool is_same = value(*high) - value(*low) <= 1e-3 * std::abs(value(*high));
  sentences.push_back(
      is_same
          ? fmt::format("{} is {}{} for all variants.", name, short_number(value(*low)), unit)
          : fmt::format("{} lies between {}{} ({}) and {}{} ({}).", name, short_number(value(*low)),
                        unit, low->name, short_number(value(*high)), unit, high->name));
}

Sentences variants(const StudyResult& result, const StudyAnswer& answer) {
  Sentences sentences;
  if (answer.variants.size() < 2) return sentences;
  const std::string& first = answer.variants.front().name;
  if (result.references.size() < 2) {
    sentences.push_back(fmt::format(
        "All variants are compared with the reference of {}, because they differ in keys that "
        "leave the exact motion as it is. The other statements are about {}.",
        first, first));
  } else {
    sentences.push_back(fmt::format(
        "The study has {} references: each variant is compared with one of its own exact motion. "
        "Statements that name no variant are about {}.",
        result.references.size(), first));
    std::vector<std::string> rules;
    double target = 0.0;
    for (const VariantAnswer& variant : answer.variants) {
      const RuleAnswer* best = variant.answer.best();
      if (best == nullptr) continue;
      target = variant.answer.target;
      if (std::find(rules.begin(), rules.end(), best->rule) == rules.end()) {
        rules.push_back(best->rule);
      }
    }
    if (!rules.empty()) {
      sentences.push_back(fmt::format(
          "For {} of {} the cheapest rule of {} is {}.", with_article(answer.error),
          percent(target), rules.size() == 1 ? "all variants that reach it" : "each variant",
          fmt::join(rules, " or ")));
    }
  }
  say_range(
      answer, "The stability limit", " s",
      [](const VariantAnswer& variant) { return variant.stable_step; }, sentences);
  for (std::size_t i = 1; i < answer.variants.size() && answer.variants.size() <= kMostNamed; ++i) {
    const VariantAnswer& variant = answer.variants[i];
    if (!std::isfinite(variant.least_cost_ratio)) continue;
    const std::string least = two_digits(variant.least_cost_ratio);
    const std::string most = two_digits(variant.most_cost_ratio);
    sentences.push_back(
        fmt::format("With equal rules and steps {} takes {} times the wall time of {}.",
                    variant.name, least == most ? least : least + " to " + most, first));
  }
  const std::string motion = result.error_probe.empty() ? "motion" : series_name(result);
  const auto farthest =
      std::max_element(answer.variants.begin(), answer.variants.end(),
                       [](const VariantAnswer& a, const VariantAnswer& b) {
                         return !std::isnan(b.difference) && !(a.difference >= b.difference);
                       });
  if (std::isfinite(farthest->difference)) {
    sentences.push_back(fmt::format("The {} differs from that of {} by up to {} ({}).", motion,
                                    first, percent(farthest->difference), farthest->name));
  } else if (result.references.size() > 1 && result.error_probe.empty()) {
    sentences.emplace_back(
        "Positions on different meshes are not compared: --error probe.NAME "
        "compares the values of a probe.");
  }
  for (const Sensitivity& each : answer.sensitivities) {
    sentences.push_back(fmt::format("A change of {} by 1 % changes the {} by about {} ({}).",
                                    each.key, motion, percent(0.01 * each.value), each.variant));
  }
  return sentences;
}

}  // namespace

std::vector<StudyConclusion> study_conclusions(const StudyResult& result) {
  std::vector<StudyConclusion> conclusions;
  if (result.rows.empty()) return conclusions;
  const StudyAnswer answer = study_answer(result);
  const auto add = [&](const char* topic, Sentences sentences) {
    if (!sentences.empty()) conclusions.push_back({topic, std::move(sentences)});
  };
  add("Cost of accuracy", cost(answer));
  add("Steps that were searched", finding_sentences(result));
  add("Variants", variants(result, answer));
  add("Runs that did not reach the end", failures(result));
  add("Limits of the comparison", limits(result, answer));
  add("Observed orders", orders(answer));
  return conclusions;
}

std::vector<std::string> answer_sentences(const StudyResult& result, const StudyAnswer& answer) {
  Sentences sentences;
  if (result.is_interrupted) {
    sentences.emplace_back(
        "The study was interrupted: this is the answer of the runs before that.");
  }
  const bool is_sweep = result.references.size() > 1 && !answer.variants.empty();
  const Sentences said = is_sweep ? variants(result, answer) : cost(answer);
  const std::size_t most = is_sweep ? kMostNamed : 1;
  sentences.insert(sentences.end(), said.begin(),
                   said.begin() + static_cast<std::ptrdiff_t>(std::min(most, said.size())));
  if (!is_sweep) {
    append(sentences, finding_sentences(result));
    append(sentences, trouble_sentences(answer));
    sentences.push_back(certainty(result, answer));
  }
  append(sentences, mesh_sentences(result));
  if (is_sweep) return sentences;
  if (answer.uses_processor_time) sentences.emplace_back(kProcessorTimes);
  if (answer.compares_phase) sentences.push_back(phase_caution(answer));
  return sentences;
}

}  // namespace tetraction
