// The data of a Session, used by stepping (session.cc) and editing (session_edits.cc).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/inverted_elements.h"

#include "automatic_step.h"
#include "load_stepping.h"
#include "simulation/scene/body_constraints.h"
#include "simulation/scene/initial_state.h"
#include "state_buffers.h"
#include "step_controller.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/step_failure.h"
#include "tetraction/simulation/stop_request.h"

namespace tetraction {

/// Measures the time from its construction to its destruction and adds it to a phase.
class PhaseTimer {
 public:
  using Clock = std::chrono::steady_clock;
  explicit PhaseTimer(double& phase) : phase_(phase), start_(Clock::now()) {}
  ~PhaseTimer() { phase_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double& phase_;
  Clock::time_point start_;
};

struct Session::Impl {
  Scene scene;
  RunSettings settings;
  std::vector<SharedDistance> shared;  // of settings.constraints
  RunProgress progress;
  StateBuffers states;

  // The last good state since the last edit, if good states are kept.
  struct GoodState {
    State state;
    BalanceSums balance;
    StepPlan plan;
  };
  bool keeps_good_states = false;
  GoodState good;

  PhaseTimes times;
  // The beginning of the calls of observers that are being made.
  std::optional<PhaseTimer::Clock::time_point> observed_since;
  std::unique_ptr<MechanicalSystem> system;
  std::unique_ptr<Stepper> stepper;
  // Of the last step that did not fail, as those of Stepper.
  Reactions reactions;
  Vector trial_external_force;  // of the step that is being made
  std::unique_ptr<Balance> balance;
  BalanceSums balance_before;  // the last step; a member in order to avoid allocations

  // Of steps that are repeated or adapt (session_adaptation.cc). All of it belongs to one step.
  std::unique_ptr<Stepper> whole_stepper;  // of the steps that are compared with two halves
  struct WorkStates {
    State middle;  // between two halves, or in the middle of a step
    State whole;   // after the step that is compared with its halves
  };
  WorkStates work_states;
  double rest_diagonal =
      0.0;  // of the box around the body at rest, m; made when it is first needed
  double landing = std::numeric_limits<double>::infinity();  // see Session::land_at()
  std::vector<const StopRequest*> stop_requests;  // of the observers, while run() is running
  StabilityLimit initial_limit;
  std::optional<BodyIdentity> body;  // made when the first checkpoint needs it

  // Of an equilibrium; null for a motion. The stepper of load steps is `stepper`.
  std::optional<StepFailure> failed_step;  // of which the message is
  std::optional<double> limit_of_failure;  // present_limit() while a message is being made

  std::unique_ptr<LoadStepping> loading;
  const StaticProblem* equilibrium_problem = nullptr;

  std::unique_ptr<StabilityTracker> tracker;            // made when "auto" first needs it
  std::unique_ptr<InversionCounter> inversion_counter;  // null if no material allows it
  std::unique_ptr<const ProbeSet> probes;

  /// Measures the time of observers. They can ask for it meanwhile.
  class ObserverTimer {
   public:
    explicit ObserverTimer(Impl& session) : session_(session) {
      session_.observed_since = PhaseTimer::Clock::now();
    }
    ~ObserverTimer() {
      session_.times.output += session_.observed_seconds();
      session_.observed_since.reset();
    }
    ObserverTimer(const ObserverTimer&) = delete;
    ObserverTimer& operator=(const ObserverTimer&) = delete;

   private:
    Impl& session_;
  };
  /// Time since the observers are being called, s; 0 if they are not.
  double observed_seconds() const {
    if (!observed_since) return 0.0;
    return std::chrono::duration<double>(PhaseTimer::Clock::now() - *observed_since).count();
  }

  /// The present state.
  const State& state() const { return states.present(); }
  AutomaticStep automatic() { return AutomaticStep(progress.plan.automatic); }

