#include "tetraction/solver/newton_minimizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "newton_direction.h"
#include "termination_message.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

class NewtonMinimizer : public Minimizer {
 public:
  NewtonMinimizer(const MechanicalSystem& system, const NewtonOptions& options)
      : system_(system), options_(options), linear_(system, options) {
    if (!(options.tolerance > 0.0 && options.tolerance < 1.0) || options.max_iterations < 1) {
      throw InputError("The solver needs 0 < tolerance < 1 and max_iterations ≥ 1.");
    }
    const double cell =
        6.0 * system.mesh().total_volume() / static_cast<double>(system.rest().element_count());
    inertia_ = system.mass().sum() * std::pow(cell, 2.0 / 3.0);
  }

  MinimizerReport minimize(const StepProblem& problem, Vector& x) override {
    MinimizerReport report;
    linear_.begin_step(problem);
    if (!evaluate(problem, x)) {
      if (!make_admissible(problem, x) || !evaluate(problem, x)) {
        report.termination = Termination::kInadmissible;
        report.message = "the elastic energy is not defined at the start of the step";
        return report;
      }
    }
    report.residual_limit = problem.residual_limit(x, options_.tolerance);
    report.asked_limit = options_.tolerance * problem.force_scale();
    report.residual = residual();
    if (!std::isfinite(report.residual_limit) || !std::isfinite(report.residual)) {
      report.termination = Termination::kInadmissible;
      report.message = "the forces or momenta are too large for double precision";
      return report;
    }
    met_curvature_ = false;
    for (;;) {
      descend(problem, x, report);
      const bool ended = report.converged() || report.termination == Termination::kNoProgress;
      // The gradient vanishes at a saddle, too, and Newton's method may stop near one.
      if (!ended || !is_suspect(problem, x, report) ||
          !find_negative_curvature(problem, x, report) || !leave(problem, x, report)) {
        break;
      }
      ++report.iterations;
    }
    report.linear = linear_.name();
    report.message = termination_message(report.termination);
    if (!report.converged() &&
        (options_.linear == LinearSolver::kCg || options_.linear == LinearSolver::kMatrixFree)) {
      report.message += "; solver.linear = \"auto\" or \"factor\" gives better directions";
    }
    if (report.converged()) linear_.end_step(report.iterations);
    return report;
  }

  bool solve_linearized(const StepProblem& problem, const Vector& x, const Matrix& right,
                        Matrix& solution) override {
    return linear_.solve_exactly(problem, x, right, solution);
  }

 private:
  // Forcing terms are the relative residuals |r|/|b| to which the linear systems are solved. They
  // follow Eisenstat & Walker (1996, choice 2) with the exponent 2. The first one of a step comes
  // from the reduction of the residual by the first iteration of the last step.
  static constexpr double kLoosest = 0.1;
  static constexpr double kTightest = 1e-4;
  static constexpr double kGamma = 0.5;

