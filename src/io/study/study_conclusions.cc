#include "study_conclusions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

namespace tetraction {
namespace {

// Errors below this many times that of the reference are not told from it, as for observed orders.
constexpr double kAboveReference = 5.0;
// An observed order that differs by less agrees with the theoretical one.
constexpr double kOrderTolerance = 0.2;
// Wall times that differ by less are taken as equal: each run is measured once.
constexpr double kTimeTolerance = 0.2;
// Shorter wall times vary much from one measurement to the next, s.
constexpr double kShortTime = 0.05;

using Rows = std::vector<const StudyRow*>;

std::string capitalised(std::string text) {
  if (!text.empty() && text.front() >= 'a' && text.front() <= 'z') {
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  }
  return text;
}

std::string in_limits(const StudyRow& row) {
  const double ratio = row.step / row.stable_step;
  if (!std::isfinite(ratio) || !(ratio > 0.0)) return {};
  return fmt::format(" ({} h_crit)",
                     ratio < 1e3 ? short_number(ratio) : fmt::format("{:.0f}", ratio));
}

// "verlet with h = 7.2e-5 s (0.9 h_crit)".
std::string named_run(const StudyRow& row) {
  return fmt::format("{} with h = {} s{}", run_label(row), short_number(row.step), in_limits(row));
}

// "7.2e-5 s (0.9 h_crit)".
std::string named_step(const StudyRow& row) {
  return fmt::format("{} s{}", short_number(row.step), in_limits(row));
}

// Two digits are as many as single measurements have.
std::string two_digits(double ratio) {
  const double unit = std::pow(10.0, std::floor(std::log10(ratio)) - 1.0);
  return short_number(std::round(ratio / unit) * unit);
}

bool is_about_one(double ratio) {
  return std::max(ratio, 1.0 / ratio) < 1.0 + kTimeTolerance;
}

// "8 times the wall time", for a ratio of at least 1.
std::string compared_time(double ratio) {
  return is_about_one(ratio) ? "about the same wall time"
                             : two_digits(ratio) + " times the wall time";
}

class Conclusions {
 public:
  explicit Conclusions(const StudyResult& result) : result_(result) {
    for (const StudyRow& row : result.rows) {
      if (row.variant != result.rows.front().variant) continue;
      first_variant_.push_back(&row);
      if (row.status == RunStatus::kFinished && row.role == StudyRole::kRun && !row.is_reference &&
          std::isfinite(error_of(row))) {
        compared_.push_back(&row);
      }
    }
  }

  std::vector<StudyConclusion> of_references() {
    if (result_.rows.empty()) return {};
    add("Variants", references());
    const std::vector<StudyResult> parts = parts_of_study(result_);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      for (StudyConclusion& own : study_conclusions(parts[i])) {
        own.topic += ": " + result_.references[i].variant;
        conclusions_.push_back(std::move(own));
      }
    }
    return std::move(conclusions_);
  }

  std::vector<StudyConclusion> all() {
    if (result_.rows.empty()) return {};
    add("Cost of accuracy", cost());
    add("Runs that did not reach the end", failures());
    add("Observed orders", orders());
    add("Limits of the comparison", limits());
    add("Conservation", conservation());
    add("Solvers", solvers());
    add("Variants", variants());
    return std::move(conclusions_);
  }

 private:
  using Sentences = std::vector<std::string>;

  void add(const char* topic, Sentences sentences) {
    if (!sentences.empty()) conclusions_.push_back({topic, std::move(sentences)});
  }

  double error_of(const StudyRow& row) const {
    return result_.error_probe.empty() ? row.position_error : row.probe_error;
  }
  std::string error_name() const {
    return result_.error_probe.empty() ? "position error"
                                       : fmt::format("error of the probe {}", result_.error_probe);
  }
  double known_reference_error() const {
    return std::isfinite(result_.reference_error) ? result_.reference_error : 0.0;
  }

  // The cheapest runs whose error, with that of the reference, is at most the target.
  struct Choice {
    const StudyRow* best = nullptr;        // of all
    const StudyRow* other_side = nullptr;  // on the other side of the stability limit than `best`
    const StudyRow* equal = nullptr;       // one that takes about the time of `best`
    bool operator==(const Choice&) const = default;
  };

