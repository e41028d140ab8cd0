// The facts of a study in plain sentences.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
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
constexpr const char* kProcessorTimes =
    "Costs are processor times, because runs shared the cores of the machine with others.";

void append(Sentences& sentences, const Sentences& more) {
  sentences.insert(sentences.end(), more.begin(), more.end());
}

// Leaves the first sentences and says where the others are.
void shorten(Sentences& sentences, const char* others) {
  if (sentences.size() <= kMostNamed) return;
  const std::size_t more = sentences.size() - kMostNamed;
  sentences.resize(kMostNamed);
  sentences.push_back(fmt::format(fmt::runtime(others), more));
}

// "verlet with h = 7.2e-5 s (0.9 h_crit)".
std::string named_run(const StudyRow& row) {
  return fmt::format("{} with h = {}", run_label(row), step_text(row));
}

// Why wall times do not count. Empty if those of all runs do.
std::string missing_times(const StudyAnswer& answer) {
  if (answer.shared == 0 || answer.uses_processor_time) return {};
  const char* why = "shared the cores of the machine with others, or had more threads than cores";
  const std::string which =
      answer.shared == answer.compared
          ? fmt::format("Nothing is said of cost, because timings are missing: all runs {}.", why)
          : fmt::format("The wall times of {} of {} runs do not count, because these runs {}.",
                        answer.shared, answer.compared, why);
  return which +
         " Make these runs again with --jobs 1, or with so many --jobs and --threads that their "
         "product is at most the number of cores.";
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
  const bool is_unsure = closest->verdict == StudyVerdict::kNotResolved;
  return fmt::format(
      "{} {} of {}: {} {} ({}).", is_unsure ? "No run is certain to reach" : "No run reaches",
      with_article(answer.error), percent(target.target),
      is_unsure ? fmt::format("the reference's own error is estimated at {}, and the smallest "
                              "difference from it is",
                              short_number(answer.reference_error))
                : "the smallest is",
      short_number(closest->error), named_run(*closest->run));
}

// Of the second rule beside the best one. A known scatter decides whether their costs differ.
std::string compared_cost(const RuleAnswer& best, const RuleAnswer& second) {
  const double scatter =
      std::fmax(best.run->time_scatter * best.cost, second.run->time_scatter * second.cost);
  if (second.cost - best.cost <= scatter) {
    return fmt::format("costs the same within the scatter of {}", percent(scatter / best.cost));
  }
  if (std::isnan(scatter) && second.relative_cost < 1.2) return "takes about the same time";
  return fmt::format("takes {} times as long", two_digits(second.relative_cost));
}

std::string cheapest(const StudyAnswer& answer, const TargetAnswer& target,
                     const Sentences& targets) {
  const RuleAnswer& best = *target.best();
  const double scatter = best.run->time_scatter;
  const RuleAnswer* second = second_of(target);
  return fmt::format(
      "For {} of {} the cheapest run is {}: its error is {}, and its time steps take {} s{}{}.{}",
      with_article(answer.error), enumeration(targets), named_run(*best.run),
      short_number(best.error), short_number(best.cost),
      answer.uses_processor_time ? " of processor time" : "",
      std::isfinite(scatter) ? ", with a scatter of " + percent(scatter) : "",
      second == nullptr ? ""
                        : fmt::format(" {} {}.", capitalised(named_run(*second->run)),
                                      compared_cost(best, *second)));
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
    for (; i + 1 < answer.targets.size(); ++i) {
      const RuleAnswer* next = answer.targets[i + 1].best();
      if (next == nullptr || next->run != best->run) break;
      targets.push_back(percent(answer.targets[i + 1].target));
    }
    const bool is_repeated = std::isfinite(best->run->time_scatter);
    has_short_times = has_short_times || (best->cost < kShortTime && !is_repeated);
    sentences.push_back(cheapest(answer, target, targets));
  }
  if (answer.uses_processor_time) sentences.emplace_back(kProcessorTimes);
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
  SharedSentences above;
  Sentences others;
  for (const StudyRow& row : result.rows) {
    if (row.role == StudyRole::kTrial) continue;
    const bool is_explicit_above = !is_implicit(row.integrator) && is_above_stability_limit(row);
    const std::string run = capitalised(named_run(row));
    if (row.status == RunStatus::kCancelled || row.status == RunStatus::kRunning) {
      others.push_back(run + " was interrupted.");
    } else if (row.status == RunStatus::kFinished) {
      if (!is_explicit_above) continue;
      others.push_back(run +
                       " reached the end although its step is above the stability limit, which is "
                       "that of the initial state.");
    } else if (row.status == RunStatus::kUnstable && is_explicit_above) {
      above.add(
          capitalised(run_label(row)) + " became unstable above its stability limit, with h = ",
          step_text(row), ".");
    } else {
      const std::string why = row.message.empty() ? "no reason was given" : row.message;
      others.push_back(fmt::format(
          "{} {}: {}{}", run, row.status == RunStatus::kUnstable ? "became unstable" : "failed",
          why, why.ends_with('.') ? "" : "."));
    }
  }
  Sentences sentences = above.all();
  append(sentences, others);
  shorten(sentences, "The table of all runs has {} more.");
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
  const auto& found = result.extrapolation;
  if (is_extrapolated(result)) {
    return fmt::format(
        "from the extrapolation with twice the steps. The three runs show the order {:.2f}, and "
        "the theoretical order is {}.",
        has_probe ? found->order_of_probe : found->order_at_end, theory);
  }
  if (found && (has_probe ? found->probe_is_exact : found->is_exact)) {
    return "from its difference from the run with twice its step.";
  }
  std::string source = "from the finest other run of its integrator and the theoretical order";
  if (found) {
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
  const double shown = seen->coarser->observed_order;
  if (std::abs(shown - theory) <= 2 * kOrderTolerance) return source + ".";
  return fmt::format(
      "{} {}. The runs of this integrator show the order {:.2f} instead, so that the estimate is "
      "uncertain.",
      source, theory, shown);
}

