#include "tetraction/simulation/study_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "series_errors.h"

namespace tetraction {
namespace {

// First trials have so many steps in the excited period, or in all where there is none.
constexpr double kStepsOfPeriod = 20.0;
constexpr double kStepsWithoutPeriod = 20.0;
constexpr double kShareOfReference = 0.4;

SearchedRule searched(const RuleQuestion& question, const StepQuestion& of) {
  SearchedRule rule;
  rule.name = to_string(question.rule);
  rule.order = order(question.rule.integrator);
  rule.seconds_per_step = question.seconds_per_step;
  const double steps = of.period > 0.0 ? kStepsOfPeriod * of.end / of.period : kStepsWithoutPeriod;
  rule.first = static_cast<Index>(std::clamp(steps, 5.0, 1e9));
  if (!is_implicit(question.rule.integrator) && question.stable_step > 0.0) {
    rule.fewest = static_cast<Index>(
        std::clamp(std::ceil(of.end / question.stable_step * (1.0 - 1e-9)), 1.0, 1e15));
    rule.first = rule.fewest;
  }
  return rule;
}

class Choice {
 public:
  Choice(const StepQuestion& question, StudyBudget& budget, const MakeTrackedRun& make)
      : question_(question), budget_(budget), make_(make) {
    choice_.rules.resize(question.rules.size());
  }

  StepChoice result() {
    choose_reference();
    if (!reference_) {
      add_first_steps();
    } else if (question_.target) {
      meet_target();
    } else {
      make_ladders();
    }
    find_stable_steps();
    collect();
    return std::move(choice_);
  }

 private:
  using Track = std::shared_ptr<const MotionTrack>;

  double step(Index n) const { return question_.end / static_cast<double>(n); }

  // A run of a rule with n steps, which stays in memory as long as there are trials.
  const TrackedRun& run(const StudyRule& rule, double step) {
    const auto [place, is_new] = runs_.try_emplace({rule, step});
    TrackedRun& made = place->second;
    if (is_new && !choice_.is_stopped) made = make_(rule, step);
    if (made.is_stopped) choice_.is_stopped = true;
    return made;
  }

  // The trial with n steps of a rule, whose error is not known yet.
  Trial trial(const StudyRule& rule, Index n) {
    const TrackedRun& made = run(rule, step(n));
    return {std::nan(""), made.seconds, made.track == nullptr};
  }

  // Whether the program chooses steps of the rule by their errors.
  static bool has_ladder(const RuleQuestion& rule) { return rule.asked.has_ladder && !rule.adapts; }

  void choose_reference() {
    choice_.reference = question_.references.front().rule.integrator;
    if (question_.reference_step) {
      const TrackedRun& made = run(choice_.reference, *question_.reference_step);
      budget_.spend(made.seconds);
      reference_ = made.track;
      choice_.reference_step = reference_ ? *question_.reference_step : 0.0;
      return;
    }
    std::vector<SearchedRule> rules;
    for (const RuleQuestion& rule : question_.references) {
      rules.push_back(searched(rule, question_));
    }
    const double goal = 0.1 * question_.target.value_or(question_.ladder.fine);
    const auto measure = [&](std::size_t index, Index n) {
      const StudyRule& rule = question_.references[index].rule;
      Trial made = trial(rule, n);
      const auto half = runs_.find({rule, question_.end / (0.5 * static_cast<double>(n))});
      if (!made.failed && half != runs_.end() && half->second.track) {
        made.error =
            relative_error(*half->second.track, *run(rule, step(n)).track, question_.error);
      }
      return made;
    };
    const ChosenReference found = find_reference(rules, goal, kShareOfReference, budget_, measure);
    choice_.reference = question_.references[found.rule].rule.integrator;
    if (found.n == 0) {
      choice_.remarks.push_back(fmt::format(
          "no run of {} reached the end within the budget, so that there is no reference",
          to_string(choice_.reference)));
      return;
    }
    choice_.reference_step = step(found.n);
    choice_.reference_error = found.error;
    reference_ = run(choice_.reference, choice_.reference_step).track;
    if (!(found.error <= 1.5 * goal)) {
      choice_.remarks.push_back(
          fmt::format("the reference has an error of its own of {}, which is more than a tenth of "
                      "the {} {:.3g} "
                      "%. A larger --budget makes it smaller",
                      std::isfinite(found.error) ? fmt::format("{:.2g} %", 100.0 * found.error)
                                                 : "unknown size",
                      question_.target ? "target" : "smallest error,", 1000.0 * goal));
    }
  }

  Trial measure(const StudyRule& rule, Index n) {
    Trial made = trial(rule, n);
    const Track& track = run(rule, step(n)).track;
    if (track == reference_) {
      made.error = choice_.reference_error;
    } else if (track) {
      made.error = relative_error(*track, *reference_, question_.error);
    }
    return made;
  }

