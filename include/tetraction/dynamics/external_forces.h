// Forces on vertices that the user gives.
#pragma once

#include <vector>

#include "tetraction/dynamics/force_term.h"

namespace tetraction {

/// A force on each vertex of a list, constant from `from` until `until`. Both times may lie inside
/// a step.
struct ExternalForce {
  std::vector<Index> vertices;
  Vector3 vector = Vector3::Zero();                        ///< N, on every vertex of the list
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
};

/// The sum of all forces that a user has put on vertices.
class ExternalForces : public ForceTerm {
 public:
  std::string name() const override { return "external_forces"; }
  EnergyAccount account() const override { return EnergyAccount::kNone; }
  bool has_load() const override { return !forces_.empty(); }
  void add_load(const Vector& mass, double time, double h, Vector& force) const override;

  const std::vector<ExternalForce>& list() const { return forces_; }
  std::vector<ExternalForce>& list() { return forces_; }

 private:
  std::vector<ExternalForce> forces_;
};

}  // namespace tetraction
