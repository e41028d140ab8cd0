#include "scaled_matrix.h"

#include <Eigen/Eigenvalues>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kGrain = 2048;

}  // namespace

ScaledMatrix::ScaledMatrix(const MechanicalSystem& system)
    : system_(system),
      inverse_root_mass_(
          system.coordinates().reduced_mass(system.mass()).cwiseSqrt().cwiseInverse()) {}

void ScaledMatrix::set_stiffness(const Vector& q, double damping_weight) {
  q_ = &q;
  stiffness_ = 1.0;
  damping_ = system_.damping().none() ? 0.0 : damping_weight;
  products_ = 0;
  if (!TangentOperator<float>::supports(system_.elastic())) {
    tangent_.reset();
    return;
  }
  if (!tangent_) {
    tangent_ = std::make_unique<TangentOperator<float>>(system_.elastic());
    viscous_ = std::make_unique<ViscousPotential>(system_.elastic());
    rows_.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * system_.vertex_count()));
  }
  // η |E(x) − E(q)|²/s has the second derivative C/s at x = q.
  viscous_->begin(q, damping_ * system_.damping().viscosity);
  tangent_->set(q, *viscous_, Vector::Zero(q.size()));
}

void ScaledMatrix::set_damping(const Vector& q) {
  q_ = &q;
  stiffness_ = 0.0;
  damping_ = 1.0;
  products_ = 0;
}

void ScaledMatrix::perform_op(const double* in, double* out) const {
  ++products_;
  const Vector u = displacement(Eigen::Map<const Vector>(in, rows()));
  if (stiffness_ != 0.0) {
    multiply_stiffness(u);
    add_vertex_terms(u);
  } else {
    product_.setZero(system_.dof_count());
  }
  if (damping_ != 0.0) multiply_damping(u);
  Eigen::Map<Vector>(out, rows()) =
      inverse_root_mass_.cwiseProduct(system_.coordinates().restrict(product_));
}

Vector ScaledMatrix::displacement(const Vector& eigenvector) const {
  return system_.coordinates().extend(inverse_root_mass_.cwiseProduct(eigenvector));
}

Vector ScaledMatrix::stiffest_vertex() const {
  if (!tangent_) return {};
  AlignedVector<float> on;
  AlignedVector<float> off;
  tangent_->diagonal(on, off);
  Index stiffest = -1;
  double most = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (!system_.coordinates().is_free(v)) continue;
    const float* row = on.data() + ElementBlocks::kRowSize * v;
    const double trace = static_cast<double>(row[0] + row[1] + row[2]) / system_.mass()[v];
    if (trace > most) {
      most = trace;
      stiffest = v;
    }
  }
  if (stiffest < 0) return {};
  const float* d = on.data() + ElementBlocks::kRowSize * stiffest;
  const float* o = off.data() + ElementBlocks::kRowSize * stiffest;
  Eigen::Matrix3f block;
  block << d[0], o[0], o[1], o[0], d[1], o[2], o[1], o[2], d[2];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(block);
  Vector alone = Vector::Zero(rows());
  alone.segment<3>(system_.coordinates().first(stiffest)) =
      solver.eigenvectors().col(2).cast<double>();
  return alone;
}

void ScaledMatrix::multiply_stiffness(const Vector& u) const {
  if (!tangent_) {
    system_.elastic().product(*q_, u, product_);
    if (damping_ != 0.0) {
      force_.setZero(system_.dof_count());
      system_.add_viscous_force(*q_, u, force_);
      product_ -= damping_ * force_;
    }
    return;
  }
  const float scale = static_cast<float>(u.cwiseAbs().maxCoeff());
  parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      float* row = rows_.data() + ElementBlocks::kRowSize * v;
      for (Index i = 0; i < 3; ++i) row[i] = static_cast<float>(u[3 * v + i]) / scale;
      row[3] = 0.0F;
    }
  });
  tangent_->multiply(rows_.data());
  product_.resize(system_.dof_count());
  parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(product_, v) =
          static_cast<double>(scale) * tangent_->row_sum(v).head<3>().cast<double>();
    }
  });
}

// Drag and mass damping; viscosity where it is not in the tangent.
void ScaledMatrix::multiply_damping(const Vector& u) const {
  force_.setZero(system_.dof_count());
  system_.add_drag_force(u, force_);
  if (stiffness_ == 0.0) system_.add_viscous_force(*q_, u, force_);
  product_ -= damping_ * force_;
}

void ScaledMatrix::add_vertex_terms(const Vector& u) const {
  if (!system_.environment().is_uniform()) {
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      vertex_block(product_, v) +=
          system_.environment().hessian(system_.mass()[v], vertex_block(*q_, v)) *
          vertex_block(u, v);
    }
  }
  if (system_.constraints().has_springs()) {
    product_ += system_.constraints().spring_stiffness().cwiseProduct(u);
  }
}

}  // namespace tetraction
