// A run: the loop over time steps, its balance, and its observers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/simulation/checkpoint.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

class ProbeSet;

/// Wall-clock seconds of a run by phase.
struct PhaseTimes {
  double mesh = 0.0;       ///< reading or generating the mesh, see Session::add_mesh_time()
  double setup = 0.0;      ///< rest state, sparsity, solver, initial state
  double stability = 0.0;  ///< estimates of the stable step
  double stepping = 0.0;   ///< time steps with their balance
  double output = 0.0;     ///< observers
  double total() const { return mesh + setup + stability + stepping + output; }
};

/// The present form of a [[fix]].
struct PresentFix {
  FixSettings settings;
  std::vector<Index> vertices;  ///< vertices that it still fixes, ascending
  Matrix targets;               ///< present targets, m: 3 × vertices
};

class Session;
struct LoadPath;
struct StepFailure;

/// The task of a session.
enum class Analysis {
  kMotion,      ///< the motion of the body
  kEquilibrium  ///< its equilibrium, as the load factor grows from 0 to 1 (simulation/equilibrium.h)
};

/// An observer of a run. All calls come from the thread that runs it.
class Observer {
 public:
  virtual ~Observer() = default;
  /// Called before the first step, at the initial state.
  virtual void on_start(const Session&) {}
  /// Called after each successful step. Returning false ends the run (kCancelled).
  virtual bool on_step(const Session&) { return true; }
  /// Called at the end, however the run ended, also if a step ended with an exception. The state is
  /// the last good one.
  virtual void on_finish(const Session&) {}
};

/// Moves one body through time: apply an edit, make a step, read the state. The scene's events, the
/// viewer and users of the library all use this class.
///
///     Session session(scene, mesh);
///     while (session.step()) {
///       if (...) session.apply(SetDamping{{.viscosity = 20.0}});
///       ... session.state() ...
///     }
///
/// or session.run(observers). A session writes no files; see io/run_recorder.h.
///
/// Const functions may be called from several threads at once, but not while another function runs,
/// and state() not by a material or a force term within a step.
class Session {
 public:
  /// Sets the run up and estimates the stable step. The session keeps a copy of the mesh, or with
  /// std::move() the caller's own arrays. The arrays behind a view_mesh() must live longer than the
  /// session. Throws InputError for errors in the scene or the mesh.
  ///
  /// An equilibrium begins with the body at rest without loads. Its steps are load steps, and its
  /// time is the load factor, which ends at 1. Loads, potentials and targets are those at t = 0. It
  /// has neither events, edits nor checkpoints. InputError is also thrown if a rigid motion of the
  /// body is free. `largest_increment` of the load factor, above 0 and at most 1, is for equilibria
  /// only: small increments trace how the body gives way, and find limit points that one large
  /// increment may pass. `examines_stability` is for equilibria under loads that depend on positions:
  /// whether they are examined for small motions that grow (LossOfStability).
  Session(Scene scene, TetMesh mesh, Analysis analysis = Analysis::kMotion,
          double largest_increment = 1.0, bool examines_stability = true);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Makes an edit between two steps, after the scene's events that are due. It takes effect with the next step. The
  /// balance records its jumps of energy and momenta as edit work and impulses. If the body does not allow it, InputError
  /// is thrown and nothing has changed. A run that has ended goes on after a later end. `what` is kept in edits().
  void apply(const Edit& edit, const std::string& what = {});
  /// The edits made so far, including the scene's events.
  const std::vector<AppliedEdit>& edits() const;

  /// Makes the scene's events that are due, then one step. The last step may be shorter, so that
  /// the run ends exactly at the end time. With time.retry a step that fails is made in smaller ones,
  /// and with time.adapt a step consists of what docs/theory.md says; either counts as one step.
  /// Returns false when the run is over; status() then says
  /// why. A step that fails leaves the state as it was before. An exception of a material or force
  /// term passes through; state, balance and status are then as before the step, which can be made
  /// again.
  bool step();
  /// Steps to the end and calls the observers. Returns how it ended. If a material or force term
  /// throws an exception, the run ends with kNotConverged, on_finish() is called, and the exception
  /// passes through.
  RunStatus run(const std::vector<Observer*>& observers = {});

