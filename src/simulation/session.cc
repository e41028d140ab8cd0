#include "tetraction/simulation/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A run counts as blown up once the integrator has made this many times the energy that entered.
constexpr double kBlowUp = 10.0;
// What it may have made in a state that is good enough to go back to.
constexpr double kGood = 0.1;
// Steps from one good state that is kept to the next.
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
  return "cancelled";
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

double Session::Impl::time_of(Index step) const {
  // Multiples of h, not a running sum: the time carries no accumulated round-off.
  return segment_time + static_cast<double>(step - segment_step) * time_step;
}

void Session::Impl::choose_step(const StabilityLimit& limit) {
  const double step = time.automatic ? 0.5 * limit.critical_step : time.step;
  if (!(step > 0.0) || !std::isfinite(step)) {
    throw InputError(
        "time.step = \"auto\" finds no stability limit for this body: give the step in seconds.");
  }
  const double left = time.end - state.time;
  constexpr double kMostSteps = 9e15;  // whole numbers that double precision tells apart
  if (std::isfinite(time.end) && left / step > kMostSteps) {
    throw InputError(
        fmt::format("The run has {:.3g} steps, more than can be counted: make time.step = {} s "
                    "larger or time.end = {} s earlier.",
                    left / step, step, time.end));
  }
  const auto count = static_cast<Index>(std::llround(std::min(left / step, kMostSteps)));
  if (count < 1 && state.step == 0) {
    throw InputError(
        fmt::format("The run has no step: time.end = {} s is less than half of "
                    "time.step = {} s. Make the step smaller or the end later.",
                    time.end, step));
  }
  time_step = step;
  segment_time = state.time;
  segment_step = state.step;
  segment_count = std::max<Index>(count, 0);
}

std::string Session::Impl::step_warning(const StabilityLimit& limit) const {
  if (is_implicit(time.integrator) || time_step <= limit.critical_step) return {};
  std::string why;
  if (system->constraints().has_springs()) {
    why = " (the springs of fix.mode = \"penalty\" count: the stiffer, the lower the limit)";
  } else if (limit.damping_rate * time_step > 0.5) {
    why = " (the damping counts: the stronger, the lower the limit)";
  }
  return fmt::format(
      "the step {:.4g} s is above the stability limit h_crit = {:.4g} s of the {} rule{}: "
      "the run will blow up. Take a smaller time.step, \"auto\", or an implicit integrator.",
      time_step, limit.critical_step, to_string(time.integrator), why);
}

void Session::Impl::warn_of_blas() {
  bool implicit = is_implicit(time.integrator);
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      implicit = implicit || (change != nullptr && is_implicit(change->time.integrator));
    }
  }
  if (!implicit) return;
  if (std::string warning = blas_warning(); !warning.empty()) {
    warnings.push_back(std::move(warning));
  }
}

void Session::Impl::warn_of_events() {
  double end = time.end;  // which events may move, as the step
  double step = time_step;
  for (const EventSettings& event : scene.event) {
    if (event.at > end - step * (1.0 - 1e-6)) {
      warnings.push_back(fmt::format(
          "{} is at {} s, but no step starts then or later: the end is at {} s. It does "
          "not happen.",
          event.where, event.at, end));
      continue;
    }
    if (event.at < 0.0) {
      warnings.push_back(
          fmt::format("{} is at {} s, before the start: it happens before the first step.",
                      event.where, event.at));
    }
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change == nullptr) continue;
      end = change->time.end;
      if (!change->time.automatic) step = change->time.step;
    }
  }
}

StabilityLimit Session::Impl::current_limit(const Vector& position) {
  const PhaseTimer timer(times.stability);
  return stability_limit(*system, position);
}

std::string Session::Impl::limit_advice() const {
  double limit = initial_limit.critical_step;
  if (system->elastic().admissible(state.position).ok()) {
    limit = std::min(limit, stability_limit(*system, state.position).critical_step);
  }
  if (!is_implicit(time.integrator)) {
    return fmt::format(
        "The step is {:.4g} s; the stability limit is {:.4g} s (initially {:.4g} s). Take a step "
        "below it, time.step = \"auto\", or an implicit integrator.",
        time_step, limit, initial_limit.critical_step);
  }
  return fmt::format(
      "The step is {:.4g} s, {:.3g} times the explicit stability limit of {:.4g} s. Take a smaller "
      "time.step{}, and check the loads.",
      time_step, time_step / limit, limit,
      time.integrator == Integrator::kBackwardEuler ? "" : " or backward-euler");
}

