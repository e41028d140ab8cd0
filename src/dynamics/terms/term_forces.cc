#include "term_forces.h"

#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// add(term, gradient) adds the gradient of a term.
template <class Add>
bool gather(const MechanicalSystem& system, const Vector& load, const Add& add, Vector& outer,
            Vector& constraint_force) {
  outer.setZero(system.dof_count());
  bool constraining = false;
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential()) continue;
    const bool constraint = term->account() == EnergyAccount::kConstraintWork;
    if (constraint && !constraining) constraint_force.setZero(system.dof_count());
    constraining = constraining || constraint;
    add(*term, constraint ? constraint_force : outer);
  }
  outer = -outer;
  if (load.size() > 0) outer += load;
  if (!constraining) return false;
  constraint_force = -constraint_force;
  outer += constraint_force;
  return true;
}

}  // namespace

bool gather_term_forces(const MechanicalSystem& system, const ForcePoint& at, const Vector& load,
                        Vector& outer, Vector& constraint_force) {
  return gather(
      system, load,
      [&](const ForceTerm& term, Vector& gradient) { term.add_gradient(at, gradient); }, outer,
      constraint_force);
}

bool gather_middle_forces(const MechanicalSystem& system, const ForcePoint& middle,
                          const ForcePoint& from, const ForcePoint& to, const Vector& load,
                          Vector& outer, Vector& constraint_force) {
  return gather(
      system, load,
      [&](const ForceTerm& term, Vector& gradient) {
        if (&term == system.contact()) {
          term.add_discrete_gradient(from, to, gradient);
        } else {
          term.add_gradient(middle, gradient);
        }
      },
      outer, constraint_force);
}

bool gather_discrete_forces(const MechanicalSystem& system, const ForcePoint& from,
                            const ForcePoint& to, const Vector& load, Vector& outer,
                            Vector& constraint_force) {
  return gather(
      system, load,
      [&](const ForceTerm& term, Vector& gradient) {
        term.add_discrete_gradient(from, to, gradient);
      },
      outer, constraint_force);
}

}  // namespace tetraction
