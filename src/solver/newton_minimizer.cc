#include "tetraction/solver/newton_minimizer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "assembled_system.h"
#include "matrix_free_cg.h"
#include "termination_message.h"
#include "tetraction/core/error.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {
namespace {

// Prices of the linear solvers in nanoseconds on one core (docs/performance.md has the measurements).
// Only their ratios matter, and only for kAuto and for the time at which a factor is renewed: results
// do not depend on how fast the machine happens to be.
struct Prices {
  double product;   // an iteration of matrix-free CG
  double newton;    // an iteration of Newton's method without the linear solve
  double assembly;  // of the matrix
  double multiply;  // by the assembled matrix
  double factorization;
  double back_solve;
};

Prices prices(double tetrahedra, double nonzeros, const CholeskyCost& cost) {
  constexpr double kInCache = 1e5;  // tetrahedra whose states the last-level cache holds
  return {(tetrahedra > kInCache ? 12.0 : 7.0) * tetrahedra,
          50.0 * tetrahedra,
          100.0 * tetrahedra,
          1.5 * nonzeros,
          cost.flops / 30.0,
          0.75 * cost.nonzeros};
}

// What a factorisation by nested dissection costs, by the number of unknowns: fitted to blocks and
// beams of 10³ to 10⁵ unknowns. Good to a factor of two, which is enough to decide on an analysis.
CholeskyCost expected_cost(double unknowns) {
  return {12.0 * unknowns * unknowns, 18.0 * std::pow(unknowns, 4.0 / 3.0)};
}

class NewtonMinimizer : public Minimizer {
 public:
  NewtonMinimizer(const MechanicalSystem& system, const NewtonOptions& options)
      : system_(system), options_(options), current_(first_choice(system, options.linear)) {
    if (!(options.tolerance > 0.0 && options.tolerance < 1.0) || options.max_iterations < 1) {
      throw InputError("The solver needs 0 < tolerance < 1 and max_iterations ≥ 1.");
    }
  }

  MinimizerReport minimize(const StepProblem& problem, Vector& x) override {
    MinimizerReport report;
    forget_factor_of_other_steps(problem);
    cost_of_step_ = 0.0;
    if (!evaluate(problem, x)) {
      if (!make_admissible(problem, x) || !evaluate(problem, x)) {
        report.termination = Termination::kInadmissible;
        report.message = "the elastic energy is not defined at the start of the step";
        return report;
      }
    }
    report.residual_limit = problem.residual_limit(x, options_.tolerance);
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
      if (!find_direction(problem, x, std::clamp(forcing, enough, kLoosest), report) ||
          !search(problem, x, report)) {
        report.termination = Termination::kNoProgress;
        break;
      }
      const double ratio = report.residual / before;
      forcing = kGamma * ratio * ratio;
      if (report.iterations == 1) first_forcing_ = std::clamp(kGamma * ratio, kTightest, kLoosest);
    }
    if (report.residual <= report.residual_limit) report.termination = Termination::kConverged;
    report.linear = name(current_);
    report.message = termination_message(report.termination);
    if (options_.linear == LinearSolver::kAuto) choose(report);
    return report;
  }

  bool solve_linearized(const StepProblem& problem, const Vector& x, const Matrix& right,
                        Matrix& solution) override {
    AssembledSystem& matrix = assembled();
    matrix.assemble(problem, x);
    if (!matrix.factorize()) return false;
    factor_price_paid();
    solution.resize(right.rows(), right.cols());
    for (Index i = 0; i < right.cols(); ++i) solution.col(i) = matrix.back_solve(right.col(i));
    return true;
  }

 private:
  // Forcing terms: how well the linear systems are solved, as |r|/|b|. From one iteration to the next
  // after Eisenstat & Walker (1996, choice 2), with the exponent 2; the first one of a step is what
  // Newton's method made of the first system of the last step.
  static constexpr double kLoosest = 0.1;
  static constexpr double kTightest = 1e-4;
  static constexpr double kGamma = 0.5;

  static LinearSolver first_choice(const MechanicalSystem& system, LinearSolver asked) {
    const bool possible = MatrixFreeCg<float>::supports(system);
    if (asked == LinearSolver::kAuto) {
      return possible ? LinearSolver::kMatrixFree : LinearSolver::kFactor;
    }
    if (asked == LinearSolver::kMatrixFree && !possible) {
      throw InputError(
          "solver.linear = \"matrix-free\" knows the three built-in materials and no free rigid "
          "handles: take \"auto\", \"cg\" or \"factor\".");
    }
    return asked;
  }

