#include "tetraction/simulation/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/quoting.h"
#include "position_errors.h"
#include "probe_errors.h"
#include "study_extrapolation.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"

namespace tetraction {
namespace {

constexpr double kNoError = std::numeric_limits<double>::quiet_NaN();

// An error below this many times the reference's own error gives no order.
constexpr double kAboveReference = 5.0;

struct Run {
  StudyRow row;
  Vector final_position;
};

// Whether all of these steps are multiples of the step of the reference.
bool times_are_steps(const std::vector<double>& steps, double reference) {
  return std::all_of(steps.begin(), steps.end(), [&](double step) {
    const double ratio = step / reference;
    return std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio && ratio > 0.5;
  });
}

// One of the references while its runs and those that are compared with it are made.
struct Reference {
  std::unique_ptr<ReferenceRecord> record;  // null if all rows are kept
  std::vector<Run> runs;                    // as PlannedReference::runs, as far as they were made
  std::optional<ReferenceExtrapolation> extrapolation;
  std::vector<std::size_t>
      members;             // in StudyPlan::runs: what is compared with it and must be made
  bool is_needed = false;  // whether its runs must be made
  std::size_t entry = 0;   // in StudyResult::references, if it has runs

  const StudyRow& finest() const { return runs.back().row; }
};

// What the solver's tolerance and round-off may change in the motion of a run. The impulses of the
// residuals that the solver left are summed up in the balance of angular momentum.
Inexactness inexactness(const StudyRow& row) {
  const double residuals = row.angular_momentum_drift_allowed;
  return {residuals > 0.0 ? residuals : 0.0,
          std::numeric_limits<double>::epsilon() * (10.0 + static_cast<double>(row.steps))};
}

class Study {
 public:
  Study(const StudyPlan& plan, const TetMesh& mesh, int jobs)
      : plan_(plan), mesh_(mesh), jobs_(jobs) {
    result_.stable_step = plan.stable_step;
    result_.end = plan.end;
    result_.reference_integrator = plan.references.front().finest().integrator;
    result_.reference_step = plan.references.front().finest().step;
    result_.error_probe = plan.error_probe;
    result_.probes = plan.probes;
    for (const StudyVariant& variant : plan.variants) {
      if (!variant.name.empty()) result_.variants.push_back({variant.name, variant.values});
    }
    for (const PlannedRun& run : plan.runs) steps_.push_back(run.step);
    std::sort(steps_.begin(), steps_.end());
    steps_.erase(std::unique(steps_.begin(), steps_.end()), steps_.end());
    members_.resize(plan.references.size());
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      members_[plan.reference_of[plan.runs[i].variant]].push_back(i);
    }
    keeps_first_ = std::count(plan.has_first_mesh.begin(), plan.has_first_mesh.end(), true) > 1;
  }

  StudyResult run(const ObserverFactory& observers, const StudyProgress& progress,
                  const StudyMemory& memory) {
    observers_ = observers;
    progress_ = progress;
    memory_ = memory;
    std::vector<std::optional<Run>> runs(plan_.runs.size());
    std::vector<Reference> references(plan_.references.size());
    // As many references at a time as runs: their positions at all times take much memory.
    const auto batch = static_cast<std::size_t>(std::max(1, jobs_));
    std::size_t known = 0;
    while (known < references.size() && !is_cancelled_) {
      const std::size_t end = std::min(known + batch, references.size());
      make_groups(known, end, references, runs);
      known = end;
    }
    result_.is_interrupted = is_cancelled_;
    if (is_cancelled_) {
      result_.remarks.emplace_back("the study was interrupted: the runs from there on are missing");
    }
    for (std::size_t i = 0; i < references.size(); ++i) set_orders(i, runs, references[i]);
    for (std::optional<Run>& run : runs) {
      if (run) result_.rows.push_back(std::move(run->row));
    }
    if (plan_.references.size() < 2) result_.references.clear();
    return std::move(result_);
  }