// The element with the largest elastic energy density: where a blow-up shows.
Index Session::Impl::hottest_element() const {
  Vector densities;
  system->elastic().energy_densities(state.position, densities);
  Index hottest = 0;
  densities.maxCoeff(&hottest);
  return hottest;
}

// A vertex that falls into the centre of attraction is the likely cause of a failure.
std::string Session::Impl::center_note() {
  if (!system->environment().is_singular()) return {};
  Index nearest = 0;
  const double distance =
      state.position.reshaped(3, system->vertex_count()).colwise().norm().minCoeff(&nearest);
  const double moved = state.velocity.segment<3>(3 * nearest).norm() * time_step;
  // Whoever has passed the centre within what it moves in a step has got an arbitrary energy there,
  // and may be far away by the time that shows.
  if (distance <= 4.0 * moved || distance == 0.0) {
    passed_center = fmt::format(
        "; vertex {} came as near as {:.3g} m to the centre of attraction, where the force has no "
        "bound: give environment.softening a length",
        system->mesh().vertex_id(nearest), distance);
  }
  return passed_center;
}

void Session::Impl::stop(RunStatus how, const std::string& what, Index element) {
  status = how;
  const std::string where =
      (element >= 0 ? fmt::format(" at element {}", element_id(element)) : "") + center_note();
  message = fmt::format("step {} (t = {:.6g} s): {}{}. {}", state.step + 1, state.time + time_step,
                        what, where, limit_advice());
}

double Session::Impl::relative_energy_error() const {
  // The floor keeps round-off in a body at rest from counting.
  double modulus = 0.0;
  for (const MaterialModel& material : system->elastic().materials()) {
    const LameParameters lame = initial_lame(material);
    modulus = std::max(modulus, lame.lambda + 2.0 * lame.mu);
  }
  const double floor = 1e-12 * modulus * system->mesh().total_volume();
  return books->energy_error() / std::max(books->energy_scale(), floor);
}

bool Session::Impl::blown_up() const {
  // The usual case without the loop over the mesh.
  if (books->energy_error() <= kBlowUp * books->energy_scale()) return false;
  return !(relative_energy_error() <= kBlowUp);
}

void Session::Impl::keep_state() {
  good.state = state;
  good.books = std::make_unique<Books>(*books);
}

Session::Session(Scene scene, TetMesh mesh) : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  s.scene = std::move(scene);
  s.time = s.scene.time;
  s.solver = s.scene.solver;
  s.materials.push_back(s.scene.material);
  for (const MaterialRegionSettings& region : s.scene.material_region) {
    s.materials.push_back(region.material);
  }
  s.environment = s.scene.environment;
  s.forces = s.scene.force;
  {
    const PhaseTimer timer(s.times.setup);
    s.system = make_system(s.scene, std::move(mesh));
    s.state = make_initial_state(s.scene, *s.system, s.constraints);
    s.stepper = make_stepper(s.time.integrator, s.solver, *s.system);
    s.books = std::make_unique<Books>(*s.system, s.state);
    const Energies& energies = s.books->energies();
    if (!std::isfinite(energies.total())) {
      throw InputError(
          fmt::format("The energy at the start is not finite (kinetic {} J, elastic {} J, "
                      "environment {} J): make speeds, moduli or environment.strength smaller.",
                      energies.kinetic, energies.elastic, energies.environment));
    }
  }
  const PhaseTimer timer(s.times.stability);
  s.initial_limit = stability_limit(*s.system, s.state.position);
  s.choose_step(s.initial_limit);
  s.system->user_force(s.state.time, s.time_step, s.external_force);
  if (std::string warning = s.step_warning(s.initial_limit); !warning.empty()) {
    s.warnings.push_back(std::move(warning));
  }
  check_events(s.scene, *s.system);
  s.warn_of_events();
  s.warn_of_blas();
}

