#include "tetraction/fem/viscous_potential.h"

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

constexpr Index kGrain = 512;

Matrix3 green_strain(const Matrix3& f) {
  return 0.5 * (f.transpose() * f - Matrix3::Identity());
}

// Ψ = c |E − E_k|² with the interface of a material, so that the element kernels serve it too.
// P = 2c F (E − E_k); dP = 2c dF (E − E_k) + c (F Fᵀ dF + F dFᵀ F).
class ViscousDensity {
 public:
  ViscousDensity(double factor, const Matrix3& start) : factor_(factor), start_(start) {}
  static bool admissible(const Matrix3&) { return true; }
  double energy_density(const Matrix3& f) const {
    return factor_ * (green_strain(f) - start_).squaredNorm();
  }
  Matrix3 first_piola(const Matrix3& f) const {
    return 2.0 * factor_ * f * (green_strain(f) - start_);
  }
  Matrix9 stiffness(const Matrix3& f) const {
    const Matrix3 stress = 2.0 * factor_ * (green_strain(f) - start_);
    const Matrix3 left = factor_ * f * f.transpose();
    Matrix9 a;
    for (int l = 0; l < 3; ++l) {
      for (int k = 0; k < 3; ++k) {
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) {
            a(3 * j + i, 3 * l + k) = (i == k ? stress(l, j) : 0.0) + (j == l ? left(i, k) : 0.0) +
                                      factor_ * f(i, l) * f(k, j);
          }
        }
      }
    }
    return a;
  }

 private:
  double factor_;
  const Matrix3& start_;
};

static_assert(Material<ViscousDensity>);

}  // namespace

ViscousPotential::ViscousPotential(const RestState& rest) : rest_(rest) {}

const VertexIncidence& ViscousPotential::incidence() const {
  if (!incidence_) incidence_ = std::make_unique<VertexIncidence>(rest_);
  return *incidence_;
}

void ViscousPotential::add_force(double viscosity, const Vector& q, const Vector& v,
                                 Vector& force) const {
  local_.resize(static_cast<std::size_t>(rest_.element_count()));
  parallel_for(rest_.element_count(), kGrain, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      const auto element = rest_.element(e);
      const Matrix3 f = deformation_gradient(element, 0, rest_.gather(q, e));
      const Matrix3 rate = f.transpose() * deformation_gradient(element, 0, rest_.gather(v, e));
      const Matrix3 stress = viscosity * (rate + rate.transpose());
      local_[static_cast<std::size_t>(e)] = -element.weights[0] * f * stress * element.gradients[0];
    }
  });
  incidence().add_gathered(local_, force);
}

void ViscousPotential::begin(const Vector& q, const Vector& displacement, double factor) {
  factor_ = factor;
  if (factor == 0.0) return;
  strain_.resize(static_cast<std::size_t>(rest_.element_count()));
  parallel_for(rest_.element_count(), kGrain, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      Matrix3& strain = strain_[static_cast<std::size_t>(e)];
      strain = green_strain(deformation_gradient(rest_.element(e), 0, rest_.gather(q, e)));
      if (displacement.size() == 0) continue;
      const Matrix3 change =
          deformation_gradient(rest_.element(e), 0, rest_.gather(displacement, e));
      strain -= 0.125 * change.transpose() * change;
    }
  });
}

Matrix3 ViscousPotential::stress(Index e, const Vector& x) const {
  const Matrix3 f = deformation_gradient(rest_.element(e), 0, rest_.gather(x, e));
  return 2.0 * factor_ * (green_strain(f) - strain_[static_cast<std::size_t>(e)]);
}

void ViscousPotential::add_value(const Vector& x, double& value) const {
  if (factor_ == 0.0) return;
  value += parallel_sum(rest_.element_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index e = begin; e < end; ++e) {
      sum += element_energy<Shape>(rest_.element(e),
                                   ViscousDensity(factor_, strain_[static_cast<std::size_t>(e)]),
                                   rest_.gather(x, e));
    }
    return sum;
  });
}

void ViscousPotential::add_value_and_gradient(const Vector& x, double& value,
                                              Vector& gradient) const {
  if (factor_ == 0.0) return;
  add_value(x, value);
  local_.resize(static_cast<std::size_t>(rest_.element_count()));
  parallel_for(rest_.element_count(), kGrain, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      const auto i = static_cast<std::size_t>(e);
      local_[i] = element_gradient<Shape>(rest_.element(e), ViscousDensity(factor_, strain_[i]),
                                          rest_.gather(x, e));
    }
  });
  incidence().add_gathered(local_, gradient);
}

void ViscousPotential::add_hessian(const Vector& x, const SparsityPattern& pattern,
                                   double* values) const {
  if (factor_ == 0.0) return;
  for (const std::vector<Index>& color : pattern.colors()) {
    parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        const Index e = color[static_cast<std::size_t>(i)];
        const ViscousDensity density(factor_, strain_[static_cast<std::size_t>(e)]);
        pattern.scatter(e, element_hessian<Shape>(rest_.element(e), density, rest_.gather(x, e)),
                        values);
      }
    });
  }
}

void ViscousPotential::add_element_terms(Index e, const Vector& x, bool with_hessian,
                                         ElasticPotential::ElementTerms& terms) const {
  if (factor_ == 0.0) return;
  const auto element = rest_.element(e);
  const ViscousDensity density(factor_, strain_[static_cast<std::size_t>(e)]);
  const Shape::NodeMatrix local = rest_.gather(x, e);
  terms.energy += element_energy<Shape>(element, density, local);
  terms.gradient += element_gradient<Shape>(element, density, local);
  if (with_hessian) terms.hessian += element_hessian<Shape>(element, density, local);
}

}  // namespace tetraction
