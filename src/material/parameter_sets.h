// The two sets of parameters by which a model can be given.
#pragma once

#include <vector>

#include "tetraction/material/material_parameter.h"

namespace tetraction {

constexpr bool is_list(const MaterialParameter& parameter) {
  return parameter.most_entries > 0;
}

// A model that is given by Young's modulus and Poisson's ratio instead of its own parameters.
template <class M>
constexpr bool kTakesYoung = !requires {
  M::kInstead;
};

// The parameters that can be given instead of the model's own.
template <class M>
std::vector<MaterialParameter> instead_of_own() {
  if constexpr (kTakesYoung<M>) {
    std::vector<MaterialParameter> all{kYoungsModulus, kPoissonsRatio};
    all.insert(all.end(), M::kBesideYoung.begin(), M::kBesideYoung.end());
    return all;
  } else {
    return {M::kInstead.begin(), M::kInstead.end()};
  }
}

}  // namespace tetraction