Session::~Session() = default;

bool Session::step() {
  Impl& s = *impl_;
  if (s.status != RunStatus::kRunning) return false;
  const PhaseTimer timer(s.times.stepping);
  if (!s.apply_events()) return false;
  s.system->user_force(s.state.time, s.time_step, s.external_force);
  const StepOutcome outcome = s.stepper->step_to(s.state, s.time_step, s.time_of(s.state.step + 1));
  s.last_report = outcome.minimizer;
  s.total_iterations += outcome.minimizer.iterations;
  s.total_factorizations += outcome.minimizer.factorizations;
  s.total_cg_iterations += outcome.minimizer.cg_iterations;
  if (!outcome.minimizer.linear.empty()) s.linear_solver = outcome.minimizer.linear;
  switch (outcome.status) {
    case StepStatus::kOk:
      break;
    case StepStatus::kInverted:
      s.stop(RunStatus::kUnstable, "the material's energy is not defined (inverted, J <= 0)",
             outcome.element);
      return false;
    case StepStatus::kNotFinite:
      s.stop(RunStatus::kUnstable, "positions or momenta overflowed", s.hottest_element());
      return false;
    case StepStatus::kOverdamped:
      s.stop(RunStatus::kUnstable,
             "the damping forces of one step would turn velocities around and give energy", -1);
      return false;
    case StepStatus::kNotConverged:
      s.stop(RunStatus::kNotConverged,
             outcome.minimizer.iterations == 0
                 ? outcome.message
                 : fmt::format("the implicit step did not converge after {} iterations: {} (force "
                               "residual {:.3g} N, allowed {:.3g} N)",
                               outcome.minimizer.iterations, outcome.message,
                               outcome.minimizer.residual, outcome.minimizer.residual_limit),
             -1);
      return false;
  }
  s.books->enter(s.state, outcome);
  const std::string center = s.center_note();
  if (s.blown_up()) {
    s.status = RunStatus::kUnstable;
    s.message = fmt::format(
        "step {} (t = {:.6g} s): the energy blew up, most at element {}: the integrator has added "
        "{:.3g} J to the {:.3g} J that entered{}. {}",
        s.state.step, s.state.time, s.element_id(s.hottest_element()), s.books->energy_error(),
        s.books->energy_scale(), center, s.limit_advice());
    return true;
  }
  if (s.keeps_good_states && s.state.step % kGoodStateInterval == 0 &&
      s.relative_energy_error() <= kGood) {
    s.keep_state();
  }
  if (s.state.step - s.segment_step >= s.segment_count) s.status = RunStatus::kFinished;
  return true;
}

void Session::keep_good_states() {
  impl_->keeps_good_states = true;
  impl_->keep_state();
}

void Session::go_back() {
  Impl& s = *impl_;
  if (s.status != RunStatus::kUnstable && s.status != RunStatus::kNotConverged) return;
  if (s.keeps_good_states && !(s.relative_energy_error() <= kGood)) {
    s.state = s.good.state;
    s.books = std::make_unique<Books>(*s.good.books);
  }
  s.status = RunStatus::kRunning;
  s.message.clear();
  s.passed_center.clear();
  // What the solver remembers of the step that failed must not tell in those to come.
  apply(SetSolver{s.solver}, R"("go back")");
}

RunStatus Session::run(const std::vector<Observer*>& observers) {
  Impl& s = *impl_;
  const auto tell = [&](const auto& call) {
    const PhaseTimer timer(s.times.output);
    for (Observer* observer : observers) call(*observer);
  };
  tell([&](Observer& o) { o.on_start(*this); });
  while (s.status == RunStatus::kRunning && step()) {
    tell([&](Observer& o) {
      if (!o.on_step(*this) && s.status == RunStatus::kRunning) {
        s.status = RunStatus::kCancelled;
        s.message = fmt::format("stopped on request after step {} (t = {:.6g} s)", s.state.step,
                                s.state.time);
      }
    });
  }
  tell([&](Observer& o) { o.on_finish(*this); });
  return s.status;
}

}  // namespace tetraction
