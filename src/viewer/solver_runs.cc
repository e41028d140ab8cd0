// The runs of a SolverThread that replace one another, with undo and redo.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "solver_thread.h"
#include "tetraction/core/error.h"
#include "tetraction/io/initial_fields.h"

namespace tetraction::viewer {
namespace {

constexpr const char* kRestart = "Restart";
// Vertices of all runs that are kept whole. Of older ones only the scenes and edits are kept.
constexpr Index kMostKeptVertices = 200'000;

}  // namespace

// Keeps the scene and the edits alone.
void SolverThread::Run::give_up() {
  made = engine->edits().edits_in_effect();
  engine.reset();
  history = HistoryLog();
  kept = KeptStates();
  marks.clear();
}

// A run at the start of a scene. Throws InputError if it cannot be set up.
SolverThread::Run SolverThread::new_run(std::shared_ptr<const Scene> scene,
                                        std::shared_ptr<const TetMesh> mesh) {
  Run run;
  run.scene = std::move(scene);
  run.mesh = std::move(mesh);
  run.recording = recording_.data();
  try {
    run.engine = std::make_unique<Engine>(*run.scene, *run.mesh, recording_);
  } catch (...) {
    recording_.restore(run.recording);
    throw;
  }
  // The present run goes on until it is left.
  Recording::Data present = std::exchange(run.recording, recording_.data());
  recording_.restore(std::move(present));
  return run;
}

// Takes the present run out of the members. take() must follow.
SolverThread::Run SolverThread::leave_run(const std::string& what, Index parted) {
  publish_edit_results();  // the marks of the last edits
  Run run;
  run.scene = scene_;
  run.mesh = mesh_;
  run.engine = std::move(engine_);
  run.recording = recording_.data();
  run.stable_step = stable_step_;
  run.passed_end = passed_end_;
  run.energy = energy_;
  run.kept_edits = kept_edits_;
  run.what = what;
  run.parted = parted;
  const auto shared = shared_.lock();
  run.history = shared->history;
  run.kept = shared->kept;
  run.marks = shared->marks;
  return run;
}

void SolverThread::take(Run& run) {
  scene_ = run.scene;
  mesh_ = run.mesh;
  engine_ = std::move(run.engine);
  recording_.restore(std::move(run.recording));
  begin();
}

// Takes a new run and makes edits in it.
void SolverThread::begin_run(Run run, const std::vector<MadeEdit>& made) {
  take(run);
  make_again(made);
}

void SolverThread::make_again(const std::vector<MadeEdit>& made) {
  for (const MadeEdit& kept : kept_settings(made, session())) {
    report_failure_of([&] { engine_->edit(kept.edit, kept.what, kept.continues_previous); });
  }
  engine_->take_edit_count();  // the user has made them before
  kept_edits_ = engine_->edits().undo_count();
}

// Returns to a run. The present one is added to `others`.
void SolverThread::continue_run(std::vector<Run>& from, std::vector<Run>& others) {
  pause();
  end_observation();
  engine_->release();
  Run next = std::move(from.back());
  const std::size_t kept_edits = next.kept_edits;
  const bool is_other_scene = next.scene != scene_;
  if (next.engine) {
    others.push_back(leave_run(next.what, next.parted));
    // What both runs have in common is kept in any case.
    if (next.kept.size() == 0) {
      next.kept = others.back().kept;
      next.kept.go_back_to(next.parted);
    }
    take(next);
    stable_step_ = next.stable_step;
    passed_end_ = next.passed_end;
    energy_ = next.energy;
    const auto shared = shared_.lock();
    shared->history.replace_by(std::move(next.history));
    shared->kept = std::move(next.kept);
    shared->marks = std::move(next.marks);
  } else {
    Run fresh = new_run(next.scene, next.mesh);
    others.push_back(leave_run(next.what, next.parted));
    begin_run(std::move(fresh), next.made);
  }
  kept_edits_ = std::min(kept_edits, engine_->edits().undo_count());
  from.pop_back();
  if (is_other_scene) ++run_changes_;  // a restart is no edit, and neither is its undo
  limit_memory();
}

// Gives up the engines of the runs that are the farthest away.
void SolverThread::limit_memory() {
  Index vertices = 0;
  std::size_t bytes = shared_.lock()->kept.bytes();
  const auto limit = [&](std::vector<Run>& runs) {
    for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
      vertices += run->mesh->vertex_count();
      bytes += run->kept.bytes();
      if (bytes > KeptStates::kBudget) run->kept = KeptStates();
      if (!run->engine || run == runs.rbegin() || vertices <= kMostKeptVertices) continue;
      run->give_up();
    }
  };
  limit(undo_);
  limit(redo_);
}

void SolverThread::keep_state() {
  if (!shared_.lock()->kept.wants(session().step_number())) return;
  auto state = engine_->kept_state();
  std::size_t bytes = 0;
  {
    const auto shared = shared_.lock();
    shared->kept.add(std::move(state));
    bytes = shared->kept.bytes();
  }
  if (2 * bytes > KeptStates::kBudget && !(undo_.empty() && redo_.empty())) limit_memory();
}

void SolverThread::execute(const ShowKept& wanted) {
  pause();
  const auto shared = shared_.lock();
  const bool is_past = wanted.time < session().time();
  shown_ = is_past ? shared->kept.nearest(wanted.time) : nullptr;
  if (shown_ && shown_->state.step == session().step_number()) shown_.reset();
}

