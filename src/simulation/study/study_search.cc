#include "tetraction/simulation/study_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "simulation/stepping/step_count.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {
namespace {

using Trials = std::map<Index, Trial>;

bool has_error(const Trial& trial) {
  return !trial.failed && std::isfinite(trial.error) && trial.error > 0.0;
}

// A number of steps from a real one.
Index whole_steps(double n) {
  return static_cast<Index>(std::clamp(n, 1.0, kMostSteps));
}

// The n at which the error is `wanted`, if it is that of the trial at `n` and has this order.
double steps_for(double wanted, Index n, double error, double order) {
  return static_cast<double>(n) * std::pow(error / wanted, 1.0 / order);
}

// The order that two trials show, or `usual` where they show none.
double order_between(const std::pair<Index, double>& a, const std::pair<Index, double>& b,
                     double usual) {
  const double ratio = static_cast<double>(b.first) / static_cast<double>(a.first);
  const double order = std::log(a.second / b.second) / std::log(ratio);
  return order > 0.3 * usual && order < 3.0 * usual ? order : usual;
}

// The trials of one rule while its ladder is found.
class LadderSearch {
 public:
  LadderSearch(const SearchedRule& rule, const LadderSettings& settings)
      : rule_(rule), settings_(settings) {}

  // The next trial, or 0 if none is needed.
  Index next() const {
    const Index least = series_above(static_cast<double>(rule_.fewest));
    if (is_done_ || static_cast<int>(trials_.size()) >= settings_.most_trials) return 0;
    if (trials_.empty()) return start();
    const auto& [coarsest, first] = *trials_.begin();
    const auto& [finest, last] = *trials_.rbegin();
    // Errors may be unknown where steps are large: two periods are needed to see a frequency.
    if (last.failed || !std::isfinite(last.error)) return finer(finest);
    if (has_error(first) && first.error < settings_.coarse && coarsest > least) {
      const double wanted = steps_for(settings_.coarse, coarsest, first.error, rule_.order);
      const double nearest = static_cast<double>(coarser(coarsest));
      return std::max(
          least, series_below(std::clamp(wanted, 0.01 * static_cast<double>(coarsest), nearest)));
    }
    if (!has_error(last) || last.error <= settings_.fine) return 0;
    if (last.error > settings_.coarse) {
      const double wanted = steps_for(settings_.coarse, finest, last.error, rule_.order);
      const double nearest = static_cast<double>(finer(finest));
      return series_below(std::clamp(wanted, nearest, 100.0 * static_cast<double>(finest)));
    }
    return finer(finest);
  }

  // What a run with n steps takes, from the trial that is nearest. 0 if nothing is known.
  double seconds(Index n) const {
    const auto above = trials_.lower_bound(n);
    if (above != trials_.end() && above->first == n) return above->second.seconds;
    const auto scaled = [&](const auto& trial) {
      return trial.second.seconds * static_cast<double>(n) / static_cast<double>(trial.first);
    };
    for (auto trial = above; trial != trials_.begin();) {
      if (!(--trial)->second.failed) return scaled(*trial);
    }
    for (auto trial = above; trial != trials_.end(); ++trial) {
      // Larger steps take more time each, where they are solved for.
      if (!trial->second.failed) return scaled(*trial);
    }
    return rule_.seconds_per_step * static_cast<double>(n);
  }

  void add(Index n, const Trial& trial) { trials_[n] = trial; }
  void stop() { is_done_ = true; }
  bool is_empty() const { return trials_.empty(); }

  // The ladder with the steps that the order demands, whatever they cost.
  Ladder ladder() const {
    Ladder ladder;
    ladder.trials = static_cast<int>(trials_.size());
    const auto [begin, last] = ends();
    if (begin == 0 && !trials_.empty()) {
      ladder.remark = fmt::format("{}: no trial run reached the end.", rule_.name);
      return ladder;
    }
    const std::vector<std::pair<Index, double>> known = errors();
    if (known.empty()) {
      ladder.remark = fmt::format(
          "{}: {}.", rule_.name,
          trials_.empty() ? "not resolved within the budget, which left no time for a trial run"
                          : "its error is not known");
    }
    ladder.is_resolved = !known.empty();
    for (Index n = begin == 0 ? start() : begin;; n = finer(n)) {
      ladder.rungs.push_back({n, expected(known, n), seconds(n), trials_.contains(n)});
      if (n >= last && ladder.rungs.size() > 1) return ladder;
    }
  }

