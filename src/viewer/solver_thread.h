// The thread of a Simulation, and the data that it shares with the window's thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "energy_watch.h"
#include "engine.h"
#include "guarded.h"
#include "history_log.h"
#include "speed_limiter.h"

namespace tetraction::viewer {

class SolverThread;

/// Notice::cause of the note about set_up(). The next command ends it.
inline constexpr const char* kSetUpCause = "set up";

// Commands from the window.
struct Action {
  std::function<void(SolverThread&)> act;
  bool is_edit = false;
};
struct DragTo {
  Vector3 position;
};
struct Observe {
  std::unique_ptr<Observer> observer;  // null ends the present observation
};
struct MakeEdit {
  Edit edit;
  std::string what;
  bool continues_previous = false;
};
struct ShowKept {
  double time = 0.0;  // s
};
struct Publish {};
using Command = std::variant<Action, DragTo, Observe, MakeEdit, ShowKept, Publish>;

/// Data that the window's thread and the solver's thread share. No computation is made while the lock
/// is held.
struct SharedState {
  std::deque<Command> commands;
  bool stop = false;
  bool running = false;
  bool busy = false;
  bool observed = false;
  int steps_per_snapshot = 1;
  double speed_limit = 0.0;
  double picture_interval = 0.0;  // s; 0: pictures are drawn when there is time for them
  bool pauses_at_end = false;
  bool pauses_at_energy_error = false;
  ColorField field;
  std::shared_ptr<const Snapshot> snapshot;
  std::shared_ptr<const TetMesh> mesh;  // of the snapshot
  std::shared_ptr<const Scene> scene;
  bool snapshot_taken = false;  // whether the window has read the snapshot
  Settings settings;
  std::size_t settings_number = 0;
  std::optional<std::string> refusal;  // of the last set_up() or add_selection()
  int set_ups_to_come = 0;             // whose results are not published yet
  HistoryLog history;
  KeptStates kept;
  std::vector<EditMark> marks;
  std::vector<Notice> notices;
  std::vector<std::string> ended_causes;
  std::string undo_text;
  std::string redo_text;
  std::size_t edit_count = 0;  // edits, undos and redos that have been made
  bool has_edits = false;      // whether there are edits that have not been undone
  bool edits_waiting = false;  // whether some are not in the texts and the count yet

  bool has_ended = false;  // whether the solver's thread does nothing any more

  bool idle() const { return commands.empty() && !busy && !running; }
};

/// Executes commands, makes steps while the simulation runs, and publishes snapshots.
class SolverThread {
 public:
  /// Sets up the scene in the calling thread. Throws InputError.
  SolverThread(Scene start_scene, TetMesh start_mesh);
  SolverThread(const SolverThread&) = delete;
  SolverThread& operator=(const SolverThread&) = delete;
  /// Gives up the step in progress, at the next iteration of its solver, and waits for this.
  ~SolverThread();

  const Recording& recording() const { return recording_; }
  EditedScene edited();

  void start();
  /// See Simulation::end().
  bool end(double seconds);
  void send(Command command);
  /// The shared state, locked as long as the result lives.
  auto lock() { return shared_.lock(); }
  /// Notifies the solver's thread that the shared state has changed.
  void wake() { wake_.notify_one(); }
  bool wait_until_idle(double seconds);

  // For actions, in the solver's thread. They do what the functions of Simulation say.
  Engine& engine() { return *engine_; }
  void run();
  void undo();
  void redo();
  void go_before_last_edit();
  void pull(const std::vector<Index>& vertices, double radius);
  void grab_obstacle(std::size_t number, const Vector3& point);
  void pause();
  void step_once();
  void restart();
  bool continue_shown();
  void reset();
  void go_back();
  void set_up(const Scene& scene, const std::string& what);
  void add_selection(const NamedSelection& named, const std::string& what);
  void grab(const std::vector<Index>& vertices);

 private:
  // A run that is not the present one, and what is needed to return to it.
  struct Run {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const TetMesh> mesh;
    std::unique_ptr<Engine> engine;  // null: given up because of its size
    std::vector<MadeEdit> made;      // of a run without an engine
    Recording::Data recording;
    HistoryLog history;
    KeptStates kept;
    std::vector<EditMark> marks;
    double stable_step = 0.0;
    bool passed_end = false;
    EnergyWatch energy;
    std::size_t kept_edits = 0;
    std::string what;   // the change between this run and the present one
    Index parted = -1;  // the last step that both have

