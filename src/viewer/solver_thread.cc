#include "solver_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "kept_settings.h"
#include "snapshot_maker.h"
#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

using Seconds = std::chrono::duration<double>;

// Shortest time between two snapshots while running. No window draws more often.
constexpr Seconds kSnapshotInterval{0.004};
// Ratio of the time between two estimates of the stability limit to the time that an estimate
// takes: after an edit that may have changed the limit, and while the body deforms.
constexpr double kLimitPauseAfterEdit = 4.0;
constexpr double kLimitPause = 30.0;
constexpr double kCatchUp = 0.08;  // s of wall clock in which a dragged vertex reaches the mouse

}  // namespace

SolverThread::SolverThread(Scene start_scene, TetMesh start_mesh)
    : scene_(std::move(start_scene)),
      mesh_(std::move(start_mesh)),
      recording_(scene_),
      engine_(std::make_unique<Engine>(scene_, mesh_, recording_)) {
  begin();
  publish();
}

SolverThread::~SolverThread() {
  if (!thread_.joinable()) return;
  shared_.lock()->stop = true;
  wake();
  thread_.join();
}

void SolverThread::start() {
  thread_ = std::thread([this] { work(); });
}

void SolverThread::send(Command command) {
  {
    const auto shared = shared_.lock();
    std::deque<Command>& commands = shared->commands;
    auto* next = std::get_if<MakeEdit>(&command);
    auto* last = commands.empty() ? nullptr : std::get_if<MakeEdit>(&commands.back());
    if (next != nullptr && last != nullptr && next->goes_on && replaces(next->edit, last->edit)) {
      last->edit = std::move(next->edit);
      last->what = std::move(next->what);
    } else if (!commands.empty() && std::holds_alternative<LeadTo>(command) &&
               std::holds_alternative<LeadTo>(commands.back())) {
      commands.back() = std::move(command);
    } else {
      commands.push_back(std::move(command));
    }
  }
  wake();
}

bool SolverThread::wait_until_idle(double seconds) {
  return shared_.lock().wait_for(became_idle_, Seconds(seconds),
                                 [](const SharedState& shared) { return shared.idle(); });
}

// Starts the history of a new engine.
void SolverThread::begin() {
  const HistoryRow row = history_row(session());
  stable_step_ = session().initial_limit().critical_step;
  limit_cost_ = session().times().stability;
  stepping_since_limit_ = 0.0;
  limit_is_old_ = false;
  pace_.restart(0.0);
  ++body_;
  const auto shared = shared_.lock();
  shared->history.clear();
  shared->history.add(row);
  shared->marks.clear();
}

// Publishes the results of edits that were made by command or by events.
void SolverThread::hand_out() {
  std::vector<EditMark> new_marks = engine_->take_marks();
  std::vector<Notice> new_notices = engine_->take_notices();
  if (!snapshot_due_ && new_marks.empty() && new_notices.empty()) return;
  Settings now = engine_->settings();
  std::string to_undo = engine_->edits().undo_text();
  std::string to_redo = engine_->edits().redo_text();
  limit_is_old_ = engine_->take_limit_change() || limit_is_old_;
  const auto shared = shared_.lock();
  shared->settings = std::move(now);
  shared->undo_text = std::move(to_undo);
  shared->redo_text = std::move(to_redo);
  shared->marks.insert(shared->marks.end(), new_marks.begin(), new_marks.end());
  std::move(new_notices.begin(), new_notices.end(), std::back_inserter(shared->notices));
}

void SolverThread::publish() {
  hand_out();
  snapshot_due_ = false;
  steps_since_snapshot_ = 0;
  const ColorField wanted = shared_.lock()->field;
  auto next = std::make_shared<Snapshot>(make_snapshot(session(), wanted));
  next->generation = ++generation_;
  next->body = body_;
  next->stable_step = stable_step_;
  next->real_time_factor = pace_.real_time_factor(session().time());
  const auto shared = shared_.lock();
  next->running = shared->running;
  if (!shared->running) next->real_time_factor = 0.0;
  shared->snapshot = std::move(next);
  shared->snapshot_taken = false;
  published_ = Clock::now();
}