// What is shown is what goes on: the run continues from the kept state that is shown, if there is one, with the
// settings of now. Returns whether it does.
bool SolverThread::continue_shown() {
  if (!shown_) return false;
  const std::shared_ptr<const KeptState> kept = std::exchange(shown_, nullptr);
  const Index step = kept->state.step;
  const std::string what = fmt::format("Continue from {:.6g} s", kept->state.time);
  pause();
  if (observer_) {
    notices_.push_back(
        {Notice::Kind::kNote,
         fmt::format("The recording of the run has ended at {:.6g} s, because the run "
                     "continues from {:.6g} s.",
                     session().time(), kept->state.time),
         "recording"});
  }
  end_observation();
  engine_->release();
  engine_->go_back();
  Run fresh = new_run(scene_, mesh_);
  fresh.engine->take_notices();  // those of the scene are known already
  Run past = leave_run(what, step);
  past.engine->forget_undone();
  take(fresh);
  const std::vector<MadeEdit> made = engine_->restore(*kept, past.recording, *past.engine, what);
  // Beyond the end the user has let the run go on before.
  passed_end_ = engine_->is_at_end(kept->state.time);
  speed_limiter_.restart(session().time());
  energy_.restart(session());
  {
    const auto shared = shared_.lock();
    HistoryLog history = past.history;
    history.go_back_to(step);
    shared->history.replace_by(std::move(history));
    shared->kept = past.kept;
    shared->kept.go_back_to(step);
    shared->marks = past.marks;
    std::erase_if(shared->marks,
                  [&](const EditMark& mark) { return mark.time > kept->state.time; });
  }
  make_again(made);
  redo_.clear();
  undo_.push_back(std::move(past));
  limit_memory();
  return true;
}

bool SolverThread::run_change_is_last() const {
  return !undo_.empty() && engine_->edits().undo_count() <= kept_edits_;
}

void SolverThread::restart() {
  pause();
  end_observation();
  engine_->release();
  engine_->go_back();  // ends a drag that could not be released in the failed state
  const std::vector<MadeEdit> made = engine_->edits().edits_in_effect();
  // A restart at the start has changed nothing.
  const bool changes = session().step_number() > 0 || engine_->edits().undo_count() > kept_edits_;
  Run fresh = new_run(scene_, mesh_);
  fresh.engine->take_notices();  // those of the scene are known already
  Run past = leave_run(kRestart);
  past.engine->forget_undone();
  begin_run(std::move(fresh), made);
  if (!changes) return;
  redo_.clear();
  undo_.push_back(std::move(past));
  limit_memory();
}

void SolverThread::reset() {
  pause();
  end_observation();
  Run fresh = new_run(kept_.front().first, kept_.front().second);
  undo_.clear();
  redo_.clear();
  begin_run(std::move(fresh), {});
}

void SolverThread::set_up(const Scene& scene, const std::string& what) {
  ++set_ups_;
  std::optional<Run> fresh;
  try {
    auto mesh = has_same_mesh(scene, *scene_)
                    ? mesh_
                    : std::make_shared<const TetMesh>(read_scene_mesh(scene));
    fresh = new_run(std::make_shared<const Scene>(scene), std::move(mesh));
  } catch (const Error& error) {
    shared_.lock()->refusal = error.what();
    return;
  }
  pause();
  end_observation();
  engine_->release();
  engine_->go_back();
  engine_->forget_undone();
  redo_.clear();
  undo_.push_back(leave_run("Set up again: " + what));
  begin_run(std::move(*fresh), {});
  ++run_changes_;
  limit_memory();
  notices_.push_back(
      {Notice::Kind::kNote, "Set up again: " + what + ". The run is at its start.", kSetUpCause});
  told_set_up_ = true;
}

void SolverThread::add_selection(const NamedSelection& named, const std::string& what) {
  const auto change = [this, named](bool adds) {
    Scene scene = *scene_;
    if (adds) {
      recording_.add(named);
      scene.selection.push_back(named);
    } else {
      recording_.remove(named);
      std::erase_if(scene.selection,
                    [&](const NamedSelection& other) { return other.name == named.name; });
    }
    scene_ = std::make_shared<const Scene>(std::move(scene));
    kept_.emplace_back(scene_, mesh_);
  };
  try {
    engine_->change_other(what, change);
    redo_.clear();
  } catch (const InputError& error) {
    shared_.lock()->refusal = error.what();
  }
}

void SolverThread::undo() {
  shown_.reset();
  if (run_change_is_last()) {
    continue_run(undo_, redo_);
    // A restart that is made again leads to the start.
    if (redo_.back().what == kRestart) redo_.back().give_up();
  } else {
    engine_->undo();
  }
}

void SolverThread::redo() {
  shown_.reset();
  if (engine_->edits().redo_text().empty() && !redo_.empty()) {
    continue_run(redo_, undo_);
  } else {
    engine_->redo();
  }
}

std::string SolverThread::undo_text() const {
  return run_change_is_last() ? undo_.back().what : engine_->edits().undo_text();
}

std::string SolverThread::redo_text() const {
  const std::string text = engine_->edits().redo_text();
  return text.empty() && !redo_.empty() ? redo_.back().what : text;
}

// Whether there are edits that have not been undone.
bool SolverThread::has_edits() const {
  return engine_->edits().undo_count() > 0 || scene_ != kept_.front().first;
}

}  // namespace tetraction::viewer
