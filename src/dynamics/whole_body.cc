#include "tetraction/dynamics/whole_body.h"

#include "tetraction/dynamics/derived_fields.h"

namespace tetraction {

Index whole_vertex_count(const MechanicalSystem& system) {
  return system.part() != nullptr ? system.part()->whole.vertices : system.vertex_count();
}

Index whole_tetrahedron_count(const MechanicalSystem& system) {
  return system.part() != nullptr ? system.part()->whole.tetrahedra
                                  : system.mesh().tetrahedron_count();
}

Index whole_freedom_count(const MechanicalSystem& system) {
  if (system.part() == nullptr) return system.coordinates().count();
  Index own = 0;
  for (Index v = 0; v < system.owned_vertex_count(); ++v) {
    own += system.coordinates().is_free(v) ? 3 : system.coordinates().map(v).count;
  }
  return static_cast<Index>(sum_over_parts(system.part(), static_cast<double>(own)));
}

Vector3 whole_resultant(const MechanicalSystem& system, const Vector& field) {
  if (system.part() == nullptr) return resultant(field);
  Vector3 sum = resultant(field.head(3 * system.owned_vertex_count()));
  system.part()->sum(sum.data(), 3);
  return sum;
}

}  // namespace tetraction
