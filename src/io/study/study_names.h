// Numbers and runs of a study in words, and the parts of a study that have references of their own.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// "a", "a and b", "a, b and c". The last of more than `most` words are only counted: "a, b and 3 more".
std::string enumeration(const std::vector<std::string>& words, std::size_t most = 1000);

/// Runs, rules, variants or sentences of one kind that are named one by one in the answer.
inline constexpr std::size_t kMostNamed = 5;

/// Sentences that are said once for all names of which they are true.
class SharedSentences {
 public:
  void add(const std::string& before, const std::string& name, const std::string& after);
  /// With at most kMostNamed names each.
  std::vector<std::string> all() const;

 private:
  struct Shared {
    std::string before;
    std::vector<std::string> names;
    std::string after;
  };
  std::vector<Shared> sentences_;
};

/// "3.1 %".
std::string percent(double share);

/// A number with up to three digits in the shortest form: 7.2e-5, 0.018, 12.
std::string short_number(double value);

/// Two digits, as many as single measurements of times have.
std::string two_digits(double ratio);

/// "an error of the probe tip", "a position error".
std::string with_article(const std::string& error);

/// The text with a capital at the beginning.
std::string capitalised(std::string text);

/// The integrator of a run with the settings of its rule, and the solver if that is compared:
/// "midpoint, solver.tolerance=1e-6", "midpoint (ceres)". Runs with the same name differ in the step
/// and the variant only.
std::string rule_name(const StudyRow& row);
std::string rule_name(const RuleFinding& finding);

/// rule_name() with the variant.
std::string run_label(const StudyRow& row);

/// " (0.9 h_crit)", or nothing without a stability limit.
std::string in_limits(const StudyRow& row);

/// "7.2e-5 s (0.9 h_crit)".
std::string step_text(const StudyRow& row);

/// Why the run did not reach the end, in a few words: the message without its step and details. Empty if it is not
/// known.
std::string reason_of(const StudyRow& row);

/// The error that the study compares as files name it: "position", "peak.probe.tip".
std::string error_word(const StudyResult& result);
/// "position error", "error of the probe tip", "error of the peak of the probe tip".
std::string error_name(const StudyResult& result);
/// "peak" or "frequency": what StudyRow::probe_value is. Empty if it is nothing.
std::string value_name(const StudyResult& result);
/// "m" or "Hz". Empty if it has none.
std::string value_unit(const StudyResult& result);
/// "peak [m]" or "frequency [Hz]": both as the heading of a column. Empty if StudyRow::probe_value is nothing.
std::string value_heading(const StudyResult& result);
/// series_name(), or "frequency of the probe tip".
std::string quantity_name(const StudyResult& result);
/// "probe tip" or "kinetic energy": what the errors of the study are of, unless it is the positions.
std::string series_name(const StudyResult& result);

/// The reference of the study: "midpoint with h = 1e-4 s", or "Richardson extrapolation of midpoint
/// with h = 1e-4 s and 5e-5 s".
std::string reference_name(const StudyResult& result);

/// For each variant its place in StudyResult::references. Empty if the study has only one reference.
std::map<std::string, std::size_t> references_of_variants(const StudyResult& result);

/// For each of StudyResult::references the part of the study that belongs to it, as a study of its own.
std::vector<StudyResult> parts_of_study(const StudyResult& result);

/// Whether the error that the orders are computed from is a difference from an extrapolation.
bool is_extrapolated(const StudyResult& result);

/// Whether the step is longer than the stability limit of the run's row.
bool is_above_stability_limit(const StudyRow& row);

/// The largest relative energy error that rounding explains: each step adds at most about one
/// rounding of the energies.
double round_off_level(const StudyRow& row);

}  // namespace tetraction
