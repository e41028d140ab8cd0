// A material as a user of the library would write it: neo-Hookean rubber with fibres in the
// direction a, Ψ = Ψ_neo-hookean + k₁/(2k₂) (exp(k₂ e²) − 1), e = |F a|² − 1.
#pragma once

#include <cmath>

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

}  // namespace tetraction::testing_support