 private:
  void tell(const PlannedRun& run) {
    const std::lock_guard lock(calling_);
    if (progress_) progress_(done_, plan_.run_count(), run);
    ++done_;
  }
  std::optional<StudyRow> kept(const PlannedRun& run) const {
    return memory_.kept ? memory_.kept(run) : std::nullopt;
  }
  void finish(const Run& run) {
    const std::lock_guard lock(calling_);
    if (memory_.made && run.row.status != RunStatus::kCancelled) memory_.made(run.row);
  }

  // Finds what is to be made of a reference and of the runs that are compared with it.
  void prepare(std::size_t index, Reference& reference, std::vector<std::optional<Run>>& runs) {
    const PlannedReference& planned = plan_.references[index];
    bool all_known = true;
    for (const std::size_t i : members_[index]) {
      if (reference_run(planned, plan_.runs[i])) continue;
      if (std::optional<StudyRow> row = kept(plan_.runs[i])) {
        runs[i] = Run{};
        runs[i]->row = std::move(*row);
        ++done_;
      } else {
        reference.members.push_back(i);
        all_known = false;
      }
    }
    const bool is_needed = !all_known || (index == 0 && !others_are_kept());
    reference.is_needed = is_needed || !take_kept(planned, reference);
  }

  // Makes the references from `begin` to before `end` and all runs that are compared with them.
  void make_groups(std::size_t begin, std::size_t end, std::vector<Reference>& references,
                   std::vector<std::optional<Run>>& runs) {
    std::vector<std::size_t> needed;
    for (std::size_t i = begin; i < end; ++i) {
      prepare(i, references[i], runs);
      if (references[i].is_needed) needed.push_back(i);
    }
    make_references(needed, references);
    std::vector<std::pair<std::size_t, const Reference*>> members;
    for (std::size_t i = begin; i < end; ++i) {
      Reference& reference = references[i];
      if (reference.runs.empty()) continue;
      for (const std::size_t run : members_[i]) {
        const std::optional<std::size_t> part = reference_run(plan_.references[i], plan_.runs[run]);
        if (part && *part < reference.runs.size()) runs[run] = reference.runs[*part];
      }
      for (const std::size_t run : reference.members) members.emplace_back(run, &reference);
    }
    run_all(members.size(), [&](std::size_t place, bool shares_machine) {
      const auto& [index, reference] = members[place];
      make_member(index, *reference, shares_machine, runs[index]);
    });
    for (std::size_t i = begin; i < end; ++i) {
      if (references[i].runs.empty()) continue;
      add_reference(i, references[i]);
      const bool is_used_later = i == 0 && keeps_first_;
      if (references[i].record && !is_used_later) {
        references[i].record->track = ReferenceTrack(std::vector<double>());
      }
    }
  }

  // Makes a run that is compared with a reference.
  void make_member(std::size_t index, const Reference& reference, bool shares_machine,
                   std::optional<Run>& place) {
    const PlannedRun& member = plan_.runs[index];
    tell(member);
    DistanceFromReference distance(reference.record->track);
    ProbeDifference difference(plan_.error_probe, reference.record->probe);
    place = run_one(member, {&distance, &difference});
    Run& run = *place;
    run.row.shares_machine = shares_machine;
    if (member.variant != plan_.references[plan_.reference_of[member.variant]].variant()) {
      run.row.role = StudyRole::kVariant;
    }
    if (reference.finest().status == RunStatus::kFinished &&
        run.row.status == RunStatus::kFinished) {
      const double at_end = (run.final_position - reference.record->track.last()).norm();
      set_errors(run.row, {at_end, distance.root_mean_square(), difference.largest()},
                 *reference.record);
    }
    run.final_position.resize(0);  // there may be many runs
    finish(run);
    if (run.row.status == RunStatus::kCancelled) is_cancelled_ = true;
  }