  bool reaches(const StudyRow& row, double target) const {
    return error_of(row) + known_reference_error() <= target;
  }

  Choice choose(double target) const {
    Rows reaching;
    for (const StudyRow* row : compared_) {
      if (reaches(*row, target) && row->wall_seconds > 0.0 && !row->shares_machine) {
        reaching.push_back(row);
      }
    }
    const auto cheaper = [](const StudyRow* a, const StudyRow* b) {
      return a->wall_seconds < b->wall_seconds;
    };
    Choice choice;
    if (reaching.empty()) return choice;
    choice.best = *std::min_element(reaching.begin(), reaching.end(), cheaper);
    for (const StudyRow* row : reaching) {
      if (row != choice.best && is_about_one(row->wall_seconds / choice.best->wall_seconds)) {
        choice.equal = row;
      }
    }
    const bool is_above = is_above_stability_limit(*choice.best);
    std::erase_if(reaching,
                  [&](const StudyRow* row) { return is_above_stability_limit(*row) == is_above; });
    if (!reaching.empty()) {
      choice.other_side = *std::min_element(reaching.begin(), reaching.end(), cheaper);
    }
    return choice;
  }

  // Whether the wall times of the runs belong together.
  bool times_are_comparable() const {
    std::set<std::pair<std::string, int>> machines;
    for (const StudyRow* row : first_variant_) machines.emplace(row->processor, row->threads);
    return machines.size() < 2;
  }

  static bool has_own_time(const StudyRow* row) { return !row->shares_machine; }

  // What is missing where runs shared the cores, and how to get it.
  Sentences missing_times() const {
    const auto alone = std::count_if(compared_.begin(), compared_.end(), has_own_time);
    const auto all = static_cast<std::ptrdiff_t>(compared_.size());
    if (alone == all) return {};
    const std::string advice =
        "Make the study again without --resume and with --jobs 1, or with so many --jobs, and "
        "with so many --threads that their product is at most the number of cores.";
    return {
        alone == 0
            ? fmt::format("Nothing is said of cost, because timings are missing: all runs shared "
                          "the cores of the machine with others, or had more threads than cores. "
                          "{}",
                          advice)
            : fmt::format("The wall times of {} of {} runs do not count here, because these runs "
                          "shared the cores of the machine with others, or had more threads than "
                          "cores. {}",
                          all - alone, all, advice)};
  }

  Sentences cost() const {
    Sentences sentences;
    if (compared_.empty() || !times_are_comparable()) return sentences;
    const Sentences missing = missing_times();
    if (std::none_of(compared_.begin(), compared_.end(), has_own_time)) return missing;
    constexpr std::array<std::pair<double, const char*>, 3> kTargets{
        {{0.1, "10 %"}, {0.01, "1 %"}, {0.001, "0.1 %"}}};
    bool has_short_times = false;
    for (std::size_t i = 0; i < kTargets.size(); ++i) {
      const Choice choice = choose(kTargets[i].first);
      if (choice.best == nullptr) {
        const bool is_reached =
            std::any_of(compared_.begin(), compared_.end(),
                        [&](const StudyRow* row) { return reaches(*row, kTargets[i].first); });
        if (is_reached) continue;  // by runs whose time is not known
        sentences.push_back(not_reached(kTargets[i].first, kTargets[i].second));
        break;
      }
      const double loosest = kTargets[i].first;
      std::vector<std::string> targets{kTargets[i].second};
      while (i + 1 < kTargets.size() && choose(kTargets[i + 1].first) == choice) {
        targets.emplace_back(kTargets[++i].second);
      }
      has_short_times = has_short_times || choice.best->wall_seconds < kShortTime;
      sentences.push_back(fmt::format(
          "For {} {} of {} the cheapest run is {}: its error is {}, and its time steps take {} s.",
          error_name().front() == 'e' ? "an" : "a", error_name(), enumeration(targets),
          named_run(*choice.best), short_number(error_of(*choice.best)),
          short_number(choice.best->wall_seconds)));
      if (choice.equal != nullptr) {
        sentences.push_back(fmt::format("{} takes about the same wall time.",
                                        capitalised(named_run(*choice.equal))));
      }
      const bool is_above = is_above_stability_limit(*choice.best);
      const char* other = is_above ? "below" : "above";
      if (choice.other_side != nullptr && choice.other_side != choice.equal) {
        sentences.push_back(fmt::format(
            "Among the steps {} the stability limit it is {}, which takes {}.", other,
            named_run(*choice.other_side),
            compared_time(choice.other_side->wall_seconds / choice.best->wall_seconds)));
      } else if (choice.other_side == nullptr && has_steps(!is_above) &&
                 !side_reaches(!is_above, loosest)) {
        sentences.push_back(
            fmt::format("No run with a step {} the stability limit reaches this error.", other));
      }
    }
    if (has_short_times) {
      sentences.push_back(fmt::format(
          "Wall times below {} s vary much from one measurement to the next; a longer end time or "
          "a finer mesh gives a surer comparison.",
          kShortTime));
    }
    sentences.insert(sentences.end(), missing.begin(), missing.end());
    return sentences;
  }

