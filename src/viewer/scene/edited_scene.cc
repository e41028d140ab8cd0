#include "edited_scene.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <variant>

#include "simulation/scene/setting_keys.h"
#include "tetraction/mesh/selection.h"

namespace tetraction::viewer {
namespace {

class SceneEditing {
 public:
  SceneEditing(EditedScene& edited, const TetMesh& mesh) : edited_(edited), mesh_(mesh) {}

  void operator()(const SetMaterial& edit) {
    if (edit.region == 0) {
      edited_.scene.material = edit.material;
    } else {
      edited_.scene.material_region.at(static_cast<std::size_t>(edit.region - 1)).material =
          edit.material;
    }
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) {
    edited_.scene.section<Section>() = edit.settings;
  }
  void operator()(const SetTime& edit) {
    const double end = edited_.scene.time.end;  // runs in the window have none
    edited_.scene.time = edit.settings;
    edited_.scene.time.end = end;
  }
  void operator()(const SetForce& edit) { set(edited_.scene.list(edit.entry.kind), edit); }
  void operator()(const SetConstraint& edit) { set(edited_.scene.constraint, edit); }
  void operator()(const SetObstacle& edit) {
    const std::size_t place = set(edited_.scene.obstacle, edit);
    std::erase(edited_.removed[list_of(ObstacleSettings())], place);
  }
  void operator()(const SetFix& edit) {
    const std::size_t place = set(edited_.scene.fix, edit);
    held_[place] = select_vertices(mesh_, edit.entry.select);
    std::erase(edited_.removed[list_of(FixSettings())], place);
  }
  void operator()(const RemoveConstraint& edit) {
    remove(list_of(ConstraintSettings()), edit.index);
  }
  void operator()(const RemoveObstacle& edit) { remove(list_of(ObstacleSettings()), edit.index); }
  void operator()(const Unfix& edit) {
    const std::vector<Index> released = select_vertices(mesh_, edit.select);
    const std::size_t list = list_of(FixSettings());
    for (std::size_t place = 0; place < edited_.scene.fix.size(); ++place) {
      if (edit.fix && *edit.fix != edited_.numbers[list][place]) continue;
      release(place, released);
    }
  }
  template <class Change>
  void operator()(const ChangeState<Change>&) const {}

 private:
  std::size_t place_of(std::size_t list, std::size_t number) const {
    const std::vector<std::size_t>& numbers = edited_.numbers[list];
    return static_cast<std::size_t>(std::find(numbers.begin(), numbers.end(), number) -
                                    numbers.begin());
  }

  void remove(std::size_t list, std::size_t number) {
    const std::size_t place = place_of(list, number);
    if (place < edited_.numbers[list].size()) edited_.removed[list].push_back(place);
  }

  // Returns the place of the entry.
  template <class Entry>
  std::size_t set(std::vector<Entry>& entries, const SetEntry<Entry>& edit) {
    const std::size_t list = list_of(edit.entry);
    const std::size_t place = place_of(list, *edit.index);
    if (place < entries.size()) {
      entries[place] = edit.entry;
    } else {
      entries.push_back(edit.entry);
      edited_.numbers[list].push_back(*edit.index);
    }
    return place;
  }

  // The vertices that are left get the places that were given to them.
  void release(std::size_t place, const std::vector<Index>& released) {
    FixSettings& fix = edited_.scene.fix[place];
    const auto known = held_.find(place);
    const std::vector<Index> before =
        known != held_.end() ? known->second : select_vertices(mesh_, fix.select);
    std::vector<Index> left;
    std::set_difference(before.begin(), before.end(), released.begin(), released.end(),
                        std::back_inserter(left));
    if (left.size() == before.size()) return;
    const auto* named = std::get_if<SelectVertices>(&fix.select);
    SelectVertices select;
    std::vector<Vector3> targets;
    for (const Index v : left) {
      select.ids.push_back(mesh_.vertex_id(v));
      if (named == nullptr || fix.targets.empty()) continue;
      const auto at = std::find(named->ids.begin(), named->ids.end(), select.ids.back());
      targets.push_back(fix.targets.at(static_cast<std::size_t>(at - named->ids.begin())));
    }
    if (left.empty()) {
      edited_.removed[list_of(fix)].push_back(place);
    } else {
      fix.select = select;
      fix.targets = targets;
    }
    held_[place] = std::move(left);
  }

  EditedScene& edited_;
  const TetMesh& mesh_;
  std::map<std::size_t, std::vector<Index>> held_;  // if edits have changed them
};

}  // namespace

EditedScene edited_scene(const Scene& scene, const TetMesh& mesh,
                         const std::vector<MadeEdit>& made) {
  EditedScene edited;
  edited.scene = scene;
  for (const LoadKind kind : values_of<LoadKind>()) {
    edited.counts[static_cast<std::size_t>(kind)] = scene.list(kind).size();
  }
  edited.counts[list_of(FixSettings())] = scene.fix.size();
  edited.counts[list_of(ConstraintSettings())] = scene.constraint.size();
  edited.counts[list_of(ObstacleSettings())] = scene.obstacle.size();
  for (std::size_t list = 0; list < kEntryLists; ++list) {
    for (std::size_t i = 0; i < edited.counts[list]; ++i) edited.numbers[list].push_back(i);
  }
  SceneEditing editing(edited, mesh);
  for (const MadeEdit& edit : made) std::visit(editing, edit.edit);
  return edited;
}

bool has_same_mesh(const Scene& a, const Scene& b) {
  const auto same = [](const auto& first, const auto& second) {
    const SceneSection& section = section_of<std::remove_cvref_t<decltype(first)>>();
    return settings_json(section, &first) == settings_json(section, &second);
  };
  return same(a.mesh, b.mesh) && same(a.initial, b.initial);
}

}  // namespace tetraction::viewer
