#include "tetraction/solver/ceres_minimizer.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ceres_elements.h"
#include "serial_openmp.h"
#include "sparse_cholesky.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Ends a solve once the gradient is small enough, the only test of convergence there is, or once
// Ceres refuses a step whose change of the cost is nothing but round-off.
class SolveMonitor : public ceres::IterationCallback {
 public:
  void set_limit(double limit) { limit_ = limit; }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    constexpr double kRoundOff = 1e-12;
    const bool drowned = summary.iteration > 0 && !summary.step_is_successful &&
                         summary.step_is_valid &&
                         std::abs(summary.cost_change) <= kRoundOff * summary.cost;
    return summary.gradient_norm <= limit_ || drowned ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                      : ceres::SOLVER_CONTINUE;
  }

 private:
  double limit_ = 0.0;
};

// Keeps Ceres from printing on its own: what it has to say is in the report.
class QuietLog {
 public:
  QuietLog() : level_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~QuietLog() { FLAGS_minloglevel = level_; }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;

 private:
  int level_;
};

class CeresMinimizer : public Minimizer {
 public:
  CeresMinimizer(const MechanicalSystem& system, const MinimizerOptions& options)
      : system_(system),
        options_(options),
        x_(system.dof_count()),
        evaluator_(system, x_),
        problem_(problem_options()) {
    if (!(options.tolerance > 0.0 && options.tolerance < 1.0) || options.max_iterations < 1) {
      throw InputError("The solver needs 0 < tolerance < 1 and max_iterations ≥ 1.");
    }
    add_blocks();
    solver_options_.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver_options_.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    solver_options_.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
    // The default radius of 1e4 would damp Newton's method to a linear rate.
    solver_options_.initial_trust_region_radius = 1e12;
    solver_options_.max_trust_region_radius = 1e20;
    solver_options_.jacobi_scaling = false;
    // Only the gradient decides (SolveMonitor).
    solver_options_.function_tolerance = 0.0;
    solver_options_.gradient_tolerance = 0.0;
    solver_options_.parameter_tolerance = 0.0;
    solver_options_.max_num_consecutive_invalid_steps = 60;
    solver_options_.num_threads = 1;  // the parallel work is done in the evaluator
    solver_options_.logging_type = ceres::SILENT;
    solver_options_.callbacks.push_back(&monitor_);
  }

  MinimizerReport minimize(const StepProblem& problem, Vector& x) override {
    MinimizerReport report;
    if (!make_admissible(problem, x)) {
      report.termination = Termination::kInadmissible;
      report.message = "the elastic energy is not defined at the start of the step";
      return report;
    }
    if (!std::isfinite(problem.residual_limit(x, options_.tolerance))) {
      report.termination = Termination::kInadmissible;
      report.message = "the forces or momenta are too large for double precision";
      return report;
    }
    x_ = x;
    // Near the minimum the changes of the cost drown in its round-off, and Ceres, which judges by
    // the cost, refuses the last steps: these are judged by the gradient. Should that fail as well,
    // Ceres goes on from there with a smaller constant under the root, which costs fewer digits.
    double shift = shift_density(problem);
    for (int attempt = 0; attempt < kAttempts; ++attempt, shift *= 1e-3) {
      solve(problem, shift, report);
      if (report.termination == Termination::kNoProgress) polish(problem, report);
      if (report.termination != Termination::kNoProgress) break;
    }
    x = x_;
    finish(report);
    return report;
  }