  bool has_steps(bool above_limit) const {
    return std::any_of(compared_.begin(), compared_.end(), [&](const StudyRow* row) {
      return is_above_stability_limit(*row) == above_limit;
    });
  }
  // Whether a run on this side of the stability limit reaches the error, at whatever cost.
  bool side_reaches(bool above_limit, double target) const {
    return std::any_of(compared_.begin(), compared_.end(), [&](const StudyRow* row) {
      return is_above_stability_limit(*row) == above_limit && reaches(*row, target);
    });
  }

  std::string not_reached(double target, const char* name) const {
    const StudyRow* best = *std::min_element(
        compared_.begin(), compared_.end(),
        [&](const StudyRow* a, const StudyRow* b) { return error_of(*a) < error_of(*b); });
    if (error_of(*best) <= target) {
      return fmt::format(
          "No run is certain to reach {} {} of {}: the reference's own error is estimated at {}, "
          "and the smallest difference from it is {} ({}).",
          error_name().front() == 'e' ? "an" : "a", error_name(), name,
          short_number(known_reference_error()), short_number(error_of(*best)), named_run(*best));
    }
    return fmt::format("No run reaches {} {} of {}: the smallest is {} ({}).",
                       error_name().front() == 'e' ? "an" : "a", error_name(), name,
                       short_number(error_of(*best)), named_run(*best));
  }

  // Failed runs with the same cause make one sentence.
  Sentences failures() const {
    Sentences sentences;
    std::vector<std::pair<std::string, Rows>> groups;  // of explicit runs above their limit
    const auto group_of = [&](const std::string& name) -> Rows& {
      for (auto& [known, rows] : groups) {
        if (known == name) return rows;
      }
      return groups.emplace_back(name, Rows{}).second;
    };
    Sentences others;
    for (const StudyRow& row : result_.rows) {
      if (row.status == RunStatus::kCancelled || row.status == RunStatus::kRunning) {
        others.push_back(fmt::format("{} was interrupted.", capitalised(named_run(row))));
        continue;
      }
      if (row.status == RunStatus::kFinished) continue;
      if (row.status == RunStatus::kUnstable && !is_implicit(row.integrator) &&
          is_above_stability_limit(row)) {
        group_of(run_label(row)).push_back(&row);
        continue;
      }
      others.push_back(
          fmt::format("{} {}: {}{}", capitalised(named_run(row)),
                      row.status == RunStatus::kUnstable ? "became unstable" : "failed",
                      row.message.empty() ? "no reason was given" : row.message,
                      row.message.empty() || row.message.back() != '.' ? "." : ""));
    }
    for (const auto& [name, rows] : groups) {
      std::vector<std::string> steps;
      for (const StudyRow* row : rows) steps.push_back(named_step(*row));
      sentences.push_back(fmt::format(
          "{} became unstable with h = {}: {} above its stability limit.", capitalised(name),
          enumeration(steps), rows.size() == 1 ? "this step is" : "these steps are"));
    }
    sentences.insert(sentences.end(), others.begin(), others.end());
    for (const StudyRow& row : result_.rows) {
      if (row.status != RunStatus::kFinished || is_implicit(row.integrator) ||
          !is_above_stability_limit(row)) {
        continue;
      }
      sentences.push_back(fmt::format(
          "{} reached the end although its step is above the stability limit, which is that of the "
          "initial state.",
          capitalised(named_run(row))));
    }
    return sentences;
  }

