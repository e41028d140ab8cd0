#include "tetraction/simulation/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using Clock = std::chrono::steady_clock;

// Adds the time until it is destroyed to a phase.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& phase) : phase_(phase), start_(Clock::now()) {}
  ~PhaseTimer() { phase_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double& phase_;
  Clock::time_point start_;
};

// A run counts as blown up once the integrator has made this many times the energy that entered.
constexpr double kBlowUp = 10.0;

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

struct Session::Impl {
  Scene scene;
  PhaseTimes times;
  std::unique_ptr<MechanicalSystem> system;
  State state;
  Vector target;  // of the fixed DOFs
  std::unique_ptr<Stepper> stepper;
  std::unique_ptr<Books> books;
  StabilityLimit initial_limit;
  double time_step = 0.0;
  Index step_count = 0;
  RunStatus status = RunStatus::kRunning;
  std::string message;
  std::string warning;
  MinimizerReport last_report;
  Index total_iterations = 0;
  Index total_factorizations = 0;

  std::int64_t element_id(Index e) const {
    return system->mesh().tetrahedron_ids[static_cast<std::size_t>(e)];
  }

  void choose_step() {
    const TimeSettings& time = scene.time;
    time_step = time.automatic ? 0.5 * initial_limit.critical_step : time.step;
    if (!(time_step > 0.0) || !std::isfinite(time_step)) {
      throw InputError(
          "time.step = \"auto\" finds no stability limit for this body: give the step in seconds.");
    }
    step_count = static_cast<Index>(std::llround(time.end / time_step));
    if (step_count < 1) {
      throw InputError(
          fmt::format("The run has no step: time.end = {} s is less than half of "
                      "time.step = {} s. Make the step smaller or the end later.",
                      time.end, time_step));
    }
    if (!is_implicit(time.integrator) && time_step > initial_limit.critical_step) {
      warning = fmt::format(
          "the step {:.4g} s is above the stability limit h_crit = {:.4g} s of the {} rule: "
          "the run will blow up. Take a smaller time.step, \"auto\", or an implicit integrator.",
          time_step, initial_limit.critical_step, to_string(time.integrator));
    }
  }

  std::string limit_advice() const {
    const StabilityLimit now = stability_limit(*system, state.position);
    const double limit = std::min(now.critical_step, initial_limit.critical_step);
    if (!is_implicit(scene.time.integrator)) {
      return fmt::format(
          "The step is {:.4g} s; the stability limit is {:.4g} s (initially {:.4g} s). Take a step "
          "below it, time.step = \"auto\", or an implicit integrator.",
          time_step, limit, initial_limit.critical_step);
    }
    return fmt::format(
        "The step is {:.4g} s, {:.3g} times the explicit stability limit of {:.4g} s: too large "
        "for "
        "this motion. Take a smaller time.step{}.",
        time_step, time_step / limit, limit,
        scene.time.integrator == Integrator::kBackwardEuler ? "" : " or backward-euler");
  }

  // The element with the largest elastic energy density: where a blow-up shows.
  Index hottest_element() const {
    Vector densities;
    system->elastic().energy_densities(state.position, densities);
    Index hottest = 0;
    densities.maxCoeff(&hottest);
    return hottest;
  }

  void stop(RunStatus how, const std::string& what, Index element) {
    status = how;
    const std::string where =
        element >= 0 ? fmt::format(" at element {}", element_id(element)) : "";
    message = fmt::format("step {} (t = {:.6g} s): {}{}. {}", state.step + 1,
                          state.time + time_step, what, where, limit_advice());
  }

  bool blown_up() const {
    // The floor keeps round-off in a body at rest from counting.
    const double floor = 1e-12 * wave_modulus() * system->mesh().total_volume();
    return !(books->energy_error() <= kBlowUp * std::max(books->energy_scale(), floor));
  }

  double wave_modulus() const {
    const LameParameters lame = initial_lame(system->elastic().material());
    return lame.lambda + 2.0 * lame.mu;
  }
};

Session::Session(Scene scene, const TetMesh& mesh) : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  s.scene = std::move(scene);
  {
    const PhaseTimer timer(s.times.setup);
    s.system = make_system(s.scene, mesh);
    s.state = make_initial_state(s.scene, *s.system);
    s.target = s.state.position;
    s.stepper = make_stepper(s.scene, *s.system);
    s.books = std::make_unique<Books>(*s.system, s.state);
  }
  const PhaseTimer timer(s.times.stability);
  s.initial_limit = stability_limit(*s.system, s.state.position);
  s.choose_step();
}

Session::~Session() = default;

bool Session::step() {
  Impl& s = *impl_;
  if (s.status != RunStatus::kRunning) return false;
  const PhaseTimer timer(s.times.stepping);
  const StepOutcome outcome = s.stepper->step(s.state, s.time_step);
  s.last_report = outcome.minimizer;
  s.total_iterations += outcome.minimizer.iterations;
  s.total_factorizations += outcome.minimizer.factorizations;
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
    case StepStatus::kNotConverged:
      s.stop(
          RunStatus::kNotConverged,
          fmt::format("the implicit step did not converge after {} iterations: {} (force residual "
                      "{:.3g} N, allowed {:.3g} N)",
                      outcome.minimizer.iterations, outcome.message, outcome.minimizer.residual,
                      outcome.minimizer.residual_limit),
          -1);
      return false;
  }
  // Multiples of h, not a running sum: the time carries no accumulated round-off.
  s.state.time = static_cast<double>(s.state.step) * s.time_step;
  s.books->enter(s.state, outcome);
  if (s.blown_up()) {
    s.status = RunStatus::kUnstable;
    s.message = fmt::format(
        "step {} (t = {:.6g} s): the energy blew up, most at element {}: the integrator has added "
        "{:.3g} J to the {:.3g} J that entered. {}",
        s.state.step, s.state.time, s.element_id(s.hottest_element()), s.books->energy_error(),
        s.books->energy_scale(), s.limit_advice());
    return true;
  }
  if (s.state.step >= s.step_count) s.status = RunStatus::kFinished;
  return true;
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

const Scene& Session::scene() const {
  return impl_->scene;
}
const MechanicalSystem& Session::system() const {
  return *impl_->system;
}
const State& Session::state() const {
  return impl_->state;
}
const Books& Session::books() const {
  return *impl_->books;
}
RunStatus Session::status() const {
  return impl_->status;
}
const std::string& Session::message() const {
  return impl_->message;
}
double Session::time_step() const {
  return impl_->time_step;
}
Index Session::step_count() const {
  return impl_->step_count;
}
const StabilityLimit& Session::initial_limit() const {
  return impl_->initial_limit;
}
StabilityLimit Session::current_limit() const {
  return stability_limit(*impl_->system, impl_->state.position);
}
const std::string& Session::warning() const {
  return impl_->warning;
}
const Vector& Session::reaction_force() const {
  return impl_->stepper->reaction_force();
}
int Session::last_iterations() const {
  return impl_->last_report.iterations;
}
Index Session::total_iterations() const {
  return impl_->total_iterations;
}
Index Session::total_factorizations() const {
  return impl_->total_factorizations;
}
const std::string& Session::solver_message() const {
  return impl_->last_report.message;
}
const PhaseTimes& Session::times() const {
  return impl_->times;
}

double Session::constraint_error() const {
  double error = 0.0;
  for (const Index i : impl_->system->constraints().fixed_dofs()) {
    error = std::max(error, std::abs(impl_->state.position[i] - impl_->target[i]));
  }
  return error;
}

}  // namespace tetraction