  /// Sets the step from the settings, and for "auto" from the stability limit. Throws InputError.
  void choose_step(const StabilityLimit& limit, CriticalModes modes);
  /// Starts steps of this size at the present state.
  void set_time_step(double step);
  /// Number of steps left with this size, including a shorter last one.
  Index steps_to_end(double step) const;
  /// With "auto": estimates the limit at the present state from the last modes. Also gives the cost
  /// of the estimate in steps.
  double tracked_limit(double& cost);
  /// With "auto": sets the step after an edit that may have changed the limit.
  void renew_automatic_step(const StabilityLimit& limit, CriticalModes modes);
  /// With "auto": twice the step that resolves the damping of single vertices; infinite without it.
  double damping_limit() const;
  /// The limit that "auto" follows: that of stability, or damping_limit() if it is smaller.
  double automatic_limit(const StabilityLimit& limit) const;
  /// Whether the step follows the limit ("auto") with the present settings.
  bool is_automatic() const;
  /// With "auto": estimates the limit if an estimate is due. Returns false if the run is over.
  bool follow_limit();
  /// One step. With "auto" it fails, without any effect, if the energy error changes in it by more
  /// than `most_energy_share` of the energy that entered. The share is in the result, or 0.
  struct Attempt {
    StepOutcome outcome;
    double energy_share = 0.0;
  };
  Attempt attempt(double most_energy_share);
  /// Makes one step as the settings say. If "auto" finds that it was too large, it is repeated with
  /// smaller sizes.
  StepOutcome advance();
  StepOutcome advance_in_smaller_steps(const Attempt& first);
  /// The length and the end of the next step of the plan, s.
  struct Span {
    double length = 0.0;
    double end = 0.0;
  };
  Span planned_span() const;
  /// Enters the length of a step that was accepted, s.
  void enter_length(double length, bool is_cut_short);

  // Steps that are repeated or adapt.
  bool adapts() const { return settings.time.adapt != StepAdaptation::kNone; }
  /// Whether the steps are bounded by the stability limit, which is followed.
  bool follows_limit() const;
  /// The largest share of the stability limit that an adaptive step may have. Its halves are then as
  /// long as the steps of "auto".
  static constexpr double kStableShare = 0.9;
  /// The bounds of adaptive steps at the present state, s.
  StepBounds bounds_of_steps() const;
  /// Adds a warning, once, if the stability limit needs steps smaller than time.min_step.
  void warn_of_smaller_steps();
  /// The next time at which an adaptive step must end, s.
  double next_landing() const;
  /// The step of this length, or the one that ends exactly at the landing if the difference is
  /// negligible.
  Span span_of(double length, double landing_time) const;
  /// time.retry: makes the step of the plan in smaller ones after it failed.
  StepOutcome advance_in_halves(StepOutcome failure);
  /// time.retry: whether the integrator has added too much energy in the step that was entered last:
  /// a tenth of the energy that entered the body, if the energy error is now larger than that energy.
  /// Says so in the outcome. `error_before`: the energy error before the step, J.
  bool refuse_energy(StepOutcome& outcome, double error_before) const;
  /// time.adapt = "error"
  StepOutcome advance_by_error();
  /// Two halves of a step, and the error of their result relative to the body's diagonal.
  struct Halves {
    StepOutcome first;
    StepOutcome second;  // of the whole step if that one failed
    double error = 0.0;
    Reactions reactions;
  };
  Halves try_halves(const Span& span);
  void accept_halves(const Halves& halves, const Span& span);
  /// time.adapt = "energy"
  StepOutcome advance_by_energy();
  /// A step of the rule with its discrete energy, J, and half of the work that is no potential's, J.
  struct EnergyTrial {
    StepOutcome outcome;
    double energy = 0.0;
    double half_work = 0.0;
    double magnitude = 0.0;  // sum of the magnitudes of all energies
  };
  EnergyTrial try_energy(const Span& span);
  /// The energy of a state with all potentials, J. `magnitude`: the sum of their magnitudes. NaN
  /// where it is not defined.
  double full_energy(const State& at, double& magnitude) const;
  /// The solver's iterations so far, of which those of all attempts count for a step.
  struct Work {
    Index iterations = 0;
    Index factorizations = 0;
    Index cg_iterations = 0;
  };
  Work work_so_far() const;
  void report_work_since(const Work& before);
  /// Whether the present time settings, or those that an event of the scene sets, are such.
  bool any_time_settings(const std::function<bool(const TimeSettings&)>& are_such) const;
  /// Adds a warning about settings of adaptive steps without such steps.
  void warn_of_unused_settings();
  /// Adds warnings about steps that were repeated, or that did not meet what adapts them.
  void warn_of_step_control();
  /// Makes the events that are due, and one step with all that belongs to it. Returns false when the
  /// run is over.
  bool step();
  /// Called between the parts of a step and the attempts at it. If an observer wants the run to
  /// stop, it is cancelled. The caller then returns without a change of the state.
  bool cancelled_within_step();
  /// Sets up an equilibrium.
  void begin_equilibrium(double largest_increment, bool examines_stability);
  void enter_equilibrium(const State& at);
  /// One load step. Returns false if there is none.
  bool load_step();
  /// Throws InputError if the session computes an equilibrium, which has none of `what`.
  void require_motion(const char* what) const;
  /// Enters what the solver did in a step.
  void count(const MinimizerReport& report);
  /// Ends a run whose step ended with the exception that is being handled.
  void fail_with_exception();
  /// Makes a stepper that remembers nothing of earlier steps.
  void renew_stepper();
  /// See Session::next_external_force().
  Vector next_external_force() const;
  /// Makes states.other() the present state, with the forces of the step that led to it.
  void accept_step();
  /// Counts inverted elements if materials allow them. If the state is the result of a small step,
  /// its elastic energy is given. Null means any other state, or new materials.
  void count_inverted(const double* energy_after_step);
  void warn_of_inverted_corners();
  /// Makes the counter of inverted elements for the present materials.
  std::unique_ptr<InversionCounter> make_inversion_counter() const;
  /// Adds warnings about a large energy error, and about events for which no step was left.
  void warn_at_the_end();
  /// A warning about a step above the limit, or an empty text.
  std::string step_warning(const StabilityLimit& limit) const;
  /// Adds warnings about nearly incompressible and unstable materials.
  void warn_of_materials();
  /// Adds a warning about a slow BLAS if the steps are implicit at the start or after an event.
  void warn_of_blas();
  /// Adds warnings about events that are too early or too late.
  void warn_of_events();
  /// Adds warnings about loads that never act.
  void warn_of_loads();
  /// Adds a warning about distances that are given more than once.
  void warn_of_repeated_constraints();
  void apply(const Edit& edit, double at, const std::string& what);
  /// Makes the events that are due. Returns false if one of them could not be made.
  bool apply_events();
  /// The identity of the body, computed once.
  const BodyIdentity& identity();
  /// Throws InputError if the checkpoint does not belong to this body and scene.
  void require_own(const Checkpoint& checkpoint);

