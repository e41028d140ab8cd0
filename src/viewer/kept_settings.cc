// The settings that a run keeps when it is restarted.
#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tetraction/mesh/selection.h"
#include "viewer/edits/edit_history.h"
#include "viewer/edits/numbering.h"

namespace tetraction::viewer {
namespace {

// Collects the settings that result from a list of edits. A force, fix or constraint was added by the
// user if its index is not below the number of those in the scene.
class SettingsCollector {
 public:
  explicit SettingsCollector(const Session& start) : start_(start), mesh_(start.system().mesh()) {
    for (std::size_t i = 0; i < start.fix_count(); ++i) {
      fixes_[i].vertices = fixes_[i].at_start = start.fix(i).vertices;
    }
  }

  void add(const MadeEdit& made) {
    if (!made.continues_previous) ++entry_;
    ++order_;
    what_ = &made.what;
    std::visit(*this, made.edit);
  }

  std::vector<MadeEdit> edits() const;

  // One function for each kind of edit, which stores the resulting settings.
  void operator()(const SetMaterial& edit) { set({Edit(edit).index(), edit.region}, edit); }
  // A drag brings the scene's own spring back.
  void operator()(const SetPull& edit) {
    const PullSettings& own = start_.settings().pull;
    const PullSettings& now = edit.settings;
    const Key key{Edit(edit).index(), 0};
    if (own.vertices == now.vertices && own.target == now.target &&
        own.stiffness == now.stiffness && own.damping == now.damping) {
      settings_.erase(key);
    } else {
      set(key, edit);
    }
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) {
    set({Edit(edit).index(), 0}, edit);
  }
  template <class Entry>
  void operator()(const SetEntry<Entry>& edit) {
    const std::size_t list = list_of(edit.entry);
    SetEntry<Entry> kept = edit;
    if (*edit.index >= counts_[list]) kept.index.reset();
    set(key_of(list, *edit.index), kept);
  }
  void operator()(const RemoveConstraint& edit) { remove(list_of(ConstraintSettings()), edit); }
  void operator()(const RemoveObstacle& edit) { remove(list_of(ObstacleSettings()), edit); }
  void operator()(const SetFix& edit) {
    Fix& fix = fixes_[*edit.index];
    fix.settings = edit.entry;
    fix.vertices = select_vertices(mesh_, edit.entry.select);
    set_origin(fix);
  }
  void operator()(const Unfix& edit) {
    const std::vector<Index> released = select_vertices(mesh_, edit.select);
    for (auto& [number, fix] : fixes_) {
      if (edit.fix && *edit.fix != number) continue;
      std::vector<Index> left;
      std::set_difference(fix.vertices.begin(), fix.vertices.end(), released.begin(),
                          released.end(), std::back_inserter(left));
      if (left.size() == fix.vertices.size()) continue;
      fix.vertices = std::move(left);
      set_origin(fix);
    }
  }
  template <class Change>
  void operator()(const ChangeState<Change>&) const {}

 private:
  using Key = std::pair<std::size_t, Index>;  // kind of the setting, number of the entry or region
  static Key key_of(std::size_t list, std::size_t index) {
    return {std::variant_size_v<Edit> + list, static_cast<Index>(index)};
  }
  struct Origin {
    int order = 0;  // number of the last edit of this setting; 0 if there was none
    int entry = 0;  // number of the group of edits that are undone together
    std::string what;
  };
  struct Setting : Origin {
    Edit edit;
  };
  struct Fix : Origin {
    std::optional<FixSettings> settings;  // if the user changed them
    std::vector<Index> vertices, at_start;
  };

  void set_origin(Origin& origin) const {
    origin.order = order_;
    origin.entry = entry_;
    origin.what = *what_;
  }
  // An entry that the user has added is simply forgotten.
  template <class Removal>
  void remove(std::size_t list, const Removal& edit) {
    const Key key = key_of(list, edit.index);
    if (edit.index < counts_[list]) {
      set(key, edit);
    } else {
      settings_.erase(key);
    }
  }
  void set(const Key& key, const Edit& edit) {
    Setting& setting = settings_[key];
    setting.edit = edit;
    set_origin(setting);
  }
  std::optional<Edit> edit_of(std::size_t number, const Fix& fix) const;
  SelectVertices ids(const std::vector<Index>& vertices) const {
    SelectVertices select;
    for (const Index v : vertices) select.ids.push_back(mesh_.vertex_id(v));
    return select;
  }

  const Session& start_;
  const TetMesh& mesh_;
  const ForEachList<std::size_t> counts_ = counts_of(start_);
  std::map<Key, Setting> settings_;
  std::map<std::size_t, Fix> fixes_;
  int order_ = 0;
  int entry_ = 0;
  const std::string* what_ = nullptr;
};

std::optional<Edit> SettingsCollector::edit_of(std::size_t number, const Fix& fix) const {
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
  std::vector<Index> released;
  std::set_difference(fix.at_start.begin(), fix.at_start.end(), fix.vertices.begin(),
                      fix.vertices.end(), std::back_inserter(released));
  if (released.empty()) return std::nullopt;
  return Unfix{ids(released), {}, number};
}

std::vector<MadeEdit> SettingsCollector::edits() const {
  std::map<int, std::pair<const Origin*, std::vector<Edit>>> by_order;
  for (const auto& [key, setting] : settings_) {
    by_order[setting.order] = {&setting, {setting.edit}};
  }
  for (const auto& [number, fix] : fixes_) {  // one Unfix may change several fixes
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
  SettingsCollector collector(start);
  for (const MadeEdit& edit : made) collector.add(edit);
  return collector.edits();
}

}  // namespace tetraction::viewer
