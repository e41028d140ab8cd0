#include "tetraction/dynamics/steppers/integrator.h"

#include <algorithm>
#include <array>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {
namespace {

// One rule. Exactly one of the last three makes its stepper.
struct Rule {
  Integrator integrator;
  const char* name;
  int order;
  bool is_variational;
  std::unique_ptr<Stepper> (*make_explicit)(const MechanicalSystem&);
  std::unique_ptr<Stepper> (*make_implicit)(const MechanicalSystem&, std::shared_ptr<Minimizer>,
                                            std::shared_ptr<RootFinder>);
  std::unique_ptr<Stepper> (*make_with_root_finder)(const MechanicalSystem&,
                                                    std::shared_ptr<Minimizer>,
                                                    std::shared_ptr<RootFinder>) = nullptr;
};

constexpr std::array kRules{
    Rule{Integrator::kExplicit, "explicit", 1, true, make_explicit_stepper, nullptr},
    Rule{Integrator::kVerlet, "verlet", 2, true, make_verlet_stepper, nullptr},
    Rule{Integrator::kMidpoint, "midpoint", 2, true, nullptr, make_midpoint_stepper},
    Rule{Integrator::kBackwardEuler, "backward-euler", 1, false, nullptr,
         make_backward_euler_stepper},
    Rule{Integrator::kEnergyMomentum, "energy-momentum", 2, false, nullptr, nullptr,
         make_energy_momentum_stepper}};

const Rule& rule_of(Integrator integrator) {
  const auto* found = std::find_if(kRules.begin(), kRules.end(),
                                   [&](const Rule& rule) { return rule.integrator == integrator; });
  if (found == kRules.end()) throw InputError("There is no such integrator.");
  return *found;
}

}  // namespace

const std::vector<Integrator>& all_integrators() {
  static const std::vector<Integrator> all = [] {
    std::vector<Integrator> list;
    list.reserve(std::size(kRules));
    for (const Rule& rule : kRules) list.push_back(rule.integrator);
    return list;
  }();
  return all;
}

std::vector<const char*> integrator_names() {
  std::vector<const char*> names;
  names.reserve(std::size(kRules));
  for (const Rule& rule : kRules) names.push_back(rule.name);
  return names;
}

std::string to_string(Integrator integrator) {
  return rule_of(integrator).name;
}

Integrator integrator_from_string(const std::string& name) {
  std::string known;
  for (const Rule& rule : kRules) {
    if (name == rule.name) return rule.integrator;
    known += (known.empty() ? "" : ", ") + std::string(rule.name);
  }
  throw InputError("\"" + name + "\" is not an integrator; there are " + known + ".");
}

bool is_implicit(Integrator integrator) {
  return rule_of(integrator).make_explicit == nullptr;
}

bool needs_root_finder(Integrator integrator) {
  return rule_of(integrator).make_with_root_finder != nullptr;
}

int order(Integrator integrator) {
  return rule_of(integrator).order;
}

bool is_variational(Integrator integrator) {
  return rule_of(integrator).is_variational;
}

std::unique_ptr<Stepper> make_stepper(Integrator integrator, const MechanicalSystem& system,
                                      std::shared_ptr<Minimizer> minimizer,
                                      std::shared_ptr<RootFinder> root_finder) {
  const Rule& rule = rule_of(integrator);
  if (rule.make_explicit != nullptr) return rule.make_explicit(system);
  if (!minimizer) throw InputError(std::string(rule.name) + " needs a minimizer.");
  if (rule.make_implicit != nullptr) {
    return rule.make_implicit(system, std::move(minimizer), std::move(root_finder));
  }
  if (!root_finder) throw InputError(std::string(rule.name) + " needs a root finder.");
  return rule.make_with_root_finder(system, std::move(minimizer), std::move(root_finder));
}

}  // namespace tetraction
