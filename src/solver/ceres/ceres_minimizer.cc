#include "tetraction/solver/ceres_minimizer.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "ceres_elements.h"
#include "core/scope_exit.h"
#include "serial_openmp.h"
#include "solver/linear/assembled_system.h"
#include "solver/newton/line_search.h"
#include "solver/newton/solver_checks.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Ends a solve when the gradient is small enough, which is the only test of convergence, or when
// Ceres refuses a step whose change of the cost is mere round-off.
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

class CeresMinimizer : public Minimizer {
 public:
  CeresMinimizer(const MechanicalSystem& system, const MinimizerOptions& options)
      : system_(system),
        options_(options),
        y_(Vector::Zero(system.coordinates().count())),
        evaluator_(system, y_),
        problem_(problem_options()),
        path_(system) {
    check_options(options);
    check_ceres(system);
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

  MinimizerReport minimize(const MinimizationProblem& problem, Vector& x) override {
    MinimizerReport report;
    report.linear = "cholesky";
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
    at_.u = x;
    // Near the minimum the changes of the cost are below its round-off. Ceres judges steps by the
    // cost and refuses the last ones. Therefore polish() takes these and judges them by the
    // gradient. If that fails as well, Ceres continues with a smaller constant under the root,
    // which costs fewer digits. Ceres converges slowly if negative eigenvalues of elements'
    // Hessians are set to zero. Therefore Newton's method with the exact Hessian is tried from time
    // to time. If that Hessian is not positive definite at the end, Ceres begins anew at a lower
    // point along a direction of negative curvature.
    double shift = shift_density(problem);
    for (int stalls = 0; stalls < kStalls;) {
      const bool went_on = solve(problem, shift, report);
      if (report.termination == Termination::kNoProgress) polish(problem, report);
      if (leave_saddle(problem, report)) continue;
      if (report.termination != Termination::kNoProgress) break;
      if (went_on) continue;
      ++stalls;
      shift *= 1e-3;
    }
    x = at_.u;
    report.message = termination_message(report.termination);
    return report;
  }

  bool solve_linearized(const MinimizationProblem& problem, const Vector& x, const Matrix& right,
                        Matrix& solution) override {
    if (!factorize(problem, x)) return false;
    solution.resize(right.rows(), right.cols());
    for (Index i = 0; i < right.cols(); ++i) solution.col(i) = assembled_->back_solve(right.col(i));
    return true;
  }

 private:
  static constexpr int kStalls = 3;
  static constexpr int kRound = 12;  // Ceres' iterations before the exact Hessian is tried

  ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::TAKE_OWNERSHIP;
    options.evaluation_callback = &evaluator_;
    options.enable_fast_removal = false;
    options.disable_all_safety_checks = true;
    return options;
  }