 private:
  static Index finer(Index n) { return series_above(1.5 * static_cast<double>(n)); }
  Index start() const {
    return series_above(static_cast<double>(std::max(rule_.first, rule_.fewest)));
  }
  static Index coarser(Index n) { return series_below(0.75 * static_cast<double>(n)); }

  std::vector<std::pair<Index, double>> errors() const {
    std::vector<std::pair<Index, double>> known;
    for (const auto& [n, trial] : trials_) {
      if (has_error(trial)) known.emplace_back(n, trial.error);
    }
    return known;
  }

  // The error at n: measured, or from the finest trial and an order that is not above the usual one.
  double expected(const std::vector<std::pair<Index, double>>& known, Index n) const {
    const auto found = trials_.find(n);
    if (found != trials_.end() || known.empty()) {
      return found != trials_.end() ? found->second.error : Trial().error;
    }
    return known.back().second *
           std::pow(static_cast<double>(known.back().first) / static_cast<double>(n),
                    safe_order(known));
  }

  double safe_order(const std::vector<std::pair<Index, double>>& known) const {
    // Large errors saturate, and show no order.
    if (known.size() < 2 || known[known.size() - 2].second > settings_.coarse) return rule_.order;
    const double order = order_between(known[known.size() - 2], known.back(), rule_.order);
    return std::min<double>(order, rule_.order);
  }

  // The largest and the smallest step of the ladder; 0 if no run reached the end.
  std::pair<Index, Index> ends() const {
    const std::vector<std::pair<Index, double>> known = errors();
    Index begin = 0;
    Index last = 0;
    for (const auto& [n, trial] : trials_) {
      if (trial.failed || (!known.empty() && !std::isfinite(trial.error))) {
        begin = 0;  // larger steps that reached the end did so by chance
        continue;
      }
      if (begin == 0 || (has_error(trial) && trial.error >= settings_.coarse)) begin = n;
      if (last < begin || !(trials_.at(last).error <= settings_.fine)) last = n;
    }
    if (begin != 0 && !known.empty() && known.back().second > settings_.fine) {
      // A tenth more, because the order is not exact.
      last = std::max(last, series_above(steps_for(settings_.fine, known.back().first,
                                                   1.1 * known.back().second, safe_order(known))));
    }
    return {begin, last};
  }

  const SearchedRule& rule_;
  const LadderSettings& settings_;
  Trials trials_;
  bool is_done_ = false;
};

// Leaves out the most expensive steps until the rest fits into the budget. Two rules keep two steps.
void fit_into_budget(const std::vector<SearchedRule>& rules, const StudyBudget& budget,
                     std::vector<Ladder>& ladders) {
  // What the first two steps of each rule take that are not made yet.
  std::vector<std::pair<double, std::size_t>> pairs;
  for (std::size_t i = 0; i < ladders.size(); ++i) {
    if (ladders[i].rungs.size() < 2) continue;
    double seconds = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      if (!ladders[i].rungs[k].is_made) seconds += ladders[i].rungs[k].seconds;
    }
    pairs.emplace_back(seconds, i);
  }
  std::sort(pairs.begin(), pairs.end());
  double planned = 0.0;
  std::vector<std::size_t> kept(ladders.size(), 0);
  for (std::size_t k = 0; k < std::min<std::size_t>(2, pairs.size()); ++k) {
    planned += pairs[k].first;
    kept[pairs[k].second] = 2;
  }
  std::vector<bool> is_cut(ladders.size(), false);
  while (true) {
    std::optional<std::size_t> cheapest;
    const auto cost = [&](std::size_t i) {
      const Rung& rung = ladders[i].rungs[kept[i]];
      return rung.is_made ? 0.0 : rung.seconds;
    };
    for (std::size_t i = 0; i < ladders.size(); ++i) {
      if (is_cut[i] || kept[i] == ladders[i].rungs.size()) continue;
      if (!cheapest || cost(i) < cost(*cheapest)) cheapest = i;
    }
    if (!cheapest) break;
    if (cost(*cheapest) > 0.0 && !budget.allows(planned + cost(*cheapest))) {
      is_cut[*cheapest] = true;
      continue;
    }
    planned += cost(*cheapest);
    ++kept[*cheapest];
  }
  for (std::size_t i = 0; i < ladders.size(); ++i) {
    if (!is_cut[i]) continue;
    Ladder& ladder = ladders[i];
    const double wanted = ladder.rungs.back().seconds;
    ladder.rungs.resize(kept[i]);
    ladder.is_resolved = false;
    ladder.remark = fmt::format(
        "{}: not resolved within the budget of {:.3g} s. Its finest step would take about "
        "{:.2g} s.",
        rules[i].name, budget.total(), wanted);
  }
}

}  // namespace

