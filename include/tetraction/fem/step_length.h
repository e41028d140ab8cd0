// How far a displacement can go before an element is inverted.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// Returns a t ≤ 1 such that no element loses more than nine tenths of its volume, at any of its
/// quadrature points, anywhere on the way from q to q + t d. If t < 1, some element loses at least 0.81 of its volume at t. Elements that
/// are inverted at q are left out, and so are elements for which `counts` returns false. An empty
/// `counts` leaves out none.
double admissible_step(const RestState& rest, const Vector& q, const Vector& d,
                       const std::function<bool(Index)>& counts = {});

/// The reason why ElasticPotential::admissible() fails at positions, for messages: "inverts element
/// ID", or "stretches element ID beyond the limit of its material".
std::string inadmissible_change(const ElasticPotential& elastic, const Vector& q, Index element,
                                std::int64_t id);

/// Whether the energy of a material is bounded to a stretch (HasStretchLimit).
bool has_stretch_limit(const ElasticPotential& elastic);
/// Returns a t ≤ `longest` such that no quadrature point of such a material loses more than nine tenths of its
/// stretch_margin() at t, or on the way from q to q + t d at the points where it is looked at. Elements that are inverted or at their
/// limit at q are left out.
double stretch_limited_step(const ElasticPotential& elastic, const Vector& q, const Vector& d,
                            double longest);
/// The least stretch_margin() of all quadrature points of such materials, 1 if there are none. Inverted elements
/// count as beyond the limit.
double least_stretch_margin(const ElasticPotential& elastic, const Vector& q);

}  // namespace tetraction
