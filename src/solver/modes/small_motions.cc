#include "small_motions.h"

#include <fmt/format.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>

#include "fem/element_blocks.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

// An orthonormal basis of the columns' span. Columns below `tolerance`, relative to the largest one,
// count as dependent.
Matrix orthonormal_basis(const Matrix& columns, double tolerance) {
  if (columns.cols() == 0 || columns.isZero(0.0)) return Matrix(columns.rows(), 0);
  Eigen::ColPivHouseholderQR<Matrix> qr;
  qr.setThreshold(tolerance);
  qr.compute(columns);
  return qr.householderQ() * Matrix::Identity(columns.rows(), qr.rank());
}

}  // namespace

Vector momentum_of_modes(const MechanicalSystem& system, const Vector& velocity) {
  return system.rest().is_quadratic() ? consistent_momentum(system, velocity)
                                      : system.momentum_of(velocity);
}

template <class Visit>
void ScaledStiffness::for_each_entry(const Visit& visit) const {
  const std::vector<int>& begin = pattern_->column_begin();
  for (Index j = 0; j < pattern_->size(); ++j) {
    const auto end = static_cast<std::size_t>(begin[static_cast<std::size_t>(j) + 1]);
    for (auto k = static_cast<std::size_t>(begin[static_cast<std::size_t>(j)]); k < end; ++k) {
      visit(k, Index{pattern_->rows()[k]}, j);
    }
  }
}

ScaledStiffness::ScaledStiffness(const MechanicalSystem& system, const Vector& q, double time,
                                 bool with_loads, double load_factor, Mass mass)
    : system_(system),
      coordinates_(system.coordinates()),
      inverse_root_mass_(coordinates_.reduced_mass(system.mass()).cwiseSqrt().cwiseInverse()),
      position_(q) {
  const ForcePoint at = system.force_point(q, time);
  terms_.reset(system.vertex_count());
  terms_gradient_.setZero(system.dof_count());
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->uniform_acceleration()) continue;
    if (term->account() == EnergyAccount::kExternalWork && !with_loads) continue;
    const bool is_constraint = term->account() == EnergyAccount::kConstraintWork;
    const double weight = is_constraint ? 1.0 : load_factor;
    HessianBlocks blocks;
    blocks.reset(system.vertex_count());
    term->add_hessian(at, HessianForm::kExact, blocks);
    terms_.add(blocks, weight);
    Vector gradient = Vector::Zero(system.dof_count());
    term->add_gradient(at, gradient);
    terms_gradient_ += weight * gradient;
  }
  for (const ForceTerm* term : system.force_terms()) {
    if (with_loads && term->has_load() && term->load_depends_on_position()) {
      LoadStiffness of_load(load_factor);
      term->add_load_stiffness(at, of_load);
      of_load.add_symmetric_part(terms_);
      Vector load = Vector::Zero(system.dof_count());
      term->add_load(at, load);
      terms_gradient_ -= load_factor * load;
    }
  }
  HessianBlocks blocks = terms_;
  if (system.nodal_volume() != nullptr) {
    system.nodal_volume()->add_outer_products(q, HessianForm::kExact, blocks);
  }
  std::vector<std::pair<Index, Index>> pairs;
  blocks.for_each_pair([&](Index i, Index j, const Matrix3&) { pairs.emplace_back(i, j); });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  pattern_ = std::make_unique<SparsityPattern>(system.rest(), coordinates_, pairs);
  values_.assign(static_cast<std::size_t>(pattern_->nonzeros()), 0.0);
  const double* tensions =
      system.nodal_volume() == nullptr ? nullptr : system.nodal_volume()->tensions(q).data();
  const EvaluationStatus status =
      BlockAccess::add_hessian(system.elastic(), q, tensions, *pattern_, values_.data());
  if (!status.ok()) {
    throw InputError(fmt::format(
        "The modes cannot be computed: the elastic energy of element {} is not defined.",
        system.mesh().tetrahedron_id(status.failed_element)));
  }
  pattern_->add_vertex_blocks(blocks.whole_diagonal(), values_.data());
  blocks.for_each_pair([&](Index i, Index j, const Matrix3& block) {
    pattern_->add_pair_block(i, j, block, values_.data());
  });
  for_each_entry([&](std::size_t k, Index i, Index j) {
    values_[k] *= inverse_root_mass_[i] * inverse_root_mass_[j];
    if (i == j) largest_ = std::max(largest_, std::abs(values_[k]));
  });
  if (!std::all_of(values_.begin(), values_.end(), [](double x) { return std::isfinite(x); })) {
    throw InputError(
        "The modes cannot be computed, as the stiffness over the mass overflows: choose other "
        "units, or moduli, density and penalties that are less far apart in size.");
  }
  if (mass == Mass::kOfElements && system.rest().is_quadratic()) find_mass();
}

void ScaledStiffness::find_mass() {
  const RestState& rest = system_.rest();
  mass_values_.assign(values_.size(), 0.0);
  Matrix local;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Matrix mass = system_.density(e) * element_mass_matrix(rest, e);
    local.setZero(3 * mass.rows(), 3 * mass.cols());
    for (Index a = 0; a < mass.rows(); ++a) {
      for (Index b = 0; b < mass.cols(); ++b) {
        local.block<3, 3>(3 * a, 3 * b).diagonal().setConstant(mass(a, b));
      }
    }
    pattern_->scatter(e, local, mass_values_.data());
  }
  for_each_entry([&](std::size_t k, Index i, Index j) {
    mass_values_[k] *= inverse_root_mass_[i] * inverse_root_mass_[j];
  });
  mass_factor_ = std::make_unique<SparseCholesky>(*pattern_);
  if (!mass_factor_->factorize(mass_values_)) {
    throw InputError(
        "The modes cannot be computed: the mass matrix is not positive definite. Check the curved "
        "edges of the elements.");
  }
}

