// Values of a material that is evaluated for many deformation gradients in one call.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "tetraction/material/custom_material.h"

namespace tetraction {

/// Stands for a BatchMaterial in computations that ask for its values one by one. The computations are made
/// twice. The first time the deformation gradients are noted and all values are zero. After evaluate() the
/// same computations in the same order get the right values. It must not depend on values at which deformation
/// gradients they ask.
class CollectedValues {
 public:
  /// Keeps a reference to `material`, which must live longer.
  explicit CollectedValues(const CustomMaterial& material) : material_(material) {}

  bool admissible(const Matrix3& f) const { return material_.admissible(f); }
  double energy_density(const Matrix3& f) const { return energies_.next(f, 0.0); }
  Matrix3 first_piola(const Matrix3& f) const { return stresses_.next(f, Matrix3::Zero()); }
  Matrix9 stiffness(const Matrix3& f) const { return stiffnesses_.next(f, Matrix9::Zero()); }
  LameParameters initial_lame() const { return material_.initial_lame(); }

  void evaluate() {
    energies_.evaluate([&](const auto& f, auto& flags, auto& values) {
      material_.evaluate({f, flags, values, {}, {}});
    });
    stresses_.evaluate([&](const auto& f, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, values, {}});
    });
    stiffnesses_.evaluate([&](const auto& f, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, {}, values});
    });
  }

 private:
  template <class Value>
  struct List {
    std::vector<Matrix3> f;
    std::vector<Value> values;
    std::size_t position = 0;

    Value next(const Matrix3& at, const Value& zero) {
      if (!values.empty()) return values[position++];
      f.push_back(at);
      return zero;
    }
    template <class Call>
    void evaluate(const Call& call) {
      if (f.empty()) return;
      std::vector<char> admissible(f.size(), 0);
      std::vector<Value> computed(f.size());
      call(f, admissible, computed);
      values = std::move(computed);
    }
  };

  const CustomMaterial& material_;
  mutable List<double> energies_;
  mutable List<Matrix3> stresses_;
  mutable List<Matrix9> stiffnesses_;
};

}  // namespace tetraction
