#include "tetraction/simulation/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "failure_diagnosis.h"
#include "mesh/shared_error.h"
#include "run_warnings.h"
#include "session_edits.h"
#include "session_impl.h"
#include "simulation/scene/body_obstacles.h"
#include "simulation/scene/initial_state.h"
#include "simulation/scene/parallel_features.h"
#include "simulation/stepping/limit_estimates.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/checkpoint_observer.h"
#include "tetraction/simulation/event_settings.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// The largest energy error, relative to the energy that entered, at a state that is good enough to go back to.
constexpr double kGood = 0.1;
// Number of steps between two good states that are kept.
constexpr Index kGoodStateInterval = 16;

bool is_good(const RunData& run) {
  return relative_energy(run, run.balance->energy_error()) <= kGood;
}

}  // namespace

int exit_code(RunStatus status) {
  switch (status) {
    case RunStatus::kFinished:
      return 0;
    case RunStatus::kCancelled:
      return 130;
    default:
      return 1;
  }
}

void Session::Impl::keep_state() {
  good.state = run.state();
  good.balance = run.balance->sums();
  good.plan = run.progress.plan;
}

Session::Session(Scene scene, TetMesh mesh, Analysis analysis, double largest_increment,
                 bool examines_stability)
    : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  RunData& run = s.run;
  run.scene = std::move(scene);
  run.analysis = analysis;
  run.settings = initial_settings(run.scene);
  if (mesh.part) {
    refuse_what_parts_lack(run.scene, analysis);
  } else {
    require_local_engine(run.scene);
  }
  {
    const PhaseTimer timer(run.times.setup);
    run.system = make_system(run.scene, std::move(mesh));
    run.settings.obstacles = initial_obstacles(run.scene, *run.system);
    run.reactions = Reactions::zero(run.system->dof_count());
    s.probes = std::make_unique<ProbeSet>(run.scene.probe, *run.system);
    if (analysis == Analysis::kEquilibrium) {
      s.equilibrium = std::make_unique<EquilibriumRun>(run, largest_increment, examines_stability);
      s.shared = shared_distances(run.settings.constraints.others);
      s.inversions.update(run, nullptr);
      s.equilibrium->warn();
      return;
    }
  }
  s.begin_motion();
}

void Session::Impl::begin_motion() {
  MechanicalSystem& system = *run.system;
  {
    const PhaseTimer timer(run.times.setup);
    std::string note;
    run.states.set(make_initial_state(run.scene, system, run.settings.constraints, note));
    shared = shared_distances(run.settings.constraints.others);
    add_warning(run.progress, std::move(note));
    run.memory.stepper = make_stepper(run.settings.time.integrator, run.settings.solver, system);
    run.balance = std::make_unique<Balance>(system, run.state());
    const Energies& energies = run.balance->energies();
    if (!std::isfinite(energies.total())) {
      throw InputError(
          fmt::format("The energy at the start is not finite (kinetic {} J, elastic {} J, "
                      "environment {} J): make speeds, moduli or environment.strength smaller.",
                      energies.kinetic(), energies.elastic(), energies.environment()));
    }
  }
  CriticalModes modes;
  const Vector& position = run.state().position;
  run.initial_limit = timed_limit(run, position, &modes);
  const PhaseTimer timer(run.times.setup);
  strategy = make_step_strategy(run);
  strategy->choose_step(run.initial_limit, std::move(modes));
  system.applied_force(position, run.state().time, run.progress.plan.time_step,
                       run.progress.external_force);
  set_obstacle_forces(run, run.state());
  inversions.update(run, nullptr);
  warn_of_materials(run);
  add_warning(run.progress, step_warning(run, run.initial_limit));
  check_events(run.scene, system);
  warn_of_events(run);
  warn_of_loads(run);
  add_warning(run.progress, repeated_constraint_warning(shared));
  warn_of_unused_settings(run);
  warn_of_blas(run);
}

Session::~Session() = default;

bool Session::step() {
  Impl& s = *impl_;
  if (s.run.progress.status != RunStatus::kRunning) return false;
  const PhaseTimer timer(s.run.times.stepping);
  try {
    return s.step();
  } catch (...) {
    // Memory of stepper and solver may belong to a state that was not reached.
    try {
      if (!s.equilibrium) renew_stepper(s.run);
    } catch (...) {
    }
    s.run.memory.stepper->reset();
    throw;
  }
}

