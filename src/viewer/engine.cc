#include "engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "simulation/stepping/step_strategy.h"
#include "snapshot_maker.h"
#include "tetraction/core/error.h"
#include "viewer/edits/event_edits.h"

namespace tetraction::viewer {
namespace {

// The scene of the session. It has no events, because the engine makes them, and no end.
Scene without_events_and_end(Scene scene) {
  scene.event.clear();
  scene.time.end = std::numeric_limits<double>::infinity();
  return scene;
}

constexpr const char* kDragCause = "drag";

bool may_change_limit(const Edit& edit) {
  return !std::holds_alternative<SetTime>(edit) && !std::holds_alternative<SetSolver>(edit) &&
         !std::holds_alternative<SetForce>(edit) && !std::holds_alternative<SetMomentum>(edit) &&
         !std::holds_alternative<SetPull>(edit);
}

// The kind of the setting that an edit changes, and the region of a material.
std::string cause_of(const Edit& edit) {
  const auto* material = std::get_if<SetMaterial>(&edit);
  return fmt::format("edit {} {}", edit.index(), material != nullptr ? material->region : 0);
}

std::string region_name(const MaterialRegionSettings& region, std::size_t number) {
  if (const auto* group = std::get_if<SelectGroup>(&region.select)) return group->name;
  return fmt::format("region {}", number);
}

}  // namespace

Engine::Engine(const Scene& scene, const TetMesh& mesh, Recording& recording)
    : events_(scene.event),
      recording_(recording),
      session_(std::make_unique<Session>(without_events_and_end(scene), mesh)),
      edits_(std::make_unique<EditHistory>(
          *session_, [this](const Edit& edit, const std::string& what) { apply(edit, what); })),
      numbering_(scene),
      end_(scene.time.end) {
  session_->keep_good_states();
  check_events(scene, session_->system());
  report_new_warnings();
  recording_.begin(scene);
  recording_.move_to(*session_);
}

Settings Engine::settings() const {
  Settings settings;
  settings.materials = session_->materials();
  const MechanicalSystem& system = session_->system();
  for (const MaterialField& material : system.materials()) {
    settings.moduli.push_back(material.lame_range());
  }
  settings.mean_density = system.total_mass() / system.mesh().total_volume();
  settings.region_names.emplace_back("body");
  const std::vector<MaterialRegionSettings>& regions = session_->scene().material_region;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    settings.region_names.push_back(region_name(regions[i], i + 1));
  }
  static_cast<ChangeableSections&>(settings) = sections();
  settings.loads = session_->loads();
  settings.fixes = session_->settings().constraints.fix_settings;
  settings.constraints = session_->constraints();
  settings.obstacles = session_->settings().obstacles;
  settings.present = present_entries(*session_);
  for (std::size_t list = 0; list < kLoadKinds; ++list) {
    std::erase_if(settings.present[list],
                  [&](std::size_t number) { return has(edits_->undone_loads(), list, number); });
  }
  return settings;
}

ChangeableSections Engine::sections() const {
  ChangeableSections sections = session_->settings();
  sections.time.step = session_->time_step();
  return sections;
}

const Vector& Engine::user_force() {
  if (user_force_) return *user_force_;
  const TetMesh& mesh = session_->system().mesh();
  Vector sum = Vector::Zero(3 * mesh.vertex_count());
  const std::vector<ForceSettings>& forces = session_->loads().force;
  for (std::size_t i = session_->scene().force.size(); i < forces.size(); ++i) {
    if (!std::holds_alternative<SelectVertices>(forces[i].select) || forces[i].total) continue;
    for (const Index v : select_vertices(mesh, forces[i].select)) {
      vertex_block(sum, v) += forces[i].vector;
    }
  }
  return user_force_.emplace(std::move(sum));
}

void Engine::apply(const Edit& edit, const std::string& what, bool by_user) {
  session_->apply(edit, what);
  if (std::holds_alternative<SetForce>(edit)) user_force_.reset();
  recording_.add(*session_, edit, what, by_user);
  // The edits of a drag have one mark.
  if (what != last_mark_) marks_.push_back({session_->time(), what});
  const bool is_drag = std::holds_alternative<SetPull>(edit) || obstacle_;
  last_mark_ = is_drag ? what : std::string();
  // A warning goes with the setting that it is about.
  const std::string cause = cause_of(edit);
  if (warned_causes_.erase(cause) > 0) end_cause(cause);
  if (const std::string& warning = session_->edits().back().warning; !warning.empty()) {
    notices_.push_back({Notice::Kind::kWarning, sentence(warning), cause});
    warned_causes_.insert(cause);
  }
  limit_changed_ = limit_changed_ || may_change_limit(edit);
  entries_changed_ =
      entries_changed_ || edited_entry(edit) || std::holds_alternative<SetMaterial>(edit);
}

