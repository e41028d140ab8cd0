// The time-stepping rules, by name.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The time-stepping rules of docs/theory.md. One table (src/dynamics/steppers/integrator.cc) has the properties of
/// each; a rule's step is in a file of its own.
enum class Integrator { kExplicit, kVerlet, kMidpoint, kBackwardEuler, kEnergyMomentum };

/// All rules, in the order of the enumeration.
const std::vector<Integrator>& all_integrators();
/// The rule's name in scenes, as "backward-euler".
std::string to_string(Integrator integrator);
/// Inverse of to_string(); throws InputError listing the valid names.
Integrator integrator_from_string(const std::string& name);
/// All names, in the order of the enumeration.
std::vector<const char*> integrator_names();
/// Whether a step solves equations: a minimisation, or those of energy-momentum.
bool is_implicit(Integrator integrator);
/// Whether these equations are not those of a minimum, so that a step needs a RootFinder, too.
bool needs_root_finder(Integrator integrator);
/// Order in the step size of the rule's positions, 1 or 2.
int order(Integrator integrator);
/// Whether the rule is derived from a discrete action (all but backward Euler and energy-momentum).
bool is_variational(Integrator integrator);

}  // namespace tetraction
