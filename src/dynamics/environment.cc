#include "tetraction/dynamics/environment.h"

#include "tetraction/core/error.h"

namespace tetraction {

Environment::Environment(const Vector3& acceleration) : acceleration_(acceleration) {
  if (!acceleration.allFinite()) {
    throw InputError("The environment's acceleration is not finite: give a finite strength.");
  }
}

double Environment::value(const Vector& mass, const Vector& q) const {
  if (acceleration_.isZero(0.0)) return 0.0;
  double energy = 0.0;
  for (Index v = 0; v < mass.size(); ++v) energy -= mass[v] * acceleration_.dot(vertex_block(q, v));
  return energy;
}

void Environment::add_gradient(const Vector& mass, Vector& gradient) const {
  if (acceleration_.isZero(0.0)) return;
  for (Index v = 0; v < mass.size(); ++v) vertex_block(gradient, v) -= mass[v] * acceleration_;
}

}  // namespace tetraction