// ", whose peak [m] is 0.0123", if the error is that of a peak or a frequency.
std::string value_of_reference(const StudyResult& result) {
  for (const StudyRow& row : result.rows) {
    if (row.directory != result.reference_directory || !std::isfinite(row.probe_value)) continue;
    return fmt::format(", whose {} is {:.5g}{}", value_name(result), row.probe_value,
                       value_unit(result).empty() ? "" : " " + value_unit(result));
  }
  return {};
}

// How sure the errors are, in one or two sentences.
std::string certainty(const StudyResult& result, const StudyAnswer& answer) {
  const std::string reference = reference_name(result);
  const std::string value = value_of_reference(result);
  if (result.reference_status != RunStatus::kFinished) {
    const bool is_elsewhere =
        result.left_out > 0 && result.reference_status == RunStatus::kCancelled;
    return fmt::format("The reference, {}, {}. Therefore there are no errors.", reference,
                       is_elsewhere ? "is a run of another part" : "did not reach the end");
  }
  if (!answer.rule_beside_reference.empty()) {
    return fmt::format(
        "The two finest runs of {} agree better with each other than with the reference, {}: the "
        "errors are mostly those of the reference. A smaller --reference-step reduces them.",
        answer.rule_beside_reference, reference);
  }
  return fmt::format(
      "All errors are differences from the reference, {}{}{}{}.",
      is_extrapolated(result) ? "the " : "", reference, value,
      std::isfinite(result.reference_error)
          ? fmt::format("{} own error is estimated at {}", !value.empty() ? ". Its" : ", whose",
                        short_number(result.reference_error))
          : ". Its own error is not known, because no other run of its integrator gives an "
            "estimate");
}

std::string phase_caution(const StudyAnswer& answer) {
  return fmt::format(
      "{} Over many periods such errors compare little but the phase of the motion: --error "
      "frequency.probe.NAME or peak.probe.NAME, or a shorter --set time.end, says more.",
      answer.is_monotone
          ? fmt::format("{} of {} errors exceed 30 %.", answer.large_errors, answer.asked)
          : "The errors do not grow steadily with the step.");
}

Sentences limits(const StudyResult& result, const StudyAnswer& answer) {
  Sentences sentences;
  if (result.is_interrupted) {
    sentences.emplace_back(
        "The study was interrupted: these statements are about the runs before that.");
  }
  const auto say = [&](const std::string& of, const std::string& reason) {
    sentences.push_back(fmt::format(
        "The reference{} is not extrapolated, because {}. It is the run with the smallest of the "
        "three steps.",
        of, reason));
  };
  const auto& found = result.extrapolation;
  if (found && !found->is_valid) say("", found->reason);
  if (found && !found->probe_is_valid && found->probe_reason != found->reason) {
    say(" of the " + series_name(result), found->probe_reason);
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

}  // namespace

std::vector<StudyConclusion> study_conclusions(const StudyResult& result) {
  if (result.rows.empty()) return {};
  const StudyAnswer answer = study_answer(result);
  std::vector<StudyConclusion> conclusions{{"Cost of accuracy", cost(answer)},
                                           {"Steps that were searched", finding_sentences(result)},
                                           {"Variants", variant_sentences(result, answer)},
                                           {"Runs that did not reach the end", failures(result)},
                                           {"Limits of the comparison", limits(result, answer)},
                                           {"Observed orders", orders(answer)}};
  std::erase_if(conclusions, [](const StudyConclusion& each) { return each.sentences.empty(); });
  return conclusions;
}

std::vector<std::string> answer_sentences(const StudyResult& result, const StudyAnswer& answer) {
  Sentences sentences;
  if (result.is_interrupted) {
    sentences.emplace_back(
        "The study was interrupted: this is the answer of the runs before that.");
  }
  const bool is_sweep = result.references.size() > 1 && !answer.variants.empty();
  Sentences said = is_sweep ? variant_sentences(result, answer) : cost(answer);
  said.resize(std::min(said.size(), is_sweep ? kMostNamed : 1));
  append(sentences, said);
  if (is_sweep) {
    append(sentences, mesh_sentences(result));
    return sentences;
  }
  Sentences of_rules = finding_sentences(result);
  append(of_rules, trouble_sentences(result, answer));
  shorten(of_rules, "The page of the study has {} more sentences on single rules.");
  append(sentences, of_rules);
  sentences.push_back(certainty(result, answer));
  append(sentences, mesh_sentences(result));
  if (answer.uses_processor_time) sentences.emplace_back(kProcessorTimes);
  if (answer.compares_phase) sentences.push_back(phase_caution(answer));
  return sentences;
}

}  // namespace tetraction
