// The elastic forces of an explicit step, which the next one begins with.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// ∇W of the elastic energy at the current position, kept from the end of the last step.
class ForceCache {
 public:
  EvaluationStatus update(const MechanicalSystem& system, const Vector& q) {
    if (valid_) return {};
    const EvaluationStatus status =
        system.elastic_energy_and_gradient(q, elastic_energy_, gradient_);
    valid_ = status.ok();
    return status;
  }
  bool is_known() const { return valid_; }
  void invalidate() { valid_ = false; }
  const Vector& gradient() const { return gradient_; }
  double elastic_energy() const { return elastic_energy_; }

 private:
  bool valid_ = false;
  double elastic_energy_ = 0.0;
  Vector gradient_;
};

}  // namespace tetraction
