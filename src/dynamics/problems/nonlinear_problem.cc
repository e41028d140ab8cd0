#include "tetraction/dynamics/problems/nonlinear_problem.h"

#include <algorithm>

#include "fem/element_blocks.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/dynamics/problems/minimizer.h"

namespace tetraction {

double NonlinearProblem::residual_limit(const Vector& u, double tolerance) const {
  return std::max(tolerance * force_scale(), round_off(u));
}

EvaluationStatus MinimizationProblem::value_and_gradient(const Vector& u, double& phi,
                                                         Vector& gradient) const {
  Vector full;
  const EvaluationStatus status = value_and_full_gradient(u, phi, full);
  if (status.ok()) gradient = coordinates().restrict(full);
  return status;
}

EvaluationStatus MinimizationProblem::residual(const Vector& u, Vector& residual) const {
  double phi = 0.0;
  return value_and_full_gradient(u, phi, residual);
}

EvaluationStatus MinimizationProblem::hessian(const Vector& u, const HessianBlocks& terms,
                                              const SparsityPattern& pattern,
                                              double* values) const {
  std::fill(values, values + pattern.nonzeros(), 0.0);
  const HessianParts parts = hessian_parts(u);
  const double* tensions =
      parts.volume == nullptr ? nullptr : parts.volume->tensions(parts.positions).data();
  const EvaluationStatus status =
      BlockAccess::add_hessian(parts.elastic, parts.positions, tensions, pattern, values);
  if (!status.ok()) return status;
  parts.viscous.add_hessian(parts.step_displacement, pattern, values);
  Matrix blocks = Matrix::Zero(3, u.size());
  for (Index v = 0; v < u.size() / 3; ++v) {
    blocks.middleCols<3>(3 * v).diagonal() = vertex_block(parts.diagonal, v);
  }
  if (has_general_terms() || parts.volume != nullptr) blocks += terms.whole_diagonal();
  pattern.add_vertex_blocks(blocks, values);
  terms.for_each_pair(
      [&](Index i, Index j, const Matrix3& block) { pattern.add_pair_block(i, j, block, values); });
  return status;
}

bool make_admissible(const NonlinearProblem& problem, Vector& u) {
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    if (problem.is_defined(u)) return true;
    u *= 0.5;
  }
  u.setZero();
  return problem.is_defined(u);
}

}  // namespace tetraction
