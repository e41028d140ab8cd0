// Makes the runs of a study.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "run_scene.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

// Stops a run at the end of a step where `stops` says so.
class StopWhen : public Observer {
 public:
  explicit StopWhen(std::function<bool()> stops) : stops_(std::move(stops)) {}
  bool on_step(const Session&) override { return !stops_(); }

 private:
  std::function<bool()> stops_;
};

// The processor time of the steps of a run. One of these is its first observer, which stops the clock, and one the last,
// which starts it again: the others work in between.
class StepClock : public Observer {
 public:
  struct Reading {
    std::optional<clockid_t> clock;  // none if the time cannot be attributed to a run
    double seconds = 0.0;
    std::optional<double> since{};

    double now() const {
      timespec time{};
      if (clock) ::clock_gettime(*clock, &time);
      return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    double total() const { return clock ? seconds : kNotKnown; }
  };

  StepClock(Reading& reading, bool starts) : reading_(reading), starts_(starts) {}
  void on_start(const Session&) override { turn(); }
  bool on_step(const Session&) override {
    turn();
    return true;
  }
  void on_finish(const Session&) override {
    if (!starts_) turn();
  }

 private:
  void turn() {
    const double now = reading_.now();
    if (!starts_ && reading_.since) reading_.seconds += now - *reading_.since;
    reading_.since = starts_ ? std::optional(now) : std::nullopt;
  }

  Reading& reading_;
  bool starts_;
};

// How the runs of a study are made: as many at a time as there are jobs.
struct Workers {
  bool shares_machine = false;     // whether the machine has too few cores for all of them
  std::optional<clockid_t> clock;  // that of a run, if there is one
};

Workers workers_for(std::size_t count, int jobs) {
  const std::size_t together =
      std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, jobs)));
  const int threads = thread_count();
  Workers workers;
  workers.shares_machine =
      together * static_cast<std::size_t>(threads) > static_cast<std::size_t>(this_machine().cores);
  if (together < 2) {
    workers.clock = CLOCK_PROCESS_CPUTIME_ID;
  } else if (threads == 1) {
    workers.clock = CLOCK_THREAD_CPUTIME_ID;
  }
  return workers;
}

// The references come first, so that what is known of a study that is stopped has errors.
std::vector<std::size_t> order_of_runs(const StudyPlan& plan) {
  std::vector<std::size_t> runs;
  for (const PlannedReference& reference : plan.references) {
    runs.insert(runs.end(), reference.runs.begin(), reference.runs.end());
  }
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    if (std::find(runs.begin(), runs.end(), i) == runs.end()) runs.push_back(i);
  }
  return runs;
}

class StudyRuns {
 public:
  StudyRuns(const StudyPlan& plan, const TetMesh& mesh, const ObserverFactory& observers,
            const StudyProgress& progress, const StudyMemory& memory)
      : plan_(plan), mesh_(mesh), observers_(observers), progress_(progress), memory_(memory) {}

  TrackedRun make_one(const PlannedRun& run) {
    std::optional<StudyRow> row = memory_.kept ? memory_.kept(run) : std::nullopt;
    if (!row) row = make_run(run, workers_for(1, 1));
    TrackedRun made;
    made.seconds = row->first_seconds;
    made.is_stopped = row->status == RunStatus::kCancelled;
    made.status = row->status;
    if (row->status == RunStatus::kFinished) made.track = track_of(run);
    return made;
  }

  StudyResult make(int jobs) {
    std::vector<std::optional<StudyRow>> rows(plan_.runs.size());
    std::vector<std::size_t> missing;
    std::size_t count = 0;
    for (const std::size_t i : order_of_runs(plan_)) {
      if (plan_.runs[i].is_left_out) continue;
      ++count;
      if (memory_.kept) rows[i] = memory_.kept(plan_.runs[i]);
      if (!rows[i]) missing.push_back(i);
    }
    count_ = count;
    done_ = count - missing.size();
    const Workers workers = workers_for(missing.size(), jobs);
    run_jobs(static_cast<Index>(missing.size()), jobs, [&](Index place) {
      if (is_cancelled_) return;
      const std::size_t i = missing[static_cast<std::size_t>(place)];
      try {
        rows[i] = make_run(plan_.runs[i], workers);
      } catch (...) {
        is_cancelled_ = true;
        throw;
      }
    });
    repeat_cheap_runs(rows);
    StudyResult result =
        compare_runs(plan_, rows, [this](const PlannedRun& run) { return track_of(run); });
    result.remarks.insert(result.remarks.end(), remarks_.begin(), remarks_.end());
    return result;
  }

