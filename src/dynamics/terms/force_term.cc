#include "tetraction/dynamics/terms/force_term.h"

#include <cmath>
#include <limits>

#include "dynamics/constraints/rigid_motions.h"

namespace tetraction {

void HessianBlocks::reset(Index vertex_count) {
  diagonal_.setZero(3, 3 * vertex_count);
  pairs_.clear();
  outers_.clear();
  outer_vertices_.clear();
  outer_vectors_.clear();
}

void HessianBlocks::add_pair(Index i, Index j, const Matrix3& block) {
  pairs_.push_back({i, j, block});
}

void HessianBlocks::add_outer(double factor, std::span<const Index> vertices,
                              std::span<const Vector3> vectors) {
  const std::size_t begin = outer_vertices_.size();
  outer_vertices_.insert(outer_vertices_.end(), vertices.begin(), vertices.end());
  outer_vectors_.insert(outer_vectors_.end(), vectors.begin(), vectors.end());
  outers_.push_back({factor, begin, outer_vertices_.size()});
}

void HessianBlocks::add(const HessianBlocks& other, double factor) {
  diagonal_ += factor * other.diagonal_;
  for (const Pair& pair : other.pairs_) {
    pairs_.push_back({pair.row, pair.column, factor * pair.block});
  }
  const std::size_t shift = outer_vertices_.size();
  for (const Outer& outer : other.outers_) {
    outers_.push_back({factor * outer.factor, outer.begin + shift, outer.end + shift});
  }
  outer_vertices_.insert(outer_vertices_.end(), other.outer_vertices_.begin(),
                         other.outer_vertices_.end());
  outer_vectors_.insert(outer_vectors_.end(), other.outer_vectors_.begin(),
                        other.outer_vectors_.end());
}

Matrix HessianBlocks::whole_diagonal() const {
  Matrix whole = diagonal_;
  for (const Outer& outer : outers_) {
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      whole.block<3, 3>(0, 3 * outer_vertices_[i]) +=
          outer.factor * outer_vectors_[i] * outer_vectors_[i].transpose();
    }
  }
  return whole;
}

void HessianBlocks::scale(double factor) {
  diagonal_ *= factor;
  for (Pair& pair : pairs_) pair.block *= factor;
  for (Outer& outer : outers_) outer.factor *= factor;
}

void HessianBlocks::add_product(const Vector& u, Vector& product) const {
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(product, v) += diagonal(v) * vertex_block(u, v);
  }
  for (const Pair& pair : pairs_) {
    vertex_block(product, pair.row) += pair.block * vertex_block(u, pair.column);
    vertex_block(product, pair.column) += pair.block.transpose() * vertex_block(u, pair.row);
  }
  for (const Outer& outer : outers_) {
    double sum = 0.0;
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      sum += outer_vectors_[i].dot(vertex_block(u, outer_vertices_[i]));
    }
    sum *= outer.factor;
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      vertex_block(product, outer_vertices_[i]) += sum * outer_vectors_[i];
    }
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

void ForceTerm::add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                      Vector& gradient) const {
  Vector force = Vector::Zero(from.position.size());
  if (is_quadratic()) {
    add_gradient(from, force);
    add_gradient(to, force);
    gradient += 0.5 * force;
    return;
  }
  const TimeSpan span{from.time, to.time};
  const double time = 0.5 * (from.time + to.time);
  const Vector middle = 0.5 * (from.position + to.position);
  add_gradient({from.mass, middle, time, span}, force);
  const Vector displacement = to.position - from.position;
  const ForcePoint start{from.mass, from.position, time, span};
  const ForcePoint end{to.mass, to.position, time, span};
  const double change = energy_change(from, to) - driven_work(from, to);
  const double linear = force.dot(displacement);
  gradient += force;
  const double rest = change - linear;
  // A difference that may be round-off, divided by a small distance, would give a force that is far too large.
  const double round_off = 64.0 * std::numeric_limits<double>::epsilon() *
                           (std::abs(energy(start)) + std::abs(energy(end)) + std::abs(linear));
  if (!(std::abs(rest) > round_off)) return;
  Vector ends = Vector::Zero(middle.size());
  add_gradient(start, ends);
  Vector at_end = Vector::Zero(middle.size());
  add_gradient(end, at_end);
  std::vector<bool> acts(static_cast<std::size_t>(middle.size() / 3));
  Vector along = Vector::Zero(middle.size());
  for (std::size_t v = 0; v < acts.size(); ++v) {
    const auto i = static_cast<Index>(v);
    acts[v] = !vertex_block(force, i).isZero(0.0) || !vertex_block(ends, i).isZero(0.0) ||
              !vertex_block(at_end, i).isZero(0.0);
    if (acts[v]) vertex_block(along, i) = vertex_block(displacement, i);
  }
  const double size = along.squaredNorm();
  if (is_in_balance(middle, force)) along = without_rigid_motion(middle, along, acts);
  // A rigid motion does not change the energy of a term that is in balance everywhere.
  const double square = along.squaredNorm();
  if (square > 1e-20 * size) gradient += rest / square * along;
}

void LoadStiffness::add_product(const Vector& u, Vector& product) const {
  for (const auto& [row, column, block] : blocks_) {
    vertex_block(product, row) += block * vertex_block(u, column);
  }
}

void LoadStiffness::add_transposed_product(const Vector& u, Vector& product) const {
  for (const auto& [row, column, block] : blocks_) {
    vertex_block(product, column) += block.transpose() * vertex_block(u, row);
  }
}

void LoadStiffness::add_symmetric_part(HessianBlocks& hessian) const {
  for (const auto& [row, column, block] : blocks_) {
    const Matrix3 half = 0.5 * block;
    if (row == column) {
      hessian.add(row, half + half.transpose());
    } else {
      hessian.add_pair(row, column, half);
    }
  }
}

double ForceTerm::dissipation(const ForcePoint&, const Vector&) const {
  return 0.0;
}

void ForceTerm::add_dissipation_gradient(const ForcePoint&, const Vector&, Vector&) const {}

void ForceTerm::add_dissipation_hessian(const ForcePoint&, const Vector&, HessianForm,
                                        HessianBlocks&) const {}

void ForceTerm::add_load(const ForcePoint&, Vector&) const {}

void ForceTerm::add_load_stiffness(const ForcePoint& at, LoadStiffness& stiffness) const {
  if (!load_depends_on_position()) return;
  const Index count = at.position.size() / 3;
  const auto points = at.position.reshaped(3, count);
  const double size = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  const double length = std::cbrt(std::numeric_limits<double>::epsilon()) * size;
  Vector position = at.position;
  const ForcePoint moved{at.mass, position, at.time, at.step};
  Matrix columns(at.position.size(), 3);
  for (Index v = 0; v < count; ++v) {
    for (Index i = 0; i < 3; ++i) {
      double& coordinate = position[3 * v + i];
      const double before = coordinate;
      Vector ahead = Vector::Zero(position.size());
      Vector behind = ahead;
      coordinate = before + length;
      const double above = coordinate;
      add_load(moved, ahead);
      coordinate = before - length;
      const double below = coordinate;
      add_load(moved, behind);
      coordinate = before;
      columns.col(i) = (behind - ahead) / (above - below);
    }
    for (Index w = 0; w < count; ++w) {
      const Matrix3 block = columns.middleRows<3>(3 * w);
      if (!block.isZero(0.0)) stiffness.add(w, v, block);
    }
  }
}

}  // namespace tetraction
