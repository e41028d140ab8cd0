#include "tetraction/simulation/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "session_impl.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/checkpoint_observer.h"
#include "tetraction/simulation/event_settings.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// A run counts as unstable once the energy error is this many times the energy that entered.
constexpr double kBlowUp = 10.0;
// The largest such ratio at a state that is good enough to go back to.
constexpr double kGood = 0.1;
// Number of steps between two good states that are kept.
constexpr Index kGoodStateInterval = 16;

}  // namespace

std::string to_string(RunStatus status) {
  switch (status) {
    case RunStatus::kRunning:
      return "running";
    case RunStatus::kFinished:
      return "ok";
    case RunStatus::kUnstable:
      return "unstable";
    case RunStatus::kNotConverged:
      return "failed";
    case RunStatus::kCancelled:
      break;
  }
  return "interrupted";
}

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

std::int64_t Session::Impl::element_id(Index e) const {
  return system->mesh().tetrahedron_id(e);
}

double Session::Impl::relative_energy(double energy) const {
  // Because of the lower bound, round-off in a body at rest does not count.
  double modulus = 0.0;
  for (const MaterialField& material : system->materials()) {
    modulus = std::max(modulus, material.lame_range().most_modulus);
  }
  modulus = largest_of_parts(system->part(), modulus);
  const double floor = 1e-12 * modulus * system->mesh().total_volume();
  return energy / std::max(balance->energy_scale(), floor);
}

double Session::Impl::relative_energy_error() const {
  return relative_energy(balance->energy_error());
}

bool Session::Impl::blown_up() const {
  // The usual case without the loop over the mesh.
  if (balance->energy_error() <= kBlowUp * balance->energy_scale()) return false;
  return !(relative_energy_error() <= kBlowUp);
}

void Session::Impl::keep_state() {
  good.state = state();
  good.balance = balance->sums();
  good.plan = progress.plan;
}

Session::Session(Scene scene, TetMesh mesh, Analysis analysis, double largest_increment,
                 bool examines_stability)
    : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  s.scene = std::move(scene);
  s.settings = initial_settings(s.scene);
  if (mesh.part) {
    refuse_what_parts_lack(s.scene, analysis);
  } else {
    require_local_engine(s.scene);
  }
  {
    const PhaseTimer timer(s.times.setup);
    s.system = make_system(s.scene, std::move(mesh));
    s.reactions = Reactions::zero(s.system->dof_count());
    s.probes = std::make_unique<ProbeSet>(s.scene.probe, *s.system);
    if (analysis == Analysis::kEquilibrium) {
      s.begin_equilibrium(largest_increment, examines_stability);
      return;
    }
    std::string note;
    s.states.set(make_initial_state(s.scene, *s.system, s.settings.constraints, note));
    s.shared = shared_distances(s.settings.constraints.others);
    if (!note.empty()) s.progress.warnings.push_back(std::move(note));
    s.stepper = make_stepper(s.settings.time.integrator, s.settings.solver, *s.system);
    s.balance = std::make_unique<Balance>(*s.system, s.state());
    const Energies& energies = s.balance->energies();
    if (!std::isfinite(energies.total())) {
      throw InputError(
          fmt::format("The energy at the start is not finite (kinetic {} J, elastic {} J, "
                      "environment {} J): make speeds, moduli or environment.strength smaller.",
                      energies.kinetic(), energies.elastic(), energies.environment()));
    }
  }
  CriticalModes modes;
  s.initial_limit = s.current_limit(s.state().position, &modes);
  const PhaseTimer timer(s.times.setup);
  s.choose_step(s.initial_limit, std::move(modes));
  s.system->applied_force(s.state().position, s.state().time, s.progress.plan.time_step,
                          s.progress.external_force);
  s.count_inverted(nullptr);
  s.warn_of_materials();
  if (std::string warning = s.step_warning(s.initial_limit); !warning.empty()) {
    s.progress.warnings.push_back(std::move(warning));
  }
  check_events(s.scene, *s.system);
  s.warn_of_events();
  s.warn_of_loads();
  s.warn_of_repeated_constraints();
  s.warn_of_unused_settings();
  s.warn_of_blas();
}

Session::~Session() = default;

bool Session::step() {
  Impl& s = *impl_;
  if (s.progress.status != RunStatus::kRunning) return false;
  const PhaseTimer timer(s.times.stepping);
  try {
    return s.step();
  } catch (...) {
    // What stepper and solver remember may belong to a state that was not reached.
    try {
      s.renew_stepper();
    } catch (...) {
      s.stepper->reset();
    }
    throw;
  }
}

bool Session::Impl::step() {
  if (loading) return load_step();
  if (!apply_events() || !follow_limit()) return false;
  states.other().step = -1;  // no attempt has written to it
  const StepOutcome outcome = advance();
  if (progress.status == RunStatus::kCancelled) return false;
  if (!outcome.ok()) {
    fail(outcome);
    return false;
  }
  count_inverted(&outcome.elastic_energy);
  center_note();  // keeps what it finds
  if (blown_up()) {
    fail_blown_up();
    return true;
  }
  if (keeps_good_states && state().step % kGoodStateInterval == 0 &&
      relative_energy_error() <= kGood) {
    keep_state();
  }
  if (state().step - progress.plan.segment_step >= progress.plan.segment_count) {
    progress.status = RunStatus::kFinished;
    warn_at_the_end();
  }
  return true;
}