  Sentences orders() const {
    Sentences sentences;
    for (const Integrator integrator : all_integrators()) {
      std::vector<double> found;
      std::vector<std::pair<double, double>> steps;
      Rows runs;
      const StudyRow* finer = nullptr;
      bool has_rows = false;
      for (const StudyRow* row : first_variant_) {
        if (row->integrator != integrator || row->compares_solver) continue;
        has_rows = true;
        if (std::isfinite(row->observed_order) && finer != nullptr) {
          found.push_back(row->observed_order);
          steps.emplace_back(finer->step, row->step);
        }
        if (std::find(compared_.begin(), compared_.end(), row) != compared_.end()) {
          runs.push_back(row);
        }
        finer = row;
      }
      if (!has_rows || !std::isfinite(error_of_any())) continue;
      sentences.push_back(found.empty() ? no_order(integrator, runs)
                                        : observed(integrator, found, steps));
    }
    return sentences;
  }

  // Any error of the study, or NaN if it has none: then nothing is said of orders.
  double error_of_any() const {
    return compared_.empty() ? std::numeric_limits<double>::quiet_NaN()
                             : error_of(*compared_.front());
  }

  std::string observed(Integrator integrator, const std::vector<double>& found,
                       const std::vector<std::pair<double, double>>& steps) const {
    const int theory = order(integrator);
    std::vector<std::string> numbers;
    std::vector<std::string> strangers;
    for (std::size_t i = 0; i < found.size(); ++i) {
      numbers.push_back(fmt::format("{:.2f}", found[i]));
      if (std::abs(found[i] - theory) > kOrderTolerance) {
        strangers.push_back(fmt::format("between {} s and {} s", short_number(steps[i].first),
                                        short_number(steps[i].second)));
      }
    }
    const std::string name = capitalised(to_string(integrator));
    std::string text =
        found.size() == 1
            ? fmt::format("{} has the observed order {} between {} s and {} s", name, numbers[0],
                          short_number(steps[0].first), short_number(steps[0].second))
            : fmt::format("{} has the observed orders {}, from the finest pair of steps up", name,
                          enumeration(numbers));
    if (strangers.empty()) {
      return text + fmt::format("; {} with the theoretical order {}.",
                                found.size() == 1 ? "it agrees" : "they agree", theory);
    }
    return text + fmt::format("; the theoretical order is {}, which the errors do not show {}.",
                              theory, found.size() == 1 ? "there" : enumeration(strangers));
  }

  std::string no_order(Integrator integrator, const Rows& runs) const {
    std::string reason = "its errors do not grow with the step";
    if (runs.size() < 2) {
      reason = "fewer than two of its runs have an error";
    } else if (!std::isfinite(result_.reference_error)) {
      reason =
          "the reference's own error is not known, and may be a large part of its errors. A run of "
          "the "
          "reference's integrator with another step gives an estimate";
    } else if ((integrator != result_.reference_integrator || is_extrapolated(result_)) &&
               error_of(*runs.front()) < kAboveReference * known_reference_error()) {
      reason = "the reference's own error is not small beside its errors";
    }
    return fmt::format("{} has no observed order: {}.", capitalised(to_string(integrator)), reason);
  }

  Sentences limits() const {
    Sentences sentences;
    if (result_.is_interrupted) {
      sentences.emplace_back(
          "The study was interrupted. What is said here is about the runs before that.");
    }
    const std::string reference = reference_name(result_);
    if (result_.extrapolation) {
      const ReferenceExtrapolation& found = *result_.extrapolation;
      const char* finest = "The run with the smallest of the three steps is the reference.";
      if (!found.is_valid) {
        sentences.push_back(
            fmt::format("The reference is not extrapolated, because {}. {}", found.reason, finest));
      }
      if (!found.probe_is_valid && found.probe_reason != found.reason) {
        sentences.push_back(
            fmt::format("The reference of the probe {} is not extrapolated, because {}. {}",
                        result_.error_probe, found.probe_reason, finest));
      }
    }
    if (result_.reference_status != RunStatus::kFinished) {
      sentences.push_back(fmt::format(
          "The reference, {}, did not reach the end. Therefore there are no errors.", reference));
    } else if (!std::isfinite(result_.reference_error)) {
      sentences.push_back(fmt::format(
          "All errors are differences from the reference, {}. Its own error is not known, because "
          "no other run of its integrator gives an estimate.",
          reference));
    } else {
      sentences.push_back(of_reference_error(reference));
      std::vector<std::string> close;
      for (const StudyRow* row : compared_) {
        if (error_of(*row) < kAboveReference * result_.reference_error) {
          close.push_back(named_run(*row));
        }
      }
      if (!close.empty()) {
        sentences.push_back(fmt::format(
            "The {} of {} {} less than five times as large: the reference's own error bounds what "
            "they say.",
            close.size() == 1 ? "error" : "errors", enumeration(close),
            close.size() == 1 ? "is" : "are"));
      }
    }
    if (!times_are_comparable()) {
      sentences.emplace_back(
          "The runs were made on different machines or with different numbers of threads. Their "
          "wall times cannot be compared.");
    }
    return sentences;
  }