void Engine::report_new_warnings() {
  for (; reported_warnings_ < session_->warnings().size(); ++reported_warnings_) {
    const std::string& warning = session_->warnings()[reported_warnings_];
    notices_.push_back({Notice::Kind::kWarning, sentence(warning), "warning: " + warning});
  }
}

void Engine::end_cause(const std::string& cause) {
  std::erase_if(notices_, [&](const Notice& notice) { return notice.cause == cause; });
  ended_causes_.push_back(cause);
}

void Engine::require_good_state() const {
  if (session_->status() == RunStatus::kRunning) return;
  // The window shows one message at a time, so that this one has the reason, too.
  throw InputError(
      fmt::format("{} The run has failed, so nothing can be changed in this state: go back to the "
                  "last good one first.",
                  session_->message()));
}

void Engine::resolve_newest(Edit& edit) const {
  const std::optional<EditedEntry> entry = edited_entry(edit);
  if (!entry || entry->index != kNewest) return;
  const std::optional<std::size_t> newest = newest_[entry->list];
  if (!newest) throw InputError("No such load, fix or constraint was added yet.");
  set_index(edit, *newest);
}

void Engine::edit(Edit edit, const std::string& what, bool continues_previous) {
  require_good_state();
  resolve_newest(edit);
  check_edit(edit);
  if (auto* set = std::get_if<SetTime>(&edit)) {
    set->settings.end = std::numeric_limits<double>::infinity();
  }
  const ForEachList<std::size_t> before = counts_of(*session_);
  std::shared_ptr<const KeptState> state =
      edits_->begins_entry(continues_previous) ? kept_state() : nullptr;
  edits_->make(edit, what, continues_previous);
  if (state) before_.push_back(std::move(state));
  if (before_.size() > edits_->undo_count()) before_.erase(before_.begin());
  ++edit_count_;
  const std::optional<EditedEntry> entry = edited_entry(edit);
  if (entry && entry->adds) newest_[entry->list] = before[entry->list];
}

void Engine::change_other(const std::string& what, const std::function<void(bool)>& act) {
  edits_->make_other(what, act);
  ++edit_count_;
}

void Engine::undo() {
  require_good_state();
  release();  // a drag is undone as a whole
  if (before_.empty() || edits_->undoes_other()) {
    edits_->undo();
  } else {
    take_back();
  }
  ++edit_count_;
}

// No step has been made since the last edit: everything becomes as it was, and the recording has no trace of it.
void Engine::take_back() {
  const std::string what = "undo: " + edits_->undo_text();
  const std::shared_ptr<const KeptState> kept = before_.back();
  Recording::Data recorded = recording_.data();
  for (std::size_t i = kept->settings->recorded; i < recorded.entries.size(); ++i) {
    const std::string cause = cause_of(recorded.entries[i].edit);
    if (warned_causes_.erase(cause) > 0) end_cause(cause);
  }
  put_back(*kept, std::move(recorded), session_->edits(), what);
  edits_->take_back();
  before_.pop_back();
  for (std::size_t list = 0; list < kEntryLists; ++list) {
    if (newest_[list] >= counts_of(*session_)[list]) newest_[list].reset();
  }
  marks_.push_back({session_->time(), what});
}

void Engine::redo() {
  require_good_state();
  release();
  std::shared_ptr<const KeptState> state = edits_->redoes_other() ? nullptr : kept_state();
  const std::size_t count = edits_->undo_count();
  edits_->redo();
  if (state && edits_->undo_count() > count) before_.push_back(std::move(state));
  ++edit_count_;
}

// Calls work(drag) if there is a drag. Ends the drag if this throws InputError.
template <class Work>
void Engine::with_drag(const Work& work) {
  if (session_->status() != RunStatus::kRunning) return;
  try {
    if (drag_) work(*drag_);
    if (spring_) work(*spring_);
    if (obstacle_) work(*obstacle_);
  } catch (const InputError& error) {
    drag_.reset();
    spring_.reset();
    obstacle_.reset();
    report_refused_drag(error.what());
  }
}

