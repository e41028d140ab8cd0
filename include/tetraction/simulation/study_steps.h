// What a study is asked for, as texts: steps, the error, limits.
#pragma once

#include <compare>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction {

/// What the number of a requested step counts.
enum class StepUnit {
  kSeconds,      ///< "1e-3"
  kStableSteps,  ///< "4x": h_crit of `explicit`, for every rule
  kPeriods,      ///< "0.02T": the excited period (simulation/excited_period.h)
  kAuto          ///< "auto": 0.5 h_crit of an explicit rule, the ladder of an implicit one
};

struct StepRequest {
  StepUnit unit = StepUnit::kSeconds;
  double value = 0.0;
  std::string text{};  ///< as it was written, for messages
};

/// A key of the scene and the value that a variant or a rule gives it.
struct VariedValue {
  std::string key;
  std::string value;

  auto operator<=>(const VariedValue&) const = default;
};

/// A rule that a study compares: an integrator with the settings of the scene, or with settings of its own.
struct StudyRule {
  StudyRule(Integrator of = Integrator::kMidpoint, std::vector<VariedValue> own = {})
      : integrator(of), settings(std::move(own)) {}

  Integrator integrator;
  std::vector<VariedValue> settings;  ///< keys of [solver] and [time], sorted by key

  auto operator<=>(const StudyRule&) const = default;
};

/// "midpoint", or "midpoint:solver.tolerance=1e-6,time.retry=3".
std::string to_string(const StudyRule& rule);
/// "solver.tolerance=1e-6, time.retry=3", as StudyRow::settings.
std::string to_string(const std::vector<VariedValue>& settings);

enum class ErrorKind { kPositions, kProbe, kPeak, kFrequency, kEnergy };
template <>
struct EnumNames<ErrorKind> {
  static constexpr std::array names{"positions", "probe", "peak.probe", "frequency.probe",
                                    "energy"};
};

/// The difference from the reference that counts as the error of a run.
struct ErrorMeasure {
  ErrorKind kind = ErrorKind::kPositions;
  std::string name{};  ///< of the probe, or the column of history.csv with an energy

  /// The name of its values in a MotionTrack.
  std::string series() const { return kind == ErrorKind::kEnergy ? "energy." + name : name; }
};

/// "positions", "probe.tip", "peak.probe.tip", "frequency.probe.tip", "energy.total_energy".
std::string to_string(const ErrorMeasure& measure);

/// The lengths that requested steps refer to.
struct StepScales {
  double end = 0.0;          ///< s
  double stable_step = 0.0;  ///< h_crit of `explicit` at the start, s
  /// The excited period, s. It is called only for steps in its units, and may throw InputError.
  std::function<double()> period{};
};

/// What a study is asked for.
struct StudyRequests {
  std::vector<StudyRule> rules;                 ///< each once
  std::vector<std::vector<StepRequest>> steps;  ///< for each rule; none: its ladder
  ErrorMeasure error{};
  double budget = 60.0;            ///< s
  std::optional<double> target{};  ///< relative error
  std::optional<Integrator> reference_integrator{};
  /// What a step of an explicit rule takes, s, as an earlier choice measured it (PlannedSteps::seconds_per_step), so that
  /// the choice is the same again. Others are measured.
  std::map<Integrator, double> seconds_per_step{};
};

/// Whether the program chooses some of the steps.
bool chooses_steps(const StudyRequests& requests);

/// The steps of one rule.
struct ResolvedSteps {
  std::vector<double> steps;  ///< s, ascending, each once
  bool has_ladder = false;    ///< whether the program chooses (further) steps: find_ladders()
};

/// The functions below throw InputError for texts that are malformed. It says where, and what to write.

/// "1e-3,4x,0.02T,auto".
std::vector<StepRequest> read_step_requests(const std::string& text);

/// "midpoint:solver.tolerance=1e-6,time.retry=3". The keys are those that a rule can have
/// (check_settings_of()).
StudyRule read_study_rule(const std::string& text);

/// Whether two rules have the same integrator and the same values of the same keys: 1e-6 is the same as 0.000001.
bool is_same_rule(const StudyRule& a, const StudyRule& b);

/// Throws InputError for settings that a rule cannot have: other keys than those of [solver] and [time], those that a
/// study sets itself, and [solver] of an explicit rule, which solves nothing.
void check_settings_of(const StudyRule& rule);

/// The requests for each rule from the texts "RULE=LIST", or "LIST" for all rules. Those without a text have none. A
/// rule with settings takes the lists of its integrator, unless it is named itself.
std::vector<std::vector<StepRequest>> assign_steps(const std::vector<std::string>& texts,
                                                   const std::vector<StudyRule>& rules);

/// The names of integrators in such texts, each once. None if one of the lists is for all rules.
std::vector<std::string> rules_with_steps(const std::vector<std::string>& texts);

/// "positions" (or "position", or nothing), "probe.NAME", "peak.probe.NAME", "frequency.probe.NAME",
/// "energy.COLUMN".
ErrorMeasure read_error_measure(const std::string& text);

/// "10s", "2min", "1h" in s.
double read_duration(const std::string& text, const std::string& where);

/// "1%" or "0.01", between 0 and 1 (both excluded).
double read_share(const std::string& text, const std::string& where);

/// The steps of a rule in s. Those in other units than s are made shorter so that they divide the end. `stable_step`
/// is h_crit of the rule itself. Without requests the rule has a ladder.
ResolvedSteps resolve_steps(const std::vector<StepRequest>& requests, Integrator rule,
                            double stable_step, const StepScales& scales);

/// The least number of the series 1, 2, 5, 10, … that is at least n.
Index series_above(double n);
/// The largest one that is at most n ≥ 1.
Index series_below(double n);

}  // namespace tetraction