  // How large the known error of the reference is, and where this comes from.
  std::string of_reference_error(const std::string& reference) const {
    const std::string error = short_number(result_.reference_error);
    const int theory = order(result_.reference_integrator);
    if (is_extrapolated(result_)) {
      const ReferenceExtrapolation& found = *result_.extrapolation;
      std::string text = fmt::format(
          "All errors are differences from the reference, the {}. Its own error is estimated at "
          "{}, from the extrapolation with twice the steps.",
          reference, error);
      if (std::isfinite(found.finest_error_at_end)) {
        text += fmt::format(" That of its finest run is {} at the end.",
                            short_number(found.finest_error_at_end));
      }
      const auto shown = [](double value) {
        return std::isfinite(value) ? fmt::format("{:.2f}", value) : std::string("none");
      };
      return text + fmt::format(
                        " The three runs show the order {} at the end and {} over time{}; the "
                        "theoretical order is {}.",
                        shown(found.order_at_end), shown(found.order_over_time),
                        result_.error_probe.empty()
                            ? ""
                            : fmt::format(", and {} of the probe", shown(found.order_of_probe)),
                        theory);
    }
    const std::string text = fmt::format(
        "All errors are differences from the reference, {}. Its own error is estimated "
        "at {}, from ",
        reference, error);
    if (result_.extrapolation) {
      const ReferenceExtrapolation& found = *result_.extrapolation;
      const bool is_exact = result_.error_probe.empty() ? found.is_exact : found.probe_is_exact;
      return text + (is_exact ? "its difference from the run with twice its step."
                              : "the finest other run of its integrator and the theoretical order. "
                                "The three runs do not show that order, so that the estimate is "
                                "uncertain.");
    }
    const std::optional<double> found = order_of_the_reference();
    const std::string source = "the finest other run of its integrator and the theoretical order";
    if (!found) {
      return text + source +
             fmt::format(" {}. No order was observed that could confirm the estimate.", theory);
    }
    if (std::abs(*found - theory) > 2 * kOrderTolerance) {
      return text + source +
             fmt::format(
                 " {}. The runs of this integrator show the order {:.2f} instead, so that "
                 "the estimate is uncertain.",
                 theory, *found);
    }
    return text + source + ".";
  }

  // The observed order of the finest pair of other runs of the reference's integrator.
  std::optional<double> order_of_the_reference() const {
    for (const StudyRow* row : first_variant_) {
      if (row->integrator == result_.reference_integrator && std::isfinite(row->observed_order)) {
        return row->observed_order;
      }
    }
    return {};
  }

  // Of each integrator the range of a number over its runs that finished.
  template <class Number>
  std::string ranges(const Number& number_of) const {
    std::vector<std::string> parts;
    for (const Integrator integrator : all_integrators()) {
      double low = std::numeric_limits<double>::infinity();
      double high = -low;
      for (const StudyRow* row : first_variant_) {
        const double value = number_of(*row);
        if (row->integrator != integrator || row->status != RunStatus::kFinished ||
            !std::isfinite(value)) {
          continue;
        }
        low = std::min(low, value);
        high = std::max(high, value);
      }
      if (low > high) continue;
      const bool is_one = short_number(low) == short_number(high);
      parts.push_back(is_one ? fmt::format("{} {}", to_string(integrator), short_number(low))
                             : fmt::format("{} {} to {}", to_string(integrator), short_number(low),
                                           short_number(high)));
    }
    return enumeration(parts);
  }

