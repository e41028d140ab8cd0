// The thread behind a Simulation: what both sides share, and the solver's side of it.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "engine.h"
#include "guarded.h"
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

/// What the window's thread and the solver's thread share. The lock is never held while something is
/// worked out.
struct SharedState {
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

  bool idle() const { return commands.empty() && !busy && !running; }
};

/// Carries out commands, makes steps while running, publishes snapshots.
class SolverThread {
 public:
  /// Sets the scene up in the calling thread. Throws InputError.
  SolverThread(Scene start_scene, TetMesh start_mesh);
  SolverThread(const SolverThread&) = delete;
  SolverThread& operator=(const SolverThread&) = delete;
  /// Stops after the step in progress.
  ~SolverThread();

  const Scene& scene() const { return scene_; }
  const TetMesh& mesh() const { return mesh_; }
  const Recording& recording() const { return recording_; }

  void start();
  void send(Command command);
  /// The shared state, locked as long as the result lives.
  auto lock() { return shared_.lock(); }
  /// Tells the solver's thread that the shared state has changed.
  void wake() { wake_.notify_one(); }
  bool wait_until_idle(double seconds);

 private:
  struct Task {
    enum class Kind { kNone, kCommand, kPublish, kStep, kEstimateLimit } kind = Kind::kNone;
    Command command{};  // of kCommand
  };

  const Session& session() const { return engine_->session(); }
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
  void report_failure_of(const Work& work);
  Task task_due(SharedState& shared, std::optional<Clock::time_point>& due);
  Task next_task();
  void carry_out(Task& task);
  void work();

  const Scene scene_;
  const TetMesh mesh_;
  Recording recording_;

  // Of the solver's thread alone.
  std::unique_ptr<Engine> engine_;
  Pace pace_;
  std::uint64_t generation_ = 0;
  std::uint64_t body_ = 0;
  Clock::time_point published_ = Clock::now();
  int steps_since_snapshot_ = 0;
  bool snapshot_due_ = true;
  double stable_step_ = 0.0;
  bool limit_is_old_ = false;
  double limit_cost_ = 0.0;            // s of the last estimate
  double stepping_since_limit_ = 0.0;  // s
  std::unique_ptr<Observer> observer_;

  Guarded<SharedState> shared_;
  std::condition_variable wake_;
  std::condition_variable became_idle_;

  std::thread thread_;  // the last: it uses all of the above
};

}  // namespace tetraction::viewer
