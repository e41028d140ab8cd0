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

// While running there is no snapshot sooner after the one before: no window draws more.
constexpr Seconds kSnapshotInterval{0.004};
// How much longer than it takes itself the run goes on before the stability limit is estimated anew:
// after an edit that may have changed it, and as the body deforms.
constexpr double kLimitPauseAfterEdit = 4.0;
constexpr double kLimitPause = 30.0;
constexpr double kCatchUp = 0.08;  // s of wall clock in which a dragged vertex reaches the mouse

}  // namespace

SolverThread::SolverThread(Scene start_scene, TetMesh start_mesh)
    : scene(std::move(start_scene)),
      mesh(std::move(start_mesh)),
      recording(scene),
      engine(std::make_unique<Engine>(scene, mesh, recording)) {
  begin();
  publish();
}

void SolverThread::send(Command command) {
  {
    const std::lock_guard lock(mutex);
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
  wake.notify_one();
}

// A new engine: its history begins.
void SolverThread::begin() {
  const HistoryRow row = history_row(session());
  stable_step = session().initial_limit().critical_step;
  limit_cost = session().times().stability;
  stepping_since_limit = 0.0;
  limit_is_old = false;
  pace.restart(0.0);
  ++body;
  const std::lock_guard lock(mutex);
  history.clear();
  history.add(row);
  marks.clear();
}

// Hands out what has become of edits, by command or by events.
void SolverThread::hand_out() {
  std::vector<EditMark> new_marks = engine->take_marks();
  std::vector<Notice> new_notices = engine->take_notices();
  if (!snapshot_due && new_marks.empty() && new_notices.empty()) return;
  Settings now = engine->settings();
  std::string to_undo = engine->edits().undo_text();
  std::string to_redo = engine->edits().redo_text();
  limit_is_old = engine->take_limit_change() || limit_is_old;
  const std::lock_guard lock(mutex);
  settings = std::move(now);
  undo_text = std::move(to_undo);
  redo_text = std::move(to_redo);
  marks.insert(marks.end(), new_marks.begin(), new_marks.end());
  std::move(new_notices.begin(), new_notices.end(), std::back_inserter(notices));
}

void SolverThread::publish() {
  hand_out();
  snapshot_due = false;
  steps_since_snapshot = 0;
  ColorField wanted{};
  {
    const std::lock_guard lock(mutex);
    wanted = field;
  }
  auto next = std::make_shared<Snapshot>(make_snapshot(session(), wanted));
  next->generation = ++generation;
  next->body = body;
  next->stable_step = stable_step;
  next->real_time_factor = pace.real_time_factor(session().state().time);
  const std::lock_guard lock(mutex);
  next->running = running;
  if (!running) next->real_time_factor = 0.0;
  snapshot = std::move(next);
  snapshot_taken = false;
  published = Clock::now();
}

// The state of a run that failed has a limit only where its energy is defined.
void SolverThread::estimate_limit() {
  limit_is_old = false;
  stepping_since_limit = 0.0;
  const MechanicalSystem& system = session().system();
  if (!system.elastic().admissible(session().state().position).ok()) return;
  const Clock::time_point start = Clock::now();
  stable_step = session().current_limit().critical_step;
  limit_cost = Seconds(Clock::now() - start).count();
}

void SolverThread::halt() {
  const std::lock_guard lock(mutex);
  running = false;
}

// One step; false if the run cannot go on.
void SolverThread::step() {
  const Index before = session().state().step;
  const Clock::time_point start = Clock::now();
  const bool went_on = engine->step() && session().status() == RunStatus::kRunning;
  stepping_since_limit += Seconds(Clock::now() - start).count();
  ++steps_since_snapshot;
  pace.advance(session().state().time);
  {
    const std::lock_guard lock(mutex);
    if (session().state().step > before) history.add(history_row(session()));
    if (!went_on) running = false;
  }
  if (session().state().step > before) {
    tell_observer([this](Observer& o) { return o.on_step(session()); });
  }
  if (!went_on) {
    snapshot_due = true;
    end_observation();
  }
  limit_is_old = engine->take_limit_change() || limit_is_old;
  if (stepping_since_limit > (limit_is_old ? kLimitPauseAfterEdit : kLimitPause) * limit_cost) {
    estimate_limit();
  }
}

// What goes wrong in an observer ends the observation, not the run.
template <class Call>
void SolverThread::tell_observer(const Call& call) {
  if (!observer) return;
  bool goes_on = false;
  std::string problem;
  try {
    goes_on = call(*observer);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (goes_on) return;
  observer.reset();
  const std::lock_guard lock(mutex);
  observed = false;
  if (!problem.empty()) notices.push_back({Notice::Kind::kWarning, std::move(problem)});
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
  {
    const std::lock_guard lock(mutex);
    observed = false;
  }
  if (!observe.observer) return;
  require_good_state();
  {
    const std::lock_guard lock(mutex);
    observed = true;
  }
  observer = std::move(observe.observer);
  tell_observer([this](Observer& o) {
    o.on_start(session());
    return true;
  });
}

void SolverThread::execute(const Run&) {
  require_good_state();
  pace.restart(session().state().time);
  const std::lock_guard lock(mutex);
  running = true;
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
  engine->release();
  engine->go_back();  // where nothing could be changed, the mouse lets go only now
  const std::vector<MadeEdit> made = engine->edits().in_force();
  engine = std::make_unique<Engine>(scene, mesh, recording);
  begin();
  for (const MadeEdit& kept : kept_settings(made, session())) {
    guarded([&] { engine->edit(kept.edit, kept.what, kept.goes_on); });
  }
}

void SolverThread::execute(const Reset&) {
  halt();
  end_observation();
  engine = std::make_unique<Engine>(scene, mesh, recording);
  begin();
}

void SolverThread::execute(const GoBack&) {
  halt();
  engine->go_back();
  const std::lock_guard lock(mutex);
  history.go_back_to(session().state().step);
}

void SolverThread::execute(const Grab& grab) {
  engine->grab(grab.vertices);
}

void SolverThread::execute(const LeadTo& lead) {
  // A run that is slower than the wall clock gets the same time on the wall; before the run has a
  // speed, as at real time.
  const double factor = pace.real_time_factor(session().state().time);
  engine->lead_to(lead.place, running ? kCatchUp * (factor > 0.0 ? factor : 1.0) : 0.0);
}

void SolverThread::execute(const Release&) {
  engine->release();
}

void SolverThread::execute(const Undo&) {
  engine->undo();
}

void SolverThread::execute(const Redo&) {
  engine->redo();
}

void SolverThread::execute(const NewSnapshot&) {}

void SolverThread::execute(MakeEdit& edit) {
  engine->edit(std::move(edit.edit), edit.what, edit.goes_on);
}

// Whatever goes wrong in the work is a notice, and the run pauses unless an edit was refused.
template <class Work>
void SolverThread::guarded(const Work& work) {
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
  const std::lock_guard lock(mutex);
  notices.push_back(std::move(notice));
}

// Does one thing that is to be done, without the lock. False if there is nothing to do until `due`.
bool SolverThread::work_once(std::unique_lock<std::mutex>& lock,
                             std::optional<Clock::time_point>& due) {
  const auto unlocked = [&](const auto& work) {
    busy = true;
    lock.unlock();
    guarded(work);
    lock.lock();
    busy = false;
    return true;
  };
  due.reset();
  if (!commands.empty()) {
    Command command = std::move(commands.front());
    commands.pop_front();
    snapshot_due = true;
    return unlocked([&] { std::visit([this](auto& specific) { execute(specific); }, command); });
  }
  if (snapshot_due) return unlocked([this] { publish(); });
  if (pace.limit() != speed_limit) pace.set_limit(speed_limit, session().state().time);
  const Clock::time_point now = Clock::now();
  if (running) {
    due = pace.due(session().state().time);
    const bool waits = *due > now;
    // One that nobody has seen yet is not replaced: making them takes longer than many a step.
    if (steps_since_snapshot >= steps_per_snapshot &&
        (waits || (snapshot_taken && now - published >= kSnapshotInterval))) {
      return unlocked([this] { publish(); });
    }
    return !waits && unlocked([this] { step(); });
  }
  if (limit_is_old) {
    return unlocked([this] {
      estimate_limit();
      snapshot_due = true;
    });
  }
  return false;
}

void SolverThread::work() {
  std::unique_lock lock(mutex);
  std::optional<Clock::time_point> due;
  while (!stop) {
    if (work_once(lock, due)) continue;
    if (due) {
      wake.wait_until(lock, *due);
    } else {
      became_idle.notify_all();
      wake.wait(lock);
    }
  }
  lock.unlock();
  end_observation();
}

}  // namespace tetraction::viewer
