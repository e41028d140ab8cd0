#include "scaled_matrix.h"

#include <cmath>

#include "core/decompositions.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
ScaledMatrix::ScaledMatrix(const MechanicalSystem& system)
    : system_(system),
      inverse_root_mass_(
          system.coordinates().reduced_mass(system.mass()).cwiseSqrt().cwiseInverse()) {}

void ScaledMatrix::set_stiffness(const Vector& q, double time, double damping_weight) {
  q_ = &q;
  stiffness_ = 1.0;
  damping_ = system_.is_dissipative() ? damping_weight : 0.0;
  products_ = 0;
  set_equations();
  gather_terms(time);
  if (!TangentOperator<float>::supports(system_.elastic())) {
    tangent_.reset();
    return;
  }
  if (!tangent_) {
    tangent_ = std::make_unique<TangentOperator<float>>(system_.elastic());
    viscous_ = std::make_unique<ViscousPotential>(system_.elastic());
    rows_.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * system_.vertex_count()));
  }
  // η |E(x) − E(q)|²/s has the second derivative C/s at x = q.
  viscous_->begin(q, damping_ * system_.damping().viscosity);
  const NodalVolume* volume = system_.nodal_volume();
  tangent_->set(q, *viscous_, Vector::Zero(q.size()),
                volume == nullptr ? nullptr : volume->tensions(q).data());
}

void ScaledMatrix::set_damping(const Vector& q, double time) {
  q_ = &q;
  stiffness_ = 0.0;
  damping_ = 1.0;
  products_ = 0;
  set_equations();
  gather_terms(time);
}

// The Hessians of the potentials, and those of the dissipation potentials at rest.
void ScaledMatrix::gather_terms(double time) {
  has_terms_ = false;
  terms_.reset(system_.vertex_count());
  const ForcePoint at = system_.force_point(*q_, time);
  if (damping_ != 0.0) {
    const Vector rest = Vector::Zero(system_.dof_count());
    for (const ForceTerm* term : system_.force_terms()) {
      if (!term->has_dissipation()) continue;
      term->add_dissipation_hessian(at, rest, HessianForm::kExact, terms_);
      has_terms_ = true;
    }
    if (has_terms_) terms_.scale(damping_);
  }
  if (stiffness_ == 0.0) return;
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || term->uniform_acceleration()) continue;
    term->add_hessian(at, HessianForm::kExact, terms_);
    has_terms_ = true;
  }
  if (const NodalVolume* volume = system_.nodal_volume(); volume != nullptr) {
    volume->add_outer_products(*q_, HessianForm::kExact, terms_);
    has_terms_ = true;
  }
}

void ScaledMatrix::set_equations() {
  const Constraints& constraints = system_.constraints();
  if (!constraints.has_equations()) return;
  const Constraints::SparseMatrix reduced =
      constraints.sparse_selector() * constraints.sparse_gradients(constraints.configuration(*q_));
  gradients_ = inverse_root_mass_.asDiagonal() * reduced;
  const Constraints::SparseMatrix matrix =
      Constraints::SparseMatrix(gradients_.transpose()) * gradients_;
  Vector unit = matrix.diagonal();
  for (double& each : unit) each = each > 0.0 ? 1.0 / std::sqrt(each) : 1.0;
  multipliers_.emplace(matrix, unit);
}

Vector ScaledMatrix::project(Vector x) const {
  if (multipliers_) x -= gradients_ * multipliers_->solve(gradients_.transpose() * x);
  return x;
}

void ScaledMatrix::perform_op(const double* in, double* out) const {
  ++products_;
  const Vector u = displacement(project(Eigen::Map<const Vector>(in, rows())));
  if (stiffness_ != 0.0) {
    multiply_stiffness(u);
  } else {
    product_.setZero(system_.dof_count());
  }
  if (stiffness_ == 0.0) multiply_damping(u);
  if (has_terms_) terms_.add_product(u, product_);
  Eigen::Map<Vector>(out, rows()) =
      project(inverse_root_mass_.cwiseProduct(system_.coordinates().restrict(product_)));
}

