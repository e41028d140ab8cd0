#include "tetraction/solver/newton_root_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/gmres.h"
#include "dynamics/problems/energy_momentum_problem.h"
#include "dynamics/problems/solve_to_round_off.h"
#include "factor_gmres.h"
#include "forcing_term.h"
#include "line_search.h"
#include "newton_linear_solver.h"
#include "solver_checks.h"

namespace tetraction {
namespace {

// The iteration. A derived class finds its directions.
class NewtonRootFinder : public RootFinder {
 public:
  explicit NewtonRootFinder(const MinimizerOptions& options) : options_(options) {
    check_options(options);
  }

  MinimizerReport find_root(RootProblem& problem, Vector& u) override {
    MinimizerReport report;
    report.linear = "gmres";
    at_.u = u;
    if (!make_admissible(problem, at_.u) || !evaluate(std::as_const(problem), at_)) {
      report.termination = Termination::kInadmissible;
      report.message = "the forces are not defined at the start of the step";
      return report;
    }
    begin(problem);
    report.residual = at_.residual;
    if (!set_limits(problem, at_.u, options_.tolerance, report)) return report;
    iterate(problem, report);
    u = at_.u;
    report.message = report.termination == Termination::kNoProgress
                         ? "no step lowers the force residual any further"
                         : termination_message(report.termination);
    end(report);
    return report;
  }

  bool newton_correction(RootProblem& problem, const Vector& u, Vector& correction) override {
    constexpr double kForcing = 1e-4;
    MinimizerReport report;
    at_.u = u;
    if (!evaluate(std::as_const(problem), at_)) return false;
    begin(problem);
    report.residual = at_.residual;
    if (!linearize(problem) || !find_direction(problem, kForcing, report)) return false;
    accept();
    correction = direction_;
    return correction.allFinite();
  }

  bool solve_linearized(RootProblem& problem, const Vector& u, const Matrix& forces,
                        Matrix& displacements) override {
    constexpr double kForcing = 1e-10;
    MinimizerReport report;
    at_.u = u;
    if (!problem.is_defined(u)) return false;
    begin(problem);
    if (!linearize(problem)) return false;
    displacements.resize(forces.rows(), forces.cols());
    for (Index i = 0; i < forces.cols(); ++i) {
      at_.force = -forces.col(i);
      report.residual = problem.free_norm(at_.force);
      if (report.residual == 0.0) {
        displacements.col(i).setZero();
        continue;
      }
      if (!find_direction(problem, kForcing, report)) return false;
      displacements.col(i) = direction_;
    }
    accept();
    return displacements.allFinite();
  }

 protected:
  virtual void begin(const RootProblem& /*problem*/) {}
  virtual void end(MinimizerReport& /*report*/) {}
  // direction_ ≈ −(∂r/∂u)⁻¹ r, to a relative residual of `forcing`.
  virtual bool find_direction(const RootProblem& problem, double forcing,
                              MinimizerReport& report) = 0;
  // Whether a direction of more digits can be had, after the last one made no progress.
  virtual bool refine() = 0;
  virtual void accept() {}
  // Begins a direction of the iteration, which measures what directions are worth. More directions may be asked for
  // to judge its trial points.
  virtual void begin_direction() {}
  // Linearises the problem at at_.u.
  virtual bool linearize(RootProblem& problem) { return problem.linearize(at_.u).ok(); }
  // Takes note of the ratio of the residuals after and before a direction that was asked for with `forcing`. Returns
  // whether the next direction shall be found with the same derivative.
  virtual bool enter_reduction(double /*ratio*/, double /*forcing*/) { return false; }
  // Whether another kind of direction is worth a try after one that made no progress.
  virtual bool tries_again() { return false; }
  // Whether directions of more digits are asked for in the iteration that goes on.
  bool is_refined() const { return is_refined_; }

  Iterate at_;
  Vector direction_;       // 3 per vertex
  bool is_probe_ = false;  // whether the present direction judges a trial point