// The state of a failed run has a limit only if its energy is defined.
void SolverThread::estimate_limit() {
  limit_is_old_ = false;
  stepping_since_limit_ = 0.0;
  const MechanicalSystem& system = session().system();
  if (!system.elastic().admissible(session().state().position).ok()) return;
  const Clock::time_point start = Clock::now();
  stable_step_ = session().current_limit().critical_step;
  limit_cost_ = Seconds(Clock::now() - start).count();
}

void SolverThread::halt() {
  shared_.lock()->running = false;
}

// Makes one step. Returns false if the run cannot continue.
void SolverThread::step() {
  const Index before = session().step_number();
  const Clock::time_point start = Clock::now();
  const bool went_on = engine_->step() && session().status() == RunStatus::kRunning;
  stepping_since_limit_ += Seconds(Clock::now() - start).count();
  ++steps_since_snapshot_;
  pace_.advance(session().time());
  {
    const auto shared = shared_.lock();
    if (session().step_number() > before) shared->history.add(history_row(session()));
    if (!went_on) shared->running = false;
  }
  if (session().step_number() > before) {
    tell_observer([this](Observer& o) { return o.on_step(session()); });
  }
  if (!went_on) {
    snapshot_due_ = true;
    end_observation();
  }
  limit_is_old_ = engine_->take_limit_change() || limit_is_old_;
  if (stepping_since_limit_ > (limit_is_old_ ? kLimitPauseAfterEdit : kLimitPause) * limit_cost_) {
    estimate_limit();
  }
}

