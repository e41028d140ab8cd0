// A Session in a thread of its own, for a window that must never wait for it.
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

/// What the window shows of settings that may change at any time: always those in force.
struct Settings {
  std::vector<MaterialSettings> materials;  ///< of each region
  std::vector<std::string> region_names;
  Damping damping;
  EnvironmentSettings environment;
  /// `step` is the one in force also where it is automatic; `end` is infinite.
  TimeSettings time;
  SolverSettings solver;
  std::vector<ForceSettings> forces;  ///< by their numbers
  std::vector<FixSettings> fixes;     ///< by their numbers; what was released is still listed
};

/// In place of the number of a fix, force or constraint: the one that edit() added last.
inline constexpr std::size_t kNewest = std::numeric_limits<std::size_t>::max();

/// A message for the user: an edit that was refused, a warning.
struct Notice {
  enum class Kind { kRefused, kWarning } kind = Kind::kWarning;
  std::string text;
};

/// Runs a scene in its own thread. All functions return at once and may be called from one other
/// thread (the window's); edits, steps and resets are made in the order in which they were asked for,
/// between two steps. The scene's events are made at their times; one that does not fit the body as
/// it is then is refused with a notice, and the run goes on. There is no end: time.end does not
/// matter.
class Simulation {
 public:
  /// Sets the scene up in the calling thread; paused at the start. Throws InputError.
  Simulation(Scene scene, TetMesh mesh);
  /// Stops after the step in progress.
  ~Simulation();

  const TetMesh& mesh() const;
  const Scene& scene() const;  ///< as it was at the start

  void run();
  void pause();
  /// One step, then pause.
  void step();
  /// Back to the scene's start, paused. The settings that edits made by hand have changed stay as they
  /// are now, and each can be undone; vertices fixed by hand are fixed where they are at the start,
  /// unless a place was given. Moves and kicks of vertices are over.
  void restart();
  /// Back to the scene's start, paused; edits made by hand are forgotten.
  void reset();
  /// After a blow-up: makes the last good state the present one again, paused, with the history up to
  /// there. Until then edits and steps are refused.
  void go_back();
  /// A snapshot after this many steps (1 or more) while running, but no more than a few hundred a
  /// second …
  void set_steps_per_snapshot(int steps);
  /// … and not faster than this many simulated seconds a second; 0: as fast as it goes.
  void set_speed_limit(double real_time_factor);
  /// What field_values of the next snapshots hold.
  void set_color_field(ColorField field);

  /// In force at the next step. `what` is a short text for menus and the time axis: "Young's modulus
  /// 2 MPa". An edit that goes on with the one before (a slider that moves, a vertex that is dragged,
  /// several settings at once) is undone together with it, and takes its place if it still waits.
  void edit(Edit edit, std::string what, bool goes_on = false);
  /// Takes the last edit back: its settings become again what they were before, at the present time.
  /// As long as no step was made since, positions and momenta are also as before. Later, vertices
  /// whose momenta were set or that were moved get the opposite of what that gave them; vertices that
  /// were released are held where they are.
  void undo();
  void redo();
  /// The mouse takes hold of vertices, leads the first of them to a place, m, and lets go; the others
  /// keep their places beside it. While the simulation runs they move there with a bounded velocity,
  /// and stop there; while it is paused they are put there. An edit, undone as a whole.
  void grab(std::vector<Index> vertices);
  void lead_to(const Vector3& place);
  void release();
  /// Texts of the edits that undo() and redo() would act on; empty: none.
  std::string undo_text() const;
  std::string redo_text() const;

  /// From now on the observer is told of the present state (on_start) and of each step, in the
  /// solver's thread: a recording. It ends (on_finish) with the next call, null for no other, when
  /// the run is reset or fails, and with this object. What the observer throws ends it with a notice;
  /// the run goes on.
  void observe(std::unique_ptr<Observer> observer);
  /// Whether there is one, or will be as soon as the solver comes to it.
  bool observed() const;

  /// Never null; the newest.
  std::shared_ptr<const Snapshot> snapshot() const;
  Settings settings() const;
  /// Rows from number `from` on: the start and all steps since, and how often earlier rows changed:
  /// by reset(), by go_back(), and when there are so many (HistoryLog) that every second one goes.
  std::vector<HistoryRow> history(std::size_t from) const;
  std::size_t history_generation() const;
  std::vector<EditMark> marks() const;
  /// Notices since the last call.
  std::vector<Notice> take_notices();
  /// True when no command waits and no step is being made: for tests and for orderly ends.
  bool idle() const;
  /// Waits until idle or for so many seconds.
  bool wait_until_idle(double seconds) const;

  /// The scene with every edit made so far as an event at its time, which `tetraction run` replays to
  /// bitwise the same history. `end`: the present time; before the first step, the scene's own.
  Scene recorded_scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction::viewer