std::vector<double> ScaledStiffness::shifted(double sigma) const {
  std::vector<double> values = values_;
  for_each_entry([&](std::size_t k, Index i, Index j) {
    if (mass_factor_) {
      values[k] -= sigma * mass_values_[k];
    } else if (i == j) {
      values[k] -= sigma;
    }
  });
  return values;
}

// R (S_D − σ RᵀR)⁻¹ Rᵀ z, where Rᵀ z = RᵀR R⁻¹ z and R x = R⁻ᵀ RᵀR x.
Vector ScaledStiffness::solve(SparseCholesky& factor, const Vector& z) const {
  if (!mass_factor_) return factor.solve(z);
  const Vector x = factor.solve(multiply(mass_values_, solve_root(z)));
  return solve_transposed_root(multiply(mass_values_, x));
}

Vector ScaledStiffness::multiply(const std::vector<double>& a, const Vector& z) const {
  Vector product = Vector::Zero(z.size());
  for_each_entry([&](std::size_t k, Index i, Index j) {
    product[i] += a[k] * z[j];
    if (i != j) product[j] += a[k] * z[i];
  });
  return product;
}

Vector ScaledStiffness::solve_transposed_root(const Vector& z) const {
  return mass_factor_ ? mass_factor_->solve_transposed_root(z) : z;
}

Vector ScaledStiffness::solve_root(const Vector& z) const {
  return mass_factor_ ? mass_factor_->solve_root(z) : z;
}

Vector ScaledStiffness::product(const Vector& z) const {
  const Vector u = displacements(z);
  Vector forces;
  system_.elastic().product(position_, u, forces);
  terms_.add_product(u, forces);
  if (system_.nodal_volume() != nullptr) {
    system_.nodal_volume()->add_product(position_, u, forces);
  }
  return scaled(forces);
}

Vector ScaledStiffness::scaled(const Vector& forces) const {
  return solve_transposed_root(inverse_root_mass_.cwiseProduct(coordinates_.restrict(forces)));
}

Matrix ScaledStiffness::scaled_columns(const Matrix& columns) const {
  Matrix scaled = inverse_root_mass_.asDiagonal() * columns;
  for (Index j = 0; mass_factor_ && j < scaled.cols(); ++j) {
    scaled.col(j) = solve_transposed_root(scaled.col(j));
  }
  return scaled;
}

Vector ScaledStiffness::displacements(const Vector& z) const {
  return coordinates_.extend(inverse_root_mass_.cwiseProduct(solve_root(z)));
}

SkewLoadStiffness::SkewLoadStiffness(const MechanicalSystem& system, const Vector& q, double time,
                                     double load_factor)
    : stiffness_(load_factor) {
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_load() || !term->load_depends_on_position()) continue;
    term->add_load_stiffness(system.force_point(q, time), stiffness_);
  }
}

Vector SkewLoadStiffness::product(const Vector& u) const {
  Vector product = Vector::Zero(u.size());
  stiffness_.add_transposed_product(u, product);
  product = -product;
  stiffness_.add_product(u, product);
  return 0.5 * product;
}

DampingMatrix::DampingMatrix(const MechanicalSystem& system, const Vector& q, double time,
                             bool with_loads)
    : system_(system), q_(q) {
  const Vector rest = Vector::Zero(q.size());
  const ForcePoint at{system.mass(), q, time};
  of_terms_.reset(system.vertex_count());
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_dissipation()) continue;
    if (!with_loads && term->account() == EnergyAccount::kExternalWork) continue;
    term->add_dissipation_hessian(at, rest, HessianForm::kExact, of_terms_);
  }
}

Vector DampingMatrix::product(const Vector& v) const {
  Vector force = Vector::Zero(v.size());
  system_.add_viscous_force(q_, v, force);
  force = -force;
  of_terms_.add_product(v, force);
  force +=
      system_.damping().mass_damping * (momentum_of_modes(system_, v) - system_.momentum_of(v));
  return force;
}

Vector DampingMatrix::product_of_terms(const Vector& v) const {
  Vector force = Vector::Zero(v.size());
  of_terms_.add_product(v, force);
  return force;
}

LinearisedEquations::LinearisedEquations(const MechanicalSystem& system,
                                         const ScaledStiffness& stiffness, const Vector& position,
                                         const Vector& multipliers)
    : q(stiffness.size(), 0), h(0, 0), allowed(0, 0), curvature(0, 0) {
  const Constraints& constraints = system.constraints();
  if (!constraints.has_equations()) return;
  constexpr double kDependent = 1e-11;
  const Matrix selector = stiffness.scaled_columns(constraints.selector());
  // Columns of the same length, because constraints may differ much in mass.
  Vector length = selector.colwise().norm().transpose();
  length = (length.array() > 0.0).select(length, 1.0);
  q = orthonormal_basis(selector * length.cwiseInverse().asDiagonal(), kDependent);
  const Matrix reduced = q.transpose() * selector;
  Matrix gradients = reduced * constraints.gradients(constraints.configuration(position));
  for (Index j = 0; j < gradients.cols(); ++j) gradients.col(j).stableNormalize();
  h = orthonormal_basis(gradients, kDependent);
  allowed = Matrix(q.cols(), q.cols() - h.cols());
  if (allowed.cols() > 0) {
    const Matrix complement = Matrix::Identity(q.cols(), q.cols()) - Matrix(h * h.transpose());
    allowed = orthonormal_basis(complement, 1e-8);
  }
  curvature = Matrix::Zero(q.cols(), q.cols());
  if (multipliers.size() > 0) {
    curvature = reduced * constraints.curvature(multipliers) * reduced.transpose();
  }
}

}  // namespace tetraction