bool Session::Impl::step() {
  if (equilibrium) return equilibrium->step(inversions, failed_step);
  if (!apply_events()) return false;
  if (const std::optional<StepCollapse> collapse = strategy->follow_limit()) {
    fail(diagnose_collapse(run, *strategy, *collapse));
    return false;
  }
  RunProgress& progress = run.progress;
  State& tried = run.states.other();
  tried.step = -1;  // no attempt has written to it
  progress.control.last_rejected = 0;
  progress.control.last_substeps = 1;
  run.balance->begin_step();
  const StepOutcome outcome = strategy->advance();
  if (progress.status == RunStatus::kCancelled) return false;
  if (!outcome.ok()) {
    fail(diagnose_step(run, *strategy, outcome, tried));
    return false;
  }
  enter_obstacle_forces(run);
  inversions.update(run, &outcome.elastic_energy);
  center_note(run);  // keeps what it finds
  if (has_blown_up(run)) {
    fail(diagnose_blow_up(run, *strategy));
    return true;
  }
  const Index number = run.state().step;
  if (keeps_good_states && number % kGoodStateInterval == 0 && is_good(run)) keep_state();
  if (number - progress.plan.segment_step >= progress.plan.segment_count) finish();
  return true;
}

void Session::Impl::finish() {
  run.progress.status = RunStatus::kFinished;
  warn_at_the_end(run, *strategy);
}

void Session::Impl::fail(Diagnosis diagnosis) {
  end_run(run, diagnosis);
  failed_step = std::move(diagnosis.failure);
}

void Session::Impl::require_motion(const char* what) const {
  if (run.analysis == Analysis::kMotion) return;
  throw InputError(fmt::format("A session that computes an equilibrium has no {}.", what));
}

void Session::apply(const Edit& edit, const std::string& what) {
  Impl& s = *impl_;
  s.require_motion("edits");
  // The last change counts: events that are due would otherwise come after this edit.
  const bool runs = s.run.progress.status == RunStatus::kRunning;
  if (runs && !s.apply_events() && s.run.progress.status == RunStatus::kNotConverged) {
    throw InputError(s.run.progress.message);
  }
  s.apply(edit, s.run.state().time, what);
  if (s.run.progress.status == RunStatus::kFinished && std::holds_alternative<SetTime>(edit) &&
      steps_to_end(s.run, s.run.progress.plan.time_step) > 0) {
    s.run.progress.status = RunStatus::kRunning;
  }
}

void Session::Impl::apply(const Edit& edit, double at, const std::string& what) {
  apply_edit(run, strategy, edit, at, what);
  shared = shared_distances(run.settings.constraints.others);
  inversions.update(run, nullptr);
  if (keeps_good_states) keep_state();
}

bool Session::Impl::apply_events() {
  // An event may make the step so short that the next event is not due yet.
  const auto due = [this] {
    return run.progress.next_event < run.scene.event.size() &&
           is_due(run.scene.event[run.progress.next_event].at, run.state().time, run.settings.time,
                  run.progress.plan.time_step);
  };
  while (due()) {
    const EventSettings& event = run.scene.event[run.progress.next_event++];
    std::vector<AppliedEdit>& edits = run.progress.edits;
    const std::size_t before = edits.size();
    try {
      for (const Edit& edit : event.edits) apply(edit, event.at, event.echo);
    } catch (const InputError& error) {
      // If not all parts have this error, the others may have made the event.
      if (run.system->part() != nullptr &&
          dynamic_cast<const SharedInputError*>(&error) == nullptr) {
        throw;
      }
      run.progress.status = RunStatus::kNotConverged;
      run.progress.message =
          fmt::format("step {} (t = {:.6g} s): the event at {} s could not be made: {}",
                      run.state().step + 1, run.state().time, event.at, error.what());
      return false;
    } catch (...) {
      if (edits.size() == before) --run.progress.next_event;
      throw;
    }
    // One entry for the whole event.
    AppliedEdit& whole = edits[before];
    for (std::size_t i = before + 1; i < edits.size(); ++i) {
      whole.energy_jump += edits[i].energy_jump;
      if (!edits[i].warning.empty()) whole.warning = edits[i].warning;
    }
    edits.resize(before + 1);
    if (run.progress.plan.segment_count <= run.state().step - run.progress.plan.segment_step) {
      finish();
      return false;
    }
  }
  return true;
}

