#include "potential_restraint.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tetraction {

bool Potentials::couple(const std::vector<Index>& vertices) const {
  return std::any_of(
      hessian.outer_vertices().begin(), hessian.outer_vertices().end(),
      [&](Index v) { return std::binary_search(vertices.begin(), vertices.end(), v); });
}

Potentials potentials_of(const MechanicalSystem& system, const Vector& x, double time,
                         Contact::Support support, Potentials::Kind kind) {
  Potentials result;
  result.gradient = Vector::Zero(system.dof_count());
  result.hessian.reset(system.vertex_count());
  const ForcePoint at = system.force_point(x, time);
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->uniform_acceleration()) continue;
    const bool is_load = term->account() == EnergyAccount::kExternalWork;
    if (kind == Potentials::kWithoutLoads && is_load) continue;
    HessianBlocks hessian;
    hessian.reset(system.vertex_count());
    if (term == system.contact()) {
      system.contact()->add_support(at, support, hessian);
    } else {
      term->add_hessian(at, HessianForm::kExact, hessian);
    }
    if (kind == Potentials::kWithoutMeans && !hessian.outers().empty()) continue;
    result.any = true;
    if (term != system.contact()) term->add_gradient(at, result.gradient);
    result.hessian.add(hessian, 1.0);
  }
  if (kind == Potentials::kWithoutLoads) return result;
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_load() || !term->load_depends_on_position()) continue;
    Vector load = Vector::Zero(system.dof_count());
    term->add_load(at, load);
    result.gradient -= load;
    term->add_load_stiffness(at, result.loads);
  }
  return result;
}

Matrix restraint_of(const MechanicalSystem& system, const Potentials& potentials,
                    const std::vector<Index>& vertices, double size, const Matrix& fields,
                    const Matrix& spins) {
  Matrix changes = Matrix::Zero(fields.rows(), fields.cols());
  for (Index mode = 0; mode < fields.cols(); ++mode) {
    Vector change = Vector::Zero(fields.rows());
    const Vector motion = fields.col(mode);
    potentials.hessian.add_product(motion, change);
    potentials.loads.add_product(motion, change);
    for (const Index v : vertices) {
      const Vector3 spin = spins.col(mode).segment<3>(3 * v);
      vertex_block(change, v) -= spin.cross(vertex_block(potentials.gradient, v));
      if (system.coordinates().is_free(v) || system.coordinates().set_of(v) >= 0) continue;
      const auto columns = system.coordinates().map(v).columns;
      vertex_block(change, v) = columns * (columns.transpose() * vertex_block(change, v)).eval();
    }
    changes.col(mode) = change;
  }
  double scale = 0.0;
  for (const Index v : vertices) {
    scale += potentials.hessian.diagonal(v).squaredNorm() +
             vertex_block(potentials.gradient, v).squaredNorm() / (size * size);
  }
  const auto is_own = [&](Index v) {
    return std::binary_search(vertices.begin(), vertices.end(), v);
  };
  for (const HessianBlocks::Pair& pair : potentials.hessian.pairs()) {
    if (is_own(pair.row)) scale += 2.0 * pair.block.squaredNorm();
  }
  for (const HessianBlocks::Outer& outer : potentials.hessian.outers()) {
    double own = 0.0;  // Σ |b_v|² over the part, and Σ |b_v| over all vertices
    double all = 0.0;
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      const double length = potentials.hessian.outer_vectors()[i].norm();
      if (is_own(potentials.hessian.outer_vertices()[i])) own += length * length;
      all += length;
    }
    scale += outer.factor * outer.factor * own * all * all;
  }
  for (const LoadStiffness::Block& block : potentials.loads.blocks()) {
    if (is_own(block.row)) scale += block.block.squaredNorm();
  }
  return scale > 0.0 ? Matrix(changes.transpose() * changes / scale)
                     : Matrix(Matrix::Zero(fields.cols(), fields.cols()));
}

}  // namespace tetraction