    void give_up();
  };

  struct Task {
    enum class Kind { kNone, kCommand, kPublish, kStep, kEstimateLimit } kind = Kind::kNone;
    Command command{};  // of kCommand
  };

  const Session& session() const { return engine_->session(); }
  void begin();
  Run new_run(std::shared_ptr<const Scene> scene, std::shared_ptr<const TetMesh> mesh);
  Run leave_run(const std::string& what, Index parted = -1);
  void take(Run& run);
  void begin_run(Run run, const std::vector<MadeEdit>& made);
  void make_again(const std::vector<MadeEdit>& made);
  void keep_state();
  void continue_run(std::vector<Run>& from, std::vector<Run>& others);
  void limit_memory();
  bool run_change_is_last() const;
  std::string undo_text() const;
  std::string redo_text() const;
  bool has_edits() const;
  void publish_edit_results();
  void publish();
  void estimate_limit();
  void step();
  template <class Call>
  void notify_observer(const Call& call);
  void end_observation();
  void execute(const Action& action) { action.act(*this); }
  void execute(const DragTo&);
  void execute(Observe& observe);
  void execute(MakeEdit& edit);
  void execute(const ShowKept& wanted);
  void execute(const Publish&) {}
  void resume();
  void check_pauses();
  void pause_for(Pause pause);
  void end_refusal();
  void report_failure_of(const std::function<void()>& work);
  Task task_due(SharedState& shared, std::optional<Clock::time_point>& due);
  Task next_task();
  void carry_out(Task& task);
  void work();
  void ask_to_end();

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const TetMesh> mesh_;
  // All scenes and meshes that there were, because the window may still use them.
  std::vector<std::pair<std::shared_ptr<const Scene>, std::shared_ptr<const TetMesh>>> kept_;
  Recording recording_;

  // Data of the solver's thread.
  std::unique_ptr<Engine> engine_;
  std::vector<Run> undo_, redo_;
  std::shared_ptr<const KeptState> shown_;  // in place of the present state
  std::size_t kept_edits_ = 0;   // EditHistory::undo_count() at the start of the present run
  std::size_t run_changes_ = 0;  // those that are not counted as edits yet
  int set_ups_ = 0;              // those that are not published yet
  std::vector<Notice> notices_;  // for the next snapshot
  bool told_set_up_ = false;     // whether the last command was a set-up, which the user was told
  bool refused_ = false;         // whether the last command was refused
  EnergyWatch energy_;
  Pause pause_ = Pause::kNone;
  bool passed_end_ = false;  // whether the user has gone on beyond the end
  SpeedLimiter speed_limiter_;
  std::uint64_t generation_ = 0;
  std::uint64_t body_ = 0;
  Clock::time_point published_ = Clock::now();
  int steps_since_snapshot_ = 0;
  double pictured_ = -1.0;  // number of the picture interval that the last snapshot began
  bool snapshot_due_ = true;
  double stable_step_ = 0.0;
  bool limit_is_old_ = false;
  bool entries_are_old_ = true;        // in the shared settings, because the run is another one
  double limit_cost_ = 0.0;            // duration of the last estimate of the limit, s
  double stepping_since_limit_ = 0.0;  // duration of the steps since then, s
  std::unique_ptr<Observer> observer_;
  std::atomic<bool> has_observer_{false};
  bool is_in_step_ = false;

  // The solver's thread has it whenever it may change the data above, except in a step, whose state is
  // that before it, until it succeeds. end() takes it to end the observation of a step that lasts.
  std::mutex working_;
  std::unique_lock<std::mutex> work_lock_{working_, std::defer_lock};   // of the solver's thread
  std::unique_lock<std::mutex> taken_over_{working_, std::defer_lock};  // of the thread of end()

  Guarded<SharedState> shared_;
  std::condition_variable wake_;
  std::condition_variable became_idle_;
  std::condition_variable ended_;
  std::atomic<bool> gives_up_{false};  // the step in progress

  std::thread thread_;  // the last member, because it uses the others
};

}  // namespace tetraction::viewer