  std::int64_t element_id(Index e) const;
  std::string limit_advice() const;
  // A note if a vertex is or was so near a singular centre that its energy there is meaningless.
  std::string center_note();
  /// Computes the stability limit of the present rule.
  StabilityLimit limit_at(const Vector& q, CriticalModes* modes = nullptr) const;
  /// The same, with its time.
  StabilityLimit current_limit(const Vector& q, CriticalModes* modes = nullptr);
  /// Ends the run because of a step that cannot be made, or because of the energy after it, with a
  /// message that names place, cause and remedy (session_failure.cc).
  void stop(RunStatus how, const std::string& what, Index element);
  void fail(const StepOutcome& outcome);
  void fail_blown_up();
  void fail_load_step(const StepOutcome& outcome);
  void end_with(RunStatus how, StepFailure failure, bool with_place);
  /// Finds the elements of a failure. `element`: one that is known, or −1.
  void locate(StepFailure& failure, Index element) const;
  std::string place_of(const StepFailure& failure) const;
  bool worst_is_held(const StepFailure& failure) const;
  FailureCause cause_of(const StepOutcome& outcome, const StepFailure& failure);
  std::string remedy_for(const StepFailure& failure, const StepOutcome& outcome) const;
  /// The smaller one of the stability limits at the start and now, s.
  double present_limit() const;
  bool blown_up() const;
  /// An energy relative to the energy that entered.
  double relative_energy(double energy) const;
  /// The energy error of the integrator, relative to the energy that entered.
  double relative_energy_error() const;
  void keep_state();
};

}  // namespace tetraction
