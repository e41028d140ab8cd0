// A Session in its own thread, for a window that must never wait for it.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "snapshot.h"
#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {
class Observer;
}

namespace tetraction::viewer {

/// The settings that the window shows. They may change at any time and are always the present ones.
struct Settings {
  std::vector<MaterialSettings> materials;  ///< of each region
  std::vector<std::string> region_names;
  Damping damping;
  EnvironmentSettings environment;
  /// `step` is the present one even if it is automatic. `end` is infinite.
  TimeSettings time;
  SolverSettings solver;
  std::vector<ForceSettings> forces;  ///< by their numbers
  std::vector<FixSettings> fixes;     ///< by their numbers, including released ones
};

/// A number that stands for the fix, force or constraint that edit() added last.
inline constexpr std::size_t kNewest = std::numeric_limits<std::size_t>::max();

/// A message for the user: an edit that was refused, a warning.
struct Notice {
  enum class Kind { kRefused, kWarning } kind = Kind::kWarning;
  std::string text;
};

/// Runs a scene in its own thread. All functions return at once and may be called from one other
/// thread, that of the window. Edits, steps and resets are made between two steps, in the order in
/// which they were requested. The scene's events are made at their times. If the body does not
/// allow an event, the event is refused with a notice, and the run continues. The run has no end:
/// time.end is ignored.
class Simulation {
 public:
  /// Sets the scene up in the calling thread. The run is paused at the start. Throws InputError.
  Simulation(Scene scene, TetMesh mesh);
  /// Stops after the step in progress.
  ~Simulation();

  const TetMesh& mesh() const;
  const Scene& scene() const;  ///< as it was at the start

  void run();
  void pause();
  /// Makes one step, then pauses.
  void step();
  /// Returns to the scene's start and pauses. Settings that were changed by hand keep their present
  /// values, and each change can be undone. Vertices fixed by hand are fixed at their positions at
  /// the start, unless a place was given. Moves and kicks of vertices are not repeated.
  void restart();
  /// Returns to the scene's start, pauses, and drops the edits made by hand.
  void reset();
  /// After a blow-up: makes the last good state the present one, with the history up to that state,
  /// and pauses. Until this is called, edits and steps are refused.
  void go_back();
  /// While running, a snapshot is made after this many steps (1 or more), but no more than a few
  /// hundred in a second …
  void set_steps_per_snapshot(int steps);
  /// … and the run is not faster than this many simulated seconds per second. 0 means no limit.
  void set_speed_limit(double real_time_factor);
  /// Sets the field that field_values of the next snapshots hold.
  void set_color_field(ColorField field);

  /// Makes an edit, which takes effect with the next step. `what` is a short text for menus and the
  /// time axis: "Young's modulus 2 MPa". An edit may continue the one before (a slider that moves,
  /// a vertex that is dragged, several settings at once). Then both are undone together, and the
  /// edit replaces the one before if that is still waiting.
  void edit(Edit edit, std::string what, bool goes_on = false);
  /// Undoes the last edit: its settings get their earlier values at the present time. If no step
  /// has been made since, positions and momenta are restored, too. Otherwise vertices that were
  /// moved or whose momenta were set get the opposite change, and vertices that were released are
  /// fixed where they are.
  void undo();
  void redo();
  /// The mouse grips vertices, leads the first of them to a place, m, and releases them. The others
  /// keep their positions relative to it. While the simulation runs, the vertices move to the place
  /// with a bounded velocity and stop there. While it is paused, they are put there. All of this is
  /// undone as one edit.
  void grab(std::vector<Index> vertices);
  void lead_to(const Vector3& place);
  void release();
  /// Texts of the edits that undo() and redo() would act on. Empty if there is none.
  std::string undo_text() const;
  std::string redo_text() const;

  /// Starts a recording: the solver's thread calls the observer's on_start at the present state and
  /// its on_step after each step. The recording ends with on_finish at the next call of this
  /// function (null: no new observer), when the run is reset or fails, and when this object is
  /// destroyed. If the observer throws, the recording ends with a notice, and the run continues.
  void observe(std::unique_ptr<Observer> observer);
  /// Whether there is a recording, or will be as soon as the solver has started it.
  bool observed() const;

  /// The newest snapshot, never null.
  std::shared_ptr<const Snapshot> snapshot() const;
  Settings settings() const;
  /// The rows of the history (the start and all steps since) from number `from` on, and how often
  /// earlier rows have changed. They change by reset(), by go_back(), and when HistoryLog removes
  /// every second row.
  std::vector<HistoryRow> history(std::size_t from) const;
  std::size_t history_generation() const;
  std::vector<EditMark> marks() const;
  /// Notices since the last call.
  std::vector<Notice> take_notices();
  /// Whether no command is waiting and no step is being made. For tests and for closing the
  /// program.
  bool idle() const;
  /// Waits until the simulation is idle, but no longer than this many seconds.
  bool wait_until_idle(double seconds) const;

  /// The scene with every edit made so far as an event at its time. `tetraction run` replays it
  /// with bitwise the same history. Its `end` is the present time, or before the first step the
  /// scene's own.
  Scene recorded_scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction::viewer