double Ladder::seconds_left() const {
  double seconds = 0.0;
  for (const Rung& rung : rungs) seconds += rung.is_made ? 0.0 : rung.seconds;
  return seconds;
}

std::vector<Ladder> find_ladders(const std::vector<SearchedRule>& rules,
                                 const LadderSettings& settings, StudyBudget& budget,
                                 const MeasureRun& measure) {
  std::vector<LadderSearch> searches;
  for (const SearchedRule& rule : rules) searches.emplace_back(rule, settings);
  const double most = settings.share * budget.total();
  while (true) {
    std::optional<std::size_t> cheapest;
    double seconds = 0.0;
    for (std::size_t i = 0; i < searches.size(); ++i) {
      const Index n = searches[i].next();
      if (n == 0) continue;
      const double estimate = searches[i].seconds(n);
      if (cheapest && estimate >= seconds) continue;
      cheapest = i;
      seconds = estimate;
    }
    if (!cheapest) break;
    LadderSearch& search = searches[*cheapest];
    // Without a trial nothing is known of a rule.
    if (seconds > (search.is_empty() ? 5.0 * most : most) || !budget.allows(seconds)) {
      search.stop();
      continue;
    }
    const Index n = search.next();
    const Trial trial = measure(*cheapest, n);
    budget.spend(trial.seconds);
    search.add(n, trial);
  }
  std::vector<Ladder> ladders;
  for (const LadderSearch& search : searches) ladders.push_back(search.ladder());
  fit_into_budget(rules, budget, ladders);
  return ladders;
}

ChosenReference find_reference(const std::vector<SearchedRule>& rules, double goal, double share,
                               StudyBudget& budget, const MeasureRun& measure) {
  const double most = share * budget.total();
  const auto first_steps = [](const SearchedRule& rule) {
    return std::max(rule.first, rule.fewest);
  };
  ChosenReference chosen;
  while (chosen.rule + 1 < rules.size()) {
    const SearchedRule& rule = rules[chosen.rule];
    const double seconds = rule.seconds_per_step * static_cast<double>(first_steps(rule));
    if (seconds < 0.25 * most) break;
    ++chosen.rule;
  }
  const double divisor = std::pow(2.0, rules[chosen.rule].order) - 1.0;
  Index n = first_steps(rules[chosen.rule]);
  double seconds_per_step = 0.0;
  // Pairs of runs with n and 2n steps. The first run of a pair may be the second one of the last pair.
  for (Index made = 0;;) {
    for (const Index next : {n, 2 * n}) {
      if (next <= made) continue;
      const Trial trial = measure(chosen.rule, next);
      ++chosen.runs;
      budget.spend(trial.seconds);
      seconds_per_step = std::max(seconds_per_step, trial.seconds / static_cast<double>(next));
      made = next;
      if (!trial.failed) chosen.n = next;
      chosen.error = trial.failed ? Trial().error : trial.error / divisor;
    }
    if (chosen.error <= goal) return chosen;
    const double wanted = std::isfinite(chosen.error)
                              ? steps_for(0.8 * goal, made, chosen.error, rules[chosen.rule].order)
                              : 0.0;
    // A run with half of the wanted steps comes first.
    n = std::max(made, whole_steps(0.5 * std::min(wanted, 8.0 * static_cast<double>(made))));
    const auto seconds = [&](Index steps) {
      return seconds_per_step * static_cast<double>(n == made ? 2 * steps : 3 * steps);
    };
    if (seconds(n) > most || !budget.allows(seconds(n))) n = made;
    if (seconds(n) > most || !budget.allows(seconds(n)) || chosen.runs > 20) return chosen;
  }
}

