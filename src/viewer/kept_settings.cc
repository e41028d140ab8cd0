#include "kept_settings.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tetraction/mesh/selection.h"

namespace tetraction::viewer {
namespace {

// Forces, fixes and constraints with numbers from those of the scene on were added by hand.
class Keeper {
 public:
  explicit Keeper(const Session& start) : start_(start), mesh_(start.system().mesh()) {
    for (std::size_t i = 0; i < start.fix_count(); ++i) {
      fixes_[i].vertices = fixes_[i].at_start = start.fix(i).vertices;
    }
  }

  void add(const MadeEdit& made) {
    if (!made.goes_on) ++entry_;
    ++order_;
    what_ = &made.what;
    std::visit(*this, made.edit);
  }

  std::vector<MadeEdit> edits() const;

  // For each kind of edit: the settings that it leaves.
  void operator()(const SetMaterial& edit) { set({edit.region, 0}, edit); }
  void operator()(const SetTime& edit) { set({0, 1}, edit); }
  void operator()(const SetSolver& edit) { set({0, 2}, edit); }
  void operator()(const SetDamping& edit) { set({0, 3}, edit); }
  void operator()(const SetEnvironment& edit) { set({0, 4}, edit); }
  void operator()(const SetForce& edit) {
    SetForce kept = edit;
    if (*edit.index >= start_.forces().size()) kept.index.reset();
    set({static_cast<Index>(*edit.index), 5}, kept);
  }
  void operator()(const SetConstraint& edit) {
    SetConstraint kept = edit;
    if (*edit.index >= start_.constraints().size()) kept.index.reset();
    set({static_cast<Index>(*edit.index), 6}, kept);
  }
  void operator()(const RemoveConstraint& edit) {
    const Key key{static_cast<Index>(edit.index), 6};
    if (edit.index < start_.constraints().size()) {
      set(key, edit);
    } else {
      settings_.erase(key);
    }
  }
  void operator()(const SetFix& edit) {
    Fix& fix = fixes_[*edit.index];
    fix.settings = edit.fix;
    fix.vertices = select_vertices(mesh_, edit.fix.select);
    touch(fix);
  }
  void operator()(const Unfix& edit) {
    const std::vector<Index> loose = select_vertices(mesh_, edit.select);
    for (auto& [number, fix] : fixes_) {
      if (edit.fix && *edit.fix != number) continue;
      std::vector<Index> left;
      std::set_difference(fix.vertices.begin(), fix.vertices.end(), loose.begin(), loose.end(),
                          std::back_inserter(left));
      if (left.size() == fix.vertices.size()) continue;
      fix.vertices = std::move(left);
      touch(fix);
    }
  }
  void operator()(const SetMomentum&) const {}
  void operator()(const ShiftState&) const {}

 private:
  using Key = std::pair<Index, int>;  // a number, and of what
  struct Kept {
    int order = 0;  // of the last edit that set it; 0: none did
    int entry = 0;  // what is undone together
    std::string what;
  };
  struct Setting : Kept {
    Edit edit;
  };
  struct Fix : Kept {
    std::optional<FixSettings> settings;  // by hand
    std::vector<Index> vertices, at_start;
  };

  void touch(Kept& kept) const {
    kept.order = order_;
    kept.entry = entry_;
    kept.what = *what_;
  }
  void set(const Key& key, const Edit& edit) {
    Setting& setting = settings_[key];
    setting.edit = edit;
    touch(setting);
  }
  std::optional<Edit> edit_of(std::size_t number, const Fix& fix) const;
  SelectVertices ids(const std::vector<Index>& vertices) const {
    SelectVertices select;
    for (const Index v : vertices) select.ids.push_back(mesh_.vertex_id(v));
    return select;
  }

  const Session& start_;
  const TetMesh& mesh_;
  std::map<Key, Setting> settings_;
  std::map<std::size_t, Fix> fixes_;
  int order_ = 0;
  int entry_ = 0;
  const std::string* what_ = nullptr;
};

std::optional<Edit> Keeper::edit_of(std::size_t number, const Fix& fix) const {
  const bool in_scene = number < start_.fix_count();
  if (fix.vertices.empty() && !in_scene) return std::nullopt;
  if (fix.settings && !fix.vertices.empty()) {
    FixSettings settings = *fix.settings;
    const auto* named = std::get_if<SelectVertices>(&fix.settings->select);
    settings.select = ids(fix.vertices);
    if (named != nullptr && !settings.targets.empty()) {
      settings.targets.clear();
      for (const std::int64_t id : std::get<SelectVertices>(settings.select).ids) {
        const auto place = std::find(named->ids.begin(), named->ids.end(), id) - named->ids.begin();
        settings.targets.push_back(fix.settings->targets[static_cast<std::size_t>(place)]);
      }
    }
    return SetFix{in_scene ? std::optional(number) : std::nullopt, settings};
  }
  std::vector<Index> loose;
  std::set_difference(fix.at_start.begin(), fix.at_start.end(), fix.vertices.begin(),
                      fix.vertices.end(), std::back_inserter(loose));
  if (loose.empty()) return std::nullopt;
  return Unfix{ids(loose), {}, number};
}

std::vector<MadeEdit> Keeper::edits() const {
  std::map<int, std::pair<const Kept*, std::vector<Edit>>> by_order;
  for (const auto& [key, setting] : settings_) {
    by_order[setting.order] = {&setting, {setting.edit}};
  }
  for (const auto& [number, fix] : fixes_) {  // one edit may release from several of them
    if (fix.order == 0) continue;
    if (const std::optional<Edit> edit = edit_of(number, fix)) {
      by_order[fix.order].first = &fix;
      by_order[fix.order].second.push_back(*edit);
    }
  }
  std::vector<MadeEdit> made;
  int entry = 0;
  for (const auto& [order, kept] : by_order) {
    for (const Edit& edit : kept.second) {
      made.push_back(
          {edit, kept.first->what, std::exchange(entry, kept.first->entry) == kept.first->entry});
    }
  }
  return made;
}

}  // namespace

std::vector<MadeEdit> kept_settings(const std::vector<MadeEdit>& made, const Session& start) {
  Keeper keeper(start);
  for (const MadeEdit& edit : made) keeper.add(edit);
  return keeper.edits();
}

}  // namespace tetraction::viewer
