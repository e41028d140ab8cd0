#include "tetraction/dynamics/terms/vertex_pull.h"

#include <utility>

namespace tetraction {

VertexPull::VertexPull(std::vector<Index> vertices, const Vector& mass, const Vector3& target,
                       double stiffness, double damping)
    : vertices_(std::move(vertices)), target_(target), stiffness_(stiffness), damping_(damping) {
  double sum = 0.0;
  for (const Index v : vertices_) sum += mass[v];
  for (const Index v : vertices_) weights_.push_back(mass[v] / sum);
}

Vector3 VertexPull::mean(const Vector& field) const {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    sum += weights_[i] * vertex_block(field, vertices_[i]);
  }
  return sum;
}

void VertexPull::add(const Vector3& total, Vector& gradient) const {
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    vertex_block(gradient, vertices_[i]) += weights_[i] * total;
  }
}

void VertexPull::add_outer(double factor, HessianBlocks& hessian) const {
  if (vertices_.size() == 1) {
    hessian.add(vertices_.front(), factor * Matrix3::Identity());
    return;
  }
  std::vector<Vector3> vectors(vertices_.size());
  for (Index axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < vectors.size(); ++i) {
      vectors[i] = weights_[i] * Vector3::Unit(axis);
    }
    hessian.add_outer(factor, vertices_, vectors);
  }
}

double VertexPull::energy(const ForcePoint& at) const {
  return 0.5 * stiffness_ * (mean(at.position) - target_).squaredNorm();
}

double VertexPull::energy_change(const ForcePoint& from, const ForcePoint& to) const {
  const Vector3 start = mean(from.position) - target_;
  const Vector3 end = mean(to.position) - target_;
  return 0.5 * stiffness_ * (end - start).dot(start + end);
}

void VertexPull::add_gradient(const ForcePoint& at, Vector& gradient) const {
  add(stiffness_ * (mean(at.position) - target_), gradient);
}

void VertexPull::add_hessian(const ForcePoint& /*at*/, HessianForm /*form*/,
                             HessianBlocks& hessian) const {
  add_outer(stiffness_, hessian);
}

void VertexPull::add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                       Vector& gradient) const {
  add(stiffness_ * (0.5 * (mean(from.position) + mean(to.position)) - target_), gradient);
}

double VertexPull::dissipation(const ForcePoint& /*at*/, const Vector& v) const {
  return 0.5 * damping_ * mean(v).squaredNorm();
}

void VertexPull::add_dissipation_gradient(const ForcePoint& /*at*/, const Vector& v,
                                          Vector& gradient) const {
  add(damping_ * mean(v), gradient);
}

void VertexPull::add_dissipation_hessian(const ForcePoint& /*at*/, const Vector& /*v*/,
                                         HessianForm /*form*/, HessianBlocks& hessian) const {
  add_outer(damping_, hessian);
}

}  // namespace tetraction
