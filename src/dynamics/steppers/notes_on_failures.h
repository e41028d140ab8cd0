// Remarks for the messages of steps whose equations have no solution.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {

/// A remark where a body with such a material (has_stretch_limit()) is near the limit of its stretch at q_k or at
/// the expected end of the step.
inline std::string note_on_limit(const MechanicalSystem& system, const Vector& begin,
                                 const Vector& end) {
  constexpr double kNear = 0.1;
  const ElasticPotential& elastic = system.elastic();
  if (std::min(least_stretch_margin(elastic, begin), least_stretch_margin(elastic, end)) > kNear) {
    return {};
  }
  return "; a material comes to the limit of its stretch, where its energy grows like "
         "-ln(margin) without bound: take a smaller step or another rule";
}

/// A remark where a body squeezes a layer of contact to almost nothing.
inline std::string note_on_layer(const MechanicalSystem& system, const State& from) {
  constexpr double kThin = 1e-2;
  const Contact* contact = system.contact();
  if (contact == nullptr) return {};
  const double gap = contact->smallest_gap(system.force_point(from.position, from.time));
  if (!(gap < kThin * contact->least_thickness())) return {};
  return fmt::format(
      "; the smallest gap is {:.1g} m: the layer of contact is too weak for this impact, so raise "
      "the stiffness or the thickness of the obstacle, or of [contact]",
      gap);
}

}  // namespace tetraction
