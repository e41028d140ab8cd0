#include "failure_measures.h"

#include <algorithm>
#include <cmath>

#include "tetraction/dynamics/body_sums.h"

namespace tetraction {

Moduli moduli_of(const MechanicalSystem& system) {
  Moduli moduli;
  for (const MaterialField& material : system.materials()) {
    moduli.least = std::min(moduli.least, material.lame_range().least_modulus);
    moduli.most = std::max(moduli.most, material.lame_range().most_modulus);
  }
  moduli.least = least_of_parts(system.part(), moduli.least);
  moduli.most = largest_of_parts(system.part(), moduli.most);
  return moduli;
}

double length_of_vertex(const MechanicalSystem& system) {
  return std::cbrt(system.mesh().total_volume() / static_cast<double>(global_vertex_count(system)));
}

double strain_of(const MechanicalSystem& system, const Vector& forces) {
  double sum = 0.0;
  double most = 0.0;
  for (Index v = 0; v < system.owned_vertex_count(); ++v) {
    sum += vertex_block(forces, v).norm();
    most = std::max(most, vertex_block(forces, v).norm());
  }
  sum = sum_over_parts(system.part(), sum);
  most = largest_of_parts(system.part(), most);
  const double volume = system.mesh().total_volume();
  const double length = length_of_vertex(system);
  const double pressure = std::max(most / (length * length), sum / std::cbrt(volume * volume));
  return pressure / moduli_of(system).most;
}

double fastest(const MechanicalSystem& system, const Vector& momentum) {
  const Vector3 mean = global_resultant(system, momentum) / system.total_mass();
  double most = 0.0;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    most = std::max(most, (vertex_block(momentum, v) / system.mass()[v] - mean).norm());
  }
  return largest_of_parts(system.part(), most);
}

double wave_speed(const MechanicalSystem& system) {
  return std::sqrt(moduli_of(system).most * system.mesh().total_volume() / system.total_mass());
}

}  // namespace tetraction