  Sentences conservation() const {
    Sentences sentences;
    const std::string energy =
        ranges([](const StudyRow& row) { return row.max_relative_energy_drift; });
    if (energy.empty()) return sentences;
    sentences.push_back(fmt::format(
        "The largest energy errors of the runs that reached the end, relative to the energy that "
        "entered, are: {}.",
        energy));
    std::vector<std::string> exact;
    for (const StudyRow* row : first_variant_) {
      if (row->status == RunStatus::kFinished &&
          row->max_relative_energy_drift <= round_off_level(*row)) {
        exact.push_back(named_run(*row));
      }
    }
    if (!exact.empty()) {
      sentences.push_back(fmt::format("The energy {} of {} {} at the level of round-off.",
                                      exact.size() == 1 ? "error" : "errors", enumeration(exact),
                                      exact.size() == 1 ? "is" : "are"));
    }
    sentences.push_back(fmt::format(
        "The change of the linear momentum that no impulse explains is, relative to the momentum: "
        "{}.",
        ranges([](const StudyRow& row) { return row.linear_momentum_drift; })));
    sentences.push_back(
        fmt::format("That of the angular momentum is: {}.",
                    ranges([](const StudyRow& row) { return row.angular_momentum_drift; })));
    std::vector<std::string> explained;
    for (const Integrator integrator : all_integrators()) {
      bool has_runs = false;
      bool is_explained = true;
      for (const StudyRow* row : first_variant_) {
        if (row->integrator != integrator || row->status != RunStatus::kFinished) continue;
        has_runs = true;
        is_explained = is_explained && row->angular_momentum_drift_allowed > 0.0 &&
                       row->angular_momentum_drift > round_off_level(*row) &&
                       row->angular_momentum_drift <=
                           row->angular_momentum_drift_allowed + round_off_level(*row);
      }
      if (has_runs && is_explained) explained.push_back(to_string(integrator));
    }
    if (!explained.empty()) {
      sentences.push_back(fmt::format(
          "For {} it is no larger than what the remaining residuals of the solver cause.",
          enumeration(explained)));
    }
    return sentences;
  }

  // Runs that differ in the solver only.
  Sentences solvers() const {
    Sentences sentences;
    for (const StudyRow* row : first_variant_) {
      if (!row->compares_solver || row->status != RunStatus::kFinished) continue;
      const auto other =
          std::find_if(first_variant_.begin(), first_variant_.end(), [&](const StudyRow* o) {
            return !o->compares_solver && o->integrator == row->integrator && o->step == row->step;
          });
      if (other == first_variant_.end() || (*other)->status != RunStatus::kFinished) continue;
      if (row->shares_machine || (*other)->shares_machine) {
        if (!(error_of(*row) > 0.0) || !(error_of(**other) > 0.0)) continue;
        sentences.push_back(fmt::format(
            "For {} with h = {} s the errors with {} and {} are {:.4g} and {:.4g}; their wall "
            "times "
            "do not count, because the runs shared the cores of the machine with others.",
            to_string(row->integrator), short_number(row->step), row->solver, (*other)->solver,
            error_of(*row), error_of(**other)));
        continue;
      }
      const double ratio = row->wall_seconds / (*other)->wall_seconds;
      if (!(ratio > 0.0) || !std::isfinite(ratio) || !times_are_comparable()) continue;
      const StudyRow& slow = ratio >= 1.0 ? *row : **other;
      const StudyRow& fast = ratio >= 1.0 ? **other : *row;
      std::string text =
          is_about_one(ratio)
              ? fmt::format("For {} with h = {} s, {} and {} take about the same wall time",
                            to_string(row->integrator), short_number(row->step), slow.solver,
                            fast.solver)
              : fmt::format("For {} with h = {} s, {} takes {} times the wall time of {}",
                            to_string(row->integrator), short_number(row->step), slow.solver,
                            two_digits(std::max(ratio, 1.0 / ratio)), fast.solver);
      if (error_of(*row) > 0.0 && error_of(**other) > 0.0) {
        text += fmt::format("; their errors are {:.4g} and {:.4g}", error_of(slow), error_of(fast));
      }
      sentences.push_back(text + ".");
    }
    return sentences;
  }

