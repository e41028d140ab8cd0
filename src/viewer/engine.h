// The work of a Simulation in its own thread: a session with its events, its edits and their
// record.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edit_history.h"
#include "numbering.h"
#include "recording.h"
#include "simulation.h"
#include "vertex_drag.h"

namespace tetraction::viewer {

/// Runs one body from the start of its scene. To be used by one thread only.
class Engine {
 public:
  /// Throws InputError. `recording` is cleared.
  Engine(const Scene& scene, const TetMesh& mesh, Recording& recording);

  const Session& session() const { return *session_; }
  Settings settings() const;
  const EditHistory& edits() const { return *edits_; }

  /// If these functions throw InputError, nothing has changed.
  void edit(Edit edit, const std::string& what, bool goes_on);
  void undo();
  void redo();
  /// The mouse grips vertices, leads the first of them to a place (m) within about `duration`
  /// seconds of simulated time (0: at once), and releases them. These calls have no effect if the
  /// grip has ended in another way or if the run has failed. go_back() ends a grip in any case.
  void grab(const std::vector<Index>& vertices);
  void lead_to(const Vector3& place, double duration);
  void release();
  /// Makes the events that are due, then one step. Returns false if the run has ended; status()
  /// then says how.
  bool step();
  /// Session::go_back().
  void go_back();

  /// The notices and marks since the last call.
  std::vector<Notice> take_notices() { return std::exchange(notices_, {}); }
  std::vector<EditMark> take_marks() { return std::exchange(marks_, {}); }
  /// Whether an edit may have changed the stability limit since the last call.
  bool take_limit_change() { return std::exchange(limit_changed_, false); }

 private:
  void apply(const Edit& edit, const std::string& what);
  void make_due_events();
  template <class Work>
  void with_drag(const Work& work);
  void resolve_newest(Edit& edit) const;
  void remember_newest(const Edit& edit, const Counts& before);
  void require_good_state() const;
  void tell_warnings();

  const std::vector<EventSettings> events_;
  Recording& recording_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<EditHistory> edits_;
  std::optional<VertexDrag> drag_;
  bool released_ = false;  // the grip was released in a state that could not be changed
  Numbering numbering_;
  std::size_t next_event_ = 0;
  std::optional<std::size_t> newest_force_, newest_fix_, newest_constraint_;
  std::vector<Notice> notices_;
  std::size_t told_warnings_ = 0;  // number of the session's warnings that were reported
  std::vector<EditMark> marks_;
  bool limit_changed_ = false;
};

}  // namespace tetraction::viewer