bool Session::Impl::cancelled_within_step() {
  const auto asked = [](const StopRequest* request) { return request->stop_requested(); };
  if (std::none_of(stop_requests.begin(), stop_requests.end(), asked)) return false;
  progress.status = RunStatus::kCancelled;
  progress.message = fmt::format(
      "stopped on request after step {} ({} = {:.6g}{}), in the middle of the next one, which was "
      "given up",
      state().step, loading ? "load factor" : "t", state().time, loading ? "" : " s");
  // What it remembers belongs to a state that was not reached.
  stepper->reset();
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
  progress.message = fmt::format(
      "step {} (t = {:.6g} s): an exception of a material or a force term ended the run: {}",
      state().step + 1, state().time, what);
  progress.status = RunStatus::kNotConverged;
}

void Session::Impl::renew_stepper() {
  auto fresh = make_stepper(settings.time.integrator, settings.solver, *system);
  stepper = std::move(fresh);
  whole_stepper.reset();
  tracker.reset();
}

void Session::Impl::accept_step() {
  stepper->exchange_reactions(reactions);
  progress.external_force.swap(trial_external_force);
  states.switch_to_other();
}

void Session::keep_good_states() {
  impl_->keeps_good_states = true;
  impl_->keep_state();
}

void Session::go_back() {
  Impl& s = *impl_;
  if (s.loading) return;
  if (s.progress.status != RunStatus::kUnstable && s.progress.status != RunStatus::kNotConverged)
    return;
  if (s.keeps_good_states && !(s.relative_energy_error() <= kGood)) {
    s.states.set(s.good.state);
    s.balance->restore(s.good.balance);
    s.progress.plan = s.good.plan;
  }
  s.progress.status = RunStatus::kRunning;
  s.progress.message.clear();
  s.progress.passed_center.clear();
  s.failed_step.reset();
  // Data that the solver keeps from the failed step must not affect later steps.
  apply(SetSolver{s.settings.solver}, R"("go back")");
}

RunStatus Session::run(const std::vector<Observer*>& observers) {
  Impl& s = *impl_;
  const auto tell = [&](const auto& call) {
    const Impl::ObserverTimer timer(s);
    for (Observer* observer : observers) call(*observer);
  };
  tell([&](Observer& o) { o.on_start(*this); });
  const auto make_step = [&] {
    try {
      return step();
    } catch (...) {
      s.fail_with_exception();
      // Observers of a body in parts wait for those of other processes, where the step may go on.
      if (s.system->part() != nullptr) throw;
      const Impl::ObserverTimer timer(s);
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
    if (request != nullptr) s.stop_requests.push_back(request);
  }
  // An exception must not leave the pointers behind.
  const auto forget = [](std::vector<const StopRequest*>* requests) { requests->clear(); };
  const std::unique_ptr<std::vector<const StopRequest*>, decltype(forget)> guard(&s.stop_requests,
                                                                                 forget);
  std::vector<CheckpointObserver*> keepers;
  for (Observer* observer : observers) {
    auto* keeper = dynamic_cast<CheckpointObserver*>(observer);
    if (keeper != nullptr && keeper->checkpoint_every() >= 0) keepers.push_back(keeper);
  }
  Index last_regular = -1;  // step of the last regular checkpoint
  const auto make_checkpoint = [&](const std::vector<CheckpointObserver*>& keeping, bool regular) {
    if (keeping.empty()) return;
    const Impl::ObserverTimer timer(s);
    const Checkpoint made = checkpoint();
    for (CheckpointObserver* keeper : keeping) keeper->on_checkpoint(*this, made, regular);
    if (regular) last_regular = step_number();
  };
  while (s.progress.status == RunStatus::kRunning && make_step()) {
    tell([&](Observer& o) {
      if (!o.on_step(*this) && s.progress.status == RunStatus::kRunning) {
        s.progress.status = RunStatus::kCancelled;
        s.progress.message = fmt::format("stopped on request after step {} (t = {:.6g} s)",
                                         s.state().step, s.state().time);
      }
    });
    if (keepers.empty() ||
        (s.progress.status != RunStatus::kRunning && s.progress.status != RunStatus::kCancelled)) {
      continue;
    }
    std::vector<CheckpointObserver*> due;
    for (CheckpointObserver* keeper : keepers) {
      const Index every = keeper->checkpoint_every();
      if (every > 0 && step_number() % every == 0) due.push_back(keeper);
    }
    make_checkpoint(due, true);
  }
  if (s.progress.status == RunStatus::kCancelled && last_regular != step_number()) {
    make_checkpoint(keepers, false);
  }
  tell([&](Observer& o) { o.on_finish(*this); });
  return s.progress.status;
}

}  // namespace tetraction