 private:
  void iterate(RootProblem& problem, MinimizerReport& report) {
    constexpr int kSlow = 2;  // such iterations in a row end it
    ForcingTerm forcing(first_forcing_);
    const bool first_may_do = !problem.is_loaded(at_.u);
    int slow = 0;
    double refined_from =
        std::numeric_limits<double>::infinity();  // residual of the last refinement
    is_refined_ = keeps_derivative_ = is_probe_ = false;
    while (!is_small_enough(report, first_may_do)) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        return;
      }
      ++report.iterations;
      const double before = report.residual;
      const bool keeps = keeps_derivative_;
      const double few = keeps ? forcing.next_with_earlier_matrix(report) : forcing.next(report);
      begin_direction();
      const bool found = (keeps || linearize(problem)) && find_direction(problem, few, report) &&
                         move_along(problem, report);
      report.residual = at_.residual;
      keeps_derivative_ = found && enter_reduction(at_.residual / before, few);
      if (!found && tries_again()) continue;
      const bool is_slow = found && is_round_off(problem, at_, before);
      const bool is_at_floor = is_slow && at_.residual <= floor_ * problem.round_off(at_.u);
      slow = is_slow && (is_at_floor || !tries_again()) ? slow + 1 : 0;
      if (!found || slow >= kSlow || is_at_floor) {
        slow = 0;
        // Round-off that a refinement did not lower will not be lowered by another one.
        const bool may_help = !found || at_.residual <= 0.5 * refined_from;
        if (!is_at_floor && may_help && refine()) {
          refined_from = at_.residual;
          is_refined_ = true;
          continue;
        }
        if (!is_at_floor) enter_floor(at_.residual / problem.round_off(at_.u));
        report.termination = Termination::kNoProgress;
        return;
      }
      accept();
      forcing.enter(report.residual / before);
      if (report.iterations == 1) first_forcing_ = forcing.first_of_next_step();
    }
    report.termination = Termination::kConverged;
  }

  // Whether residuals before and after an iteration differ by little and may be mere round-off. A
  // direction lowers the residual of the linear equations at least tenfold, and near the solution that is
  // the residual. The estimate of round-off may be too small by the margin, so that a limit just above the estimate
  // may be out of reach; without an end the iteration would wander there.
  static bool is_round_off(const RootProblem& problem, const Iterate& at, double before) {
    constexpr double kLittle = 0.5;
    return at.residual > kLittle * before &&
           at.residual <= kRoundOffMargin * problem.round_off(at.u);
  }

  // Remembers where round-off ended an iteration, relative to the estimate. Later iterations end there at once.
  void enter_floor(double ratio) {
    constexpr double kAbove = 1.5;
    if (ratio <= kRoundOffMargin) floor_ = std::min(kAbove * ratio, kRoundOffMargin);
  }

  // Moves at_ along direction_. The measure of a trial point is |r| if the longest step lowers it well.
  // Otherwise it is the length of the next correction with the same derivative, |(∂r/∂u)⁻¹ r|, which
  // must fall (the natural monotonicity test of Deuflhard 2004, section 3.1.4). Along motions that the
  // stiff parts of a body resist only to second order, such as turns, |r| allows tiny steps only.
  bool move_along(const RootProblem& problem, MinimizerReport& report) {
    constexpr double kWell = 0.5;
    constexpr double kShortest = 1e-3;
    constexpr double kForcing = 0.1;
    const double longest = problem.longest_step(at_.u, direction_, false);
    const Vector whole = direction_;
    const double length = whole.norm();
    const Iterate start = at_;
    Iterate trial;
    for (double t = longest; t > kShortest * longest; t *= 0.5) {
      trial.u = start.u + t * whole;
      if (!evaluate(problem, trial)) continue;
      if ((t == longest && trial.residual <= kWell * start.residual) ||
          trial.residual <= report.residual_limit) {
        at_ = std::move(trial);
        return true;
      }
      at_.force = trial.force;
      is_probe_ = true;
      const bool shorter = find_direction(problem, kForcing, report) &&
                           direction_.norm() <= (1.0 - 0.25 * t) * length;
      at_.force = start.force;
      is_probe_ = false;
      if (shorter) {
        at_ = std::move(trial);
        return true;
      }
    }
    at_ = start;
    return line_search_.search(problem, {whole, false, report.residual_limit}, at_);
  }

  MinimizerOptions options_;
  LineSearch line_search_;
  double first_forcing_ = ForcingTerm::kFirst;
  double floor_ = 0.0;  // residuals that were round-off, relative to the estimate
  bool is_refined_ = false;
  bool keeps_derivative_ = false;  // for the next direction of the iteration
};

class FactorRootFinder : public NewtonRootFinder {
 public:
  FactorRootFinder(const MechanicalSystem& system, const MinimizerOptions& options)
      : NewtonRootFinder(options), linear_(system) {}

