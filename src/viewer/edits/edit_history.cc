#include "edit_history.h"

#include <algorithm>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

constexpr std::size_t kMostEntries = 200;

std::vector<std::int64_t> ids_of(const TetMesh& mesh, const std::vector<Index>& vertices) {
  std::vector<std::int64_t> ids;
  ids.reserve(vertices.size());
  for (const Index v : vertices) ids.push_back(mesh.vertex_id(v));
  return ids;
}

// The value of a field at a vertex. An empty field is zero.
Vector3 at_vertex(const Vector& field, Index v) {
  if (field.size() == 0) return Vector3::Zero();
  return vertex_block(field, v);
}

// The edit q += displacement, p += impulse for all vertices where one of them is not zero. No value
// if there are no such vertices.
std::optional<Edit> shift_of(const TetMesh& mesh, const Vector& displacement,
                             const Vector& impulse) {
  ShiftSettings shift;
  bool has_displacement = false;
  bool has_impulse = false;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 d = at_vertex(displacement, v);
    const Vector3 j = at_vertex(impulse, v);
    if (d.isZero(0.0) && j.isZero(0.0)) continue;
    shift.vertices.push_back(mesh.vertex_id(v));
    shift.displacement.push_back(d);
    shift.impulse.push_back(j);
    has_displacement = has_displacement || !d.isZero(0.0);
    has_impulse = has_impulse || !j.isZero(0.0);
  }
  if (!has_displacement) shift.displacement.clear();
  if (!has_impulse) shift.impulse.clear();
  if (shift.vertices.empty()) return std::nullopt;
  return ShiftState{std::move(shift)};
}

bool same_fix(const PresentFix& a, const PresentFix& b) {
  return a.vertices == b.vertices && a.targets == b.targets &&
         a.settings.components == b.settings.components &&
         a.settings.velocity == b.settings.velocity &&
         a.settings.is_penalty == b.settings.is_penalty && a.settings.penalty == b.settings.penalty;
}

// Whether a later edit makes an earlier one of the same kind superfluous.
struct Replaces {
  const Edit& earlier;
  bool operator()(const SetMaterial& next) const {
    return next.region == std::get<SetMaterial>(earlier).region;
  }
  bool operator()(const SetForce& next) const {
    const SetForce& last = std::get<SetForce>(earlier);
    return next.index.has_value() && next.index == last.index && next.entry.kind == last.entry.kind;
  }
  bool operator()(const SetFix& next) const {
    const SetFix& last = std::get<SetFix>(earlier);
    return next.index.has_value() && next.index == last.index &&
           next.entry.select == last.entry.select &&
           (next.entry.target.has_value() || !next.entry.targets.empty());
  }
  template <class Section>
  bool operator()(const SetSection<Section>&) const {
    return true;
  }
  template <class Other>
  bool operator()(const Other&) const {
    return false;
  }
};

}  // namespace

bool replaces(const Edit& later, const Edit& earlier) {
  if (later.index() != earlier.index()) return false;
  return std::visit(Replaces{earlier}, later);
}

EditHistory::EditHistory(const Session& session, Apply apply)
    : session_(session), apply_(std::move(apply)) {}

