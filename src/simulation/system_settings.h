// The objects of a system that edits may replace, without its constraints.
#pragma once

#include <utility>
#include <vector>

#include "initial_state.h"

namespace tetraction {

/// Materials, environment, damping and forces of a system.
class SystemSettings {
 public:
  /// Those that the system has.
  explicit SystemSettings(const MechanicalSystem& system)
      : materials_(system.elastic().materials()),
        environment_(system.environment()),
        damping_(system.damping()),
        forces_(system.forces()) {}
  /// Those of the settings. Throws InputError.
  SystemSettings(const RunSettings& settings, const TetMesh& mesh)
      : environment_(make_environment(settings.environment)), damping_(settings.damping) {
    for (const MaterialSettings& material : settings.materials) {
      materials_.push_back(make_material(material));
    }
    for (const ForceSettings& force : settings.forces) forces_.push_back(make_force(force, mesh));
  }

  /// Sets them in a system with as many regions.
  void put_in(MechanicalSystem& system) {
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      system.set_material(static_cast<Index>(i), materials_[i]);
    }
    system.set_environment(environment_);
    system.set_damping(damping_);
    system.set_forces(std::move(forces_));
  }

 private:
  std::vector<MaterialModel> materials_;
  Environment environment_;
  Damping damping_;
  std::vector<ExternalForce> forces_;
};

}  // namespace tetraction
