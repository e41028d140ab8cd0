// A run: the loop over time steps, its books, and those who watch it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/books.h"
#include "tetraction/dynamics/stability.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

/// How a run stands or ended.
enum class RunStatus {
  kRunning,
  kFinished,      ///< the end time was reached
  kUnstable,      ///< the energy or the positions blew up, or an element inverted
  kNotConverged,  ///< an implicit step's minimisation did not converge
  kCancelled      ///< an observer asked to stop
};

/// "running", "ok", "unstable", "failed", "cancelled": the words of summary.json and study.csv.
std::string to_string(RunStatus status);

/// Exit code of a program whose run ended so: 0 finished, 1 failed numerically, 130 interrupted.
int exit_code(RunStatus status);

/// Wall-clock seconds of a run by phase.
struct PhaseTimes {
  double setup = 0.0;      ///< rest state, sparsity, solver, initial state
  double stability = 0.0;  ///< estimates of the stable step
  double stepping = 0.0;   ///< time steps with their books
  double output = 0.0;     ///< observers
  double total() const { return setup + stability + stepping + output; }
};

class Session;

/// Watches a run. All calls come from the thread that runs it.
class Observer {
 public:
  virtual ~Observer() = default;
  /// Before the first step, at the initial state.
  virtual void on_start(const Session&) {}
  /// After each step that went well. Returning false ends the run (kCancelled).
  virtual bool on_step(const Session&) { return true; }
  /// At the end, however the run ended; the state is the last good one.
  virtual void on_finish(const Session&) {}
};

/// One body moving through time as a scene says.
///
///     Session session(scene, mesh);
///     while (session.step()) { ... session.state() ... }
///
/// or session.run(observers). Not for: files (io/run_recorder.h).
class Session {
 public:
  /// Sets everything up and estimates the stable step. Throws InputError for what the scene or the
  /// mesh does not allow.
  Session(Scene scene, const TetMesh& mesh);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Takes one step. Returns false when the run is over: status() tells why. A step that fails
  /// leaves the state as it was before.
  bool step();
  /// Steps to the end and calls the observers. Returns how it ended.
  RunStatus run(const std::vector<Observer*>& observers = {});

  const Scene& scene() const;
  const MechanicalSystem& system() const;
  const State& state() const;
  const Books& books() const;
  RunStatus status() const;
  /// One line on how the run ended: what, where (step, element), what to do. Empty if all is well.
  const std::string& message() const;
  /// h, s.
  double time_step() const;
  /// Number of steps of the whole run: end/h, rounded.
  Index step_count() const;
  /// Stable-step estimate at the initial state.
  const StabilityLimit& initial_limit() const;
  /// Stable-step estimate at the current state, worked out anew.
  StabilityLimit current_limit() const;
  /// A remark for the user before the run starts (a step above the stability limit), or empty.
  const std::string& warning() const;
  /// Forces that hold the fixed DOFs during the last step (3 per vertex, N).
  const Vector& reaction_force() const;
  /// Largest |q_i − c_i| over the fixed DOFs, m.
  double constraint_error() const;
  /// Of the last step and of the run so far.
  int last_iterations() const;
  Index total_iterations() const;
  Index total_factorizations() const;
  /// Why the last implicit step's minimisation stopped.
  const std::string& solver_message() const;
  const PhaseTimes& times() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
