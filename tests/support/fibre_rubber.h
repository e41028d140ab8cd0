// A material as a user of the library would write it: neo-Hookean rubber with fibres in the
// direction a, Ψ = Ψ_neo-hookean + k₁/(2k₂) (exp(k₂ e²) − 1), e = |F a|² − 1.
#pragma once

#include <cmath>
#include <utility>

#include "tetraction/material/material.h"

namespace tetraction::testing_support {

class FibreRubber {
 public:
  static constexpr const char* kName = "fibre-rubber";
  FibreRubber(const LameParameters& lame, double k1, double k2, const Vector3& direction)
      : rubber_(lame.mu, lame.lambda), k1_(k1), k2_(k2), a_(direction.normalized()) {}

  bool admissible(const Matrix3& f) const { return rubber_.admissible(f); }
  double energy_density(const Matrix3& f) const {
    return rubber_.energy_density(f) + 0.5 * k1_ / k2_ * std::expm1(k2_ * std::pow(strain(f), 2));
  }
  Matrix3 first_piola(const Matrix3& f) const {
    const double e = strain(f);
    const Matrix3 m = f * a_ * a_.transpose();
    return rubber_.first_piola(f) + 2.0 * k1_ * e * std::exp(k2_ * e * e) * m;
  }
  Matrix9 stiffness(const Matrix3& f) const {
    const double e = strain(f);
    const double k = 2.0 * k1_ * std::exp(k2_ * e * e);
    const Vector9 m = flatten(f * a_ * a_.transpose());
    Matrix9 a = rubber_.stiffness(f) + 2.0 * k * (1.0 + 2.0 * k2_ * e * e) * m * m.transpose();
    for (int j = 0; j < 3; ++j) {
      for (int l = 0; l < 3; ++l) {
        a.block<3, 3>(3 * j, 3 * l).diagonal().array() += k * e * a_[j] * a_[l];
      }
    }
    return a;
  }
  LameParameters initial_lame() const {
    return {rubber_.initial_lame().mu, rubber_.initial_lame().lambda + 4.0 * k1_};
  }

 private:
  double strain(const Matrix3& f) const {
    const Vector3 d = (f - Matrix3::Identity()) * a_;
    return d.dot(2.0 * a_ + d);
  }

  NeoHookean rubber_;
  double k1_;
  double k2_;
  Vector3 a_;
};

/// The same with fibres that wind around the axis x.
class WindingFibres {
 public:
  static constexpr const char* kName = "winding fibres";
  explicit WindingFibres(const LameParameters& lame) : lame_(lame) {}
  FibreRubber at(const MaterialPlace& place) const {
    const double angle = 2.0 * place.position.x() + place.position.y();
    return {lame_, 1e5, 0.5, {0.5, std::cos(angle), std::sin(angle)}};
  }
  LameParameters initial_lame() const { return {lame_.mu, lame_.lambda + 4e5}; }

 private:
  LameParameters lame_;
};

/// A PlacedMaterial that is evaluated for many F in one call.
template <PlacedMaterial M>
class InBatches : public M {
 public:
  explicit InBatches(M material) : M(std::move(material)) {}
  void evaluate(const MaterialValues& values) const {
    for (std::size_t k = 0; k < values.f.size(); ++k) {
      const auto law = this->at(values.places[k]);
      const Matrix3& f = values.f[k];
      values.admissible[k] = law.admissible(f) ? 1 : 0;
      if (values.admissible[k] == 0) continue;
      if (!values.energy.empty()) values.energy[k] = law.energy_density(f);
      if (!values.stress.empty()) values.stress[k] = law.first_piola(f);
      if (!values.stiffness.empty()) values.stiffness[k] = law.stiffness(f);
    }
  }
};

/// Neo-Hookean rubber with fibres that bear no compression: Ψ = Ψ_neo-hookean + ½ k ⟨e⟩², e = |F a|² − 1. ∂P/∂F
/// jumps where e = 0. `factor` is 1 for the right stiffness.
class TensionFibres : public NeoHookean {
 public:
  TensionFibres(const LameParameters& lame, double k, const Vector3& direction, double factor = 1.0)
      : NeoHookean(lame.mu, lame.lambda), k_(k), a_(direction.normalized()), factor_(factor) {}
  double energy_density(const Matrix3& f) const {
    return NeoHookean::energy_density(f) + 0.5 * k_ * std::pow(std::fmax(strain(f), 0.0), 2);
  }
  Matrix3 first_piola(const Matrix3& f) const {
    return NeoHookean::first_piola(f) +
           2.0 * k_ * std::fmax(strain(f), 0.0) * f * a_ * a_.transpose();
  }
  Matrix9 stiffness(const Matrix3& f) const {
    Matrix9 result = NeoHookean::stiffness(f);
    const double e = strain(f);
    if (e < 0.0) return result;
    const Vector9 m = flatten(f * a_ * a_.transpose());
    result += factor_ * 4.0 * k_ * m * m.transpose();
    for (int j = 0; j < 3; ++j) {
      for (int l = 0; l < 3; ++l) {
        result.block<3, 3>(3 * j, 3 * l).diagonal().array() += 2.0 * k_ * e * a_[j] * a_[l];
      }
    }
    return result;
  }

 private:
  double strain(const Matrix3& f) const { return (f * a_).squaredNorm() - 1.0; }

  double k_;
  Vector3 a_;
  double factor_;
};

}  // namespace tetraction::testing_support