  /// Starts keeping good states, to which go_back() can return after a blow-up: a copy of the state
  /// every few steps and after each edit.
  void keep_good_states();
  /// Makes the last good state the present one after a run that failed, so that the run can
  /// continue. This is the state before the step that failed, or an earlier one if the energy error
  /// was large by then and good states are kept. It is never a state before the last edit. The
  /// solver starts again as after a SetSolver, and edits() contains it as one. Does nothing after a
  /// run that ended well.
  void go_back();

  /// Everything that a run needs to go on from the present state. restore() continues from there
  /// with the same bits as this session continues now, on the same machine and with as many threads.
  /// For this purpose stepper and solver forget what they remember of earlier steps, as after a
  /// SetSolver, but without an entry in edits(). The next implicit step therefore computes a
  /// factor of its matrix anew, if the solver needs one, and begins with a poorer first guess.
  /// Within its tolerance its result is the same as without the checkpoint. Call it between two steps, at any time and status.
  Checkpoint checkpoint();
  /// Goes on from a checkpoint of this session, or of another one with the same mesh and scene. All
  /// that checkpoint() has is replaced: state, balance, settings, counters, edits, warnings, status.
  /// Good states (keep_good_states()) begin with the restored one. Throws InputError, and changes
  /// nothing, if the mesh, the regions of material, the densities or the names of the force terms
  /// differ, or if the checkpoint has fewer [[fix]], [[constraint]] or [[force]], or more events that
  /// were made, than this session's scene has. Other differences of the scenes are not found: the
  /// settings of the checkpoint then replace those of the scene.
  void restore(const Checkpoint& checkpoint);

