// The part of a Simulation that works in the solver's thread: a session with its events, its edits
// and their recording.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "kept_states.h"
#include "recording.h"
#include "simulation.h"
#include "viewer/drags/obstacle_drag.h"
#include "viewer/drags/spring_drag.h"
#include "viewer/drags/vertex_drag.h"
#include "viewer/edits/edit_history.h"
#include "viewer/edits/numbering.h"

namespace tetraction::viewer {

/// Runs a body from the start of its scene. Not thread-safe.
class Engine {
 public:
  /// Sets up the scene and begins `recording` with it. Throws InputError.
  Engine(const Scene& scene, const TetMesh& mesh, Recording& recording);

  const Session& session() const { return *session_; }
  Settings settings() const;
  /// Those of sections alone, whose number does not grow with edits.
  ChangeableSections sections() const;
  /// The sum of the forces that edits have put on single vertices, 3 per vertex, N.
  const Vector& user_force();
  const EditHistory& edits() const { return *edits_; }

  /// If one of these functions throws InputError, nothing has changed.
  void edit(Edit edit, const std::string& what, bool continues_previous);
  /// EditHistory::make_other().
  void change_other(const std::string& what, const std::function<void(bool)>& act);
  void undo();
  void redo();
  /// A drag with the mouse: grab() begins it, drag_to() moves the first vertex to a position (m) in
  /// about `duration` seconds of simulated time (0: at once), and release() ends it. If the body cannot
  /// be moved there at once, there is a notice, and the drag goes on. drag_to() and release() have no
  /// effect if the drag has ended already or the run has failed. go_back() ends a drag in any case.
  void grab(const std::vector<Index>& vertices);
  /// A drag with a spring (SpringDrag). `critical_step` is the stability limit, s.
  void pull(const std::vector<Index>& vertices, double radius, double critical_step);
  /// A drag of an obstacle (ObstacleDrag) at its point, m.
  void grab_obstacle(std::size_t number, const Vector3& point);
  void set_pull_radius(double radius);
  /// The drag with a spring, or null.
  const SpringDrag* spring() const { return spring_ ? &*spring_ : nullptr; }
  void drag_to(const Vector3& position, double duration);
  void release();
  void make_due_events();
  /// Makes the events that are due, then one step. Returns false if the run has ended. The session's
  /// status() then has the reason.
  bool step();
  /// Throws InputError with the reason if the run has failed.
  void require_good_state() const;
  /// Session::go_back().
  void go_back();
  /// The same, then EditHistory::go_before_last().
  void go_before_last_edit();
  /// The present state, for restore().
  std::shared_ptr<const KeptState> kept_state();
  /// Goes on from a state that another engine of the same scene has kept. `recorded` is the recording
  /// of its run, whose entries after the state are left out. Stepper and solver begin anew, which is
  /// recorded as edits, `what`. Returns the edits that the user made after the state.
  std::vector<MadeEdit> restore(const KeptState& kept, Recording::Data recorded,
                                const Engine& other, const std::string& what);
  /// Whether a time, s, is the end of the run or beyond it: time.end of the scene or of its events so far.
  bool is_at_end(double time) const {
    constexpr double kRoundOff = 1e-9;
    return time >= end_ * (1.0 - kRoundOff);
  }

  /// EditHistory::forget_undone().
  void forget_undone() { edits_->forget_undone(); }

  /// The notices and marks that are new since the last call.
  std::vector<Notice> take_notices() { return std::exchange(notices_, {}); }
  /// The causes of notices that have ended since the last call.
  std::vector<std::string> take_ended_causes() { return std::exchange(ended_causes_, {}); }
  std::vector<EditMark> take_marks() { return std::exchange(marks_, {}); }
  /// The number of edits, undos and redos that succeeded since the last call.
  std::size_t take_edit_count() { return std::exchange(edit_count_, 0); }
  /// Whether settings besides those of sections() may have changed since the last call.
  bool take_entry_change() { return std::exchange(entries_changed_, false); }
  /// Whether an edit may have changed the stability limit since the last call.
  bool take_limit_change() { return std::exchange(limit_changed_, false); }

 private:
  void apply(const Edit& edit, const std::string& what, bool by_user = true);
  void take_back();
  void put_back(const KeptState& kept, Recording::Data recorded,
                const std::vector<AppliedEdit>& edits, const std::string& what);
  template <class Work>
  void with_drag(const Work& work);
  void report_refused_drag(const std::string& reason);
  void resolve_newest(Edit& edit) const;
  void report_new_warnings();
  void end_cause(const std::string& cause);

  const std::vector<EventSettings> events_;
  Recording& recording_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<EditHistory> edits_;
  // The states before the last entries of the edits, after which no step was made.
  std::vector<std::shared_ptr<const KeptState>> before_;
  std::optional<VertexDrag> drag_;
  std::optional<SpringDrag> spring_;
  std::optional<ObstacleDrag> obstacle_;
  std::string refused_drag_;      // the last notice of the drag, which is not repeated
  bool release_pending_ = false;  // the drag ended in a failed state and must be released later
  Numbering numbering_;
  std::size_t next_event_ = 0;
  double end_ = 0.0;
  ForEachList<std::optional<std::size_t>> newest_;
  std::optional<Vector> user_force_;
  std::vector<Notice> notices_;
  std::vector<std::string> ended_causes_;
  std::set<std::string> warned_causes_;  // edits with a warning that holds
  std::size_t reported_warnings_ = 0;    // number of warnings that are already notices
  std::shared_ptr<const KeptSettings> kept_settings_;  // of the last kept state
  std::vector<EditMark> marks_;
  std::string last_mark_;  // of a drag, whose edits share one
  std::size_t edit_count_ = 0;
  bool limit_changed_ = false;
  bool entries_changed_ = true;
};

}  // namespace tetraction::viewer
