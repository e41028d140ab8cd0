// The time-stepping rules, by name.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The time-stepping rules of docs/theory.md. What there is to know of each stands in one table
/// (src/dynamics/integrator.cc); a rule's step is in a file of its own.
enum class Integrator { kExplicit, kVerlet, kMidpoint, kBackwardEuler };

/// All rules, in the order of the enumeration.
const std::vector<Integrator>& all_integrators();
/// "explicit", "verlet", "midpoint", "backward-euler".
std::string to_string(Integrator integrator);
/// Inverse of to_string(); throws InputError listing the valid names.
Integrator integrator_from_string(const std::string& name);
/// All names, in the order of the enumeration.
std::vector<const char*> integrator_names();
/// Whether a step solves a minimisation.
bool is_implicit(Integrator integrator);
/// Order in the step size of the rule's positions: 2 for verlet and midpoint, 1 for the others.
int order(Integrator integrator);
/// Whether the rule is derived from a discrete action (all but backward Euler).
bool is_variational(Integrator integrator);

}  // namespace tetraction
