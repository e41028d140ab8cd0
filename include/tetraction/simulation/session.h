// A run: the loop over time steps, its balance, and those who watch it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/balance.h"
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
  double stepping = 0.0;   ///< time steps with their balance
  double output = 0.0;     ///< observers
  double total() const { return setup + stability + stepping + output; }
};

/// An edit that was made, or an event with all its edits.
struct AppliedEdit {
  double at = 0.0;           ///< s: when it was asked for
  double time = 0.0;         ///< s: of the state it was made at
  Index step = 0;            ///< of that state
  std::string what;          ///< as JSON text
  double energy_jump = 0.0;  ///< of the total energy, J: entered as edit work
  std::string warning;       ///< for the user, or empty
};

/// The steps of a run so far.
struct StepRange {
  double smallest = 0.0;  ///< s; but for one that the end cut short; 0 before the first step
  double largest = 0.0;   ///< s
  double last = 0.0;      ///< length of the last step, s
  Index changes = 0;      ///< how often the next step was of another size
};

/// Elements with J < 0, which only some materials allow (St Venant–Kirchhoff and custom ones).
struct InvertedElements {
  Index now = 0;            ///< in the present state
  Index most = 0;           ///< largest number so far
  Index most_step = 0;      ///< step at which that was first so
  std::int64_t first = -1;  ///< number of the first one in the mesh file; −1: there was none
  double first_time = 0.0;  ///< when it was found, s
};

/// A [[fix]] as it is now.
struct PresentFix {
  FixSettings settings;
  std::vector<Index> vertices;  ///< those that it still holds, ascending
  Matrix targets;               ///< where it holds them now, m: 3 × vertices
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

/// One body moving through time: apply an edit, step, read the state. The scene's events, the
/// viewer and users of the library all go through here.
///
///     Session session(scene, mesh);
///     while (session.step()) {
///       if (...) session.apply(SetDamping{{.viscosity = 20.0}});
///       ... session.state() ...
///     }
///
/// or session.run(observers). Not for: files (io/run_recorder.h).
class Session {
 public:
  /// Sets everything up and estimates the stable step. Keeps the mesh: a copy, or with std::move()
  /// the caller's own; the arrays behind a view_mesh() must live longer than the session. Throws
  /// InputError for what the scene or the mesh does not allow.
  Session(Scene scene, TetMesh mesh);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Makes an edit between two steps: it is in force at the next one. Its jumps of energy and
  /// momentum are entered in the balance as edit work. Throws InputError, and leaves everything as it
  /// was, for what the body does not allow. `what` is kept in edits().
  void apply(const Edit& edit, const std::string& what = {});
  /// The edits made so far, the scene's events among them.
  const std::vector<AppliedEdit>& edits() const;

  /// Makes the scene's events that are due, then takes one step; the last one before the end is as long
  /// as what is left, so that the end is met exactly. Returns false when the run is over: status() tells
  /// why. A step that fails leaves the state as it was before.
  bool step();
  /// Steps to the end and calls the observers. Returns how it ended.
  RunStatus run(const std::vector<Observer*>& observers = {});

  /// From now on good states are kept, to go back to after a blow-up: a copy of the state each few
  /// steps and after each edit.
  void keep_good_states();
  /// After a run that failed: makes the last good state the present one and the run able to go on.
  /// That is the state before the step that failed; or an earlier one, if the integrator had made
  /// much energy by then and good states are kept. Goes back behind no edit. The solver begins anew,
  /// as after a SetSolver, and as such it is entered in edits(). Does nothing after a run that ended
  /// well.
  void go_back();

  /// The scene as it was at the start.
  const Scene& scene() const;
  /// Integrator, step and end as they are now.
  const TimeSettings& time_settings() const;
  /// The solver of implicit steps as it is now.
  const SolverSettings& solver_settings() const;
  /// Of each region, as they are now.
  const std::vector<MaterialSettings>& materials() const;
  const Damping& damping() const;
  const EnvironmentSettings& environment() const;
  /// By their numbers, those that edits have added at the end.
  const std::vector<ForceSettings>& forces() const;
  std::size_t fix_count() const;
  PresentFix fix(std::size_t i) const;
  /// A length that was not given is the one that is kept. Removed ones are null.
  const std::vector<std::optional<ConstraintSettings>>& constraints() const;
  const MechanicalSystem& system() const;
  const State& state() const;
  const Balance& balance() const;
  RunStatus status() const;
  /// One line on how the run ended: what, where (step, element), what to do. Empty if all is well.
  const std::string& message() const;
  /// h of the steps to come, s. The last one before the end may be shorter. time.step = "auto" changes it.
  double time_step() const;
  /// The steps taken so far.
  const StepRange& steps() const;
  /// Number of steps of the whole run: end/h, rounded up; where the step changes, those taken and those
  /// that are left; very many if there is no end.
  Index step_count() const;
  /// Whether a material is defined for J < 0, or an event may set one that is.
  bool may_invert() const;
  /// The elements that are and were inverted.
  const InvertedElements& inverted_elements() const;
  /// Stable-step estimate at the initial state: of verlet if that is the rule, else of explicit.
  const StabilityLimit& initial_limit() const;
  /// Stable-step estimate at the current state, worked out anew.
  StabilityLimit current_limit() const;
  /// Remarks for the user. Before the run: a step above the stability limit, events that never happen, a
  /// slow BLAS, nearly incompressible elements. Added during the run: the first inverted element. Added
  /// at the end: a large energy error.
  const std::vector<std::string>& warnings() const;
  /// What the constraints did during the last step (3 per vertex, N).
  const Vector& reaction_force() const;
  /// User forces of the last step; before the first, of the first (3 per vertex, N).
  Vector external_force() const;
  /// User forces at the present time: those of the next step (3 per vertex, N).
  Vector next_external_force() const;
  /// The vertices of the scene's [[constraint]] number i.
  const std::vector<Index>& constraint_vertices(std::size_t i) const;
  /// The force that pulled the ends of the scene's distance constraint number i together during the
  /// last step (negative: kept them apart), N.
  double tension(std::size_t i) const;
  /// Largest distance of a constrained vertex from where it should be, m.
  double constraint_error() const;
  /// Of the last step and of the run so far.
  int last_iterations() const;
  Index total_iterations() const;
  Index total_factorizations() const;
  Index total_cg_iterations() const;
  /// What the last implicit step solved its linear systems with: "matrix-free", "cg", "factor",
  /// "cholesky" (Ceres); empty before one.
  const std::string& linear_solver() const;
  /// Why the last implicit step's minimisation stopped.
  const std::string& solver_message() const;
  const PhaseTimes& times() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
