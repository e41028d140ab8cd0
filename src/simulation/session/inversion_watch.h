// The inverted elements of a run.
#pragma once

#include <memory>

#include "fem/inverted_elements.h"
#include "simulation/stepping/run_data.h"

namespace tetraction {

/// Counts inverted elements if materials allow them.
class InversionWatch {
 public:
  /// Enters their number at the present state in the progress of the run, with a warning about the first one.
  /// If the state is the result of a step, its elastic energy is given. Null means any other state, or new
  /// materials.
  void update(RunData& run, const double* energy_after_step);
  /// Takes the materials of the body as they are now.
  void renew(const MechanicalSystem& system);

 private:
  std::unique_ptr<InversionCounter> counter_;  // null if no material allows it
};

/// Whether a material is defined for J < 0, or an event may set such a material.
bool may_invert(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