  Sentences variants() const {
    Sentences sentences;
    std::vector<std::string> names;
    for (const StudyRow& row : result_.rows) {
      if (std::find(names.begin(), names.end(), row.variant) == names.end()) {
        names.push_back(row.variant);
      }
    }
    if (names.size() < 2) return sentences;
    sentences.push_back(fmt::format(
        "The statements above on accuracy, orders and conservation are those of the variant {}, "
        "whose run is the reference. The other variants differ from it in keys that leave the "
        "exact motion as it is. Their differences from the reference show what these keys change.",
        names.front()));
    for (std::size_t i = 1; i < names.size(); ++i) compare_variant(names[i], sentences);
    return sentences;
  }

  // What the stability limit and the wall times of a variant are beside those of the first one.
  void compare_variant(const std::string& name, Sentences& sentences) const {
    const std::string& first_name = result_.rows.front().variant;
    double low = std::numeric_limits<double>::infinity();
    double high = 0.0;
    double limit = 0.0;
    for (const StudyRow& row : result_.rows) {
      if (row.variant != name) continue;
      for (const StudyRow* first : first_variant_) {
        if (first->integrator != row.integrator || first->step != row.step ||
            first->compares_solver) {
          continue;
        }
        limit = row.stable_step / first->stable_step;
        if (row.status != RunStatus::kFinished || first->status != RunStatus::kFinished) continue;
        if (row.shares_machine || first->shares_machine) continue;
        // Chance decides on shorter times.
        if (std::min(row.wall_seconds, first->wall_seconds) < kShortTime) continue;
        const double ratio = row.wall_seconds / first->wall_seconds;
        low = std::min(low, ratio);
        high = std::max(high, ratio);
      }
    }
    if (limit > 0.0 && std::isfinite(limit) && std::abs(limit - 1.0) > 1e-3) {
      sentences.push_back(fmt::format("The stability limit of {} is {} times that of {}.", name,
                                      short_number(limit), first_name));
    }
    if (low <= high && times_are_comparable()) {
      sentences.push_back(fmt::format(
          "With equal integrators and steps {} takes {} times the wall time of {}.", name,
          two_digits(low) == two_digits(high)
              ? two_digits(low)
              : fmt::format("{} to {}", two_digits(low), two_digits(high)),
          first_name));
    }
  }

  // What differs between the variants that have references of their own.
  Sentences references() const {
    const std::vector<VariantReference>& references = result_.references;
    const VariantReference& first = references.front();
    Sentences sentences;
    sentences.push_back(fmt::format(
        "The study has {} references. Variants whose exact motions differ, as with other "
        "materials, loads or meshes, are not compared with one reference. All errors are "
        "differences from the reference of the same variant.",
        references.size()));
    bool has_other_meshes = false;
    for (const VariantReference& reference : references) {
      has_other_meshes = has_other_meshes || (&reference != &first && is_finished(reference) &&
                                              !std::isfinite(reference.difference.position));
      if (reference.variants.size() < 2) continue;
      sentences.push_back(fmt::format("The variants {} share the reference of the first of them.",
                                      enumeration(reference.variants)));
    }
    if (result_.error_probe.empty() && has_other_meshes && is_finished(first)) {
      sentences.emplace_back(
          "The errors do not say how far the motions on different meshes are from each other. "
          "--error probe.NAME compares the values of a probe.");
    }
    for (const VariantReference& reference : references) {
      const ReferenceDifference& difference = reference.difference;
      std::string text;
      if (std::isfinite(difference.position)) {
        text = fmt::format(
            "The positions of the reference of {} differ from those of {} by {} at the end and by "
            "{} over the whole time (root mean square), relative to the displacement of the latter",
            reference.variant, first.variant, short_number(difference.position),
            short_number(difference.position_rms));
        if (result_.error_probe.empty()) text += errors_of(reference);
        sentences.push_back(text + ".");
      }
      if (!std::isfinite(difference.probe)) continue;
      sentences.push_back(
          fmt::format("The probe {} of the reference of {} differs by up to {} from that of {}, "
                      "relative to the largest value of the latter{}.",
                      result_.error_probe, reference.variant, short_number(difference.probe),
                      first.variant, errors_of(reference)));
    }
    for (std::size_t i = 1; i < references.size(); ++i) {
      compare_variant(references[i].variant, sentences);
    }
    return sentences;
  }

