#include "solve_to_round_off.h"

#include <utility>

namespace tetraction {

void add_call(const MinimizerReport& report, MinimizerReport& all) {
  const MinimizerReport before = std::exchange(all, report);
  all.iterations += before.iterations;
  all.factorizations += before.factorizations;
  all.cg_iterations += before.cg_iterations;
  all.met_negative_curvature |= before.met_negative_curvature;
}

MinimizerReport solve_to_round_off(PotentialProblem& problem, Vector& u, MinimizerReport& all,
                                   const std::function<MinimizerReport()>& call) {
  constexpr int kMoves = 4;
  const auto solve = [&] {
    MinimizerReport report = call();
    add_call(report, all);
    return report;
  };
  MinimizerReport report = solve();
  for (int i = 0; i < kMoves && report.termination == Termination::kNoProgress; ++i) {
    const double before = report.residual;
    problem.move_origin(u);
    report = solve();
    if (i > 0 && report.residual > 0.5 * before) break;
  }
  if (report.termination != Termination::kNoProgress) return report;
  problem.move_origin(u);
  if (report.residual <= kRoundOffMargin * problem.round_off(u)) {
    report.termination = all.termination = Termination::kConverged;
  }
  return report;
}

}  // namespace tetraction
