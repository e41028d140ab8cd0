#include "term_forces.h"

namespace tetraction {

bool gather_term_forces(const MechanicalSystem& system, const ForcePoint& at, const Vector& load,
                        Vector& outer, Vector& constraint_force) {
  outer.setZero(system.dof_count());
  bool constraining = false;
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential()) continue;
    const bool constraint = term->account() == EnergyAccount::kConstraintWork;
    if (constraint && !constraining) constraint_force.setZero(system.dof_count());
    constraining = constraining || constraint;
    term->add_gradient(at, constraint ? constraint_force : outer);
  }
  outer = -outer;
  if (load.size() > 0) outer += load;
  if (!constraining) return false;
  constraint_force = -constraint_force;
  outer += constraint_force;
  return true;
}

}  // namespace tetraction