// The mouse moves on after a refusal. The same notice is made once only.
void Engine::report_refused_drag(const std::string& reason) {
  if (std::exchange(refused_drag_, reason) == reason) return;
  notices_.push_back({Notice::Kind::kRefused, reason, kDragCause});
}

void Engine::grab(const std::vector<Index>& vertices) {
  require_good_state();
  release();
  if (vertices.empty()) return;
  drag_.emplace(*session_, vertices,
                [this](const Edit& made, const std::string& what, bool continues_previous) {
                  edit(made, what, continues_previous);
                });
}

void Engine::pull(const std::vector<Index>& vertices, double radius, double critical_step) {
  require_good_state();
  release();
  if (vertices.empty()) return;
  spring_.emplace(*session_, vertices, radius, critical_step,
                  [this](const Edit& made, const std::string& what, bool continues_previous) {
                    edit(made, what, continues_previous);
                  });
}

void Engine::grab_obstacle(std::size_t number, const Vector3& point) {
  require_good_state();
  release();
  obstacle_.emplace(*session_, number, point,
                    [this](const Edit& made, const std::string& what, bool continues_previous) {
                      edit(made, what, continues_previous);
                    });
}

void Engine::set_pull_radius(double radius) {
  if (!spring_ || session_->status() != RunStatus::kRunning) return;
  spring_->set_radius(radius);
}

void Engine::drag_to(const Vector3& position, double duration) {
  with_drag([&](auto& drag) {
    if constexpr (requires { drag.move_at_once(position); }) {
      if (duration > 0.0) return drag.drag_to(position, duration);
      try {
        drag.move_at_once(position);
      } catch (const InputError& error) {
        report_refused_drag(error.what());
      }
    } else {
      drag.drag_to(position, duration);
    }
  });
}

void Engine::release() {
  const bool drags = drag_ || spring_ || obstacle_;
  release_pending_ = drags && session_->status() != RunStatus::kRunning;
  if (release_pending_) return;
  with_drag([](auto& drag) { drag.release(); });
  drag_.reset();
  spring_.reset();
  obstacle_.reset();
  last_mark_.clear();
  if (!std::exchange(refused_drag_, {}).empty()) end_cause(kDragCause);
}

void Engine::make_due_events() {
  const auto due = [this] {
    return next_event_ < events_.size() && is_due(events_[next_event_].at, session_->time(),
                                                  session_->settings().time, session_->time_step());
  };
  while (due()) {
    const EventSettings& event = events_[next_event_++];
    const std::string what = fmt::format("event at {:.6g} s", event.at);
    for (const Edit& edit : event.edits) {
      const ForEachList<std::size_t> before = counts_of(*session_);
      bool refused = true;
      try {
        std::optional<Edit> translated = numbering_.translated(edit);
        if (!translated) {
          throw InputError(
              "it changes an entry that an earlier event should have added, but that event was "
              "refused.");
        }
        if (changes_what_was_removed(edit, *translated, present_entries(*session_),
                                     std::span(events_).first(next_event_))) {
          throw InputError(
              "it changes a fixed set or a constraint that was deleted or switched off.");
        }
        translated = with_present_settings(*translated, event, settings());
        if (auto* set = std::get_if<SetTime>(&*translated)) {
          if (std::isfinite(set->settings.end)) end_ = set->settings.end;
          set->settings.end = std::numeric_limits<double>::infinity();
        }
        apply(*translated, what, false);
        refused = false;
        // What was taken back would be added with other numbers.
        if (counts_of(*session_) != before) edits_->forget_undone();
      } catch (const InputError& error) {
        notices_.push_back({Notice::Kind::kRefused,
                            fmt::format("The {} could not be made: {}", what, error.what())});
      }
      numbering_.record_edit(edit, before, refused);
    }
    recording_.set_events_made(next_event_, numbering_);
  }
}

bool Engine::step() {
  require_good_state();
  before_.clear();
  make_due_events();
  with_drag([](auto& drag) { drag.before_step(); });
  session_->land_at(next_event_ < events_.size() ? events_[next_event_].at
                                                 : std::numeric_limits<double>::infinity());
  const bool succeeded = session_->step();
  before_.clear();
  if (succeeded) edits_->stepped();
  report_new_warnings();
  recording_.move_to(*session_);
  return succeeded;
}

