// What a Session holds; shared by stepping (session.cc) and editing (session_edits.cc).
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

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

  // The last good state since the last edit, if such are kept.
  struct GoodState {
    State state;
    std::unique_ptr<Books> books;
  };
  bool keeps_good_states = false;
  GoodState good;

  PhaseTimes times;
  std::unique_ptr<MechanicalSystem> system;
  BodyConstraints constraints;
  State state;
  std::unique_ptr<Stepper> stepper;
  std::unique_ptr<Books> books;
  StabilityLimit initial_limit;

  // Steps of equal size since the start or the last edit of the step.
  double time_step = 0.0;
  double segment_time = 0.0;
  Index segment_step = 0;
  Index segment_count = 0;

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
  void choose_step(const StabilityLimit& limit);
  /// A warning for a step above the limit, or empty.
  std::string step_warning(const StabilityLimit& limit) const;
  /// Warns of a slow BLAS where a step is implicit, at the start or after an event.
  void warn_of_blas();
  /// Warns of events that are too early or too late.
  void warn_of_events();
  void apply(const Edit& edit, double at, const std::string& what);
  /// Makes the events that are due. Returns false if one of them could not be made.
  bool apply_events();
  /// The time of a step of the current segment, s.
  double time_of(Index step) const;

  std::int64_t element_id(Index e) const;
  std::string limit_advice() const;
  Index hottest_element() const;
  // Says if a vertex is or was so near a singular centre that its energy there means nothing.
  std::string center_note();
  StabilityLimit current_limit(const Vector& position);
  void stop(RunStatus how, const std::string& what, Index element);
  bool blown_up() const;
  /// The energy that the integrator has made, relative to what entered.
  double relative_energy_error() const;
  void keep_state();
};

}  // namespace tetraction