// The settings that an edit is about to change.
struct EditHistory::BeforeVisitor {
  const Session& session;
  const EntryNumbers& undone_loads;
  std::vector<Before> operator()(const SetMaterial& e) const {
    const auto region = static_cast<std::size_t>(e.region);
    if (region >= session.materials().size()) return {};  // the session will refuse the edit
    return {Edit(SetMaterial{e.region, session.materials()[region]})};
  }
  template <class Section>
  std::vector<Before> operator()(const SetSection<Section>&) const {
    return {Edit(SetSection<Section>{session.settings().section<Section>()})};
  }
  std::vector<Before> operator()(const SetForce& e) const {
    const std::vector<ForceSettings>& loads = session.loads().list(e.entry.kind);
    const std::size_t i = e.index.value_or(loads.size());
    const std::size_t list = list_of(e.entry);
    if (i >= loads.size() || has(undone_loads, list, i)) return {Added{list, i}};
    return {Edit(SetForce{i, loads[i]})};
  }
  std::vector<Before> operator()(const SetFix& e) const {
    const std::size_t i = e.index.value_or(session.fix_count());
    if (i >= session.fix_count()) return {FixBefore{i, std::nullopt}};
    return {FixBefore{i, session.fix(i)}};
  }
  std::vector<Before> operator()(const Unfix& e) const {
    std::vector<Before> fixes;
    for (std::size_t i = 0; i < session.fix_count(); ++i) {
      if (!e.fix || *e.fix == i) fixes.emplace_back(FixBefore{i, session.fix(i)});
    }
    return fixes;
  }
  std::vector<Before> constraint(std::size_t i) const {
    const auto& all = session.constraints();
    if (i >= all.size() || !all[i]) return {Added{list_of(ConstraintSettings()), i}};
    return {Edit(SetConstraint{i, *all[i]})};
  }
  std::vector<Before> operator()(const SetConstraint& e) const {
    return constraint(e.index.value_or(session.constraints().size()));
  }
  std::vector<Before> operator()(const RemoveConstraint& e) const { return constraint(e.index); }
  std::vector<Before> obstacle(std::size_t i) const {
    const std::vector<BodyObstacle>& all = session.settings().obstacles;
    if (i >= all.size() || all[i].removed) return {Added{list_of(ObstacleSettings()), i}};
    return {Edit(SetObstacle{i, all[i].settings})};
  }
  std::vector<Before> operator()(const SetObstacle& e) const {
    return obstacle(e.index.value_or(session.settings().obstacles.size()));
  }
  std::vector<Before> operator()(const RemoveObstacle& e) const { return obstacle(e.index); }
  template <class Change>
  std::vector<Before> operator()(const ChangeState<Change>&) const {
    return {};
  }
};

std::vector<EditHistory::Before> EditHistory::before(const Edit& edit) const {
  return std::visit(BeforeVisitor{session_, undone_loads_}, edit);
}

// Kind and number of the setting.
std::pair<std::size_t, std::size_t> EditHistory::part_of(const Before& before) {
  constexpr std::size_t kFirstList = std::variant_size_v<Edit>;
  if (const auto* edit = std::get_if<Edit>(&before)) {
    if (const std::optional<EditedEntry> entry = edited_entry(*edit)) {
      return {kFirstList + entry->list, *entry->index};
    }
    const auto* material = std::get_if<SetMaterial>(edit);
    return {edit->index(), material != nullptr ? static_cast<std::size_t>(material->region) : 0};
  }
  if (const auto* added = std::get_if<Added>(&before)) {
    return {kFirstList + added->list, added->index};
  }
  return {kFirstList + list_of(FixSettings()), std::get<FixBefore>(before).index};
}

// An edit of an entry that was taken back adds it again.
Edit EditHistory::adding_again(Edit edit) const {
  std::visit(
      [this]<class Kind>(Kind& kind) {
        if constexpr (kSetsEntry<Kind>) {
          const std::size_t count = counts_of(session_)[list_of(kind.entry)];
          if (kind.index && *kind.index >= count) kind.index.reset();
        }
      },
      edit);
  return edit;
}

void EditHistory::make(const Edit& edit, const std::string& what, Entry& entry) {
  std::vector<Before> parts = before(edit);
  const State state = session_.state();
  apply_(edit, what);
  if (entry.edits.empty()) entry.state = state;
  for (Before& part : parts) {
    const bool is_stored =
        std::any_of(entry.before.begin(), entry.before.end(),
                    [&](const Before& old) { return part_of(old) == part_of(part); });
    if (!is_stored) entry.before.push_back(std::move(part));
  }
  Edit redo_edit = edit;
  if (const std::optional<EditedEntry> added = edited_entry(edit); added && added->adds) {
    set_index(redo_edit, counts_of(session_)[added->list] - 1);
  } else if (std::visit([]<class Kind>(const Kind&) { return kChangesState<Kind>; }, redo_edit)) {
    const auto add = [](Vector& sum, const Vector& part) {
      if (sum.size() == 0) sum = Vector::Zero(part.size());
      sum += part;
    };
    add(entry.displacement, session_.state().position - state.position);
    add(entry.impulse, session_.state().momentum - state.momentum);
  }
  if (!entry.edits.empty() && replaces(redo_edit, entry.edits.back())) entry.edits.pop_back();
  entry.edits.push_back(std::move(redo_edit));
  entry.what = what;
}

// Stores the targets of fixed vertices after the edits of an entry. An undo needs them to compute by
// how much the edits moved the targets.
void EditHistory::store_targets(Entry& entry) const {
  for (Before& part : entry.before) {
    auto* fix = std::get_if<FixBefore>(&part);
    if (fix == nullptr || !fix->fix) continue;
    const PresentFix after = session_.fix(fix->index);
    fix->targets_after = after.vertices == fix->fix->vertices ? after.targets : Matrix();
  }
}

