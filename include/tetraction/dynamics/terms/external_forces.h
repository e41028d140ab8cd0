// Forces on vertices that the user gives.
#pragma once

#include <vector>

#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

/// A force on each vertex of a list, whose directions do not change with the deformation.
struct ExternalForce {
  std::vector<Index> vertices;
  Vector3 vector = Vector3::Zero();  ///< N, on every vertex of the list
  /// If it is not empty: one force for each vertex instead, 3 × vertices, N.
  Matrix vectors{};
  LoadHistory history{};
};

/// The sum of all forces that a user has put on vertices.
class ExternalForces : public ForceTerm {
 public:
  std::string name() const override { return "external_forces"; }
  EnergyAccount account() const override { return EnergyAccount::kNone; }
  bool has_load() const override { return !forces_.empty(); }
  void add_load(const ForcePoint& at, Vector& force) const override;

  const std::vector<ExternalForce>& list() const { return forces_; }
  std::vector<ExternalForce>& list() { return forces_; }

 private:
  std::vector<ExternalForce> forces_;
};

}  // namespace tetraction