  // Calls make(i, whether the machine has too few cores for all at the same time) for the first `count`
  // numbers. After a run was stopped no further one begins. If one throws, the others are stopped.
  template <class Function>
  void run_all(std::size_t count, const Function& make) {
    const auto together =
        std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, jobs_)));
    const auto threads = together * static_cast<std::size_t>(thread_count());
    const bool shares_machine = threads > static_cast<std::size_t>(this_machine().cores);
    run_jobs(static_cast<Index>(count), jobs_, [&](Index i) {
      if (is_cancelled_) return;
      try {
        make(static_cast<std::size_t>(i), shares_machine);
      } catch (...) {
        is_cancelled_ = true;
        throw;
      }
    });
  }

  // Whether no further reference has to be made, and compared with the first one.
  bool others_are_kept() const {
    const bool are_compared = keeps_first_ || !plan_.error_probe.empty();
    if (plan_.references.size() < 2 || !are_compared || !memory_.kept) return true;
    const auto is_kept = [&](const PlannedRun& run) { return kept(run).has_value(); };
    for (std::size_t i = 1; i < plan_.references.size(); ++i) {
      const std::vector<PlannedRun>& runs = plan_.references[i].runs;
      if (!std::all_of(runs.begin(), runs.end(), is_kept)) return false;
    }
    return std::all_of(plan_.runs.begin(), plan_.runs.end(), [&](const PlannedRun& run) {
      return plan_.reference_of[run.variant] == 0 || is_kept(run);
    });
  }

  // Takes the rows of the reference that were made before. Returns whether they are all there.
  bool take_kept(const PlannedReference& planned, Reference& reference) {
    for (const PlannedRun& run : planned.runs) {
      std::optional<StudyRow> row = kept(run);
      if (!row) {
        reference.runs.clear();
        return false;
      }
      reference.runs.emplace_back();
      reference.runs.back().row = std::move(*row);
    }
    reference.extrapolation = reference.finest().extrapolation;
    done_ += planned.runs.size();
    return true;
  }

  // Times at which the runs of a variant are compared with their reference.
  std::vector<double> times_of(const PlannedReference& planned) const {
    // Tracks in memory at the same time.
    const Index tracks = (planned.runs.size() == 3 ? 4 : 1) + (keeps_first_ ? 1 : 0);
    return comparison_times(steps_, result_.end,
                            tracks * 3 * mesh_of(planned.variant()).vertex_count());
  }

  // Makes the runs of these references.
  void make_references(const std::vector<std::size_t>& needed, std::vector<Reference>& references) {
    struct Part {
      std::size_t reference;  // in `needed`
      std::size_t run;
    };
    std::vector<Part> parts;
    std::vector<std::vector<std::unique_ptr<ReferenceRecord>>> records(needed.size());
    std::vector<std::vector<std::optional<Run>>> made(needed.size());
    for (std::size_t n = 0; n < needed.size(); ++n) {
      const PlannedReference& planned = plan_.references[needed[n]];
      const std::vector<double> times = times_of(planned);
      for (std::size_t i = 0; i < planned.runs.size(); ++i) {
        records[n].push_back(std::make_unique<ReferenceRecord>(times, plan_.error_probe));
        parts.push_back({n, i});
      }
      made[n].resize(planned.runs.size());
    }
    run_all(parts.size(), [&](std::size_t place, bool shares_machine) {
      const auto [n, i] = parts[place];
      const PlannedRun& planned = plan_.references[needed[n]].runs[i];
      tell(planned);
      made[n][i] = run_one(planned, {&records[n][i]->track, &records[n][i]->probe});
      made[n][i]->row.shares_machine = shares_machine;
      made[n][i]->final_position.resize(0);
      if (made[n][i]->row.status == RunStatus::kCancelled) is_cancelled_ = true;
    });
    for (std::size_t n = 0; n < needed.size(); ++n) {
      Reference& reference = references[needed[n]];
      // Runs begin in their order: if the study was stopped, the last ones are missing.
      for (std::optional<Run>& run : made[n]) {
        if (run) reference.runs.push_back(std::move(*run));
      }
      if (!reference.runs.empty()) complete_reference(needed[n], reference, records[n]);
    }
  }

  // Makes the reference from its runs, and their errors.
  void complete_reference(std::size_t index, Reference& reference,
                          std::vector<std::unique_ptr<ReferenceRecord>>& records) {
    const PlannedReference& planned = plan_.references[index];
    const bool is_whole =
        reference.runs.size() == planned.runs.size() &&
        std::none_of(reference.runs.begin(), reference.runs.end(),
                     [](const Run& run) { return run.row.status == RunStatus::kCancelled; });
    records.resize(reference.runs.size());
    std::vector<ReferenceDistance> distances(records.size());
    if (planned.runs.size() == 3 && is_whole) extrapolate(planned, reference, records, distances);
    reference.record = std::move(records.back());
    if (index == 0) {
      first_record_ = reference.record.get();
      first_is_complete_ = is_whole && reference.finest().status == RunStatus::kFinished;
    }
    if (!is_whole) return;
    if (index > 0) {
      reference.runs.back().row.reference_difference = difference_from_first(index, reference);
    }
    for (std::size_t i = 0; i < reference.runs.size(); ++i) {
      Run& run = reference.runs[i];
      const bool is_itself =
          i + 1 == reference.runs.size() &&
          !(reference.extrapolation && reference.extrapolation->is_valid_for(has_error_probe()));
      if (is_itself && planned.is_row[i]) run.row.role = StudyRole::kReference;
      if (run.row.status == RunStatus::kFinished &&
          reference.finest().status == RunStatus::kFinished) {
        set_errors(run.row, distances[i], *reference.record);
      }
      finish(run);
    }
  }

  // Extrapolates the three runs of a reference. The last record becomes that of the extrapolation.
  void extrapolate(const PlannedReference& planned, Reference& reference,
                   std::vector<std::unique_ptr<ReferenceRecord>>& records,
                   std::vector<ReferenceDistance>& distances) const {
    const auto failed =
        std::find_if(reference.runs.begin(), reference.runs.end(),
                     [](const Run& run) { return run.row.status != RunStatus::kFinished; });
    const double step = planned.runs[1].step;
    if (failed == reference.runs.end()) {
      Inexactness inexact;
      for (const Run& run : reference.runs) {
        const Inexactness own = inexactness(run.row);
        inexact.residuals = std::max(inexact.residuals, own.residuals);
        inexact.round_off = std::max(inexact.round_off, own.round_off);
      }
      ExtrapolatedReference extrapolated =
          extrapolate_reference(planned.finest().integrator, step, inexact,
                                {records[0].get(), records[1].get(), records[2].get()});
      reference.extrapolation = std::move(extrapolated.result);
      // Between the steps of the finest run its probe is interpolated.
      const ReferenceProbe& probe = records[2]->probe;
      if (!times_are_steps(steps_, planned.finest().step) && probe.largest() > 0.0) {
        reference.extrapolation->error_of_probe += probe.interpolation_error() / probe.largest();
      }
      distances.assign(extrapolated.distances.begin(), extrapolated.distances.end());
    } else {
      reference.extrapolation = ReferenceExtrapolation{};
      ReferenceExtrapolation& found = *reference.extrapolation;
      found.step = step;
      found.is_valid = found.probe_is_valid = false;
      found.reason = found.probe_reason =
          fmt::format("the run with a step of {:.4g} s did not reach the end", failed->row.step);
      if (reference.finest().status == RunStatus::kFinished) {
        for (std::size_t i = 0; i < 2; ++i) {
          distances[i] = distance_between(*records[i], *records[2]);
        }
      }
    }
    reference.runs.back().row.extrapolation = reference.extrapolation;
  }

  // How far a reference is from the first one.
  ReferenceDifference difference_from_first(std::size_t index, const Reference& reference) const {
    ReferenceDifference difference;
    if (first_record_ == nullptr || !first_is_complete_ ||
        reference.finest().status != RunStatus::kFinished) {
      return difference;
    }
    const ReferenceRecord& first = *first_record_;
    const ReferenceRecord& own = *reference.record;
    if (first.probe.largest() > 0.0 && own.probe.has_values()) {
      difference.probe = own.probe.largest_difference(first.probe) / first.probe.largest();
    }
    if (!plan_.has_first_mesh[index]) return difference;
    difference.position =
        (own.track.last() - first.track.last()).norm() / first.track.scale_at_end();
    const std::size_t count = std::min(own.track.sample_count(), first.track.sample_count());
    double squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      squares += (own.track.sample(i) - first.track.sample(i)).squaredNorm();
    }
    if (count > 0) {
      difference.position_rms =
          std::sqrt(squares / static_cast<double>(count)) / first.track.scale_over_time();
    }
    return difference;
  }

  bool has_error_probe() const { return !plan_.error_probe.empty(); }

  // Enters a reference in the result.
  void add_reference(std::size_t index, Reference& reference) {
    const StudyVariant& variant = plan_.variants[plan_.references[index].variant()];
    VariantReference entry;
    entry.variant = variant.name;
    entry.status = reference.finest().status;
    entry.directory = reference.finest().directory;
    entry.extrapolation = reference.extrapolation;
    entry.difference = reference.finest().reference_difference;
    for (std::size_t i = 0; i < plan_.variants.size(); ++i) {
      if (plan_.reference_of[i] == index) entry.variants.push_back(plan_.variants[i].name);
    }
    const std::string of_variant =
        plan_.references.size() > 1 ? " of " + variant.name : std::string();
    if (entry.status != RunStatus::kFinished) {
      if (entry.status != RunStatus::kCancelled) {
        result_.remarks.push_back("the reference run" + of_variant + " did not reach the end (" +
                                  reference.finest().message + "): there are no errors");
      }
    } else if (entry.extrapolation) {
      const double step = reference.finest().step;
      if (!entry.extrapolation->is_valid) {
        result_.remarks.push_back(fmt::format(
            "the reference{} is not extrapolated: {}. It is the run with a step of {:.4g} s.",
            of_variant, entry.extrapolation->reason, step));
      }
      if (has_error_probe() && !entry.extrapolation->probe_is_valid &&
          entry.extrapolation->probe_reason != entry.extrapolation->reason) {
        result_.remarks.push_back(fmt::format(
            "the reference{} of the probe {} is not extrapolated: {}. It is the run with a step of "
            "{:.4g} s.",
            of_variant, plan_.error_probe, entry.extrapolation->probe_reason, step));
      }
    }
    if (index == 0) {
      result_.reference_status = entry.status;
      result_.reference_directory = entry.directory;
      result_.extrapolation = entry.extrapolation;
    }
    reference.entry = result_.references.size();
    result_.references.push_back(std::move(entry));
  }

  const TetMesh& mesh_of(std::size_t variant) const {
    const auto& own = plan_.variants[variant].mesh;
    return own ? *own : mesh_;
  }

  // Stops a run if another one was stopped or has thrown an exception.
  class StopWithOthers : public Observer {
   public:
    explicit StopWithOthers(const std::atomic<bool>& flag) : flag_(flag) {}
    bool on_step(const Session&) override { return !flag_; }

   private:
    const std::atomic<bool>& flag_;
  };

  Run run_one(const PlannedRun& planned, std::vector<Observer*> watching) {
    const StudyVariant& variant = plan_.variants[planned.variant];
    Scene scene = variant.scene;
    scene.time.integrator = planned.integrator;
    scene.time.step = planned.step;
    scene.time.automatic = false;
    if (!planned.solver.empty() && planned.solver != scene.solver.kind) {
      scene.solver.kind = planned.solver;
      scene.solver.linear = LinearSolver::kAuto;  // another solver has other linear solvers
    }
    Run run;
    run.row.integrator = planned.integrator;
    run.row.step = planned.step;
    run.row.solver = planned.solver;
    run.row.compares_solver = planned.compares_solver;
    run.row.variant = variant.name;
    run.row.directory = planned.directory;
    run.row.position_error = run.row.position_error_rms = run.row.observed_order = kNoError;

    run.row.date = utc_now();
    const Machine machine = this_machine();
    run.row.processor = machine.processor;
    run.row.cores = machine.cores;
    run.row.threads = thread_count();

    Session session(scene, mesh_of(planned.variant));
    std::vector<std::unique_ptr<Observer>> observers;
    if (observers_) {
      const std::lock_guard lock(calling_);
      observers = observers_(run.row.directory);
    }
    for (const auto& observer : observers) watching.push_back(observer.get());
    StopWithOthers stop(is_cancelled_);
    watching.push_back(&stop);
    run.row.status = session.run(watching);
    run.row.stable_step = session.initial_limit().critical_step;
    run.row.message = session.message();
    run.row.steps = session.state().step;
    run.row.wall_seconds = session.times().stepping;
    const double simulated = session.state().time;
    run.row.seconds_per_simulated_second =
        simulated > 0.0 ? run.row.wall_seconds / simulated : kNoError;
    run.row.iterations_per_step =
        run.row.steps > 0
            ? static_cast<double>(session.total_iterations()) / static_cast<double>(run.row.steps)
            : 0.0;
    const Balance& balance = session.balance();
    run.row.max_relative_energy_drift = balance.max_relative_energy_drift();
    run.row.linear_momentum_drift = balance.linear_momentum_drift();
    run.row.angular_momentum_drift = balance.angular_momentum_drift();
    run.row.angular_momentum_drift_allowed = balance.allowed_angular_momentum_drift();
    if (run.row.status == RunStatus::kFinished) run.final_position = session.state().position;
    return run;
  }

  // The error that orders are computed from.
  double error_of(const StudyRow& row) const {
    return result_.error_probe.empty() ? row.position_error : row.probe_error;
  }

  // Which of the runs of the reference this run of the table is, if it is one.
  static std::optional<std::size_t> reference_run(const PlannedReference& reference,
                                                  const PlannedRun& planned) {
    for (std::size_t i = 0; i < reference.runs.size(); ++i) {
      if (reference.is_row[i] && planned.directory == reference.runs[i].directory &&
          planned.step == reference.runs[i].step) {
        return i;
      }
    }
    return {};
  }

  // Makes distances from the reference relative.
  static void set_errors(StudyRow& row, const ReferenceDistance& distance,
                         const ReferenceRecord& reference) {
    row.position_error = distance.at_end / reference.track.scale_at_end();
    row.position_error_rms = distance.over_time / reference.track.scale_over_time();
    const double largest = reference.probe.largest();
    if (largest > 0.0) row.probe_error = distance.of_probe / largest;
  }

  // Computes the error of a reference and the orders between neighbouring steps of its runs.
  void set_orders(std::size_t index, std::vector<std::optional<Run>>& runs,
                  const Reference& reference) {
    // Without runs if the study was stopped.
    if (reference.runs.empty() || reference.finest().status != RunStatus::kFinished) return;
    const std::size_t variant = plan_.references[index].variant();
    std::vector<StudyRow*> rows;  // without those of another solver
    for (const std::size_t i : members_[index]) {
      if (runs[i] && plan_.runs[i].variant == variant) rows.push_back(&runs[i]->row);
    }
    const bool is_run =
        !reference.extrapolation || !reference.extrapolation->is_valid_for(has_error_probe());
    const double reference_error = error_of_reference(rows, reference);
    const double known_error = reference_error > 0.0 ? reference_error : kNoError;
    result_.references[reference.entry].error = known_error;
    if (index == 0) result_.reference_error = known_error;
    const double possible_error =
        reference_error > 0.0 ? reference_error : possible_error_of_reference(rows);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const StudyRow& finer = *rows[i - 1];
      StudyRow& row = *rows[i];
      if (!are_neighbours(finer, row)) continue;
      const bool is_of_family = is_run && row.integrator == result_.reference_integrator;
      if (!is_of_family && error_of(finer) < kAboveReference * possible_error) continue;
      row.observed_order = observed_order(finer.step, error_of(finer), row.step, error_of(row),
                                          is_of_family ? result_.reference_step : 0.0);
    }
  }

  static bool are_neighbours(const StudyRow& finer, const StudyRow& row) {
    return finer.integrator == row.integrator && !row.compares_solver &&
           finer.role != StudyRole::kReference;
  }

  // How large the error of a reference may be of which no run of its own rule tells it. Errors of two neighbouring
  // steps with e(h) = C h^p + e_r give e_r = e₁ − h₁^p (e₂ − e₁)/(h₂^p − h₁^p), if it is not far below e₁. The
  // smallest of these counts, because all runs have the same reference.
  double possible_error_of_reference(const std::vector<StudyRow*>& rows) const {
    constexpr double kFound = 0.1;  // of e₁
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const double e1 = error_of(*rows[i - 1]);
      const double e2 = error_of(*rows[i]);
      if (!are_neighbours(*rows[i - 1], *rows[i]) || !(e1 > 0.0) || !std::isfinite(e2)) continue;
      const double ratio = std::pow(rows[i]->step / rows[i - 1]->step, order(rows[i]->integrator));
      const double constant = e1 - std::max(0.0, e2 - e1) / (ratio - 1.0);
      smallest = std::min(smallest, std::max(constant, kFound * e1));
    }
    return std::isfinite(smallest) ? smallest : 0.0;
  }

  // The error of the reference itself is estimated from the finest other run of its family and the
  // rule's order p: e(h) = C (h^p − h_r^p), so that C h_r^p = e h_r^p/(h^p − h_r^p). It is zero if
  // there is no such run.
  double error_of_reference(const std::vector<StudyRow*>& rows, const Reference& reference) const {
    if (reference.extrapolation) {
      const ReferenceExtrapolation& found = *reference.extrapolation;
      const double error = result_.error_probe.empty() ? found.error_at_end : found.error_of_probe;
      if (std::isfinite(error)) return error;
    }
    for (const StudyRow* row : rows) {
      if (row->integrator != result_.reference_integrator || !(error_of(*row) > 0.0) ||
          row->step <= result_.reference_step) {
        continue;
      }
      const double ratio = std::pow(row->step / result_.reference_step, order(row->integrator));
      return error_of(*row) / (ratio - 1.0);
    }
    return 0.0;
  }

  const StudyPlan& plan_;
  const TetMesh& mesh_;
  StudyResult result_;
  ObserverFactory observers_;
  StudyProgress progress_;
  StudyMemory memory_;
  std::vector<double> steps_;                      // of all runs, ascending, without repeats
  std::vector<std::vector<std::size_t>> members_;  // for each reference its runs in plan_.runs
  bool keeps_first_ = false;  // whether further references have positions to compare with the first
  const ReferenceRecord* first_record_ = nullptr;  // of the first reference, if it was made
  bool first_is_complete_ = false;                 // whether that reference reached the end
  std::size_t done_ = 0;                           // runs that were begun or kept
  int jobs_;                                       // runs at the same time
  std::mutex calling_;                             // held while a function of the caller is called
  std::atomic<bool> is_cancelled_{false};          // whether a run was stopped on request
};

}  // namespace

