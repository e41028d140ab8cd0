// Deformations without change of volume, for closed forms of the stress of rubber.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::testing_support {

// F = diag(λ, b, c) of a deformation that keeps the volume, and dΨ/dλ along it: the nominal stress of the
// incompressible material.
struct Deformation {
  const char* name;
  std::function<Vector3(double)> stretches;
  std::function<Vector3(double)> rates;
};
inline std::vector<Deformation> deformations() {
  return {{"uniaxial", [](double l) { return Vector3(l, 1 / std::sqrt(l), 1 / std::sqrt(l)); },
           [](double l) {
             const double lateral = -0.5 * std::pow(l, -1.5);
             return Vector3(1.0, lateral, lateral);
           }},
          {"equibiaxial", [](double l) { return Vector3(l, l, 1 / (l * l)); },
           [](double l) { return Vector3(1.0, 1.0, -2.0 / (l * l * l)); }},
          {"pure shear", [](double l) { return Vector3(l, 1.0, 1.0 / l); },
           [](double l) { return Vector3(1.0, 0.0, -1.0 / (l * l)); }}};
}
template <class M>
double nominal_stress(const M& material, const Deformation& state, double stretch) {
  const Matrix3 f = state.stretches(stretch).asDiagonal();
  return material.first_piola(f).diagonal().dot(state.rates(stretch));
}

}  // namespace tetraction::testing_support
