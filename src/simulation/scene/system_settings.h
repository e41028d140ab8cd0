// The objects of a system that edits may replace, without its constraints.
#pragma once

#include <utility>
#include <vector>

#include "body_loads.h"
#include "tetraction/simulation/run_settings.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

/// Materials, environment, damping and loads of a system.
class SystemSettings {
 public:
  /// Those that the system has.
  explicit SystemSettings(const MechanicalSystem& system)
      : materials_(system.materials()),
        environment_(system.environment()),
        damping_(system.damping()),
        loads_{system.forces(), system.pressures()} {}
  /// Those of the settings. Throws InputError.
  SystemSettings(const RunSettings& settings, const MechanicalSystem& system,
                 const AmplitudeList& amplitudes)
      : environment_(make_environment(settings.environment, amplitudes)),
        damping_(settings.damping),
        loads_(make_loads(settings.loads, system, amplitudes)) {
    for (std::size_t i = 0; i < settings.materials.size(); ++i) {
      materials_.push_back(make_material(settings.materials[i], system, static_cast<Index>(i)));
    }
  }

  /// Sets them in a system with as many regions.
  void put_in(MechanicalSystem& system) {
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      system.set_material(static_cast<Index>(i), materials_[i]);
    }
    system.set_environment(environment_);
    system.set_damping(damping_);
    system.set_forces(std::move(loads_.forces));
    system.set_pressures(std::move(loads_.pressures));
  }

 private:
  std::vector<MaterialField> materials_;
  Environment environment_;
  Damping damping_;
  BodyLoads loads_;
};

}  // namespace tetraction
