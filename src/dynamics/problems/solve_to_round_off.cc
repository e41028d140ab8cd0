#include "solve_to_round_off.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/parallel.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {
namespace {

// ½ε times the root sum of squares of the elements' |∇²W_e| ℓ at u, N.
double round_off_of_stiffness(const PotentialProblem& problem, const Vector& u) {
  const MinimizationProblem::HessianParts parts = problem.hessian_parts(u);
  const RestState& rest = parts.elastic.rest();
  const auto position = [&](Index v) {
    Vector3 x = vertex_block(parts.positions.origin(), v);
    if (const Vector* moved = parts.positions.displacement()) x += vertex_block(*moved, v);
    return x;
  };
  const double own = parallel_sum(rest.element_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    ElasticPotential::ElementTerms terms;
    for (Index e = begin; e < end; ++e) {
      if (!parts.elastic.element_terms(e, parts.positions, true, terms)) continue;
      const auto nodes = rest.nodes(e);
      double length = 0.0;
      for (const Index v : nodes)
        length = std::max(length, (position(v) - position(nodes[0])).norm());
      sum += terms.hessian.squaredNorm() * length * length;
    }
    return sum;
  });
  return 0.5 * std::numeric_limits<double>::epsilon() *
         std::sqrt(sum_over_parts(problem.system().part(), own));
}

}  // namespace

bool is_round_off(const PotentialProblem& problem, const Vector& u, double residual) {
  return residual <= kRoundOffMargin * problem.round_off(u) ||
         residual <= round_off_of_stiffness(problem, u);
}

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
  if (is_round_off(problem, u, report.residual)) {
    report.termination = all.termination = Termination::kConverged;
  }
  return report;
}

}  // namespace tetraction
