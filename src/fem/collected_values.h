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

  /// Where the values are that are noted from now on. For a PlacedMaterial.
  void go_to(const MaterialPlace& place) { place_ = place; }

  double energy_density(const Matrix3& f) const { return next(energies_, f, 0.0); }
  Matrix3 first_piola(const Matrix3& f) const {
    return next(stresses_, f, Matrix3(Matrix3::Zero()));
  }
  Matrix9 stiffness(const Matrix3& f) const {
    return next(stiffnesses_, f, Matrix9(Matrix9::Zero()));
  }
  /// Whether the energy is defined is to be found out before.
  static bool admissible(const Matrix3&) { return true; }
  LameParameters initial_lame() const { return material_.initial_lame(); }

  void evaluate() {
    energies_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, values, {}, {}, places});
    });
    stresses_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, values, {}, places});
    });
    stiffnesses_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, {}, values, places});
    });
  }

 private:
  template <class Value>
  struct List {
    std::vector<Matrix3> f;
    std::vector<MaterialPlace> places;
    std::vector<Value> values;
    std::size_t position = 0;

    template <class Call>
    void evaluate(const Call& call) {
      if (f.empty()) return;
      std::vector<char> admissible(f.size(), 0);
      std::vector<Value> computed(f.size());
      call(f, places, admissible, computed);
      values = std::move(computed);
    }
  };

  template <class Value>
  Value next(List<Value>& list, const Matrix3& f, const Value& zero) const {
    if (!list.values.empty()) return list.values[list.position++];
    list.f.push_back(f);
    if (material_.has_places()) list.places.push_back(place_);
    return zero;
  }

  const CustomMaterial& material_;
  MaterialPlace place_;
  mutable List<double> energies_;
  mutable List<Matrix3> stresses_;
  mutable List<Matrix9> stiffnesses_;
};

}  // namespace tetraction