// The coordinates of single vertices come in the order of the vertices, the own ones first.
double ScaledMatrix::dot(const Vector& x, const Vector& y) const {
  if (system_.part() == nullptr) return x.dot(y);
  const Index own = own_freedom_count(system_);
  return sum_over_parts(system_.part(), x.head(own).dot(y.head(own)));
}

Vector ScaledMatrix::pseudo_random_start() const {
  Vector field(system_.dof_count());
  for (Index i = 0; i < field.size(); ++i) {
    const auto id = static_cast<std::uint64_t>(system_.mesh().vertex_id(i / 3));
    // The finalizer of SplitMix64.
    std::uint64_t z = 3 * id + static_cast<std::uint64_t>(i % 3) + 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    field[i] = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-52 - 1.0;
  }
  return system_.coordinates().restrict(field);
}

Vector ScaledMatrix::displacement(const Vector& eigenvector) const {
  return system_.coordinates().extend(inverse_root_mass_.cwiseProduct(eigenvector));
}

Vector ScaledMatrix::stiffest_vertex() const {
  if (!tangent_) return {};
  AlignedVector<float> on;
  AlignedVector<float> off;
  tangent_->diagonal(on, off);
  // Only nodal volumes are so stiff that the choice depends on terms.
  Matrix terms = Matrix::Zero(3, 3 * system_.vertex_count());
  if (system_.nodal_volume() != nullptr) terms = terms_.whole_diagonal();
  Index stiffest = -1;
  double most = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (!system_.coordinates().is_free(v)) continue;
    const float* row = on.data() + ElementBlocks::kRecordSize * v;
    const double trace =
        (static_cast<double>(row[0] + row[1] + row[2]) + terms.middleCols<3>(3 * v).trace()) /
        system_.mass()[v];
    if (trace > most) {
      most = trace;
      stiffest = v;
    }
  }
  if (stiffest < 0) return {};
  const float* d = on.data() + ElementBlocks::kRecordSize * stiffest;
  const float* o = off.data() + ElementBlocks::kRecordSize * stiffest;
  Matrix3 block;
  block << d[0], o[0], o[1], o[0], d[1], o[2], o[1], o[2], d[2];
  block += terms.middleCols<3>(3 * stiffest);
  Vector alone = Vector::Zero(rows());
  alone.segment<3>(system_.coordinates().first(stiffest)) = symmetric_eigen(block).vectors.col(2);
  return alone;
}

void ScaledMatrix::multiply_stiffness(const Vector& u) const {
  if (!tangent_) {
    system_.elastic().product(*q_, u, product_);
    add_shared(system_.part(), product_, 3);
    if (damping_ != 0.0) {
      force_.setZero(system_.dof_count());
      system_.add_viscous_force(*q_, u, force_);
      product_ -= damping_ * force_;
    }
    return;
  }
  float scale = static_cast<float>(u.cwiseAbs().maxCoeff());
  if (scale == 0.0F) scale = 1.0F;  // nothing moves in this part of the body
  parallel_for(system_.vertex_count(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      float* row = rows_.data() + ElementBlocks::kRecordSize * v;
      for (Index i = 0; i < 3; ++i) row[i] = static_cast<float>(u[3 * v + i]) / scale;
      row[3] = 0.0F;
    }
  });
  tangent_->multiply(rows_.data());
  product_.resize(system_.dof_count());
  parallel_for(system_.vertex_count(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(product_, v) =
          static_cast<double>(scale) * tangent_->record_sum(v).head<3>().cast<double>();
    }
  });
  add_shared(system_.part(), product_, 3);
}

// Viscosity alone.
void ScaledMatrix::multiply_damping(const Vector& u) const {
  force_.setZero(system_.dof_count());
  system_.add_viscous_force(*q_, u, force_);
  product_ -= damping_ * force_;
}

}  // namespace tetraction
