// The data that the solver's thread gives to the window: a state and the fields that are drawn.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/core/types.h"
#include "tetraction/io/obstacle_surface.h"
#include "tetraction/simulation/session.h"
#include "viewer/color_field.h"

namespace tetraction::viewer {

/// The data of one step for the charts and the history table.
struct HistoryRow {
  Index step = 0;
  double time = 0.0;                                                    ///< s
  double kinetic = 0.0, elastic = 0.0, environment = 0.0, total = 0.0;  ///< J
  double external_work = 0.0, constraint_work = 0.0, dissipated_energy = 0.0, edit_work = 0.0,
         energy_error = 0.0;                   ///< J
  Vector3 linear_momentum = Vector3::Zero();   ///< kg m/s
  Vector3 angular_momentum = Vector3::Zero();  ///< kg m²/s
  int iterations = 0;
  std::vector<double> probes{};  ///< values of the scene's probes; NaN where a file has none
};

/// The numbers of a row between the step and the iterations, as history.csv names them.
inline constexpr const char* kHistoryNumbers =
    "time,kinetic_energy,elastic_energy,environment_energy,total_energy,external_work,"
    "dissipated_energy,constraint_work,edit_work,energy_error,px,py,pz,lx,ly,lz";
/// Where a row has them.
template <class Row>
auto numbers_of(Row& row) {
  auto& p = row.linear_momentum;
  auto& l = row.angular_momentum;
  std::vector<decltype(&row.time)> numbers;
  for (auto* number :
       {&row.time, &row.kinetic, &row.elastic, &row.environment, &row.total, &row.external_work,
        &row.dissipated_energy, &row.constraint_work, &row.edit_work, &row.energy_error, &p[0],
        &p[1], &p[2], &l[0], &l[1], &l[2]}) {
    numbers.push_back(number);
  }
  return numbers;
}

/// An edit on the time axis.
struct EditMark {
  double time = 0.0;
  std::string what;
};

/// Why a running simulation has paused by itself.
enum class Pause { kNone, kEnd, kEnergyError };

/// A state between two steps. It is not changed after it has been published. Therefore the window may
/// keep it for any time.
struct Snapshot {
  std::uint64_t generation = 0;  ///< number of the snapshot
  std::uint64_t body = 0;        ///< number of the body; increases with every reset
  double time = 0.0;             ///< s
  Index step = 0;
  RunStatus status = RunStatus::kRunning;
  bool running = false;       ///< whether the solver makes steps
  bool earlier = false;       ///< whether it is a kept state, from which the run can go on
  double newest = 0.0;        ///< the time that the run has reached, s
  std::string message;        ///< of a run that ended; otherwise empty
  Index failed_element = -1;  ///< that a failure is about, or −1
  Vector position;            ///< 3 per vertex, m
  Vector velocity, momentum;  ///< m/s, kg m/s
  Vector external_force;      ///< of all loads, N
  Vector user_force;          ///< of the forces that the user has added, N
  Vector reaction_force;      ///< N
  Vector contact_force;       ///< of obstacles, without friction, N; empty without obstacles
  std::shared_ptr<const ObstacleSurface> obstacles;  ///< null without obstacles
  std::vector<std::uint8_t> fixed;  ///< per vertex: 1 if a [[fix]] or the mouse prescribes it
  ColorField field;
  bool field_on_cells = false;
  std::vector<float> field_values;  ///< per vertex or per tetrahedron
  double stable_step = 0.0;         ///< estimate of the explicit limit, s
  double real_time_factor = 0.0;    ///< simulated seconds per real second; 0 if paused
  Pause pause = Pause::kNone;
  double energy_error = 0.0;     ///< that EnergyWatch has found, J
  double energy_entered = 0.0;   ///< J
  bool knows_last_edit = false;  ///< whether go_before_last_edit() is possible
  std::vector<Index> pulled;     ///< vertices that the mouse pulls with a spring
  double pull_radius = 0.0;      ///< m
  double adapted_step = 0.0;     ///< the last step if steps adapt, s; otherwise 0
};

}  // namespace tetraction::viewer
