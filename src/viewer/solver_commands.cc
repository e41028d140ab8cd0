// The commands of a Simulation in the solver's thread.
#include <chrono>
#include <utility>

#include "solver_thread.h"
#include "tetraction/core/interruption.h"

namespace tetraction::viewer {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kDragDelay = 0.08;  // real time in which a dragged vertex reaches the mouse, s

}  // namespace

void SolverThread::pause_for(Pause pause) {
  pause_ = pause;
  snapshot_due_ = true;
  shared_.lock()->running = false;
}

void SolverThread::check_pauses() {
  bool at_end = false;
  bool at_energy_error = false;
  {
    const auto shared = shared_.lock();
    at_end = shared->pauses_at_end && !passed_end_;
    at_energy_error = shared->pauses_at_energy_error;
  }
  if (at_energy_error && energy_.exceeded(session())) pause_for(Pause::kEnergyError);
  if (at_end && engine_->is_at_end(session().time())) pause_for(Pause::kEnd);
}

// Goes on after a pause that the run has made by itself.
void SolverThread::resume() {
  if (pause_ == Pause::kEnd) passed_end_ = true;
  if (pause_ == Pause::kEnergyError) energy_.allow(session());
  pause_ = Pause::kNone;
}

void SolverThread::run() {
  continue_shown();
  engine_->require_good_state();
  resume();
  speed_limiter_.restart(session().time());
  shared_.lock()->running = true;
}

void SolverThread::grab(const std::vector<Index>& vertices) {
  continue_shown();
  engine_->grab(vertices);
  redo_.clear();
}

void SolverThread::grab_obstacle(std::size_t number, const Vector3& point) {
  continue_shown();
  engine_->grab_obstacle(number, point);
  redo_.clear();
}

void SolverThread::pull(const std::vector<Index>& vertices, double radius) {
  continue_shown();
  engine_->pull(vertices, radius, stable_step_);
  redo_.clear();
}

void SolverThread::go_before_last_edit() {
  shown_.reset();
  if (!engine_->edits().knows_state_before_last()) return;
  go_back();
  engine_->go_before_last_edit();
  pause_ = Pause::kNone;
  energy_.restart(session());
}

void SolverThread::step_once() {
  continue_shown();
  pause();
  resume();
  step();
}

void SolverThread::go_back() {
  if (continue_shown()) return;
  pause();
  pause_ = Pause::kNone;
  engine_->go_back();
  const auto shared = shared_.lock();
  shared->history.go_back_to(session().step_number());
  shared->kept.go_back_to(session().step_number());
}

// Estimates the stability limit. In a failed state this is possible only if the energy is defined.
void SolverThread::estimate_limit() {
  limit_is_old_ = false;
  stepping_since_limit_ = 0.0;
  const MechanicalSystem& system = session().system();
  if (!system.elastic().admissible(session().state().position).ok()) return;
  const Clock::time_point start = Clock::now();
  const Interruptible interruptible(gives_up_);
  stable_step_ = session().current_limit().critical_step;
  limit_cost_ = Seconds(Clock::now() - start).count();
}

void SolverThread::execute(const DragTo& drag) {
  // The delay is in real time. Therefore it is converted to simulated time with the measured speed.
  // Until the speed has been measured, it is assumed to be 1.
  const double factor = speed_limiter_.real_time_factor(session().time());
  const bool running = shared_.lock()->running;
  engine_->drag_to(drag.position, running ? kDragDelay * (factor > 0.0 ? factor : 1.0) : 0.0);
}

void SolverThread::execute(MakeEdit& edit) {
  const bool is_time = std::holds_alternative<SetTime>(edit.edit);
  continue_shown();
  engine_->edit(std::move(edit.edit), edit.what, edit.continues_previous);
  redo_.clear();
  if (!is_time) return;
  // Another rule or step is the answer to an energy error.
  energy_.restart(session());
  if (pause_ == Pause::kEnergyError) pause_ = Pause::kNone;
}

}  // namespace tetraction::viewer