// An error in an observer ends the observation, not the run.
template <class Call>
void SolverThread::tell_observer(const Call& call) {
  if (!observer_) return;
  bool goes_on = false;
  std::string problem;
  try {
    goes_on = call(*observer_);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (goes_on) return;
  observer_.reset();
  const auto shared = shared_.lock();
  shared->observed = false;
  if (!problem.empty()) {
    shared->notices.push_back({Notice::Kind::kWarning, std::move(problem)});
  }
}

void SolverThread::end_observation() {
  tell_observer([this](Observer& o) {
    o.on_finish(session());
    return false;
  });
}

void SolverThread::require_good_state() const {
  if (session().status() == RunStatus::kRunning) return;
  throw InputError("The run has failed: go back to the last good state first.");
}

void SolverThread::execute(Observe& observe) {
  end_observation();
  shared_.lock()->observed = false;
  if (!observe.observer) return;
  require_good_state();
  shared_.lock()->observed = true;
  observer_ = std::move(observe.observer);
  tell_observer([this](Observer& o) {
    o.on_start(session());
    return true;
  });
}

void SolverThread::execute(const Run&) {
  require_good_state();
  pace_.restart(session().time());
  shared_.lock()->running = true;
}

void SolverThread::execute(const Pause&) {
  halt();
}

void SolverThread::execute(const Step&) {
  halt();
  step();
}

void SolverThread::execute(const Restart&) {
  halt();
  end_observation();
  engine_->release();
  engine_->go_back();  // a grip that could not be released in the failed state ends here
  const std::vector<MadeEdit> made = engine_->edits().in_force();
  engine_ = std::make_unique<Engine>(scene_, mesh_, recording_);
  begin();
  for (const MadeEdit& kept : kept_settings(made, session())) {
    report_failure_of([&] { engine_->edit(kept.edit, kept.what, kept.goes_on); });
  }
}

void SolverThread::execute(const Reset&) {
  halt();
  end_observation();
  engine_ = std::make_unique<Engine>(scene_, mesh_, recording_);
  begin();
}

void SolverThread::execute(const GoBack&) {
  halt();
  engine_->go_back();
  shared_.lock()->history.go_back_to(session().step_number());
}

void SolverThread::execute(const Grab& grab) {
  engine_->grab(grab.vertices);
}

void SolverThread::execute(const LeadTo& lead) {
  // A run that is slower than real time gets the same time of the wall clock. Before the speed of
  // the run is known, real time is assumed.
  const double factor = pace_.real_time_factor(session().time());
  const bool running = shared_.lock()->running;
  engine_->lead_to(lead.place, running ? kCatchUp * (factor > 0.0 ? factor : 1.0) : 0.0);
}

void SolverThread::execute(const Release&) {
  engine_->release();
}

void SolverThread::execute(const Undo&) {
  engine_->undo();
}

void SolverThread::execute(const Redo&) {
  engine_->redo();
}

void SolverThread::execute(const NewSnapshot&) {}

void SolverThread::execute(MakeEdit& edit) {
  engine_->edit(std::move(edit.edit), edit.what, edit.goes_on);
}

// Any error in the work becomes a notice. The run pauses, unless the error is a refused edit.
template <class Work>
void SolverThread::report_failure_of(const Work& work) {
  Notice notice;
  try {
    work();
    return;
  } catch (const InputError& error) {
    notice = {Notice::Kind::kRefused, error.what()};
  } catch (const std::exception& error) {
    notice = {Notice::Kind::kWarning,
              fmt::format("The solver stopped: {}. Reset, or open the scene again.", error.what())};
    halt();
  }
  shared_.lock()->notices.push_back(std::move(notice));
}

// The next task. If there is none, `due` is the time at which to ask again.
SolverThread::Task SolverThread::task_due(SharedState& shared,
                                          std::optional<Clock::time_point>& due) {
  due.reset();
  if (!shared.commands.empty()) {
    Task task{Task::Kind::kCommand, std::move(shared.commands.front())};
    shared.commands.pop_front();
    return task;
  }
  if (snapshot_due_) return {Task::Kind::kPublish};
  const double time = session().time();
  if (pace_.limit() != shared.speed_limit) pace_.set_limit(shared.speed_limit, time);
  const Clock::time_point now = Clock::now();
  if (shared.running) {
    due = pace_.due(time);
    const bool waits = *due > now;
    // A snapshot that nobody has read yet is not replaced, because making one may take longer than
    // a step.
    if (steps_since_snapshot_ >= shared.steps_per_snapshot &&
        (waits || (shared.snapshot_taken && now - published_ >= kSnapshotInterval))) {
      return {Task::Kind::kPublish};
    }
    return {waits ? Task::Kind::kNone : Task::Kind::kStep};
  }
  return {limit_is_old_ ? Task::Kind::kEstimateLimit : Task::Kind::kNone};
}

// Waits for the next task. Returns nothing when the thread shall stop.
SolverThread::Task SolverThread::next_task() {
  auto shared = shared_.lock();
  shared->busy = false;
  while (!shared->stop) {
    std::optional<Clock::time_point> due;
    Task task = task_due(*shared, due);
    if (task.kind != Task::Kind::kNone) {
      shared->busy = true;
      return task;
    }
    if (due) {
      shared.wait_until(wake_, *due);
    } else {
      became_idle_.notify_all();
      shared.wait(wake_);
    }
  }
  return {};
}

void SolverThread::carry_out(Task& task) {
  switch (task.kind) {
    case Task::Kind::kNone:
      return;
    case Task::Kind::kCommand:
      snapshot_due_ = true;
      std::visit([this](auto& specific) { execute(specific); }, task.command);
      return;
    case Task::Kind::kPublish:
      publish();
      return;
    case Task::Kind::kStep:
      step();
      return;
    case Task::Kind::kEstimateLimit:
      estimate_limit();
      snapshot_due_ = true;
      return;
  }
}

void SolverThread::work() {
  for (;;) {
    Task task = next_task();
    if (task.kind == Task::Kind::kNone) break;
    report_failure_of([&] { carry_out(task); });
  }
  end_observation();
}

}  // namespace tetraction::viewer