  // One parameter block for the coordinates of each vertex and of each affine set.
  void add_blocks() {
    const FreeCoordinates& coordinates = system_.coordinates();
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const FreeCoordinates::VertexMap map = coordinates.map(v);
      if (map.count > 0 && coordinates.set_of(v) < 0) {
        problem_.AddParameterBlock(y_.data() + map.first, map.count);
      }
    }
    for (std::size_t set = 0; set < coordinates.sets().size(); ++set) {
      problem_.AddParameterBlock(y_.data() + coordinates.first_of_set(static_cast<Index>(set)),
                                 3 * (1 + coordinates.sets()[set].rank()));
    }
    std::vector<int> firsts;
    for (Index e = 0; e < system_.rest().element_count(); ++e) {
      ceres::CostFunction* cost = make_element_cost(evaluator_, system_, e, firsts);
      if (cost == nullptr) continue;
      std::vector<double*> blocks;
      blocks.reserve(firsts.size());
      for (const int first : firsts) blocks.push_back(y_.data() + first);
      problem_.AddResidualBlock(cost, nullptr, blocks);
    }
  }

  // Energy density c of the shift, J/m³. It is so large, compared with the current energies, that
  // the matrix of which K is the root stays positive. It is at most 0.1 μ, with which the method is
  // tested well.
  double shift_density(const MinimizationProblem& problem) const {
    constexpr double kLargest = 0.1;
    constexpr double kSmallest = 1e-12;
    constexpr double kOverEnergy = 1e3;
    double mu = std::numeric_limits<double>::infinity();
    for (const MaterialField& material : system_.elastic().materials()) {
      mu = std::min(mu, material.lame_range().least.mu);
    }
    double phi = 0.0;
    if (!problem.value(at_.u, phi).ok()) return kLargest * mu;
    phi += problem.square_value();
    return std::clamp(kOverEnergy * phi / system_.mesh().total_volume(), kSmallest * mu,
                      kLargest * mu);
  }

  // Runs one round of Ceres. Returns whether Ceres would have continued.
  bool solve(const MinimizationProblem& problem, double shift, MinimizerReport& report) {
    evaluator_.begin(problem, at_.u, shift);
    y_.setZero();
    report.residual_limit = problem.residual_limit(at_.u, options_.tolerance);
    report.asked_limit = asked_limit(problem, at_.u, options_.tolerance);
    // Ceres sums the gradient in another order. Half the limit leaves room for this round-off.
    const bool first = report.iterations == 0 && problem.is_loaded(at_.u);
    monitor_.set_limit(0.5 * (first ? report.asked_limit : report.residual_limit));
    const int most = std::min(kRound, options_.max_iterations - report.iterations);
    solver_options_.max_num_iterations = most;
    ceres::Solver::Summary summary;
    // Ceres must not print. Its messages are in the report.
    const ScopeExit restore_log([level = FLAGS_minloglevel] { FLAGS_minloglevel = level; });
    FLAGS_minloglevel = google::GLOG_FATAL;
    const SerialOpenMp serial;
    const SerialBlas serial_blas;
    ceres::Solve(solver_options_, &problem_, &summary);
    at_.u += system_.coordinates().extend(y_);
    const int taken = std::max(0, static_cast<int>(summary.iterations.size()) - 1);
    report.iterations += taken;
    report.factorizations += std::max(0, summary.num_linear_solves);

    // The gradient is computed again, outside Ceres, as an independent check.
    if (evaluate(problem, at_)) {
      judge(report);
    } else {
      report.termination = Termination::kInadmissible;
    }
    return taken >= most;
  }

  // Sets the report to what at_ means.
  void judge(MinimizerReport& report) const {
    report.residual = at_.residual;
    if (report.residual <= report.residual_limit) {
      report.termination = Termination::kConverged;
    } else if (report.iterations >= options_.max_iterations) {
      report.termination = Termination::kIterationLimit;
    } else {
      report.termination = Termination::kNoProgress;
    }
  }

  // If there is a direction of negative curvature at the end of a solve, moves to a lower point
  // along it.
  bool leave_saddle(const MinimizationProblem& problem, MinimizerReport& report) {
    if (!report.converged() && report.termination != Termination::kNoProgress) return false;
    const NegativeCurvature descent =
        assembled().find_negative_curvature(problem, at_.u, report.factorizations);
    if (!descent.found()) return false;
    if (report.iterations >= options_.max_iterations) {
      report.termination = Termination::kIterationLimit;
      return false;
    }
    if (!follow(problem, descent, at_, path(problem))) return false;
    report.met_negative_curvature = true;
    ++report.iterations;
    judge(report);
    if (report.iterations < options_.max_iterations) return true;
    report.termination = Termination::kIterationLimit;
    return false;
  }

  // Newton steps with the exact Hessian. The matrix must be positive definite, so that the steps
  // cannot end at a saddle point.
  void polish(const MinimizationProblem& problem, MinimizerReport& report) {
    while (report.termination == Termination::kNoProgress) {
      ++report.iterations;
      ++report.factorizations;
      if (!factorize(problem, at_.u)) return;
      const FreeCoordinates& coordinates = system_.coordinates();
      const Vector direction =
          coordinates.extend(assembled_->back_solve(-coordinates.restrict(at_.force)));
      if (!line_search_.search(problem, {direction, false, report.residual_limit, path(problem)},
                               at_))
        return;
      judge(report);
    }
  }

  // Factorises the assembled Hessian with CHOLMOD. Returns false if it is not positive definite.
  bool factorize(const MinimizationProblem& problem, const Vector& x) {
    return assembled().assemble(problem, x) && assembled().factorize();
  }

  AssembledSystem& assembled() {
    if (!assembled_) assembled_ = std::make_unique<AssembledSystem>(system_);
    return *assembled_;
  }

  // Without inertia a minimum may be far away, along a curved valley.
  TurningPath* path(const MinimizationProblem& problem) {
    return problem.has_inertia() ? nullptr : &path_;
  }

  const MechanicalSystem& system_;
  MinimizerOptions options_;
  // Ceres' parameter blocks point into it. It holds the free coordinates of the displacement from
  // the first point of a solve.
  Vector y_;
  ElementEvaluator evaluator_;
  SolveMonitor monitor_;
  ceres::Problem problem_;
  ceres::Solver::Options solver_options_;
  Iterate at_;
  TurningPath path_;
  LineSearch line_search_;
  std::unique_ptr<AssembledSystem> assembled_;  // made when first needed
};

}  // namespace

void check_ceres(const MechanicalSystem& system) {
  if (system.nodal_volume() != nullptr) {
    throw InputError(
        "Ceres cannot take mesh.volume = \"nodal\", which couples vertices that belong to no "
        "common tetrahedron: set solver.kind = \"newton\", or mesh.volume = \"element\".");
  }
  for (const ForceTerm* term : system.force_terms()) check_ceres(*term);
}

void check_ceres(const ForceTerm& term) {
  if (term.couples_only_neighbors()) return;
  throw InputError("Ceres cannot take the force term \"" + term.name() +
                   "\", which couples several vertices whether or not they belong to a common "
                   "tetrahedron: set solver.kind = \"newton\".");
}

std::unique_ptr<Minimizer> make_ceres_minimizer(const MechanicalSystem& system,
                                                const MinimizerOptions& options) {
  return std::make_unique<CeresMinimizer>(system, options);
}

}  // namespace tetraction