  static std::string name(LinearSolver linear) {
    return linear == LinearSolver::kMatrixFree ? "matrix-free"
                                               : (linear == LinearSolver::kCg ? "cg" : "factor");
  }

  AssembledSystem& assembled() {
    if (!assembled_) assembled_ = std::make_unique<AssembledSystem>(system_);
    return *assembled_;
  }

  bool evaluate(const StepProblem& problem, const Vector& x) {
    return problem.value_and_full_gradient(x, phi_, gradient_).ok() && std::isfinite(phi_);
  }

  double residual() const { return system_.coordinates().restricted_norm(gradient_); }

  // A factor made for another step size is of another matrix altogether.
  void forget_factor_of_other_steps(const StepProblem& problem) {
    const double sum = problem.coefficient().sum();
    if (std::abs(sum - coefficient_sum_) > 0.01 * std::abs(sum)) {
      stale_ = true;
      if (single_) single_->forget();
      if (double_) double_->forget();
      coefficient_sum_ = sum;
    }
  }

  // direction_ ≈ −(∇²Φ)⁻¹∇Φ.
  bool find_direction(const StepProblem& problem, const Vector& x, double forcing,
                      MinimizerReport& report) {
    return current_ == LinearSolver::kMatrixFree ? find_without_matrix(problem, x, forcing, report)
                                                 : find_with_matrix(problem, x, forcing, report);
  }

  bool find_without_matrix(const StepProblem& problem, const Vector& x, double forcing,
                           MinimizerReport& report) {
    const double unknowns = static_cast<double>(system_.coordinates().count());
    const Prices p =
        prices(static_cast<double>(system_.rest().element_count()), 0.0, expected_cost(unknowns));
    // With kAuto no more iterations than would have paid for a factor, in this step and before.
    int most = std::max(2000, static_cast<int>(unknowns));
    if (options_.linear == LinearSolver::kAuto) {
      const double worth = p.assembly + p.factorization + 4.0 * p.back_solve;
      most = std::max(50, static_cast<int>((worth - regret_ - cost_of_step_) / p.product));
    }
    CgReport cg = single_precision_ ? solve_in(single(), problem, x, forcing, most)
                                    : solve_in(twice(), problem, x, forcing, most);
    if (single_precision_ && !cg.converged && !cg.negative_curvature &&
        options_.linear == LinearSolver::kMatrixFree) {
      // Round-off of single precision: from now on in double.
      single_precision_ = false;
      single_.reset();
      report.cg_iterations += cg.iterations;
      cg = solve_in(twice(), problem, x, forcing, most);
    }
    report.cg_iterations += cg.iterations;
    cost_of_step_ +=
        p.newton + p.product * (cg.iterations + CoarseChoice::kPrice * cg.coarse_spaces);
    if (!cg.converged && !cg.negative_curvature && options_.linear == LinearSolver::kAuto) {
      current_ = LinearSolver::kFactor;
      regret_ = 0.0;
      return find_with_matrix(problem, x, forcing, report);
    }
    return direction_.allFinite();
  }

  template <class T>
  CgReport solve_in(MatrixFreeCg<T>& cg, const StepProblem& problem, const Vector& x,
                    double forcing, int most) {
    cg.set(problem, x);
    const CgReport report = cg.solve(gradient_, forcing, most, direction_);
    safe_ = cg.step_is_safe();
    return report;
  }

  MatrixFreeCg<float>& single() {
    if (!single_) single_ = std::make_unique<MatrixFreeCg<float>>(system_);
    return *single_;
  }
  MatrixFreeCg<double>& twice() {
    if (!double_) double_ = std::make_unique<MatrixFreeCg<double>>(system_);
    return *double_;
  }

  bool find_with_matrix(const StepProblem& problem, const Vector& x, double forcing,
                        MinimizerReport& report) {
    AssembledSystem& matrix = assembled();
    safe_ = false;
    matrix.assemble(problem, x);
    const Vector right = -system_.coordinates().restrict(gradient_);
    Vector solution;
    if (current_ == LinearSolver::kCg) {
      const CgReport cg =
          matrix.solve(right, false, forcing, static_cast<int>(2 * right.size()) + 100, solution);
      report.cg_iterations += cg.iterations;
    } else if (!solve_with_factor(problem, x, right, forcing, solution, report)) {
      return false;
    }
    direction_ = system_.coordinates().extend(solution);
    return direction_.allFinite();
  }