  void make_ladders() {
    std::vector<SearchedRule> rules;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < question_.rules.size(); ++i) {
      if (!has_ladder(question_.rules[i])) continue;
      rules.push_back(searched(question_.rules[i], question_));
      places.push_back(i);
    }
    const std::vector<Ladder> ladders = find_ladders(
        rules, question_.ladder, budget_,
        [&](std::size_t i, Index n) { return measure(question_.rules[places[i]].rule, n); });
    for (std::size_t i = 0; i < ladders.size(); ++i) {
      // A step that is finer than that of the reference has nothing to be compared with.
      const bool is_own = question_.rules[places[i]].rule.integrator == choice_.reference;
      const double finest = is_own ? choice_.reference_step : 0.0;
      for (const Rung& rung : ladders[i].rungs) {
        chosen_[places[i]].insert(std::max(step(rung.n), finest));
      }
      if (!ladders[i].remark.empty()) choice_.remarks.push_back(ladders[i].remark);
      choice_.seconds += ladders[i].seconds_left();
    }
  }

  // Runs that have the searched error meet the target together with that of the reference.
  void meet_target() {
    const double error = std::isfinite(choice_.reference_error) ? choice_.reference_error : 0.0;
    const double goal = *question_.target - std::min(1.1 * error, 0.5 * *question_.target);
    for (std::size_t i = 0; i < question_.rules.size() && !choice_.is_stopped; ++i) {
      const RuleQuestion& rule = question_.rules[i];
      if (rule.adapts) continue;
      const TargetStep& found = choice_.rules[i].target.emplace(
          find_target_step(searched(rule, question_), i, goal, budget_,
                           [&](std::size_t, Index n) { return measure(rule.rule, n); }));
      for (const auto& made : found.runs) chosen_[i].insert(step(made.first));
    }
  }

  // Without a reference nothing is known of errors: two steps of each rule show what becomes of them.
  void add_first_steps() {
    for (std::size_t i = 0; i < question_.rules.size(); ++i) {
      const RuleQuestion& rule = question_.rules[i];
      if (!has_ladder(rule)) continue;
      const Index n = searched(rule, question_).first;
      chosen_[i] = {step(n), step(2 * n)};
    }
  }

  void find_stable_steps() {
    constexpr double kAccuracy = 0.02;
    StudyBudget left(budget_.total() - budget_.spent() - choice_.seconds);
    for (std::size_t i = 0; i < question_.rules.size() && !choice_.is_stopped; ++i) {
      const RuleQuestion& rule = question_.rules[i];
      const SearchedRule limit = searched(rule, question_);
      if (rule.adapts || is_implicit(rule.rule.integrator) || limit.fewest <= 1) continue;
      // There may be some ten runs.
      const double seconds = run_seconds(rule, limit.fewest);
      if (!left.allows(5.0 * seconds)) continue;
      choice_.rules[i].stable = find_stable_step(limit.fewest, kAccuracy, left,
                                                 [&](Index n) { return trial(rule.rule, n); });
    }
    budget_.spend(left.spent());
  }

  // What a run with n steps takes, from one of the runs that were made.
  double run_seconds(const RuleQuestion& rule, Index n) const {
    double each = rule.seconds_per_step;
    for (const auto& [key, made] : runs_) {
      if (key.first == rule.rule && made.track) each = made.seconds * key.second / question_.end;
    }
    return each * static_cast<double>(n);
  }

  void collect() {
    for (std::size_t i = 0; i < question_.rules.size(); ++i) {
      const RuleQuestion& rule = question_.rules[i];
      std::set<double> steps = chosen_[i];
      // A rule that adapts its steps has about the same error whatever its first one is: one run of it is enough.
      if (rule.asked.has_ladder && rule.adapts) {
        steps.insert(step(series_above(static_cast<double>(searched(rule, question_).first))));
      }
      steps.insert(rule.asked.steps.begin(), rule.asked.steps.end());
      RuleChoice& choice = choice_.rules[i];
      choice.steps.assign(steps.begin(), steps.end());
      for (const auto& [key, made] : runs_) {
        if (key.first == rule.rule && !steps.contains(key.second)) {
          choice.trials.push_back(key.second);
        }
      }
    }
  }

  const StepQuestion& question_;
  StudyBudget& budget_;
  const MakeTrackedRun& make_;
  std::map<std::pair<StudyRule, double>, TrackedRun> runs_;  // by rule and step
  Track reference_;
  std::map<std::size_t, std::set<double>> chosen_;
  StepChoice choice_;
};

}  // namespace

double relative_error(const MotionTrack& run, const MotionTrack& reference,
                      const ErrorMeasure& measure) {
  if (measure.kind == ErrorKind::kPositions) {
    return (run.last() - reference.last()).norm() / scales_of(reference).at_end;
  }
  return series_error(measure, run, reference);
}

StepChoice choose_steps(const StepQuestion& question, StudyBudget& budget,
                        const MakeTrackedRun& make) {
  return Choice(question, budget, make).result();
}

}  // namespace tetraction
