// Tests with every time-stepping rule.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <type_traits>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction::testing_support {

inline std::vector<Integrator> all_rules() {
  return {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
          Integrator::kBackwardEuler, Integrator::kEnergyMomentum};
}

/// The name of a case whose parameter is a rule, a solver or a name: its letters and digits.
inline constexpr auto name_of_rule = [](const auto& info) {
  std::string name;
  if constexpr (std::is_convertible_v<decltype(info.param), std::string>) {
    name = info.param;
  } else {
    name = to_string(info.param);
  }
  std::erase(name, '-');
  return name;
};

}  // namespace tetraction::testing_support