TargetStep find_target_step(const SearchedRule& rule, std::size_t index, double target,
                            StudyBudget& budget, const MeasureRun& measure, int most_runs) {
  TargetStep result;
  Trials trials;
  Index coarse = rule.fewest - 1;  // largest n that is known to be too small
  bool is_unstable = false;        // whether the run with that n failed
  Index n = std::max(rule.first, rule.fewest);
  while (true) {
    if (!trials.empty()) {
      const auto& [made, trial] = *trials.rbegin();
      const double seconds = trial.seconds * static_cast<double>(n) / static_cast<double>(made);
      if (!budget.allows(seconds)) {
        result.outcome = TargetOutcome::kNoBudget;
        break;
      }
    }
    const Trial trial = measure(index, n);
    budget.spend(trial.seconds);
    trials[n] = trial;
    result.runs.emplace_back(n, trial);
    if (!trial.failed && trial.error <= target) {
      result.n = n;
      result.trial = trial;
    } else {
      coarse = n;
      is_unstable = trial.failed;
      const bool is_better = has_error(trial) && !(result.trial.error < trial.error);
      if (result.n == 0 && (result.runs.size() == 1 || is_better)) result.trial = trial;
    }
    const double low = static_cast<double>(std::max<Index>(coarse, 1));
    const double high = static_cast<double>(result.n);
    const bool is_close = result.n != 0 && result.n <= coarse + 1;
    if (is_close || (result.n != 0 && is_unstable && high <= 1.02 * low)) {
      const bool at_limit = is_unstable || (coarse < rule.fewest && rule.fewest > 1);
      result.outcome = at_limit ? TargetOutcome::kStability : TargetOutcome::kMet;
      break;
    }
    // The secant is that of the two trials with errors nearest the target, or of the two finest ones until
    // the target is met.
    std::vector<std::pair<Index, double>> known;
    for (const auto& [steps, made] : trials) {
      if (has_error(made)) known.emplace_back(steps, made.error);
    }
    std::sort(known.begin(), known.end(), [&](const auto& a, const auto& b) {
      if (result.n == 0) return a.first > b.first;
      return std::abs(std::log(a.second / target)) < std::abs(std::log(b.second / target));
    });
    double wanted = 2.0 * low;
    if (!known.empty()) {
      const double order =
          known.size() > 1 ? order_between(known[0], known[1], rule.order) : rule.order;
      wanted = std::ceil(steps_for(target, known[0].first, known[0].second, order) * (1.0 - 1e-9));
    } else if (result.n != 0) {
      wanted = low;  // all errors are zero
    }
    const bool is_limited = is_unstable && wanted <= low;
    if (result.n == 0) {
      wanted = std::clamp(wanted, low + 1.0, 10.0 * low);
    } else if (wanted >= std::min(high, std::ceil(0.995 * high))) {
      result.outcome = TargetOutcome::kMet;
      break;
    } else if (trials.contains(coarse)) {
      if (wanted <= low) wanted = std::floor(std::sqrt(low * high));
      wanted = std::clamp(wanted, low + 1.0, high - 1.0);
    } else {
      wanted = std::max({wanted, low + (coarse == 0 ? 0.0 : 1.0), std::floor(0.1 * high)});
    }
    if (static_cast<int>(result.runs.size()) >= most_runs) {
      result.outcome = result.n == 0 && known.empty() && !is_unstable ? TargetOutcome::kNoError
                       : result.n == 0                                ? TargetOutcome::kNotMet
                       : is_limited                                   ? TargetOutcome::kStability
                                                                      : TargetOutcome::kMet;
      break;
    }
    n = whole_steps(wanted);
  }
  double last = std::numeric_limits<double>::infinity();
  for (const auto& [steps, trial] : trials) {
    if (!has_error(trial)) continue;
    if (trial.error > last) result.is_monotone = false;
    last = trial.error;
  }
  return result;
}

StableStep find_stable_step(Index first, double accuracy, StudyBudget& budget,
                            const std::function<Trial(Index n)>& run) {
  StableStep found;
  double seconds_per_step = 0.0;
  double factor = 1.1;
  double n = static_cast<double>(first);
  while (budget.allows(seconds_per_step * n)) {
    const Trial trial = run(whole_steps(n));
    ++found.runs;
    budget.spend(trial.seconds);
    (trial.failed ? found.unstable : found.stable) = whole_steps(n);
    // A run that fails stops early.
    seconds_per_step = std::max(seconds_per_step, trial.seconds / n);
    const double low = static_cast<double>(found.unstable);
    const double high = static_cast<double>(found.stable);
    if (found.stable != 0 && found.unstable != 0) {
      if (high <= (1.0 + accuracy) * low || found.stable == found.unstable + 1) break;
      n = std::clamp(std::round(std::sqrt(low * high)), low + 1.0, high - 1.0);
      continue;
    }
    if (found.stable == 1) break;
    n = found.unstable == 0 ? std::min(high - 1.0, std::floor(n / factor))
                            : std::max(low + 1.0, std::ceil(n * factor));
    n = std::max(n, 1.0);
    if (n >= kMostSteps) break;
    factor *= factor;
  }
  return found;
}

}  // namespace tetraction
