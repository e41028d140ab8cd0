// What a Simulation does in its own thread: a session with its events, edits and their record.
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

/// One body from its scene's start on. Not for several threads.
class Engine {
 public:
  /// Throws InputError. `recording` is cleared.
  Engine(const Scene& scene, const TetMesh& mesh, Recording& recording);

  const Session& session() const { return *session_; }
  Settings settings() const;
  const EditHistory& edits() const { return *edits_; }

  /// These throw InputError, with everything as it was.
  void edit(Edit edit, const std::string& what, bool goes_on);
  void undo();
  void redo();
  /// The mouse takes hold of vertices, leads the first of them to a place (m, to be reached in about
  /// `duration` seconds of simulated time; 0: at once), and lets go. What it does after the hold ended
  /// in another way, or while the run has failed, is nothing; a hold ends at the latest in go_back().
  void grab(const std::vector<Index>& vertices);
  void lead_to(const Vector3& place, double duration);
  void release();
  /// Makes the events that are due, then one step. False: the run has ended, status() tells how.
  bool step();
  /// Session::go_back().
  void go_back();

  /// What has come together since the last call.
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
  bool released_ = false;  // in a state in which nothing could be changed
  Numbering numbering_;
  std::size_t next_event_ = 0;
  std::optional<std::size_t> newest_force_, newest_fix_, newest_constraint_;
  std::vector<Notice> notices_;
  std::size_t told_warnings_ = 0;  // of the session
  std::vector<EditMark> marks_;
  bool limit_changed_ = false;
};

}  // namespace tetraction::viewer
