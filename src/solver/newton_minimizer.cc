#include "tetraction/solver/newton_minimizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "newton_direction.h"
#include "termination_message.h"
#include "tetraction/core/error.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {
namespace {

class NewtonMinimizer : public Minimizer {
 public:
  NewtonMinimizer(const MechanicalSystem& system, const NewtonOptions& options)
      : system_(system), options_(options), linear_(system, options) {
    if (!(options.tolerance > 0.0 && options.tolerance < 1.0) || options.max_iterations < 1) {
      throw InputError("The solver needs 0 < tolerance < 1 and max_iterations ≥ 1.");
    }
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
    double forcing = first_forcing_;
    while (report.residual > report.residual_limit) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        break;
      }
      ++report.iterations;
      // No more digits than the end of the step needs.
      const double enough = 0.3 * report.residual_limit / report.residual;
      const double before = report.residual;
      if (!linear_.find(problem, x, gradient_, std::clamp(forcing, enough, kLoosest), report,
                        direction_) ||
          !search(problem, x, report)) {
        report.termination = Termination::kNoProgress;
        break;
      }
      const double ratio = report.residual / before;
      forcing = kGamma * ratio * ratio;
      if (report.iterations == 1) first_forcing_ = std::clamp(kGamma * ratio, kTightest, kLoosest);
    }
    if (report.residual <= report.residual_limit) report.termination = Termination::kConverged;
    report.linear = linear_.name();
    report.message = termination_message(report.termination);
    if (report.converged()) linear_.end_step(report.iterations);
    return report;
  }

  bool solve_linearized(const StepProblem& problem, const Vector& x, const Matrix& right,
                        Matrix& solution) override {
    return linear_.solve_exactly(problem, x, right, solution);
  }

 private:
  // Forcing terms: how well the linear systems are solved, as |r|/|b|. From one iteration to the next
  // after Eisenstat & Walker (1996, choice 2), with the exponent 2; the first one of a step is what
  // Newton's method made of the first system of the last step.
  static constexpr double kLoosest = 0.1;
  static constexpr double kTightest = 1e-4;
  static constexpr double kGamma = 0.5;

  bool evaluate(const StepProblem& problem, const Vector& x) {
    return problem.value_and_full_gradient(x, phi_, gradient_).ok() && std::isfinite(phi_);
  }

  double residual() const { return system_.coordinates().restricted_norm(gradient_); }

  // Saint Venant–Kirchhoff is defined for any J and may have to go through 0.
  double longest_step(const StepProblem& problem, const Vector& x) const {
    const ElasticPotential& elastic = system_.elastic();
    Vector positions;
    problem.positions(x, positions);
    return admissible_step(system_.rest(), positions, direction_, [&](Index e) {
      return !std::holds_alternative<StVenantKirchhoff>(
          elastic.materials()[static_cast<std::size_t>(elastic.material_index(e))]);
    });
  }

  // x ← x + t d with the first t of a halving sequence that lowers Φ or halves the residual.
  bool search(const StepProblem& problem, Vector& x, MinimizerReport& report) {
    constexpr double kArmijo = 1e-4;
    constexpr double kRoundOff = 1e-11;
    const double longest = linear_.is_safe() ? 1.0 : longest_step(problem, x);
    const double slope = gradient_.dot(direction_);
    if (!(slope < 0.0)) return false;
    before_ = x;
    gradient_before_ = gradient_;
    const double phi = phi_;
    const double residual_before = report.residual;
    for (double t = longest; t > 1e-6 * longest; t *= 0.5) {
      x = before_ + t * direction_;
      // Where the fall of Φ drowns in its round-off, the residual decides, and a much shorter step
      // would be no better.
      const double fall = -t * slope;
      const bool drowned = fall <= kRoundOff * std::abs(phi);
      if (drowned && t < 0.1 * longest) break;
      if (!evaluate(problem, x)) continue;
      report.residual = residual();
      const bool lower = drowned ? report.residual <= 0.9 * residual_before
                                 : phi_ <= phi - kArmijo * fall;
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