std::string to_string(StudyRole role) {
  switch (role) {
    case StudyRole::kReference:
      return "reference";
    case StudyRole::kVariant:
      return "variant";
    case StudyRole::kRun:
      break;
  }
  return "run";
}

std::string to_string(ReferenceKind kind) {
  return kind == ReferenceKind::kRun ? "run" : "richardson";
}

ReferenceKind reference_kind_from_string(const std::string& name) {
  for (const ReferenceKind kind : {ReferenceKind::kRun, ReferenceKind::kRichardson}) {
    if (name == to_string(kind)) return kind;
  }
  throw InputError(
      fmt::format("{} is not a kind of reference; there are run and richardson.", in_quotes(name)));
}

std::size_t StudyPlan::run_count() const {
  std::size_t count = runs.size();
  for (const PlannedReference& reference : references) {
    for (const bool is_row : reference.is_row) count += is_row ? 0 : 1;
  }
  return count;
}

double observed_order(double h1, double e1, double h2, double e2, double hr) {
  if (!(e1 > 0.0) || !(e2 > e1) || !(h2 > h1) || !(h1 > hr)) return kNoError;
  if (hr == 0.0) return std::log(e2 / e1) / std::log(h2 / h1);
  const double target = std::log(e2 / e1);
  const auto ratio = [&](double p) {
    return std::log((std::pow(h2, p) - std::pow(hr, p)) / (std::pow(h1, p) - std::pow(hr, p)));
  };
  double low = 1e-3;
  double high = 12.0;
  if (ratio(low) > target || ratio(high) < target) return kNoError;
  while (high - low > 1e-10) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) < target ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

StudyResult run_study(const StudyPlan& plan, const TetMesh& mesh, const ObserverFactory& observers,
                      const StudyProgress& progress, const StudyMemory& memory, int jobs) {
  return Study(plan, mesh, jobs).run(observers, progress, memory);
}

StudyResult run_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings,
                      const ObserverFactory& observers, const StudyProgress& progress) {
  return run_study(plan_study(scene, mesh, settings), mesh, observers, progress);
}

}  // namespace tetraction