void EditHistory::make(const Edit& edit, const std::string& what, bool continues_previous) {
  const std::lock_guard lock(mutex_);
  if (continues_previous && can_continue_ && !undo_.empty()) {
    make(edit, what, undo_.back());
  } else {
    Entry entry;
    make(edit, what, entry);
    before_last_ = entry.state;
    undo_.push_back(std::move(entry));
    if (undo_.size() > kMostEntries) drop_oldest_entry();
  }
  store_targets(undo_.back());
  redo_.clear();
  can_continue_ = true;
}

void EditHistory::make_other(const std::string& what, const std::function<void(bool)>& act) {
  act(true);
  const std::lock_guard lock(mutex_);
  Entry entry;
  entry.what = what;
  entry.act = act;
  undo_.push_back(std::move(entry));
  if (undo_.size() > kMostEntries) drop_oldest_entry();
  before_last_.reset();
  redo_.clear();
  can_continue_ = false;
}

void EditHistory::make_all(const std::vector<Edit>& edits, const std::string& what, Entry& entry,
                           bool all_or_none) {
  try {
    for (const Edit& edit : edits) make(adding_again(edit), what, entry);
  } catch (const InputError&) {
    if (all_or_none && !entry.edits.empty()) {
      store_targets(entry);
      Entry reverted;
      revert(entry, what, reverted, false);
    }
    throw;
  }
  store_targets(entry);
}

Edit EditHistory::inverse(const FixBefore& before, bool at_once) const {
  const PresentFix& old = *before.fix;
  const PresentFix now = session_.fix(before.index);
  FixSettings fix = old.settings;
  fix.select = SelectVertices{ids_of(session_.system().mesh(), old.vertices)};
  fix.target.reset();
  fix.offset.reset();
  fix.targets.clear();
  for (std::size_t i = 0; i < old.vertices.size(); ++i) {
    const auto column = static_cast<Index>(i);
    const auto held = std::lower_bound(now.vertices.begin(), now.vertices.end(), old.vertices[i]);
    if (at_once) {
      fix.targets.emplace_back(old.targets.col(column));
    } else if (held == now.vertices.end() || *held != old.vertices[i]) {
      fix.targets.emplace_back(vertex_block(session_.state().position, old.vertices[i]));
    } else {
      Vector3 target = now.targets.col(held - now.vertices.begin());
      if (before.targets_after.cols() == old.targets.cols()) {
        target -= before.targets_after.col(column) - old.targets.col(column);
      }
      fix.targets.push_back(target);
    }
  }
  return SetFix{before.index, fix};
}

// The edits that restore the earlier settings. Edits that release vertices or remove constraints and obstacles come
// first.
std::vector<Edit> EditHistory::inverse(const Entry& entry) const {
  std::vector<Edit> release;
  std::vector<Edit> edits;
  for (auto part = entry.before.rbegin(); part != entry.before.rend(); ++part) {
    if (const auto* edit = std::get_if<Edit>(&*part)) {
      edits.push_back(*edit);
    } else if (const auto* added = std::get_if<Added>(&*part)) {
      if (added->list < kLoadKinds) {  // loads cannot be taken away, but they can be zero
        ForceSettings zero =
            session_.loads().list(static_cast<LoadKind>(added->list))[added->index];
        zero.vector.setZero();
        zero.value = 0.0;
        if (zero.total) zero.total->setZero();
        if (zero.acceleration) zero.acceleration->setZero();
        edits.emplace_back(SetForce{added->index, zero});
      } else if (added->list == list_of(ObstacleSettings())) {
        if (!session_.settings().obstacles[added->index].removed) {
          release.emplace_back(RemoveObstacle{added->index});
        }
      } else if (session_.constraints()[added->index]) {
        release.emplace_back(RemoveConstraint{added->index});
      }
    } else if (const auto* fix = std::get_if<FixBefore>(&*part)) {
      const PresentFix now = session_.fix(fix->index);
      if (!fix->fix || fix->fix->vertices.empty()) {
        Unfix unfix;
        unfix.fix = fix->index;
        if (!now.vertices.empty()) release.emplace_back(unfix);
      } else if (!same_fix(*fix->fix, now)) {
        edits.push_back(inverse(*fix, entry.state.has_value()));
      }
    }
  }
  release.insert(release.end(), edits.begin(), edits.end());
  return release;
}