 private:
  std::shared_ptr<const MotionTrack> track_of(const PlannedRun& run) const {
    const auto found = tracks_.find(run.directory);
    if (found != tracks_.end()) return found->second;
    return memory_.track ? memory_.track(run) : nullptr;
  }

  const TetMesh& mesh_of(const PlannedRun& run) const {
    const auto& own = plan_.variants[run.variant].mesh;
    return own ? *own : mesh_;
  }

  StudyRow make_run(const PlannedRun& run, const Workers& workers) {
    {
      const std::lock_guard lock(calling_);
      if (progress_) progress_(done_, count_, run);
      ++done_;
    }
    MotionRecorder recorder;
    StudyRow row = row_of(run, recorder, workers);
    if (row.status == RunStatus::kCancelled) {
      is_cancelled_ = true;
      return row;
    }
    const std::lock_guard lock(calling_);
    if (memory_.made) memory_.made(run, row, recorder.track());
    if (!memory_.track || !memory_.made) {
      tracks_[run.directory] = std::make_shared<const MotionTrack>(recorder.take());
    }
    return row;
  }

  StudyRow row_of(const PlannedRun& run, MotionRecorder& recorder, const Workers& workers) {
    StudyRow row;
    row.integrator = run.integrator;
    row.step = run.step;
    row.solver = run.solver;
    row.compares_solver = run.compares_solver;
    row.settings = to_string(run.settings);
    row.variant = plan_.variants[run.variant].name;
    row.directory = run.directory;
    row.role = run.role;
    row.shares_machine = workers.shares_machine;
    row.position_error = row.position_error_rms = row.observed_order = kNotKnown;
    row.date = utc_now();
    const Machine machine = this_machine();
    row.processor = machine.processor;
    row.cores = machine.cores;
    row.threads = thread_count();

    Session session(scene_of(plan_, run), mesh_of(run));
    std::vector<std::unique_ptr<Observer>> observers;
    if (observers_) {
      const std::lock_guard lock(calling_);
      observers = observers_(row.directory);
    }
    StepClock::Reading processor{workers.clock};
    StepClock first(processor, false);
    StepClock last(processor, true);
    StopWhen stop([this] { return is_cancelled_.load(); });
    std::vector<Observer*> watching{&first, &recorder};
    for (const auto& observer : observers) watching.push_back(observer.get());
    watching.insert(watching.end(), {&stop, &last});
    row.status = session.run(watching);

    row.stable_step = session.initial_limit().critical_step;
    row.message = session.message();
    row.steps = session.step_number();
    row.wall_seconds = row.first_seconds = session.times().stepping;
    row.processor_seconds = processor.total();
    const double simulated = session.time();
    row.seconds_per_simulated_second = simulated > 0.0 ? row.wall_seconds / simulated : kNotKnown;
    row.iterations_per_step = row.steps > 0 ? static_cast<double>(session.total_iterations()) /
                                                  static_cast<double>(row.steps)
                                            : 0.0;
    const Balance& balance = session.balance();
    row.max_relative_energy_drift = balance.max_relative_energy_drift();
    row.linear_momentum_drift = balance.linear_momentum_drift();
    row.angular_momentum_drift = balance.angular_momentum_drift();
    row.angular_momentum_drift_allowed = balance.allowed_angular_momentum_drift();
    return row;
  }

  bool may_repeat(const PlannedRun& run, const StudyRow& row) const {
    constexpr double kLongest = 0.5;  // s; the times of longer runs vary little
    return run.role == StudyRole::kRun && row.status == RunStatus::kFinished && row.repeats == 0 &&
           !row.shares_machine && row.processor_seconds < kLongest &&
           row.processor == this_machine().processor;
  }

