#include "mass_properties.h"

#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/consistent_mass.h"

namespace tetraction {
namespace {

// The sums over masses of 1, r and r rᵀ.
struct Moments {
  double mass = 0.0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();

  // About the point `origin`, from which r is measured.
  MassProperties properties(const Vector3& origin) const {
    const Vector3 center = first / mass;
    const Matrix3 central = second - mass * center * center.transpose();
    return {origin + center, central.trace() * Matrix3::Identity() - central};
  }
};

}  // namespace

MassProperties mass_properties(const MechanicalSystem& system) {
  const RestState& rest = system.rest();
  const Vector3 origin = center_of_mass(system, system.mesh().rest_positions());
  Moments moments;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Matrix masses = system.density(e) * element_mass_matrix(rest, e);
    Matrix arms(3, masses.cols());
    Index a = 0;
    for (const Index v : rest.nodes(e)) arms.col(a++) = rest.position(v) - origin;
    moments.mass += masses.sum();
    moments.first += arms * masses.rowwise().sum();
    moments.second += arms * masses * arms.transpose();
  }
  return moments.properties(origin);
}

MassProperties lumped_mass_properties(const MechanicalSystem& system) {
  const Vector x = system.mesh().rest_positions();
  const Vector3 origin = center_of_mass(system, x);
  Moments moments;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(x, v) - origin;
    moments.mass += system.mass()[v];
    moments.first += system.mass()[v] * arm;
    moments.second += system.mass()[v] * arm * arm.transpose();
  }
  return moments.properties(origin);
}

}  // namespace tetraction
