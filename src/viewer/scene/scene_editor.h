// Changes the scene of a simulation, as the window's tree and inspector want it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "document/off_entries.h"
#include "document/outline.h"
#include "document/scene_changes.h"
#include "scene_texts.h"
#include "viewer/display_units.h"
#include "viewer/simulation.h"

namespace tetraction::viewer {

/// Used in the thread of the window. A change for which there is an Edit is made in the running session, and so is a
/// selection that gets a name. Any other change is made in the scene itself, and the run is set up again from its start.
class SceneEditor {
 public:
  /// `off` are entries that the file of the scene has as switched off.
  explicit SceneEditor(Simulation& simulation, std::vector<OffEntry> off = {});

  /// Takes the present settings of the simulation and the units of the window. True if they may have changed.
  bool update();
  /// The scene with the present settings. Null if a scene file cannot hold it.
  const Json& scene() const { return scene_; }
  const std::vector<OutlineGroup>& outline() const { return outline_; }
  std::vector<Field> fields(const EntryPlace& place) const;

  /// What a new entry of a list acts on: the selected vertices, or, if they are not enough for it, all of the body or of
  /// its surface. `selected` is their selection, or null. A constraint needs two vertices in any case.
  Json usual_selection(const std::string& section, const Json& selected) const;

  /// Makes a change. Returns why it is not possible; otherwise an empty text. A simulation may still refuse it later:
  /// then there is a notice, or Simulation::take_refusal(). `continues_previous`: see Simulation::edit().
  std::string change(const SceneChange& change, bool continues_previous = false);
  std::string duplicate(const EntryPlace& place);
  std::string remove(const EntryPlace& place);
  /// The events that change an entry, as "the event at 0.5 s". Empty if there are none.
  std::string events_that_change(const EntryPlace& place) const;
  /// Whether the change sets up the run again. No value if it is not possible.
  std::optional<bool> sets_up_again(const SceneChange& change) const;

  /// Switches an entry of a list off, and on again.
  std::string switch_off(const EntryPlace& place);
  std::string switch_on(std::size_t off);
  void forget(std::size_t off);
  /// Those that are not in the scene, for instance because switching off was undone.
  const std::vector<OffEntry>& off() const { return off_; }
  /// Those that do not act now, for a file.
  std::vector<OffEntry> off_now() const;
  bool is_off(const OffEntry& entry) const;

 private:
  std::string change_as(const SceneChange& change, const std::string& what,
                        bool continues_previous = false);
  struct Prepared {
    std::optional<Edit> edit;
    std::optional<NamedSelection> named;  // that is added
    Scene scene;                          // if there is neither
  };
  Prepared prepare(const SceneChange& change) const;
  std::optional<Edit> edit_of(const SceneChange& change) const;
  SceneChange with_model(const SceneChange& change) const;
  SceneChange in_edited_scene(const SceneChange& change, const EditedScene& edited) const;

  Simulation& simulation_;
  std::optional<std::size_t> shown_;  // Simulation::settings_number()
  Settings settings_;
  Scene present_;
  Json scene_;
  UnitSystem units_{};  // of the texts of the tree
  std::vector<OutlineGroup> outline_;
  std::vector<OffEntry> off_;
};

/// The scene with all edits in effect as if they held from the start, as a scene file can hold it. A run without an end
/// gets the usual one. Throws InputError for a scene that a file cannot hold.
Scene scene_with_edits(const Simulation& simulation);

}  // namespace tetraction::viewer
