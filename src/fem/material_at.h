// The law at a point of the body.
#pragma once

#include <concepts>

#include "tetraction/fem/rest_state.h"
#include "tetraction/material/material_field.h"

namespace tetraction {

/// The place of point i for a PlacedMaterial.
MaterialPlace place_of(const RestState& rest, Index i);

/// Returns body(law), where `law` is the material at point i and `m` is field.model() as its own type.
template <class M, class Body>
decltype(auto) with_material_at(const MaterialField& field, const M& m, const RestState& rest,
                                Index i, const Body& body) {
  if constexpr (std::same_as<M, CustomMaterial>) {
    if (m.has_places()) return body(m.at(place_of(rest, i)));
  }
  return field.with_element(m, rest.element_of(i), body);
}

}  // namespace tetraction
