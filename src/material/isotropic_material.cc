#include <tuple>

#include "core/simd_targets.h"
#include "isotropic_material-inl.h"
#include "material/laws/laws-inl.h"
#include "tetraction/material/material.h"

namespace tetraction {
namespace {

template <class... M>
constexpr auto functions_of(const std::variant<M...>*) {
  return std::tuple(&IsotropicMaterial<M>::energy_density..., &IsotropicMaterial<M>::first_piola...,
                    &IsotropicMaterial<M>::stiffness...);
}
// The compiler emits the functions of all models, because an object refers to them.
[[gnu::used]] constexpr auto kFunctions = functions_of(static_cast<const IsotropicModel*>(nullptr));

}  // namespace
}  // namespace tetraction