  bool solve_with_factor(const StepProblem& problem, const Vector& x, const Vector& right,
                         double forcing, Vector& solution, MinimizerReport& report) {
    constexpr int kMost = 30;
    constexpr int kFree = 3;
    AssembledSystem& matrix = *assembled_;
    if (options_.keep_factor && matrix.has_factor() && !stale_) {
      const CgReport cg = matrix.solve(right, true, forcing, kMost, solution);
      report.cg_iterations += cg.iterations;
      const Prices p = current_prices();
      regret_ += std::max(0, cg.iterations - kFree) * (p.multiply + p.back_solve);
      if (regret_ > p.factorization) stale_ = true;
      if (cg.converged) return true;
    }
    ++report.factorizations;
    if (!matrix.factorize()) {
      ++report.factorizations;
      matrix.assemble_projected(problem, x);
      if (!matrix.factorize()) return false;
    }
    factor_price_paid();
    solution = matrix.back_solve(right);
    return true;
  }

  void factor_price_paid() {
    stale_ = false;
    regret_ = 0.0;
  }

  Prices current_prices() {
    return prices(static_cast<double>(system_.rest().element_count()),
                  static_cast<double>(assembled().nonzeros()), assembled().cost());
  }

  // Saint Venant–Kirchhoff is defined for any J and may have to go through 0.
  double longest_step(const Vector& x) const {
    const ElasticPotential& elastic = system_.elastic();
    return admissible_step(system_.rest(), x, direction_, [&](Index e) {
      return !std::holds_alternative<StVenantKirchhoff>(
          elastic.materials()[static_cast<std::size_t>(elastic.material_index(e))]);
    });
  }

  // x ← x + t d with the first t of a halving sequence that lowers Φ or halves the residual.
  bool search(const StepProblem& problem, Vector& x, MinimizerReport& report) {
    constexpr double kArmijo = 1e-4;
    constexpr double kRoundOff = 1e-11;
    const double longest = safe_ ? 1.0 : longest_step(x);
    const double slope = gradient_.dot(direction_);
    if (!(slope < 0.0)) return false;
    before_ = x;
    gradient_before_ = gradient_;
    const double phi = phi_;
    const double residual_before = report.residual;
    for (double t = longest; t > 1e-6 * longest; t *= 0.5) {
      x = before_ + t * direction_;
      if (!evaluate(problem, x)) continue;
      report.residual = residual();
      // Where the fall of Φ drowns in its round-off, the residual decides.
      const double fall = -t * slope;
      const bool lower = fall > kRoundOff * std::abs(phi)
                             ? phi_ <= phi - kArmijo * fall
                             : report.residual <= 0.9 * residual_before;
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

  // The rule of kAuto: matrix-free, until what it has cost beyond a factor that lasts for twenty
  // steps would have paid for the factor.
  void choose(const MinimizerReport& report) {
    constexpr double kLife = 20.0;
    if (current_ != LinearSolver::kMatrixFree || !report.converged()) return;
    const Prices rough = prices(static_cast<double>(system_.rest().element_count()), 0.0,
                                expected_cost(static_cast<double>(system_.coordinates().count())));
    const double with_factor =
        report.iterations * (rough.newton + rough.assembly + 3.0 * rough.back_solve) +
        rough.factorization / kLife;
    regret_ = std::max(0.0, regret_ + cost_of_step_ - with_factor);
    if (regret_ > rough.factorization) {
      current_ = LinearSolver::kFactor;
      regret_ = 0.0;
    }
  }

  const MechanicalSystem& system_;
  NewtonOptions options_;
  LinearSolver current_;
  std::unique_ptr<MatrixFreeCg<float>> single_;
  std::unique_ptr<MatrixFreeCg<double>> double_;
  std::unique_ptr<AssembledSystem> assembled_;
  double first_forcing_ = 0.01;
  bool single_precision_ = true;
  bool safe_ = false;    // the direction can be gone to its end
  bool stale_ = false;   // the factor is to be made anew
  double regret_ = 0.0;  // work that another choice would have spared
  double coefficient_sum_ = 0.0;
  double cost_of_step_ = 0.0;
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
