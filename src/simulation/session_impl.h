// What a Session holds; shared by stepping (session.cc) and editing (session_edits.cc).
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "fem/inverted_elements.h"

#include "automatic_step.h"
#include "body_constraints.h"
#include "initial_state.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// Adds the time until it is destroyed to a phase.
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
  // As they are now: the scene's own values until an edit.
  TimeSettings time;
  SolverSettings solver;
  std::vector<MaterialSettings> materials;
  EnvironmentSettings environment;
  std::vector<ForceSettings> forces;

  // Steps of equal size since the start or the last change of the step.
  struct Stepping {
    double time_step = 0.0;
    double segment_time = 0.0;
    Index segment_step = 0;
    Index segment_count = 0;
    AutomaticStep automatic;  // if the settings say so
  };

  // The last good state since the last edit, if such are kept.
  struct GoodState {
    State state;
    std::unique_ptr<Balance> balance;
    Stepping stepping;
  };
  bool keeps_good_states = false;
  GoodState good;

  PhaseTimes times;
  std::unique_ptr<MechanicalSystem> system;
  BodyConstraints constraints;
  State state;
  std::unique_ptr<Stepper> stepper;
  std::unique_ptr<Balance> balance;
  StabilityLimit initial_limit;

  Stepping stepping;
  std::unique_ptr<StabilityTracker> tracker;  // made when "auto" first needs it
  double first_time_step = 0.0;               // of "auto", at the start or the last edit
  StepRange steps;
  InvertedElements inverted;
  std::unique_ptr<InversionCounter> inversion_counter;  // null: no material allows any

  std::size_t next_event = 0;
  std::vector<AppliedEdit> edits;
  RunStatus status = RunStatus::kRunning;
  std::string message;
  std::vector<std::string> warnings;
  Vector external_force;  // of the last step; empty: none
  MinimizerReport last_report;
  Index total_iterations = 0;
  Index total_factorizations = 0;
  std::string passed_center;  // center_note() of the last vertex that was near
  Index total_cg_iterations = 0;
  std::string linear_solver;  // used last

  /// Sets the step from `time` with the stability limit that "auto" needs; throws InputError.
  void choose_step(const StabilityLimit& limit, CriticalModes modes);
  /// Steps of this size from the present state on.
  void set_time_step(double step);
  /// Steps that are left with this size, the last one shorter.
  Index steps_to_end(double step) const;
  /// "auto": the limit at the present state, from the last one's modes, and what it cost in steps.
  double tracked_limit(double& cost);
  /// "auto" after an edit that may have changed the limit.
  void renew_automatic_step(const StabilityLimit& limit, CriticalModes modes);
  /// Whether "auto" follows the limit with the present settings.
  bool is_automatic() const;
  /// "auto": estimates the limit if that is due. False: the run is over.
  bool follow_limit();
  /// One step, made smaller as often as it takes if "auto" finds that it was too large.
  StepOutcome advance();
  StepOutcome attempt();
  /// Counts inverted elements where materials allow them; of a state that a small step led to with the
  /// elastic energy that is given, or else (null) of any state and new materials.
  void count_inverted(const double* energy_after_step);
  /// Warns of a large energy error, and of events for which no step was left.
  void warn_at_the_end();
  /// A warning for a step above the limit, or empty.
  std::string step_warning(const StabilityLimit& limit) const;
  /// Warns of a slow BLAS where a step is implicit, at the start or after an event.
  void warn_of_blas();
  /// Warns of events that are too early or too late.
  void warn_of_events();
  void apply(const Edit& edit, double at, const std::string& what);
  /// Makes the events that are due. Returns false if one of them could not be made.
  bool apply_events();

  std::int64_t element_id(Index e) const;
  std::string limit_advice() const;
  Index hottest_element() const;
  // Says if a vertex is or was so near a singular centre that its energy there means nothing.
  std::string center_note();
  /// The limit of the present rule.
  StabilityLimit limit_at(const Vector& q, CriticalModes* modes = nullptr) const;
  /// The same, with its time.
  StabilityLimit current_limit(const Vector& q, CriticalModes* modes = nullptr);
  void stop(RunStatus how, const std::string& what, Index element);
  bool blown_up() const;
  /// An energy relative to what entered.
  double relative_energy(double energy) const;
  /// The energy that the integrator has made, relative to what entered.
  double relative_energy_error() const;
  void keep_state();
};

}  // namespace tetraction
