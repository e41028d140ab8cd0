#include "solver_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "snapshot_maker.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"

namespace tetraction::viewer {
namespace {

using Seconds = std::chrono::duration<double>;

// Shortest time between two snapshots of a running simulation. The window does not draw more often.
constexpr Seconds kSnapshotInterval{0.004};
// The stability limit is estimated again when the steps since the last estimate have taken this many
// times as long as the estimate: after an edit that may have changed the limit, and otherwise.
constexpr double kLimitPauseAfterEdit = 4.0;
constexpr double kLimitPause = 30.0;

// Sets a flag as long as it lives.
class Raised {
 public:
  explicit Raised(bool& flag) : flag_(flag) { flag_ = true; }
  ~Raised() { flag_ = false; }
  Raised(const Raised&) = delete;
  Raised& operator=(const Raised&) = delete;

 private:
  bool& flag_;
};

constexpr const char* kCommandCause = "command";

void end_causes(SharedState& shared, const std::vector<std::string>& causes) {
  for (const std::string& cause : causes) {
    std::erase_if(shared.notices, [&](const Notice& notice) { return notice.cause == cause; });
    shared.ended_causes.push_back(cause);
  }
}

bool is_edit(const Command& command) {
  const auto* action = std::get_if<Action>(&command);
  return action != nullptr ? action->is_edit : std::holds_alternative<MakeEdit>(command);
}

}  // namespace

SolverThread::SolverThread(Scene start_scene, TetMesh start_mesh)
    : scene_(std::make_shared<const Scene>(std::move(start_scene))),
      mesh_(std::make_shared<const TetMesh>(std::move(start_mesh))),
      recording_(*scene_),
      engine_(std::make_unique<Engine>(*scene_, *mesh_, recording_)) {
  begin();
  publish();
}

SolverThread::~SolverThread() {
  if (!thread_.joinable()) return;
  ask_to_end();
  if (taken_over_.owns_lock()) taken_over_.unlock();
  thread_.join();
}

void SolverThread::ask_to_end() {
  gives_up_ = true;
  shared_.lock()->stop = true;
  wake();
}

bool SolverThread::end(double seconds) {
  ask_to_end();
  if (shared_.lock().wait_for(ended_, Seconds(seconds),
                              [](const SharedState& shared) { return shared.has_ended; })) {
    return true;
  }
  // Only a recording is worth waiting for: a frame that is being written, for instance.
  if (!has_observer_) return false;
  taken_over_.lock();
  if (shared_.lock()->has_ended) {
    taken_over_.unlock();
    return true;
  }
  // A step of several parts has entered some of them in the balance already.
  const TimeSettings& time = session().time_settings();
  if (is_in_step_ && (time.retry > 0 || time.adapt != StepAdaptation::kNone)) observer_.reset();
  end_observation();
  return false;
}

void SolverThread::start() {
  thread_ = std::thread([this] { work(); });
}

void SolverThread::send(Command command) {
  {
    const auto shared = shared_.lock();
    shared->edits_waiting = shared->edits_waiting || is_edit(command);
    std::deque<Command>& commands = shared->commands;
    auto* next = std::get_if<MakeEdit>(&command);
    auto* last = commands.empty() ? nullptr : std::get_if<MakeEdit>(&commands.back());
    if (next != nullptr && last != nullptr && next->continues_previous &&
        replaces(next->edit, last->edit)) {
      last->edit = std::move(next->edit);
      last->what = std::move(next->what);
    } else if (!commands.empty() && command.index() == commands.back().index() &&
               (std::holds_alternative<DragTo>(command) ||
                std::holds_alternative<ShowKept>(command))) {
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
  if (kept_.empty() || kept_.back().first != scene_) kept_.emplace_back(scene_, mesh_);
  stable_step_ = session().initial_limit().critical_step;
  limit_cost_ = session().times().stability;
  stepping_since_limit_ = 0.0;
  limit_is_old_ = false;
  speed_limiter_.restart(session().time());
  energy_.restart(session());
  pause_ = Pause::kNone;
  passed_end_ = false;
  ++body_;
  shown_.reset();
  entries_are_old_ = true;
  auto start = engine_->kept_state();
  const auto shared = shared_.lock();
  shared->history.clear();
  shared->history.add(row);
  shared->kept = KeptStates();
  shared->kept.add(std::move(start));
  shared->marks.clear();
}

EditedScene SolverThread::edited() {
  const std::lock_guard lock(working_);
  return edited_scene(*scene_, *mesh_, engine_->edits().edits_in_effect());
}

// Publishes the settings, marks and notices that edits and events have changed.
void SolverThread::publish_edit_results() {
  std::vector<EditMark> new_marks = engine_->take_marks();
  std::vector<Notice> new_notices = engine_->take_notices();
  if (!snapshot_due_ && new_marks.empty() && new_notices.empty()) return;
  const std::vector<std::string> ended = engine_->take_ended_causes();
  const std::size_t new_edits = engine_->take_edit_count() + std::exchange(run_changes_, 0);
  const bool is_whole = engine_->take_entry_change() || std::exchange(entries_are_old_, false);
  Settings settings;
  if (is_whole) {
    settings = engine_->settings();
  } else {  // a move of a drag, for instance, which must not cost more the more edits there are
    static_cast<ChangeableSections&>(settings) = engine_->sections();
  }
  std::string undo_text = this->undo_text();
  std::string redo_text = this->redo_text();
  limit_is_old_ = engine_->take_limit_change() || limit_is_old_;
  const auto shared = shared_.lock();
  if (is_whole) {
    shared->settings = std::move(settings);
  } else {
    static_cast<ChangeableSections&>(shared->settings) = settings;
  }
  ++shared->settings_number;
  shared->scene = scene_;
  shared->set_ups_to_come -= std::exchange(set_ups_, 0);
  shared->undo_text = std::move(undo_text);
  shared->redo_text = std::move(redo_text);
  shared->edit_count += new_edits;
  shared->has_edits = has_edits();
  end_causes(*shared, ended);
  for (const std::string& cause : ended) {
    std::erase_if(notices_, [&](const Notice& notice) { return notice.cause == cause; });
  }
  shared->edits_waiting = std::any_of(shared->commands.begin(), shared->commands.end(), is_edit);
  shared->marks.insert(shared->marks.end(), new_marks.begin(), new_marks.end());
  std::move(new_notices.begin(), new_notices.end(), std::back_inserter(notices_));
}

void SolverThread::publish() {
  publish_edit_results();
  snapshot_due_ = false;
  steps_since_snapshot_ = 0;
  const ColorField field = shared_.lock()->field;
  auto next = std::make_shared<Snapshot>(shown_ ? make_snapshot(session(), field, *shown_)
                                                : make_snapshot(session(), field));
  next->generation = ++generation_;
  next->body = body_;
  next->stable_step = stable_step_;
  if (session().time_settings().adapt != StepAdaptation::kNone) {
    next->adapted_step = session().steps().last;
  }
  if (!shown_) next->user_force = engine_->user_force();
  next->pause = pause_;
  next->energy_error = energy_.error();
  next->energy_entered = energy_.entered();
  next->knows_last_edit = engine_->edits().knows_state_before_last();
  if (const SpringDrag* spring = engine_->spring()) {
    next->pulled = spring->pulled();
    next->pull_radius = spring->radius();
  }
  next->real_time_factor = speed_limiter_.real_time_factor(session().time());
  const auto shared = shared_.lock();
  next->running = shared->running;
  if (!shared->running) next->real_time_factor = 0.0;
  shared->snapshot = std::move(next);
  shared->mesh = mesh_;
  shared->snapshot_taken = false;
  // The window clears its messages when it sees a new run.
  std::move(notices_.begin(), notices_.end(), std::back_inserter(shared->notices));
  notices_.clear();
  published_ = Clock::now();
}

void SolverThread::pause() {
  shared_.lock()->running = false;
}

// Makes one step. If the run cannot continue, it is no longer running.
void SolverThread::step() {
  const Index before = session().step_number();
  const Clock::time_point start = Clock::now();
  const bool can_continue = [this] {
    const Raised in_step(is_in_step_);
    const Interruptible interruptible(gives_up_, &work_lock_);
    return engine_->step() && session().status() == RunStatus::kRunning;
  }();
  stepping_since_limit_ += Seconds(Clock::now() - start).count();
  ++steps_since_snapshot_;
  speed_limiter_.advance(session().time());
  {
    const auto shared = shared_.lock();
    if (session().step_number() > before) shared->history.add(history_row(session()));
    if (!can_continue) shared->running = false;
  }
  if (session().step_number() > before) {
    notify_observer([this](Observer& o) { return o.on_step(session()); });
    if (can_continue) keep_state();
  }
  if (!can_continue) {
    snapshot_due_ = true;
    end_observation();
  } else {
    check_pauses();
  }
  limit_is_old_ = engine_->take_limit_change() || limit_is_old_;
  if (stepping_since_limit_ > (limit_is_old_ ? kLimitPauseAfterEdit : kLimitPause) * limit_cost_) {
    estimate_limit();
  }
}

// Calls the observer. If the observer throws, the observation ends and the run continues.
template <class Call>
void SolverThread::notify_observer(const Call& call) {
  if (!observer_) return;
  bool continues = false;
  std::string problem;
  try {
    continues = call(*observer_);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (continues) return;
  observer_.reset();
  has_observer_ = false;
  const auto shared = shared_.lock();
  shared->observed = false;
  if (!problem.empty()) {
    shared->notices.push_back({Notice::Kind::kWarning, std::move(problem)});
  }
}

void SolverThread::end_observation() {
  notify_observer([this](Observer& o) {
    o.on_finish(session());
    return false;
  });
}

void SolverThread::execute(Observe& observe) {
  end_observation();
  shared_.lock()->observed = false;
  if (!observe.observer) return;
  continue_shown();
  engine_->require_good_state();
  shared_.lock()->observed = true;
  observer_ = std::move(observe.observer);
  has_observer_ = true;
  notify_observer([this](Observer& o) {
    o.on_start(session());
    return true;
  });
}

// Calls work(). An InputError or NumericalError becomes a notice about a refused command. Any other exception becomes a
// warning, and the run is paused.
void SolverThread::report_failure_of(const std::function<void()>& work) {
  Notice notice;
  try {
    work();
    return;
  } catch (const InputError& error) {
    notice = {Notice::Kind::kRefused, error.what(), kCommandCause};
  } catch (const NumericalError& error) {
    notice = {Notice::Kind::kRefused, error.what(), kCommandCause};
  } catch (const std::exception& error) {
    notice = {Notice::Kind::kWarning,
              fmt::format("The solver stopped: {}. Reset, or open the scene again.", error.what())};
    pause();
  }
  refused_ = notice.cause == kCommandCause;
  shared_.lock()->notices.push_back(std::move(notice));
}

// A command that succeeds ends what was said about one that was refused.
void SolverThread::end_refusal() {
  if (std::exchange(refused_, false)) end_causes(*shared_.lock(), {kCommandCause});
}

// Returns the next task. If a running simulation has none yet, `due` is the time of the next step.
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
  if (speed_limiter_.limit() != shared.speed_limit)
    speed_limiter_.set_limit(shared.speed_limit, time);
  const Clock::time_point now = Clock::now();
  if (shared.running) {
    if (shared.picture_interval > 0.0) {
      constexpr double kRoundOff = 1e-9;
      const double number = std::floor(time / shared.picture_interval + kRoundOff);
      const bool published = shared.snapshot->time == time;
      if (number != pictured_ && !published) return {Task::Kind::kPublish};
      if (number != pictured_ && !shared.snapshot_taken) {
        due = now + std::chrono::milliseconds(1);
        return {Task::Kind::kNone};
      }
      pictured_ = number;
    }
    due = speed_limiter_.due(time);
    const bool waits = *due > now;
    // A snapshot is made only after the window has read the previous one, because it may take longer
    // than a step.
    if (steps_since_snapshot_ >= shared.steps_per_snapshot &&
        (waits || (shared.snapshot_taken && now - published_ >= kSnapshotInterval))) {
      return {Task::Kind::kPublish};
    }
    return {waits ? Task::Kind::kNone : Task::Kind::kStep};
  }
  return {limit_is_old_ ? Task::Kind::kEstimateLimit : Task::Kind::kNone};
}

// Waits for the next task. Returns a task of kind kNone when the thread shall stop.
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
      if (std::holds_alternative<Publish>(task.command)) return;
      if (std::exchange(told_set_up_, false)) end_causes(*shared_.lock(), {kSetUpCause});
      std::visit([this](auto& specific) { execute(specific); }, task.command);
      end_refusal();
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
    work_lock_.lock();
    if (task.kind == Task::Kind::kNone) break;
    report_failure_of([&] { carry_out(task); });
    work_lock_.unlock();
  }
  end_observation();
  work_lock_.unlock();
  shared_.lock()->has_ended = true;
  ended_.notify_all();
}

}  // namespace tetraction::viewer
