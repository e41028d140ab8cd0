// A record of all edits of a scene, from which the run can be repeated.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "numbering.h"
#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Stores all edits with their times and makes a scene from them. The functions may be called from
/// any thread.
class Recording {
 public:
  explicit Recording(Scene scene);

  /// Forgets everything (reset).
  void clear();
  /// Records an edit that the session has just made.
  void add(const Session& session, const Edit& edit, const std::string& note);
  /// To be called when the session has made a step or gone back.
  void move_to(const Session& session);
  /// The scene's first `count` events are over. Later edits of events are numbered accordingly.
  void set_events_made(std::size_t count, const Numbering& numbering);

  /// The scene with all edits as events, each at the time of the state that it changed, together
  /// with the scene's own events that are still to come.
  Scene scene() const;

 private:
  struct Entry {
    Index step = 0;
    double time = 0.0;
    double time_step = 0.0;  // step from that time on, s
    Edit edit;
    std::string note;
  };

  void set_ends(Scene& scene) const;
  void add_events_to_come(Scene& scene) const;

  const Scene start_;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  Index step_ = 0;
  double time_ = 0.0;
  double first_time_step_ = 0.0;
  Counts counts_;
  std::size_t events_made_ = 0;
  Numbering numbering_;
};

}  // namespace tetraction::viewer
