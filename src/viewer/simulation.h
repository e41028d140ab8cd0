// A Session in its own thread, so that the window never has to wait for it.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/edited_scene.h"
#include "snapshot.h"
#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {
class Observer;
}

namespace tetraction::viewer {

/// The present settings, which the window shows.
struct Settings : ChangeableSections {
  // `time.step` is the present time step, also if it is automatic. `time.end` is infinite.
  std::vector<MaterialSettings> materials;  ///< per region
  std::vector<LameRange> moduli;  ///< per region: the small-strain parameters of its elements
  double mean_density = 0.0;      ///< of the whole body, kg/m³
  std::vector<std::string> region_names;
  LoadLists loads;
  std::vector<FixSettings> fixes;  ///< with those that have been released
  std::vector<std::optional<ConstraintSettings>> constraints;  ///< null: removed
  std::vector<BodyObstacle> obstacles;                         ///< with those that were removed
  EntryNumbers present;  ///< present_entries() without loads whose addition was undone
};

/// An index that stands for the fix, force or constraint that edit() added last.
inline constexpr std::size_t kNewest = std::numeric_limits<std::size_t>::max();

/// A message for the user.
struct Notice {
  enum class Kind { kRefused, kWarning, kNote } kind = Kind::kWarning;
  std::string text;
  /// What it is about. A later notice of the same cause replaces it, and it goes with its cause
  /// (Simulation::take_ended_causes()). Empty: it stays until the user closes it.
  std::string cause{};
};

/// A warning of the library as a sentence. Such warnings begin like the rest of a line of the terminal, or with a key of
/// the scene.
std::string sentence(std::string warning);

/// The settings of a moment with the scene that they belong to.
struct Present {
  std::size_t number = 0;  ///< Simulation::settings_number()
  Settings settings;
  std::shared_ptr<const Scene> start;  ///< without the edits
};

/// Runs a scene in its own thread. The functions must be called from one thread, that of the window.
/// They return at once. Their commands are executed between two steps, in the order of the calls. The
/// scene's events are made at their times. If the session refuses an event, there is a notice, and the
/// run continues. It goes on beyond time.end, unless set_pauses() says otherwise.
class Simulation {
 public:
  /// Sets up the scene in the calling thread. The run is paused. Throws InputError.
  Simulation(Scene scene, TetMesh mesh);
  /// Gives up the step in progress, and waits for this.
  ~Simulation();

  /// Gives up the step in progress and ends the recording. Nothing may be asked of the simulation after
  /// that. Returns false if the solver does not answer within these seconds, because it factorises a
  /// large matrix, for instance. The files of the recording are then complete with the state before
  /// that step, or, if its steps adapt or are repeated (time.adapt, time.retry), without summary and
  /// final state. The program may end without the destructor, which would wait for the solver.
  bool end(double seconds);

  /// The mesh of the newest snapshot, and the scene without the edits. They stay valid as long as this object,
  /// also after set_up().
  const TetMesh& mesh() const;
  const Scene& scene() const;

  void run();
  void pause();
  /// Makes the events of the scene that are due now, which otherwise the next step would do.
  void make_due_events();
  /// Makes one step, then pauses.
  void step();
  /// Returns to the scene's start and pauses. Settings that the user changed keep their present
  /// values. Vertices that the user fixed are fixed at their positions at the
  /// start, unless a target was given. Changes of positions and momenta are not repeated.
  void restart();
  /// Returns to the scene's start, pauses, and removes the user's edits.
  void reset();
  /// Pauses and shows the kept state nearest to a time (Snapshot::earlier), or the present one at its
  /// time and later. run(), step(), edits, drags and recordings then continue from the state that is
  /// shown, with the settings of now; undo() brings back the run as it was. A recording ends there. The
  /// other commands return to the present state first.
  void show_at(double time);
  /// Continues from the state that is shown, paused.
  void continue_here();
  /// The times of the kept states, s, in ascending order.
  std::vector<double> kept_times() const;
  /// Whether a running simulation pauses at time.end, and when the energy error passes a hundredth of
  /// the energy that entered (EnergyWatch). Snapshot::pause then says why. run() goes on.
  void set_pauses(bool at_end, bool at_energy_error);
  /// Undoes the last edit and brings back the positions and momenta before it, after a failure, too.
  /// The time goes on. Does nothing unless Snapshot::knows_last_edit.
  void go_before_last_edit();
  /// Returns to the last good state after a failure, with the history up to that state, and pauses.
  /// After a failure edits and steps are refused until this function is called.
  void go_back();
  /// Sets the number of steps (1 or more) between two snapshots of a running simulation. There are at
  /// most a few hundred snapshots per second.
  void set_steps_per_snapshot(int steps);
  /// Limits the simulated seconds per real second. 0 means no limit.
  void set_speed_limit(double real_time_factor);
  /// Makes a snapshot of the first state at or after each multiple of this time, s, and waits with the
  /// next step until it has been read. 0 ends this.
  void set_picture_interval(double interval);
  /// Sets the field of Snapshot::field_values in the next snapshots.
  void set_color_field(ColorField field);

