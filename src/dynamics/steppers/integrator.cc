#include "tetraction/dynamics/steppers/integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/dynamics/steppers/oscillator.h"
#include "tetraction/dynamics/steppers/stepper.h"

// A new rule has its factory function in its own source and declares it here; the public header declares those
// that programs call by name.
namespace tetraction {
namespace {

// The effect of a step on the amplitude and phase of an oscillator, for x = ωh: formulas (35) of docs/theory.md.
struct Rotation {
  double angle = 0.0;  // θ; 0 if the rule is unstable
  double decay = 0.0;  // −ln r
};
Rotation explicit_rotation(double x) {
  return {x < 2.0 ? 2.0 * std::asin(0.5 * x) : 0.0};
}
Rotation midpoint_rotation(double x) {
  return {2.0 * std::atan(0.5 * x)};
}
Rotation backward_euler_rotation(double x) {
  return {std::atan(x), 0.5 * std::log1p(x * x)};
}

// One rule. Exactly one of the last three makes its stepper.
struct Rule {
  Integrator integrator;
  const char* name;
  int order;
  bool is_variational;
  Rotation (*rotation)(double omega_h);
  std::unique_ptr<Stepper> (*make_explicit)(const MechanicalSystem&);
  std::unique_ptr<Stepper> (*make_implicit)(const MechanicalSystem&, std::shared_ptr<Minimizer>,
                                            std::shared_ptr<RootFinder>);
  std::unique_ptr<Stepper> (*make_with_root_finder)(const MechanicalSystem&,
                                                    std::shared_ptr<Minimizer>,
                                                    std::shared_ptr<RootFinder>) = nullptr;
};

constexpr std::array kRules{
    Rule{Integrator::kExplicit, "explicit", 1, true, explicit_rotation, make_explicit_stepper,
         nullptr},
    Rule{Integrator::kVerlet, "verlet", 2, true, explicit_rotation, make_verlet_stepper, nullptr},
    Rule{Integrator::kMidpoint, "midpoint", 2, true, midpoint_rotation, nullptr,
         make_midpoint_stepper},
    Rule{Integrator::kBackwardEuler, "backward-euler", 1, false, backward_euler_rotation, nullptr,
         make_backward_euler_stepper},
    // For linear forces this is the midpoint rule.
    Rule{Integrator::kEnergyMomentum, "energy-momentum", 2, false, midpoint_rotation, nullptr,
         nullptr, make_energy_momentum_stepper}};

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

OscillatorResponse oscillator_response(Integrator rule, double omega_h) {
  const Rotation rotation = rule_of(rule).rotation(omega_h);
  OscillatorResponse response;
  response.is_stable = rotation.angle > 0.0;
  if (!response.is_stable) return response;
  response.period_error = omega_h / rotation.angle - 1.0;
  response.damping_ratio = rotation.decay / rotation.angle;
  response.amplitude_left = std::exp(-2.0 * std::numbers::pi * rotation.decay / rotation.angle);
  return response;
}

double resolved_omega_h(Integrator rule, double period_error, double loss) {
  const auto resolved = [&](double omega_h) {
    const OscillatorResponse response = oscillator_response(rule, omega_h);
    return response.is_stable && std::abs(response.period_error) <= period_error &&
           response.amplitude_left >= 1.0 - loss;
  };
  double low = 0.0;
  double high = 1.0;
  while (resolved(high)) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (resolved(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace tetraction
