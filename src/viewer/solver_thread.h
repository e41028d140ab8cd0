// The thread behind a Simulation: what both sides share, and the solver's side of it.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "engine.h"
#include "history_log.h"
#include "pace.h"

namespace tetraction::viewer {

// What the window asks for, in the order in which it does.
struct Run {};
struct Pause {};
struct Step {};
struct Restart {};
struct Reset {};
struct GoBack {};
struct Grab {
  std::vector<Index> vertices;
};
struct LeadTo {
  Vector3 place;
};
struct Release {};
struct Undo {};
struct Redo {};
struct NewSnapshot {};
struct Observe {
  std::unique_ptr<Observer> observer;  // null: none from now on
};
struct MakeEdit {
  Edit edit;
  std::string what;
  bool goes_on = false;
};
using Command = std::variant<Run, Pause, Step, Restart, Reset, GoBack, Grab, LeadTo, Release, Undo,
                             Redo, NewSnapshot, Observe, MakeEdit>;

/// Carries out commands, makes steps while running, publishes snapshots. The window's side uses
/// send() and, under the mutex, what both sides share.
struct SolverThread {
  /// Sets the scene up in the calling thread. Throws InputError.
  SolverThread(Scene start_scene, TetMesh start_mesh);

  const Scene scene;
  const TetMesh mesh;
  Recording recording;

  // Of the solver's thread alone.
  std::unique_ptr<Engine> engine;
  Pace pace;
  std::uint64_t generation = 0;
  std::uint64_t body = 0;
  Clock::time_point published = Clock::now();
  int steps_since_snapshot = 0;
  bool snapshot_due = true;
  double stable_step = 0.0;
  bool limit_is_old = false;
  double limit_cost = 0.0;            // s of the last estimate
  double stepping_since_limit = 0.0;  // s
  std::unique_ptr<Observer> observer;

  // Of both, under the mutex, which is never held while something is worked out.
  mutable std::mutex mutex;
  std::condition_variable wake;
  mutable std::condition_variable became_idle;
  std::deque<Command> commands;
  bool stop = false;
  bool running = false;
  bool busy = false;
  bool observed = false;
  int steps_per_snapshot = 1;
  double speed_limit = 0.0;
  ColorField field = ColorField::kNone;
  std::shared_ptr<const Snapshot> snapshot;
  bool snapshot_taken = false;  // by the window
  Settings settings;
  HistoryLog history;
  std::vector<EditMark> marks;
  std::vector<Notice> notices;
  std::string undo_text;
  std::string redo_text;

  std::thread thread;  // the last: it uses all of the above

  bool idle() const { return commands.empty() && !busy && !running; }
  void send(Command command);
  /// The solver's thread, until `stop`.
  void work();

 private:
  const Session& session() const { return engine->session(); }
  void begin();
  void hand_out();
  void publish();
  void estimate_limit();
  void halt();
  void step();
  template <class Call>
  void tell_observer(const Call& call);
  void end_observation();
  void require_good_state() const;
  void execute(const Run&);
  void execute(const Pause&);
  void execute(const Step&);
  void execute(const Restart&);
  void execute(const Reset&);
  void execute(const GoBack&);
  void execute(const Grab&);
  void execute(const LeadTo&);
  void execute(const Release&);
  void execute(const Undo&);
  void execute(const Redo&);
  void execute(const NewSnapshot&);
  void execute(Observe& observe);
  void execute(MakeEdit& edit);
  template <class Work>
  void guarded(const Work& work);
  bool work_once(std::unique_lock<std::mutex>& lock, std::optional<Clock::time_point>& due);
};

}  // namespace tetraction::viewer