  /// Makes an edit, which takes effect with the next step. `what` is a short text for menus and the time
  /// axis, such as "Young's modulus 2 MPa". An edit may continue the previous one, for instance while a
  /// slider moves. Then both are undone together, and the edit replaces the previous one if that has
  /// not been made yet.
  void edit(Edit edit, std::string what, bool continues_previous = false);
  /// Sets up a scene in place of the present one, pauses at its start and makes a notice. All edits
  /// have to be in that scene (edited_scene()). If the scene cannot be set up, nothing changes, and
  /// take_refusal() has the reason.
  void set_up(Scene scene, std::string what);
  /// Adds a named selection to the scene, as one entry of undo(). Nothing uses it yet, so that the run goes on. If
  /// the name is taken, take_refusal() says so.
  void add_selection(NamedSelection named, std::string what);
  /// Why set_up() or add_selection() did not succeed. No value if there is no news.
  std::optional<std::string> take_refusal();

  /// Undoes the last edit, restart() or set_up(). After the last two the run is as it was before, with its
  /// history and its edits. Otherwise the settings get their earlier values at the present time. If no step has
  /// been made since the edit, positions and momenta are restored, too. Otherwise an edit of positions
  /// or momenta is undone by the opposite change, and vertices that were released are fixed at their
  /// present positions.
  void undo();
  void redo();
  /// A drag with the mouse: grab() begins it, drag_to() moves the first vertex to a position (m), and
  /// release() ends it. The other vertices keep their positions relative to the first. While the
  /// simulation runs, the vertices move with a bounded velocity. While it is paused, they are moved at
  /// once. The whole drag is undone as one edit.
  void grab(std::vector<Index> vertices);
  /// The same with a damped spring instead of an exact constraint (SpringDrag): the body gives way. It
  /// pulls all vertices within `radius` (m at rest; 0: the usual one), which may change meanwhile.
  void pull(std::vector<Index> vertices, double radius = 0.0);
  void set_pull_radius(double radius);
  /// The same for an obstacle (ObstacleDrag), whose point (m) follows the mouse.
  void grab_obstacle(std::size_t number, const Vector3& point);
  void drag_to(const Vector3& position);
  void release();
  /// Texts of the edits that undo() and redo() would process. Empty if there is none.
  std::string undo_text() const;
  std::string redo_text() const;

  /// The number of edits, undos and redos that have been made since the scene was set up.
  std::size_t edit_count() const;
  /// Whether there are edits that have not been undone, and one of them, an undo or a redo came after the
  /// first `count`. Edits that are still to be made are taken into account.
  bool edited_since(std::size_t count) const;

  /// Starts a recording: the solver's thread calls the observer's on_start at the present state and
  /// its on_step after each step. The recording ends with on_finish at the next call of this
  /// function, when the run is reset or fails, and when this object is destroyed. A null pointer ends
  /// the present recording only. If the observer throws, the recording ends with a notice, and the run continues.
  void observe(std::unique_ptr<Observer> observer);
  /// Whether there is a recording, or the solver has still to start it.
  bool observed() const;

  /// The newest snapshot. It is never null. The solver makes the next one only after this.
  std::shared_ptr<const Snapshot> snapshot() const;
  /// The same for someone who only looks: the next snapshot waits for the one who draws.
  std::shared_ptr<const Snapshot> peek() const;
  /// Its number of the run, Snapshot::body.
  std::uint64_t body() const;
  Settings settings() const;
  /// A counter that increases when the settings may have changed.
  std::size_t settings_number() const;
  Present present() const;
  /// The scene with all edits so far as if they held from its start. It is made when it is asked for, because
  /// this takes longer the more edits there are. Waits for the command in progress, but not for a step.
  EditedScene edited_scene() const;
  /// Whether set_up() was called and has not been executed yet.
  bool is_setting_up() const;
  /// The rows of the history from index `from` on. Row 0 is the start.
  std::vector<HistoryRow> history(std::size_t from) const;
  /// A counter that increases when earlier rows are removed: by restart(), reset(), go_back(), and
  /// when HistoryLog removes every second row.
  std::size_t history_generation() const;
  std::vector<EditMark> marks() const;
  /// The notices that are new since the last call.
  std::vector<Notice> take_notices();
  /// The causes of notices that do not exist any more, new since the last call. Notices that are not
  /// taken yet do not have them.
  std::vector<std::string> take_ended_causes();
  /// Whether no command is waiting and no step is being made.
  bool idle() const;
  /// Waits until the simulation is idle, but no longer than this many seconds.
  bool wait_until_idle(double seconds) const;

  /// The scene with all edits so far as events. `tetraction run` replays it with a bitwise identical
  /// history. Its end is the present time. Before the first step it is the end of the original scene.
  Scene recorded_scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction::viewer