 private:
  bool find_direction(const RootProblem& problem, double forcing,
                      MinimizerReport& report) override {
    return linear_.find(problem, at_, forcing, report, direction_);
  }
  bool refine() override { return linear_.refine(); }
  void accept() override { linear_.move(); }

  FactorGmres linear_;
};

// Directions with the linear solvers of a minimisation. In steps that resolve the motion the Hessian H is so close to
// ∂r/∂u that −H⁻¹r serves as the direction, and that an H serves for all of a step: the simplified Newton method
// (Deuflhard 2004, section 2.1.1). Where this does not reduce the residual well, directions come from flexible GMRES
// with H as its preconditioner. Where that needs many iterations, because H is not close to ∂r/∂u, a factor is cheaper:
// each iteration then costs a product and a back substitution only.
class KrylovRootFinder : public NewtonRootFinder {
 public:
  KrylovRootFinder(const MechanicalSystem& system, const NewtonOptions& options)
      : NewtonRootFinder(options),
        system_(system),
        linear_(system, options),
        may_choose_(options.linear == LinearSolver::kAuto),
        mass_(system.mass()),
        reduced_mass_(system.coordinates().reduced_mass(mass_)) {}

 private:
  void begin(const RootProblem& problem) override {
    linear_.begin_step(problem.approximation(), at_.u);
    with_gmres_ = 0;
    is_simple_ = false;
    keeps_energy_of_contact_ = system_.contact() != nullptr &&
                               dynamic_cast<const EnergyMomentumProblem*>(&problem) != nullptr;
  }
  void end(MinimizerReport& report) override {
    report.linear = with_factor_ > 0 ? "factor" : linear_.name();
    if (report.converged()) linear_.end_step(report.iterations);
  }
  bool refine() override { return with_factor_ > 0 ? factor_->refine() : linear_.refine(); }
  void accept() override {
    if (factor_) factor_->move();
  }
  void begin_direction() override {
    // In the layers of contact a residual just below its limit adds too much energy. Directions of ∂r/∂u leave far less.
    is_simple_ = with_gmres_ == 0 && with_factor_ == 0 && !keeps_energy_of_contact_;
    if (with_gmres_ > 0) --with_gmres_;
  }
  bool linearize(RootProblem& problem) override {
    point_ = at_.u;
    has_new_matrix_ = true;
    return NewtonRootFinder::linearize(problem);
  }

  bool enter_reduction(double ratio, double forcing) override {
    constexpr double kGood = 0.05;     // so few iterations follow that a new matrix does not pay
    constexpr double kPoor = 0.3;      // GMRES is faster
    constexpr double kExpected = 3.0;  // times the forcing term
    if (ratio > std::max(kPoor, kExpected * forcing)) tries_again();
    return with_factor_ == 0 && !keeps_energy_of_contact_ &&
           ratio <= std::max(kGood, kExpected * forcing);
  }
  // Directions with H alone have not served: those of GMRES may.
  bool tries_again() override {
    constexpr int kDirections = 4;  // with GMRES, before H alone is tried again
    if (is_simple_) with_gmres_ = kDirections;
    return is_simple_;
  }

  bool find_direction(const RootProblem& problem, double forcing,
                      MinimizerReport& report) override {
    constexpr int kDirections = 50;  // that are found with the factor before it is left again
    constexpr double kFewestUseful = 1e-5;  // of relative residuals: the next iteration gains more
    begins_iteration_ = !is_probe_;
    if (with_factor_ > 0) {
      --with_factor_;
      return factor_->find(problem, at_, forcing, report, direction_);
    }
    // In steps that turn or strain the body much the Hessian changes with each iteration and is often
    // indefinite. A factor then serves one direction only.
    constexpr int kLastsInStep = 4;  // factors in a step
    if (report.factorizations > kLastsInStep && !is_refined()) linear_.leave_factor();
    is_simple_ = is_simple_ && problem.approximation().has_inertia() &&
                 find_simply(problem, forcing, report);
    if (is_simple_) return true;
    bool converged = false;
    if (find_without(problem, std::max(forcing, kFewestUseful), report, converged) &&
        (converged || !may_choose_)) {
      return true;
    }
    if (!may_choose_) return false;
    if (!factor_) factor_ = std::make_unique<FactorGmres>(system_);
    with_factor_ = kDirections;
    return factor_->find(problem, at_, forcing, report, direction_);
  }

