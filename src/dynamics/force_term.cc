#include "tetraction/dynamics/force_term.h"

namespace tetraction {

void HessianBlocks::reset(Index vertex_count) {
  diagonal_.setZero(3, 3 * vertex_count);
  pairs_.clear();
}

void HessianBlocks::add_pair(Index i, Index j, const Matrix3& block) {
  pairs_.push_back({i, j, block});
}

void HessianBlocks::scale(double factor) {
  diagonal_ *= factor;
  for (Pair& pair : pairs_) pair.block *= factor;
}

void HessianBlocks::add_product(const Vector& u, Vector& product) const {
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(product, v) += diagonal(v) * vertex_block(u, v);
  }
  for (const Pair& pair : pairs_) {
    vertex_block(product, pair.row) += pair.block * vertex_block(u, pair.column);
    vertex_block(product, pair.column) += pair.block.transpose() * vertex_block(u, pair.row);
  }
}

Index ForceTerm::undefined_vertex(const ForcePoint&) const {
  return -1;
}

double ForceTerm::longest_step(const ForcePoint&, const Vector&) const {
  return std::numeric_limits<double>::infinity();
}

double ForceTerm::energy(const ForcePoint&) const {
  return 0.0;
}

double ForceTerm::energy_change(const ForcePoint& from, const ForcePoint& to) const {
  return energy(to) - energy(from);
}

void ForceTerm::add_gradient(const ForcePoint&, Vector&) const {}

void ForceTerm::add_hessian(const ForcePoint&, HessianForm, HessianBlocks&) const {}

double ForceTerm::driven_work(const ForcePoint&, const ForcePoint&) const {
  return 0.0;
}

double ForceTerm::dissipation(const ForcePoint&, const Vector&) const {
  return 0.0;
}

void ForceTerm::add_dissipation_gradient(const ForcePoint&, const Vector&, Vector&) const {}

void ForceTerm::add_dissipation_hessian(const ForcePoint&, const Vector&, HessianForm,
                                        HessianBlocks&) const {}

void ForceTerm::add_load(const ForcePoint&, Vector&) const {}

void ForceTerm::add_load_stiffness(const ForcePoint&, HessianBlocks&) const {}

}  // namespace tetraction
