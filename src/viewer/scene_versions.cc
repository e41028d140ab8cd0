// Scenes that a SolverThread sets up one after another, with undo and redo.
#include <memory>
#include <utility>

#include "solver_thread.h"
#include "tetraction/core/error.h"
#include "tetraction/io/initial_fields.h"

namespace tetraction::viewer {

// Sets up another version at its start. The present one is added to the others. Throws InputError; then nothing has
// changed.
void SolverThread::change_version(Version next, std::vector<Version>& others,
                                  const std::string& what) {
  engine_->release();  // it would be recorded with the next version otherwise
  auto engine = std::make_unique<Engine>(*next.scene, *next.mesh, recording_);
  pause();
  end_observation();
  others.push_back({scene_, mesh_, engine_->edits().edits_in_effect(), what});
  engine_ = std::move(engine);
  scene_ = std::move(next.scene);
  mesh_ = std::move(next.mesh);
  begin();
  make_kept_edits(next.made);
  ++set_ups_;
}

void SolverThread::set_up(const Scene& scene, const std::string& what) {
  Version next{std::make_shared<const Scene>(scene), mesh_, {}, {}};
  try {
    if (!has_same_mesh(scene, *scene_)) {
      next.mesh = std::make_shared<const TetMesh>(read_scene_mesh(scene));
    }
    change_version(std::move(next), undo_, "Set up again: " + what);
  } catch (const Error& error) {
    shared_.lock()->refusal = error.what();
    return;
  }
  redo_.clear();
  shared_.lock()->notices.push_back(
      {Notice::Kind::kNote, "Set up again: " + what + ". The run is at its start."});
}

void SolverThread::undo() {
  if (undo_.empty() || !engine_->edits().undo_text().empty()) return engine_->undo();
  const Version previous = undo_.back();
  change_version(previous, redo_, previous.what);
  undo_.pop_back();
}

void SolverThread::redo() {
  if (redo_.empty() || !engine_->edits().redo_text().empty()) return engine_->redo();
  const Version next = redo_.back();
  change_version(next, undo_, next.what);
  redo_.pop_back();
}

void SolverThread::grab(const std::vector<Index>& vertices) {
  redo_.clear();
  engine_->grab(vertices);
}

}  // namespace tetraction::viewer
