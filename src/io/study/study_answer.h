// The answer of a step-size study: which rule and step meet an error at the least cost, and how sure this is.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

enum class StudyVerdict {
  kMet,          ///< the error and that of the reference together are at most the target
  kNotResolved,  ///< the error is, but not with that of the reference
  kNotMet,       ///< the smallest error of the rule is above the target
  kFailed        ///< no run of the rule reached the end with an error
};
/// "met", "not resolved", "not met", "failed".
std::string to_string(StudyVerdict verdict);

/// What a rule reaches for a target. Rows are those of the StudyResult, which must live as long.
struct RuleAnswer {
  std::string rule;
  StudyVerdict verdict = StudyVerdict::kFailed;
  const StudyRow* run =
      nullptr;  ///< that with the largest step that meets the target, or with the smallest error
  double error = 0.0;
  double cost = 0.0;           ///< s; NaN if it is not known
  double relative_cost = 0.0;  ///< to the cheapest of all rules; NaN unless the target is met
  std::string note;            ///< where the rule is unstable, or when and why it failed
};

/// Where a rule is unstable, or its first run that failed.
struct RuleTrouble {
  std::string rule;
  std::string run;     ///< "h = 1e-3 s, at t = 7e-3 s"; empty if it does not matter
  std::string reason;  ///< what its runs did, as the end of a sentence: "failed: no convergence"
};

struct TargetAnswer {
  double target = 0.0;
  std::vector<RuleAnswer> rules;
  const RuleAnswer* best() const;  ///< null if no rule meets the target at a known cost
};

/// An order that can be seen between two neighbouring steps.
struct OrderSeen {
  const StudyRow* finer;
  const StudyRow* coarser;
};

/// A variant of the scene beside the first one.
struct VariantAnswer {
  std::string name;
  std::vector<VariedValue> values;
  double stable_step = 0.0;  ///< of its first row, s
  double difference = 0.0;   ///< of its motion from that of the first one; NaN if it is not known
  double change =
      0.0;  ///< ln of the ratio of peaks or frequencies to that of the first one; else `difference`
  double reference_error = 0.0;  ///< of its reference
  double least_cost_ratio =
      0.0;  ///< to that of the first one with equal rules and steps; NaN if unknown
  double most_cost_ratio = 0.0;
  TargetAnswer
      answer;  ///< for the strictest target of which the first variant has a cheapest run, or for 1 %
};

/// A relative change per relative change of a varied number, from the first variant; both as natural logarithms of the
/// ratio, but the change of a motion, which has no sign, as VariantAnswer::difference.
struct Sensitivity {
  std::string key;
  std::string variant;  ///< with the smallest change of the number
  double value = 0.0;
};

struct StudyAnswer {
  std::string error;  ///< "position error", "error of the probe tip"
  std::vector<TargetAnswer>
      targets;  ///< 10, 1 and 0.1 %, or StudyResult::target, of the first variant
  std::vector<RuleTrouble> troubles;  ///< of the first variant
  std::vector<OrderSeen> orders;
  double reference_error = 0.0;  ///< NaN if it is not known
  /// A rule whose two finest runs agree better with each other than with the reference. Empty if there is none.
  std::string rule_beside_reference;
  std::size_t compared = 0;      ///< runs of the first variant with an error, also trials
  std::size_t asked = 0;         ///< those of them that are no trials
  std::size_t large_errors = 0;  ///< those of the latter with an error above 30 %
  bool is_monotone = true;       ///< whether errors grow with the step
  bool compares_phase = false;   ///< whether these errors say little but a difference of phase
  bool has_comparable_costs =
      false;               ///< whether all runs were made by one machine with equal threads
  std::size_t shared = 0;  ///< compared runs whose wall time does not count
  bool uses_processor_time = false;     ///< costs are processor times, because the machine was busy
  std::vector<VariantAnswer> variants;  ///< empty without variants
  std::vector<Sensitivity> sensitivities;
  bool has_signed_changes = false;  ///< whether the error is that of a peak or a frequency
};

/// The facts of a study.
StudyAnswer study_answer(const StudyResult& result);

/// Sentences on one topic.
struct StudyConclusion {
  std::string topic;
  std::vector<std::string> sentences;
};

/// The facts in plain sentences. A topic about which the numbers say nothing is left out.
std::vector<StudyConclusion> study_conclusions(const StudyResult& result);

/// What the search of steps found besides the table of the answer: what limits a step, and the largest stable steps.
std::vector<std::string> finding_sentences(const StudyResult& result);
/// How far the variants differ, and what that costs; empty with fewer than two.
std::vector<std::string> variant_sentences(const StudyResult& result, const StudyAnswer& answer);
/// What the run on a finer mesh tells; empty without a value.
std::vector<std::string> mesh_sentences(const StudyResult& result);
/// StudyAnswer::troubles. Rules with the same reason share a sentence. Where the search found how long stable steps
/// are, finding_sentences() says it.
std::vector<std::string> trouble_sentences(const StudyResult& result, const StudyAnswer& answer);
/// The same as the member `searched` of study.json.
nlohmann::ordered_json findings_json(const StudyResult& result);
/// The same again, for a study that ends at `end`. Throws nlohmann::json::exception or InputError for another kind of
/// value.
std::vector<RuleFinding> findings_from_json(const nlohmann::json& list, double end);

enum class AnswerFormat { kTerminal, kMarkdown, kLatex };
/// "markdown", "latex". Throws InputError for another word.
AnswerFormat answer_format_from_string(const std::string& name);

/// The table of the answer and its sentences, at most 33 lines on a terminal. Tables for papers have no sentences.
std::string answer_text(const StudyResult& result, AnswerFormat format = AnswerFormat::kTerminal);

/// The sentences, at most twelve: the cheapest rule, what the table does not say of the rules, how sure it is, and
/// what is better compared.
std::vector<std::string> answer_sentences(const StudyResult& result, const StudyAnswer& answer);

/// The table of the answer as a table of HTML for study.html, or without an identifier for any page.
std::string answer_html(const StudyResult& result, const StudyAnswer& answer,
                        const std::string& id = "answer");

/// The facts as the member `answer` of study.json.
nlohmann::ordered_json answer_json(const StudyAnswer& answer);

}  // namespace tetraction
