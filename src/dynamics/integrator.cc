#include "tetraction/dynamics/integrator.h"

#include <algorithm>
#include <array>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {
namespace {

// One rule. Exactly one of the last two makes its stepper.
struct Rule {
  Integrator integrator;
  const char* name;
  int order;
  bool is_variational;
  std::unique_ptr<Stepper> (*make_explicit)(const MechanicalSystem&);
  std::unique_ptr<Stepper> (*make_implicit)(const MechanicalSystem&, std::shared_ptr<Minimizer>);
};

constexpr std::array kRules{
    Rule{Integrator::kExplicit, "explicit", 1, true, make_explicit_stepper, nullptr},
    Rule{Integrator::kVerlet, "verlet", 2, true, make_verlet_stepper, nullptr},
    Rule{Integrator::kMidpoint, "midpoint", 2, true, nullptr, make_midpoint_stepper},
    Rule{Integrator::kBackwardEuler, "backward-euler", 1, false, nullptr,
         make_backward_euler_stepper}};

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
    for (const Rule& rule : kRules) list.push_back(rule.integrator);
    return list;
  }();
  return all;
}

std::vector<const char*> integrator_names() {
  std::vector<const char*> names;
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
  return rule_of(integrator).make_implicit != nullptr;
}

int order(Integrator integrator) {
  return rule_of(integrator).order;
}

bool is_variational(Integrator integrator) {
  return rule_of(integrator).is_variational;
}

std::unique_ptr<Stepper> make_stepper(Integrator integrator, const MechanicalSystem& system,
                                      std::shared_ptr<Minimizer> minimizer) {
  const Rule& rule = rule_of(integrator);
  if (rule.make_explicit != nullptr) return rule.make_explicit(system);
  if (!minimizer) throw InputError(std::string(rule.name) + " needs a minimizer.");
  return rule.make_implicit(system, std::move(minimizer));
}

}  // namespace tetraction
