#include "tetraction/simulation/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/error.h"
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

// The element with the largest elastic energy density. A blow-up appears there first.
Index Session::Impl::hottest_element() const {
  Vector densities;
  system->elastic().energy_densities(state.position, densities);
  Index hottest = 0;
  densities.maxCoeff(&hottest);
  return hottest;
}

void Session::Impl::stop(RunStatus how, const std::string& what, Index element) {
  status = how;
  const std::string where =
      (element >= 0 ? fmt::format(" at element {}", element_id(element)) : "") + center_note();
  message = fmt::format("step {} (t = {:.6g} s): {}{}. {}", state.step + 1,
                        state.time + stepping.time_step, what, where, limit_advice());
}

double Session::Impl::relative_energy(double energy) const {
  // Because of the lower bound, round-off in a body at rest does not count.
  double modulus = 0.0;
  for (const MaterialModel& material : system->elastic().materials()) {
    const LameParameters lame = initial_lame(material);
    modulus = std::max(modulus, lame.lambda + 2.0 * lame.mu);
  }
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
  good.state = state;
  good.balance = std::make_unique<Balance>(*balance);
  good.stepping = stepping;
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
    s.balance = std::make_unique<Balance>(*s.system, s.state);
    const Energies& energies = s.balance->energies();
    if (!std::isfinite(energies.total())) {
      throw InputError(
          fmt::format("The energy at the start is not finite (kinetic {} J, elastic {} J, "
                      "environment {} J): make speeds, moduli or environment.strength smaller.",
                      energies.kinetic(), energies.elastic(), energies.environment()));
    }
  }
  CriticalModes modes;
  s.initial_limit = s.current_limit(s.state.position, &modes);
  const PhaseTimer timer(s.times.setup);
  s.choose_step(s.initial_limit, std::move(modes));
  s.system->external_force(s.state.time, s.stepping.time_step, s.external_force);
  s.count_inverted(nullptr);
  for (const auto& warning_of : {locking_warning, instability_warning}) {
    if (std::string warning = warning_of(*s.system); !warning.empty()) {
      s.warnings.push_back(std::move(warning));
    }
  }
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
  if (!s.apply_events() || !s.follow_limit()) return false;
  const StepOutcome outcome = s.advance();
  switch (outcome.status) {
    case StepStatus::kOk:
      break;
    case StepStatus::kInverted:
      s.stop(RunStatus::kUnstable,
             s.is_automatic() ? "the body is crushed or torn (inverted, J <= 0, whatever the step)"
                              : "the material's energy is not defined (inverted, J <= 0)",
             outcome.element);
      return false;
    case StepStatus::kNotFinite:
      s.stop(RunStatus::kUnstable,
             outcome.message.empty() ? "positions or momenta overflowed" : outcome.message,
             s.hottest_element());
      return false;
    case StepStatus::kUndefined:
      s.stop(RunStatus::kUnstable, outcome.message, -1);
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
  s.count_inverted(&outcome.elastic_energy);
  const std::string center = s.center_note();
  if (s.blown_up()) {
    s.status = RunStatus::kUnstable;
    s.message = fmt::format(
        "step {} (t = {:.6g} s): the energy blew up, most at element {}: the integrator has added "
        "{:.3g} J to the {:.3g} J that entered{}. {}",
        s.state.step, s.state.time, s.element_id(s.hottest_element()), s.balance->energy_error(),
        s.balance->energy_scale(), center, s.limit_advice());
    return true;
  }
  if (s.keeps_good_states && s.state.step % kGoodStateInterval == 0 &&
      s.relative_energy_error() <= kGood) {
    s.keep_state();
  }
  if (s.state.step - s.stepping.segment_step >= s.stepping.segment_count) {
    s.status = RunStatus::kFinished;
    s.warn_at_the_end();
  }
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
    s.balance = std::make_unique<Balance>(*s.good.balance);
    s.stepping = s.good.stepping;
  }
  s.status = RunStatus::kRunning;
  s.message.clear();
  s.passed_center.clear();
  // Data that the solver keeps from the failed step must not affect later steps.
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
