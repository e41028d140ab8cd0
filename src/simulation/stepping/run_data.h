// The data of a run that the parts of a session share.
#pragma once

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tetraction/dynamics/state.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/stop_request.h"

namespace tetraction {

/// Two objects, of which one is the present state. A step writes its result to the other one, which
/// then becomes the present one, so that nothing is copied and a failed step has changed nothing.
/// Those outside look at one of the two objects only, the home, whose vectors keep their addresses.
/// The state is copied there when they ask for it.
class StateBuffers {
 public:
  const State& present() const { return *present_.load(std::memory_order_acquire); }
  /// The object that is not the present state. Its vectors have the size of the body. They must be
  /// written in place, not exchanged for others.
  State& other() { return present_ == &home_ ? other_ : home_; }
  /// Makes the other object the present state.
  void switch_to_other() { present_ = &other(); }
  /// Copies `state` and makes it the present state.
  void set(const State& state) {
    home_ = state;
    present_ = &home_;
  }
  /// The present state in its home. Several threads may call this at once.
  const State& at_home() const {
    if (present_.load(std::memory_order_acquire) != &home_) {
      const std::scoped_lock lock(moving_);
      if (present_ != &home_) {
        home_ = other_;
        present_ = &home_;
      }
    }
    return home_;
  }

 private:
  mutable State home_;
  State other_;
  mutable std::atomic<const State*> present_{&home_};
  mutable std::mutex moving_;
};

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

/// What the limit of explicit steps beside obstacles needs.
struct ImpactMemory {
  double clear_until = -std::numeric_limits<double>::infinity();  // nothing comes near before, s
  double impedance = 0.0;  // the largest ρc of the body, Pa s/m; 0: not known
};

/// The objects that remember something of earlier steps. All of it is forgotten at a checkpoint.
struct StepMemory {
  std::unique_ptr<Stepper> stepper;
  std::unique_ptr<Stepper> whole_stepper;     // of steps that are compared with two halves
  std::unique_ptr<StabilityTracker> tracker;  // made when the limit is first followed
  ImpactMemory impact;
};

/// Work space of one step. Its vectors stay from step to step, so that a step need not allocate.
struct StepWork {
  Vector external_force;       // in the step that is being made, N
  BalanceSums balance_before;  // before this step
  State middle;                // between two halves, or in the middle of a step
  State whole;                 // after the step that is compared with its halves
};

/// The scene, its objects, and how far the run has come. The functions of this folder read and change it.
struct RunData {
  Scene scene;
  Analysis analysis = Analysis::kMotion;
  RunSettings settings;
  RunProgress progress;
  StateBuffers states;
  std::unique_ptr<MechanicalSystem> system;
  StepMemory memory;
  StepWork work;
  Reactions reactions;  // of the last step that did not fail, as those of Stepper
  std::unique_ptr<Balance> balance;
  StabilityLimit initial_limit;
  double landing = std::numeric_limits<double>::infinity();  // see Session::land_at()
  std::vector<const StopRequest*>
      stop_requests;  // of the observers, while Session::run() is running
  PhaseTimes times;

  /// The present state.
  const State& state() const { return states.present(); }
};

/// Round-off of times near t, s.
double round_off_of_time(double t);
/// Adds the warning unless it is empty.
void add_warning(RunProgress& progress, std::string warning);

/// An energy relative to the energy that entered.
double relative_energy(const RunData& run, double energy);
/// Whether the energy error of the integrator is so large that the run counts as unstable.
bool has_blown_up(const RunData& run);
/// The user forces at the present time, those of the next step: 3 per vertex, N.
Vector next_external_force(const RunData& run);

/// The number of steps left with this size, including a shorter last one.
Index steps_to_end(const RunData& run, double step);
/// Starts steps of this size at the present state.
void set_time_step(RunData& run, double step);
/// Enters the length of a step that was accepted, s.
void enter_length(RunProgress& progress, double length, bool is_cut_short);
/// Enters what the solver did in a step.
void count_iterations(RunProgress& progress, const MinimizerReport& report);
/// Sets progress.obstacle_forces to those at this state.
void set_obstacle_forces(RunData& run, const State& at);
/// Sets them to the means over the step that the balance has now.
void enter_obstacle_forces(RunData& run);
/// Makes states.other() the present state, with the forces of the step that led to it.
void accept_step(RunData& run);
/// Makes a stepper that remembers nothing of earlier steps, and forgets all other memory of them.
void renew_stepper(RunData& run);
/// Called between the parts of a step and the attempts at it. If an observer wants the run to stop, it
/// is cancelled. The caller then returns without a change of the state.
bool is_cancelled_within_step(RunData& run);

}  // namespace tetraction