void Engine::go_back() {
  if (session_->status() == RunStatus::kRunning) return;
  session_->go_back();
  // Going back resets the solver. A replay must do the same. Therefore it is recorded as an edit
  // that sets the solver.
  recording_.add(*session_, SetSolver{session_->solver_settings()}, "back to the last good state",
                 false);
  recording_.move_to(*session_);
  marks_.push_back({session_->time(), "back to the last good state"});
  limit_changed_ = true;
  if (release_pending_) release();
}

std::shared_ptr<const KeptState> Engine::kept_state() {
  const std::size_t edits = session_->edits().size();
  if (!kept_settings_ || kept_settings_->edits != edits) {
    kept_settings_ = std::make_shared<const KeptSettings>(KeptSettings{
        session_->settings(), prescribed_vertices(*session_), edits, recording_.entry_count(),
        next_event_, numbering_, end_, edits_->undone_loads()});
  }
  return std::make_shared<const KeptState>(KeptState{session_->present_state(),
                                                     session_->balance().sums(),
                                                     session_->time_step(), kept_settings_});
}

// Puts the session back to a state of a run with this recording and these Session::edits().
void Engine::put_back(const KeptState& kept, Recording::Data recorded,
                      const std::vector<AppliedEdit>& edits, const std::string& what) {
  const KeptSettings& then = *kept.settings;
  Checkpoint checkpoint = session_->checkpoint();
  checkpoint.settings = then.settings;
  checkpoint.state = kept.state;
  checkpoint.balance = kept.balance;
  checkpoint.progress.edits.assign(edits.begin(),
                                   edits.begin() + static_cast<std::ptrdiff_t>(then.edits));
  session_->restore(checkpoint);
  reported_warnings_ = std::min(reported_warnings_, session_->warnings().size());
  limit_changed_ = entries_changed_ = true;
  kept_settings_.reset();
  user_force_.reset();
  next_event_ = then.events_made;
  numbering_ = then.numbering;
  end_ = then.end;
  recorded.entries.resize(then.recorded);
  recorded.events_made = then.events_made;
  recorded.numbering = then.numbering;
  recording_.restore(std::move(recorded));
  if (session_->step_number() > 0) {
    // A replay must begin anew here, too, and count its steps from here.
    TimeSettings time = then.settings.time;
    if (time.adapt != StepAdaptation::kNone) time.step = kept.time_step;
    apply(SetSolver{then.settings.solver}, what, false);
    apply(SetTime{time}, what, false);
  }
  recording_.move_to(*session_);
}

std::vector<MadeEdit> Engine::restore(const KeptState& kept, Recording::Data recorded,
                                      const Engine& other, const std::string& what) {
  const KeptSettings& then = *kept.settings;
  // The edits of the user with the indices of what they added, as EditHistory has them.
  ForEachList<std::size_t> counts = counts_of(*session_);
  std::vector<MadeEdit> before;
  std::vector<MadeEdit> after;
  for (std::size_t i = 0; i < recorded.entries.size(); ++i) {
    const Recording::Entry& entry = recorded.entries[i];
    MadeEdit made{entry.edit, entry.note};
    if (const std::optional<EditedEntry> edited = edited_entry(entry.edit);
        edited && edited->adds) {
      set_index(made.edit, counts[edited->list]++);
    }
    if (entry.by_user) (i < then.recorded ? before : after).push_back(std::move(made));
  }

  put_back(kept, std::move(recorded), other.session().edits(), what);
  // Loads that were undone and that this run does not have yet are left out.
  const EntryNumbers& undone = other.edits().undone_loads();
  EntryNumbers undone_here;
  for (std::size_t list = 0; list < kLoadKinds; ++list) {
    const std::size_t count = counts_of(*session_)[list];
    std::ranges::copy_if(undone[list], std::back_inserter(undone_here[list]),
                         [count](std::size_t number) { return number < count; });
  }
  std::erase_if(after, [&](const MadeEdit& made) {
    const std::optional<EditedEntry> entry = edited_entry(made.edit);
    return entry && entry->index && has(undone, entry->list, *entry->index) &&
           !has(undone_here, entry->list, *entry->index);
  });
  edits_->remember(std::move(before), std::move(undone_here));
  return after;
}

void Engine::go_before_last_edit() {
  go_back();
  release();
  if (before_.empty()) {
    edits_->go_before_last();
  } else {
    take_back();
  }
  ++edit_count_;
}

}  // namespace tetraction::viewer