void Session::Impl::fail_with_exception() {
  std::string what = "it is no std::exception";
  try {
    throw;
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
  }
  run.progress.message = fmt::format(
      "step {} (t = {:.6g} s): an exception of a material or a force term ended the run: {}",
      run.state().step + 1, run.state().time, what);
  run.progress.status = RunStatus::kNotConverged;
}

void Session::keep_good_states() {
  impl_->keeps_good_states = true;
  impl_->keep_state();
}

void Session::go_back() {
  Impl& s = *impl_;
  if (s.equilibrium) return;
  if (s.run.progress.status != RunStatus::kUnstable &&
      s.run.progress.status != RunStatus::kNotConverged)
    return;
  if (s.keeps_good_states && !is_good(s.run)) {
    s.run.states.set(s.good.state);
    s.run.balance->restore(s.good.balance);
    s.run.progress.plan = s.good.plan;
  }
  s.run.progress.status = RunStatus::kRunning;
  s.run.progress.message.clear();
  s.run.progress.passed_center.clear();
  s.failed_step.reset();
  // Data that the solver keeps from the failed step must not affect later steps.
  apply(SetSolver{s.run.settings.solver}, R"("go back")");
}

RunStatus Session::run(const std::vector<Observer*>& observers) {
  Impl& s = *impl_;
  const auto tell = [&](const auto& call) {
    const auto timer = s.time_observers();
    for (Observer* observer : observers) call(*observer);
  };
  tell([&](Observer& o) { o.on_start(*this); });
  const auto make_step = [&] {
    try {
      return step();
    } catch (...) {
      s.fail_with_exception();
      // Observers of a body in parts wait for those of other processes, where the step may go on.
      if (s.run.system->part() != nullptr) throw;
      const auto timer = s.time_observers();
      for (Observer* observer : observers) {
        try {
          observer->on_finish(*this);
        } catch (...) {  // the exception of the step is the one that tells what happened
        }
      }
      throw;
    }
  };
  for (const Observer* observer : observers) {
    const auto* request = dynamic_cast<const StopRequest*>(observer);
    if (request != nullptr) s.run.stop_requests.push_back(request);
  }
  // An exception must not leave the pointers there.
  const ScopeExit forget([&s] { s.run.stop_requests.clear(); });
  std::vector<CheckpointObserver*> keepers;
  for (Observer* observer : observers) {
    auto* keeper = dynamic_cast<CheckpointObserver*>(observer);
    if (keeper != nullptr && keeper->checkpoint_every() >= 0) keepers.push_back(keeper);
  }
  Index last_regular = -1;  // step of the last regular checkpoint
  const auto make_checkpoint = [&](const std::vector<CheckpointObserver*>& keeping, bool regular) {
    if (keeping.empty()) return;
    const auto timer = s.time_observers();
    const Checkpoint made = checkpoint();
    for (CheckpointObserver* keeper : keeping) keeper->on_checkpoint(*this, made, regular);
    if (regular) last_regular = step_number();
  };
  while (s.run.progress.status == RunStatus::kRunning && make_step()) {
    tell([&](Observer& o) {
      if (!o.on_step(*this) && s.run.progress.status == RunStatus::kRunning) {
        s.run.progress.status = RunStatus::kCancelled;
        s.run.progress.message = fmt::format("stopped on request after step {} (t = {:.6g} s)",
                                             s.run.state().step, s.run.state().time);
      }
    });
    if (keepers.empty() || (s.run.progress.status != RunStatus::kRunning &&
                            s.run.progress.status != RunStatus::kCancelled)) {
      continue;
    }
    std::vector<CheckpointObserver*> due;
    for (CheckpointObserver* keeper : keepers) {
      const Index every = keeper->checkpoint_every();
      if (every > 0 && step_number() % every == 0) due.push_back(keeper);
    }
    make_checkpoint(due, true);
  }
  if (s.run.progress.status == RunStatus::kCancelled && last_regular != step_number()) {
    make_checkpoint(keepers, false);
  }
  tell([&](Observer& o) { o.on_finish(*this); });
  return s.run.progress.status;
}

}  // namespace tetraction