  // Which runs are repeated follows from their rows, so that the same study again repeats nothing.
  void repeat_cheap_runs(std::vector<std::optional<StudyRow>>& rows) {
    if (plan_.repeats == 0 || is_cancelled_) return;
    double spent = 0.0;
    std::vector<std::size_t> cheap;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!rows[i]) continue;
      if (rows[i]->repeats > 0) spent += rows[i]->repeats * rows[i]->processor_seconds;
      if (may_repeat(plan_.runs[i], *rows[i])) cheap.push_back(i);
    }
    std::sort(cheap.begin(), cheap.end(), [&](std::size_t a, std::size_t b) {
      return rows[a]->processor_seconds < rows[b]->processor_seconds;
    });
    for (const std::size_t i : cheap) {
      StudyRow& row = *rows[i];
      if (spent + plan_.repeats * row.processor_seconds > plan_.repeat_seconds) return;
      if (!repeat(plan_.runs[i], row)) return;
      spent += plan_.repeats * row.processor_seconds;
      if (row.repeats > 0 && memory_.repeated) memory_.repeated(plan_.runs[i], row);
    }
  }

  // Makes the repeats of a run. Returns false if they were stopped; the row is as it was then, and also if they move
  // differently.
  bool repeat(const PlannedRun& run, StudyRow& row) {
    const std::shared_ptr<const MotionTrack> track = track_of(run);
    std::vector<double> times{row.processor_seconds};
    double fastest_wall = row.wall_seconds;
    for (int k = 0; k < plan_.repeats; ++k) {
      StepClock::Reading processor{CLOCK_PROCESS_CPUTIME_ID};
      StepClock first(processor, false);
      StepClock last(processor, true);
      StopWhen stop([this] { return memory_.is_stopped && memory_.is_stopped(); });
      Session session(scene_of(plan_, run), mesh_of(run));
      const RunStatus status = session.run({&first, &stop, &last});
      if (status == RunStatus::kCancelled) return false;
      if (status != RunStatus::kFinished ||
          (track && session.present_state().position != track->last())) {
        remarks_.push_back(
            fmt::format("the run in {} was made again and ended differently, although nothing was "
                        "changed: its times are those of the first run alone",
                        run.directory));
        return true;
      }
      if (processor.total() < *std::min_element(times.begin(), times.end())) {
        fastest_wall = session.times().stepping;
      }
      times.push_back(processor.total());
    }
    const auto [fastest, slowest] = std::minmax_element(times.begin(), times.end());
    const double mean =
        std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
    row.repeats = plan_.repeats;
    row.time_scatter = mean > 0.0 ? (*slowest - *fastest) / mean : 0.0;
    row.processor_seconds = *fastest;
    row.seconds_per_simulated_second = fastest_wall / plan_.end;
    row.wall_seconds = fastest_wall;
    return true;
  }

  const StudyPlan& plan_;
  const TetMesh& mesh_;
  const ObserverFactory& observers_;
  const StudyProgress& progress_;
  const StudyMemory& memory_;
  std::map<std::string, std::shared_ptr<const MotionTrack>> tracks_;  // by the folders of runs
  std::vector<std::string> remarks_;                                  // of repeats
  std::size_t count_ = 1;                  // runs that the study makes or keeps
  std::size_t done_ = 0;                   // runs that were begun or kept
  std::mutex calling_;                     // held while a function of the caller is called
  std::atomic<bool> is_cancelled_{false};  // whether a run was stopped on request
};

}  // namespace

void leave_to_others(StudyPlan& plan, std::size_t part, std::size_t parts) {
  std::size_t place = 0;
  for (const std::size_t i : order_of_runs(plan)) {
    plan.runs[i].is_left_out = place++ % parts != part;
  }
}

StudyMemory memory_of_runs() {
  using Run = std::pair<StudyRow, std::shared_ptr<const MotionTrack>>;
  const auto runs = std::make_shared<std::map<std::string, Run>>();  // by their folders
  StudyMemory memory;
  memory.kept = [runs](const PlannedRun& run) -> std::optional<StudyRow> {
    const auto found = runs->find(run.directory);
    if (found == runs->end()) return {};
    StudyRow row = found->second.first;
    row.role = run.role;
    row.compares_solver = run.compares_solver;
    return row;
  };
  memory.made = [runs](const PlannedRun& run, const StudyRow& row, const MotionTrack& track) {
    (*runs)[run.directory] = {row, std::make_shared<const MotionTrack>(track)};
  };
  memory.track = [runs](const PlannedRun& run) {
    const auto found = runs->find(run.directory);
    return found == runs->end() ? nullptr : found->second.second;
  };
  return memory;
}

StudyResult run_study(const StudyPlan& plan, const TetMesh& mesh, const ObserverFactory& observers,
                      const StudyProgress& progress, const StudyMemory& memory, int jobs) {
  return StudyRuns(plan, mesh, observers, progress, memory).make(jobs);
}

TrackedRun make_tracked_run(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh,
                            const ObserverFactory& observers, const StudyProgress& progress,
                            const StudyMemory& memory) {
  return StudyRuns(plan, mesh, observers, progress, memory).make_one(run);
}

}  // namespace tetraction