  Analysis analysis() const;
  /// The results of the load steps so far; null unless the session computes an equilibrium.
  const LoadPath* load_path() const;
  /// The scene as it was at the start.
  const Scene& scene() const;
  /// All present settings that edits may change.
  const RunSettings& settings() const;
  /// The present integrator, step and end.
  const TimeSettings& time_settings() const { return settings().time; }
  /// The present solver of implicit steps.
  const SolverSettings& solver_settings() const { return settings().solver; }
  /// The present materials, one for each region.
  const std::vector<MaterialSettings>& materials() const { return settings().materials; }
  const Damping& damping() const { return settings().damping; }
  const EnvironmentSettings& environment() const { return settings().environment; }
  /// The [[force]] loads by their numbers. Those that edits have added are at the end.
  const std::vector<ForceSettings>& forces() const { return loads().force; }
  /// The loads of all kinds by their numbers.
  const LoadLists& loads() const { return settings().loads; }
  std::size_t fix_count() const { return settings().constraints.fixes.size(); }
  PresentFix fix(std::size_t i) const;
  /// The constraints by their numbers. If the length of a distance was not given, the settings hold
  /// the length that it keeps. Removed constraints are null.
  const std::vector<std::optional<ConstraintSettings>>& constraints() const {
    return settings().constraints.other_settings;
  }
  const MechanicalSystem& system() const;
  /// The present state. The addresses of this object and of its positions, momenta and velocities
  /// stay the same as long as the session lives, whatever happens, so that others may look at them.
  /// Their numbers are those of the present state after a call of this function and until the next
  /// step, edit, go_back() or restore(); after one of these call it again. The first call after a
  /// step may copy the state, about a tenth of the time of an explicit step. time() and
  /// step_number() never do.
  const State& state() const;
  /// state().time, s.
  double time() const;
  /// state().step, the number of steps made.
  Index step_number() const;
  const Balance& balance() const;
  RunStatus status() const;
  /// One line that says what ended the run, where (step, element), and what the user can do. Empty
  /// if nothing went wrong.
  const std::string& message() const;
  /// The step that failed, with its cause and the elements concerned (simulation/step_failure.h).
  /// Null unless the run ended with such a step or with a blow-up of the energy.
  const StepFailure* failure() const;
  /// Size of the next steps, s. The last one before the end may be shorter. time.step = "auto" and
  /// time.adapt change it.
  double time_step() const;
  /// The steps taken so far.
  const StepRange& steps() const;
  /// Number of steps of the whole run: end/h, rounded up. If the step changes, it is the number of
  /// steps made plus the number of steps left of the present size. It is very large if there is no
  /// end.
  Index step_count() const;
  /// Whether a material is defined for J < 0, or an event may set such a material.
  bool may_invert() const;
  /// The elements that are inverted now and those that were.
  const InvertedElements& inverted_elements() const;
  /// Stable-step estimate at the initial state, for verlet if that is the rule, otherwise for
  /// explicit.
  const StabilityLimit& initial_limit() const;
  /// Computes the stable-step estimate at the present state.
  StabilityLimit current_limit() const;
  /// Warnings for the user. Before the run they are: a step above the stability limit, events that
  /// never happen, a slow BLAS, nearly incompressible elements. The first inverted element is added
  /// during the run, and a large energy error at the end.
  const std::vector<std::string>& warnings() const;
  /// Reactions of the constraints in the last step (3 per vertex, N).
  const Vector& reaction_force() const;
  /// Reactions::delay of the same step, N s.
  const Vector& reaction_delay() const;
  /// The force of each obstacle on the body and its moment about the origin, N and N m, in the order of
  /// Contact::obstacle(), with friction: its impulses in the last step, divided by the length of the step. Before the
  /// first step, and in an equilibrium, they are the forces at the present state.
  const std::vector<ObstacleForce>& obstacle_forces() const;
  /// User forces in the last step, pressure included, or before the first step those of the first (3
  /// per vertex, N).
  Vector external_force() const;
  /// User forces at the present time: those of the next step (3 per vertex, N).
  Vector next_external_force() const;
  /// The vertices of the scene's [[constraint]] number i.
  const std::vector<Index>& constraint_vertices(std::size_t i) const;
  /// The force that pulled the ends of the scene's distance constraint number i together during the
  /// last step (negative: kept them apart), N.
  double tension(std::size_t i) const;
  /// Largest distance of a constrained vertex from its prescribed position, m.
  double constraint_error() const;
  /// Iterations of the last step and of the run so far.
  int last_iterations() const;
  Index total_iterations() const;
  Index total_factorizations() const;
  Index total_cg_iterations() const;
  /// The linear solver of the last implicit step: "matrix-free", "cg", "factor" or "cholesky"
  /// (Ceres). Empty before such a step.
  const std::string& linear_solver() const;
  /// Why the last implicit step's minimisation stopped.
  const std::string& solver_message() const;
  /// The times up to now, those of an observer that is being called included.
  PhaseTimes times() const;
  /// Adds the time, s, that the mesh took before the session was made, to times().mesh.
  void add_mesh_time(double seconds);

  /// The scene's probes. They are evaluated when an observer, or another user, asks for them.
  const ProbeSet& probes() const;
  /// The present state where it is, without a copy. Its address changes with each step.
  const State& present_state() const;
  /// external_force() without a copy. It is empty if there are no user forces.
  const Vector& present_external_force() const;

  /// The outcome of time.retry and time.adapt so far.
  const StepControl& step_control() const;
  /// Whether steps may be repeated or adapt (time.retry, time.adapt) now or after an event of the
  /// scene, and whether one of them adapts in this way.
  bool may_repeat_steps() const;
  bool may_adapt(StepAdaptation adaptation) const;
  /// Adaptive steps end at this time, s, if they come so far. The scene's events and the end are
  /// such times anyway. A caller who makes events of his own sets it before each step.
  void land_at(double time);
  /// Adds the times of an earlier part of the same run to times(), after restore().
  void add_times(const PhaseTimes& earlier);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