  static bool is_finished(const VariantReference& reference) {
    return reference.status == RunStatus::kFinished;
  }

  // The errors of a reference and of the first one, if they are known.
  std::string errors_of(const VariantReference& reference) const {
    const double first = result_.references.front().error;
    if (!std::isfinite(reference.error) || !std::isfinite(first)) return {};
    return fmt::format("; the errors of the two references in time are estimated at {} and {}",
                       short_number(reference.error), short_number(first));
  }

  const StudyResult& result_;
  Rows first_variant_;
  Rows compared_;  // runs of the first variant with an error
  std::vector<StudyConclusion> conclusions_;
};

}  // namespace

std::vector<StudyConclusion> study_conclusions(const StudyResult& all) {
  StudyResult result = all;
  // Nobody asked for these.
  std::erase_if(result.rows, [](const StudyRow& row) { return row.role == StudyRole::kReference; });
  return result.references.size() < 2 ? Conclusions(result).all()
                                      : Conclusions(result).of_references();
}

std::map<std::string, std::size_t> references_of_variants(const StudyResult& result) {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < result.references.size(); ++i) {
    for (const std::string& variant : result.references[i].variants) places.emplace(variant, i);
  }
  return places;
}

std::vector<StudyResult> parts_of_study(const StudyResult& result) {
  StudyResult empty;
  empty.end = result.end;
  empty.reference_integrator = result.reference_integrator;
  empty.reference_step = result.reference_step;
  empty.is_interrupted = result.is_interrupted;
  empty.error_probe = result.error_probe;
  empty.probes = result.probes;
  empty.stable_step = std::numeric_limits<double>::quiet_NaN();  // that of the first variant
  std::vector<StudyResult> parts(result.references.size(), empty);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const VariantReference& reference = result.references[i];
    parts[i].reference_status = reference.status;
    parts[i].reference_directory = reference.directory;
    parts[i].reference_error = reference.error;
    parts[i].extrapolation = reference.extrapolation;
  }
  const std::map<std::string, std::size_t> places = references_of_variants(result);
  for (const StudyRow& row : result.rows) {
    const auto found = places.find(row.variant);
    if (found != places.end()) parts[found->second].rows.push_back(row);
  }
  return parts;
}

bool is_extrapolated(const StudyResult& result) {
  return result.extrapolation && result.extrapolation->is_valid_for(!result.error_probe.empty());
}

std::string enumeration(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " and " : ", ";
    text += words[i];
  }
  return text;
}

std::string short_number(double value) {
  const bool is_small = value != 0.0 && std::abs(value) < 0.01;
  std::string text = is_small ? fmt::format("{:.2e}", value) : fmt::format("{:.3g}", value);
  const auto exponent = text.find('e');
  if (exponent == std::string::npos) return text;
  // "7.20e-05" becomes "7.2e-5", and "3e+15" becomes "3e15".
  std::string digits = text.substr(0, exponent);
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  std::size_t power = exponent + 2;
  while (power + 1 < text.size() && text[power] == '0') ++power;
  return digits + 'e' + (text[exponent + 1] == '-' ? "-" : "") + text.substr(power);
}

std::string run_label(const StudyRow& row) {
  std::string label = to_string(row.integrator);
  std::string tags = row.variant;
  if (row.compares_solver) tags += (tags.empty() ? "" : ", ") + row.solver;
  return tags.empty() ? label : label + " (" + tags + ")";
}

std::string reference_name(const StudyResult& result) {
  const std::string rule = to_string(result.reference_integrator);
  const std::string finest = short_number(result.reference_step);
  if (!is_extrapolated(result)) {
    return fmt::format("{} with h = {} s", rule, finest);
  }
  return fmt::format("Richardson extrapolation of {} with h = {} s and {} s", rule,
                     short_number(result.extrapolation->step), finest);
}

bool is_above_stability_limit(const StudyRow& row) {
  return row.step > row.stable_step;
}

double round_off_level(const StudyRow& row) {
  return std::numeric_limits<double>::epsilon() * (10.0 + static_cast<double>(row.steps));
}

}  // namespace tetraction