std::optional<Edit> EditHistory::shift_back(const Entry& entry) const {
  const TetMesh& mesh = session_.system().mesh();
  if (entry.state) {
    return shift_of(mesh, entry.state->position - session_.state().position,
                    entry.state->momentum - session_.state().momentum);
  }
  // What a drag did to the motion is past.
  const bool is_drag = std::any_of(entry.edits.begin(), entry.edits.end(), [](const Edit& edit) {
    return !std::visit([]<class Kind>(const Kind&) { return kChangesState<Kind>; }, edit);
  });
  if (is_drag) return std::nullopt;
  return shift_of(mesh, -entry.displacement, -entry.impulse);
}

void EditHistory::revert(const Entry& entry, const std::string& what, Entry& done,
                         bool all_or_none) {
  make_all(inverse(entry), what, done, all_or_none);
  for (const Before& part : entry.before) {
    const auto* added = std::get_if<Added>(&part);
    if (added == nullptr || added->list >= kLoadKinds ||
        has(undone_loads_, added->list, added->index)) {
      continue;
    }
    std::vector<std::size_t>& undone = undone_loads_[added->list];
    undone.insert(std::ranges::upper_bound(undone, added->index), added->index);
  }
  // The shift is computed after the other edits, because they may have restored positions already.
  if (const std::optional<Edit> shift = shift_back(entry)) {
    make_all({*shift}, what, done, all_or_none);
  }
}

void EditHistory::undo() {
  if (undo_.empty()) return;
  if (undo_.back().act) undo_.back().act(false);
  const std::lock_guard lock(mutex_);
  if (!undo_.back().act) {
    Entry done;
    revert(undo_.back(), "undo: " + undo_.back().what, done);
  }
  to_redo();
}

void EditHistory::take_back() {
  const std::lock_guard lock(mutex_);
  to_redo();
}

void EditHistory::to_redo() {
  before_last_.reset();
  redo_.push_back(std::move(undo_.back()));
  undo_.pop_back();
  can_continue_ = false;
}

void EditHistory::go_before_last() {
  if (!knows_state_before_last()) return;
  undo_.back().state = before_last_;
  undo();
}

void EditHistory::redo() {
  if (redo_.empty()) return;
  const std::lock_guard lock(mutex_);
  before_last_.reset();
  Entry entry;
  if (redo_.back().act) {
    redo_.back().act(true);
    entry = std::move(redo_.back());
  } else {
    make_all(redo_.back().edits, redo_.back().what, entry);
    for (const Edit& edit : redo_.back().edits) {
      if (!is_undone_load(edit)) continue;
      const auto set = *edited_entry(edit);
      std::erase(undone_loads_[set.list], *set.index);
    }
  }
  redo_.pop_back();
  undo_.push_back(std::move(entry));
  can_continue_ = false;
}

void EditHistory::append(const Entry& entry, std::vector<MadeEdit>& made) {
  bool continues_previous = false;
  for (const Edit& edit : entry.edits) {
    made.push_back({edit, entry.what, std::exchange(continues_previous, true)});
  }
}

void EditHistory::drop_oldest_entry() {
  for (const Edit& edit : undo_.front().edits) {
    std::erase_if(not_undoable_, [&](const MadeEdit& old) { return replaces(edit, old.edit); });
  }
  append(undo_.front(), not_undoable_);
  undo_.erase(undo_.begin());
}

std::vector<MadeEdit> EditHistory::edits_in_effect() const {
  const std::lock_guard lock(mutex_);
  std::vector<MadeEdit> made = not_undoable_;
  for (const Entry& entry : undo_) append(entry, made);
  std::erase_if(made, [this](const MadeEdit& edit) { return is_undone_load(edit.edit); });
  return made;
}

bool EditHistory::is_undone_load(const Edit& edit) const {
  const std::optional<EditedEntry> entry = edited_entry(edit);
  return entry && entry->index && has(undone_loads_, entry->list, *entry->index);
}

void EditHistory::remember(std::vector<MadeEdit> made, EntryNumbers undone_loads) {
  const std::lock_guard lock(mutex_);
  not_undoable_ = std::move(made);
  undone_loads_ = std::move(undone_loads);
}

void EditHistory::stepped() {
  for (Entry& entry : undo_) entry.state.reset();
}

}  // namespace tetraction::viewer