 private:
  static constexpr int kAttempts = 3;

  ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::TAKE_OWNERSHIP;
    options.evaluation_callback = &evaluator_;
    options.enable_fast_removal = false;
    options.disable_all_safety_checks = true;
    return options;
  }

  void add_blocks() {
    const DofConstraints& constraints = system_.constraints();
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      double* block = x_.data() + 3 * v;
      problem_.AddParameterBlock(block, 3);
      std::vector<int> held;
      for (int i = 0; i < 3; ++i) {
        if (constraints.is_fixed(3 * v + i)) held.push_back(i);
      }
      if (held.size() == 3) {
        problem_.SetParameterBlockConstant(block);
      } else if (!held.empty()) {
        problem_.SetManifold(block, new ceres::SubsetManifold(3, held));
      }
    }
    for (Index e = 0; e < system_.rest().element_count(); ++e) {
      std::vector<double*> blocks;
      for (const Index v : system_.rest().nodes(e)) blocks.push_back(x_.data() + 3 * v);
      problem_.AddResidualBlock(make_element_cost(evaluator_, e), nullptr, blocks);
    }
  }

  // Energy density c of the shift, J/m³: large enough beside the energies at hand that the matrix
  // under the root stays positive, and no larger than 0.1 μ, where the method is well tried.
  double shift_density(const StepProblem& problem) const {
    constexpr double kLargest = 0.1;
    constexpr double kSmallest = 1e-12;
    constexpr double kOverEnergy = 1e3;
    const double mu = initial_lame(system_.elastic().material()).mu;
    double phi = 0.0;
    if (!problem.value(x_, phi).ok()) return kLargest * mu;
    return std::clamp(kOverEnergy * phi / system_.mesh().total_volume(), kSmallest * mu,
                      kLargest * mu);
  }

  void solve(const StepProblem& problem, double shift, MinimizerReport& report) {
    evaluator_.begin(problem, shift);
    report.residual_limit = problem.residual_limit(x_, options_.tolerance);
    // Ceres adds the gradient up in another order: half the limit leaves room for round-off.
    monitor_.set_limit(0.5 * report.residual_limit);
    solver_options_.max_num_iterations = options_.max_iterations - report.iterations;
    ceres::Solver::Summary summary;
    const QuietLog quiet;
    const SerialOpenMp serial;
    ceres::Solve(solver_options_, &problem_, &summary);
    report.iterations += std::max(0, static_cast<int>(summary.iterations.size()) - 1);
    report.factorizations += std::max(0, summary.num_linear_solves);

    assess(problem, report);
  }

  // Ceres' word is not taken for it: the gradient is computed anew, outside Ceres.
  void assess(const StepProblem& problem, MinimizerReport& report) {
    double phi = 0.0;
    if (!problem.value_and_gradient(x_, phi, gradient_).ok()) {
      report.termination = Termination::kInadmissible;
      return;
    }
    report.residual = gradient_.norm();
    if (report.residual <= report.residual_limit) {
      report.termination = Termination::kConverged;
    } else if (report.iterations >= options_.max_iterations) {
      report.termination = Termination::kIterationLimit;
    } else {
      report.termination = Termination::kNoProgress;
    }
  }

  // Newton steps with the exact Hessian, each kept only if it halves the gradient; the matrix has
  // to be positive definite, so that this cannot leave the minimum's surroundings for a saddle
  // point.
  void polish(const StepProblem& problem, MinimizerReport& report) {
    const SerialOpenMp serial;
    if (!cholesky_) {
      pattern_ = std::make_unique<SparsityPattern>(system_.rest(), system_.constraints());
      cholesky_ = std::make_unique<SparseCholesky>(*pattern_);
      hessian_.resize(static_cast<std::size_t>(pattern_->nonzeros()));
    }
    while (report.termination == Termination::kNoProgress) {
      if (!problem.hessian(x_, *pattern_, hessian_.data()).ok()) return;
      ++report.iterations;
      ++report.factorizations;
      if (!cholesky_->factorize(hessian_)) return;
      const Vector before = x_;
      const double residual = report.residual;
      x_ -= system_.constraints().extend_by_zero(
          cholesky_->solve(system_.constraints().restrict_to_free(gradient_)));
      assess(problem, report);
      if (report.termination == Termination::kInadmissible || report.residual > 0.5 * residual) {
        if (report.converged()) return;
        x_ = before;
        assess(problem, report);
        return;
      }
    }
  }

  static void finish(MinimizerReport& report) {
    switch (report.termination) {
      case Termination::kConverged:
        report.message = "converged: the force residual is below its limit";
        break;
      case Termination::kIterationLimit:
        report.message = "the iteration limit was reached";
        break;
      case Termination::kNoProgress:
        report.message = "no step lowers the potential any further";
        break;
      case Termination::kInadmissible:
        report.message = "the elastic energy is not defined at the end of the minimisation";
        break;
    }
  }

  const MechanicalSystem& system_;
  MinimizerOptions options_;
  Vector x_;  // what Ceres' parameter blocks point into
  ElementEvaluator evaluator_;
  SolveMonitor monitor_;
  ceres::Problem problem_;
  ceres::Solver::Options solver_options_;
  Vector gradient_;
  // For polish(), made when first needed.
  std::unique_ptr<SparsityPattern> pattern_;
  std::unique_ptr<SparseCholesky> cholesky_;
  std::vector<double> hessian_;
};

}  // namespace

std::unique_ptr<Minimizer> make_ceres_minimizer(const MechanicalSystem& system,
                                                const MinimizerOptions& options) {
  return std::make_unique<CeresMinimizer>(system, options);
}

}  // namespace tetraction