  // Newton's method until the residual is small enough or no direction makes progress.
  void descend(const StepProblem& problem, Vector& x, MinimizerReport& report) {
    double forcing = first_forcing_;
    const bool first_may_do = !problem.is_loaded(x);
    const auto done = [&] {
      return report.residual <= report.asked_limit ||
             ((report.iterations > 0 || first_may_do) && report.residual <= report.residual_limit);
    };
    while (!done()) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        return;
      }
      ++report.iterations;
      // The system is not solved to more digits than the end of the step needs.
      const double enough = 0.3 * report.residual_limit / report.residual;
      const double before = report.residual;
      if (!linear_.find(problem, x, gradient_, std::clamp(forcing, enough, kLoosest), report,
                        direction_) ||
          !search(problem, x, report)) {
        if (linear_.refine()) continue;
        report.termination = Termination::kNoProgress;
        return;
      }
      if (linear_.negative_curvature().found()) {
        met_curvature_ = true;
        leave(problem, x, report);
      }
      const double ratio = report.residual / before;
      forcing = kGamma * ratio * ratio;
      if (report.iterations == 1) first_forcing_ = std::clamp(kGamma * ratio, kTightest, kLoosest);
    }
    report.termination = Termination::kConverged;
  }

  // Whether to examine the Hessian at the end of a minimisation. It is always examined if a
  // direction of negative curvature was met, if the step was a large one, or if the body may
  // buckle. Otherwise it is examined so seldom that it costs no more than one per cent of the work.
  bool is_suspect(const StepProblem& problem, const Vector& x, const MinimizerReport& report) {
    constexpr int kOrdinary = 5;     // iterations
    constexpr double kShare = 0.01;  // of the work
    constexpr double kNewton = 5.0;  // work of an iteration of Newton's method …
    constexpr double kStep = 15.0;   // … and of a step, in iterations of conjugate gradients
    credit_ += kShare * (kStep + kNewton * report.iterations + report.cg_iterations);
    const bool may_buckle = buckles(problem, x);
    if (met_curvature_ || !report.converged()) return true;
    if (linear_.is_definite()) return false;
    // The first guess was good enough, as for a body at rest.
    const bool nothing_known = report.iterations == 0 && !known_;
    known_ = report.iterations == 0;
    return nothing_known || may_buckle || report.iterations > kOrdinary || credit_ > price_;
  }

  // Whether a strut as thin as an element could buckle within s under the compressive stress
  // σ = √(2EW/V). A bending wave of wave number k in a strut with the radius of gyration r has the
  // frequency ω² = (E r² k⁴ − σ k²)/ρ ≥ −σ²/(4Eρr²). With l = √12 r it follows that Φ may have a
  // saddle if 6 W s² > m l². If the Hessian was definite at a similar energy W, it need not be
  // examined again.
  bool buckles(const StepProblem& problem, const Vector& x) {
    constexpr double kGrowth = 1.2;
    constexpr double kMemory = 0.97;
    double energy = 0.0;
    if (!problem.elastic_energy(x, energy).ok()) return true;
    const double s = problem.step();
    definite_energy_ *= kMemory;
    if (6.0 * energy * s * s <= inertia_ || energy <= kGrowth * definite_energy_) return false;
    definite_energy_ = energy;
    return true;
  }

  bool find_negative_curvature(const StepProblem& problem, const Vector& x,
                               MinimizerReport& report) {
    const int before = report.cg_iterations;
    const bool found = linear_.find_negative_curvature(problem, x, report);
    price_ = 1.0 + report.cg_iterations - before;
    credit_ = 0.0;
    return found;
  }

  // Moves x to a lower point along the direction of negative curvature that was found.
  bool leave(const StepProblem& problem, Vector& x, MinimizerReport& report) {
    before_ = x;
    if (!follow(problem, linear_.negative_curvature(), phi_, gradient_, x)) return false;
    gradient_before_ = gradient_;
    const double phi = phi_;
    if (evaluate(problem, x)) {
      report.residual = residual();
      return true;
    }
    x = before_;
    gradient_.swap(gradient_before_);
    phi_ = phi;
    return false;
  }

  bool evaluate(const StepProblem& problem, const Vector& x) {
    return problem.value_and_full_gradient(x, phi_, gradient_).ok() && std::isfinite(phi_);
  }

  double residual() const { return system_.coordinates().restricted_norm(gradient_); }

  // x ← x + t d with the first t of a halving sequence that lowers Φ or halves the residual.
  bool search(const StepProblem& problem, Vector& x, MinimizerReport& report) {
    constexpr double kArmijo = 1e-4;
    constexpr double kRoundOff = 1e-11;
    const double longest = longest_step(problem, x, direction_, linear_.is_safe());
    const double slope = gradient_.dot(direction_);
    if (!(slope < 0.0)) return false;
    before_ = x;
    gradient_before_ = gradient_;
    const double phi = phi_;
    const double residual_before = report.residual;
    for (double t = longest; t > 1e-6 * longest; t *= 0.5) {
      x = before_ + t * direction_;
      // If the decrease of Φ is below its round-off, the residual decides, and a much shorter step
      // would be no better.
      const double fall = -t * slope;
      const bool drowned = fall <= kRoundOff * std::abs(phi);
      if (drowned && t < 0.1 * longest) break;
      if (!evaluate(problem, x)) continue;
      report.residual = residual();
      const bool lower =
          drowned ? report.residual <= 0.9 * residual_before : phi_ <= phi - kArmijo * fall;
      if (lower || report.residual <= 0.5 * residual_before ||
          report.residual <= report.residual_limit) {
        return true;
      }
    }
    x = before_;
    gradient_.swap(gradient_before_);
    phi_ = phi;
    report.residual = residual_before;
    return false;
  }

  const MechanicalSystem& system_;
  NewtonOptions options_;
  NewtonDirection linear_;
  double first_forcing_ = 0.01;
  bool met_curvature_ = false;    // in this minimisation
  bool known_ = false;            // the last minimisation took no iteration either
  double inertia_ = 0.0;          // m l², l the size of an element
  double definite_energy_ = 0.0;  // elastic energy when the Hessian was examined last
  double credit_ = 0.0;  // for examining the next Hessian, in iterations of conjugate gradients
  double price_ = 30.0;  // of the last one
  double phi_ = 0.0;
  Vector gradient_;  // 3 per vertex
  Vector gradient_before_;
  Vector direction_;
  Vector before_;
};

}  // namespace

std::unique_ptr<Minimizer> make_newton_minimizer(const MechanicalSystem& system,
                                                 const NewtonOptions& options) {
  return std::make_unique<NewtonMinimizer>(system, options);
}

}  // namespace tetraction