  // direction_ ≈ −H⁻¹r. Returns false if H is not positive definite.
  bool find_simply(const RootProblem& problem, double forcing, MinimizerReport& report) {
    constexpr double kTightest = 1e-4;
    MinimizerReport inner;
    inner.residual = report.residual;
    const bool found =
        solve_with_hessian(problem, at_.force, std::clamp(forcing, kTightest, 0.1), inner);
    report.cg_iterations += inner.cg_iterations;
    report.factorizations += inner.factorizations;
    direction_ = preconditioned_.d;
    return found && !preconditioned_.curvature.found();
  }

  // preconditioned_ ≈ −H⁻¹ right.
  bool solve_with_hessian(const RootProblem& problem, const Vector& right, double forcing,
                          MinimizerReport& report) {
    const NewtonSystem system{problem.approximation(), point_,           right, forcing,
                              has_new_matrix_,         begins_iteration_};
    has_new_matrix_ = begins_iteration_ = false;
    return linear_.find(system, report, preconditioned_);
  }

  bool find_without(const RootProblem& problem, double forcing, MinimizerReport& report,
                    bool& converged) {
    // The relative residuals of a solve with the Hessian. More digits take more iterations of GMRES.
    constexpr double kTightest = 1e-3;
    constexpr double kLoosest = 0.05;
    const int most = may_choose_ ? 6 : 40;
    const FreeCoordinates& coordinates = problem.coordinates();
    MinimizerReport inner;
    inner.residual = report.residual;
    bool found = true;
    const GmresReport solved = gmres<true>(
        -coordinates.restrict(at_.force),
        [&](const Vector& y, Vector& product) { derivative_.multiply(problem, y, product); },
        [&](const Vector& y, Vector& z) {
          // Forces on the vertices whose generalised forces are −y.
          right_ = coordinates.extend(y.cwiseQuotient(reduced_mass_));
          for (Index v = 0; v < mass_.size(); ++v) vertex_block(right_, v) *= -mass_[v];
          found =
              found && solve_with_hessian(problem, right_,
                                          std::clamp(0.5 * forcing, kTightest, kLoosest), inner);
          z = found ? restrict_displacement(coordinates, preconditioned_.d) : y;
        },
        forcing, most, free_);
    report.cg_iterations += inner.cg_iterations;
    report.factorizations += inner.factorizations;
    direction_ = coordinates.extend(free_);
    converged = solved.reduction <= std::max(forcing, kLoosest);
    return found && direction_.allFinite() && solved.reduction < 1.0;
  }

  // The free coordinates of displacements T y: (TᵀMT)⁻¹TᵀM T y.
  Vector restrict_displacement(const FreeCoordinates& coordinates, const Vector& full) const {
    Vector weighted = full;
    for (Index v = 0; v < mass_.size(); ++v) vertex_block(weighted, v) *= mass_[v];
    return coordinates.restrict(weighted).cwiseQuotient(reduced_mass_);
  }

  const MechanicalSystem& system_;
  NewtonLinearSolver linear_;
  std::unique_ptr<FactorGmres> factor_;
  bool may_choose_;
  int with_factor_ = 0;  // directions to be found with the factor
  int with_gmres_ = 0;   // … and with GMRES, although H might serve alone
  bool keeps_energy_of_contact_ = false;
  bool is_simple_ = false;        // whether H serves alone for the present direction
  Vector point_;                  // u of the linearisation
  bool has_new_matrix_ = true;    // and whether the linear solvers do not know it yet
  bool begins_iteration_ = true;  // with the next solve
  const Vector& mass_;
  Vector reduced_mass_;
  Vector free_;  // direction_ over the free coordinates
  Derivative derivative_;
  Vector right_;  // work space, 3 per vertex, of the preconditioner
  NewtonDirection preconditioned_;
};

}  // namespace

std::unique_ptr<RootFinder> make_newton_root_finder(const MechanicalSystem& system,
                                                    const MinimizerOptions& options) {
  return std::make_unique<FactorRootFinder>(system, options);
}

std::unique_ptr<RootFinder> make_newton_krylov_root_finder(const MechanicalSystem& system,
                                                           const NewtonOptions& options) {
  return std::make_unique<KrylovRootFinder>(system, options);
}

}  // namespace tetraction
