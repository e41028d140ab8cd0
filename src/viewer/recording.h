// A recording of all edits, from which a run can be repeated.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "simulation.h"
#include "tetraction/simulation/session.h"
#include "viewer/edits/numbering.h"

namespace tetraction::viewer {

/// Stores all edits with their times and makes a scene of them. All functions are thread-safe.
class Recording {
 public:
  /// An edit that was made.
  struct Entry {
    Index step = 0;
    double time = 0.0;
    double time_step = 0.0;  ///< time step after the edit, s
    Edit edit;
    std::string note;
    bool by_user = true;  ///< not by an event of the scene
  };
  /// Everything that it has stored.
  struct Data {
    Scene start;
    std::vector<Entry> entries;
    Index step = 0;
    double time = 0.0;
    double first_time_step = 0.0;
    ForEachList<std::size_t> counts{};
    EntryNumbers present{};  ///< present_entries()
    std::size_t events_made = 0;
    Numbering numbering{Scene()};
  };

  explicit Recording(const Scene& scene);

  Data data() const;
  std::size_t entry_count() const;
  void restore(Data data);

  /// Begins again with a scene.
  void begin(const Scene& scene);
  /// Adds a selection to the start, if it is not there. Throws InputError if another one has its name.
  void add(const NamedSelection& named);
  /// Takes a selection out of the start, unless an edit that was made needs it.
  void remove(const NamedSelection& named);
  /// Adds an edit that the session has just made.
  void add(const Session& session, const Edit& edit, const std::string& note, bool by_user);
  /// Must be called when the session has made a step or gone back.
  void move_to(const Session& session);
  /// Must be called when the scene's first `count` events have been made. `numbering` translates the
  /// indices of the other events.
  void set_events_made(std::size_t count, const Numbering& numbering);

  /// The scene with all edits as events. Each event has the time of the state that the edit changed.
  /// The scene's own events that have not been made yet follow.
  Scene scene() const;

 private:
  void set_ends(Scene& scene) const;
  void add_events_to_come(Scene& scene) const;
  Settings present_settings() const;

  mutable std::mutex mutex_;
  Data data_;
};

}  // namespace tetraction::viewer
