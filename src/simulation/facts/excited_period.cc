#include "tetraction/simulation/excited_period.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

// The names of the amplitudes that act on the body.
std::set<std::string> acting_amplitudes(const Scene& scene) {
  std::set<std::string> names{scene.environment.amplitude};
  for (const LoadKind kind : values_of<LoadKind>()) {
    for (const ForceSettings& load : scene.list(kind)) names.insert(load.amplitude);
  }
  for (const FixSettings& fix : scene.fix) names.insert(fix.amplitude);
  for (const ConstraintSettings& constraint : scene.constraint) names.insert(constraint.amplitude);
  return names;
}

// The shortest period of the sines among them.
ExcitedPeriod period_of_amplitudes(const Scene& scene) {
  const std::set<std::string> acting = acting_amplitudes(scene);
  ExcitedPeriod shortest;
  for (const AmplitudeSettings& amplitude : scene.amplitude) {
    const bool oscillates = amplitude.kind == AmplitudeKind::kSine && amplitude.frequency > 0.0;
    if (!oscillates || !acting.contains(amplitude.name)) continue;
    const double period = 1.0 / amplitude.frequency;
    if (shortest.period != 0.0 && period >= shortest.period) continue;
    shortest = {period, "the amplitude " + amplitude.name};
  }
  return shortest;
}

// All forces on the vertices at the initial positions, at times of the run. Those at which the energy is not
// defined are left out.
std::vector<Vector> forces_over_time(const MechanicalSystem& system, const State& start,
                                     double end) {
  constexpr int kTimes = 33;
  std::vector<Vector> forces;
  Vector loads;
  for (int i = 0; i < kTimes; ++i) {
    const double time = start.time + (end - start.time) * i / (kTimes - 1);
    Vector position = start.position;
    system.constraints().prescribe(time, position);
    double energy = 0.0;
    Vector gradient;
    if (!system.elastic_energy_and_gradient(position, energy, gradient).ok()) continue;
    for (const ForceTerm* term : system.force_terms()) {
      if (term->has_potential()) term->add_gradient(system.force_point(position, time), gradient);
    }
    system.external_force(position, time, (end - start.time) / kTimes, loads);
    if (loads.size() > 0) gradient -= loads;
    forces.emplace_back(-gradient);
  }
  return forces;
}

// The part of a vector along a mode, or 0 if it is not above what round-off and an irregular mesh explain.
double part_along(const NormalMode& mode, const Vector& excitation) {
  constexpr double kNoise = 1e-7;
  const double part = std::abs(mode.shape.dot(excitation));
  return part > kNoise * mode.shape.norm() * excitation.norm() ? part : 0.0;
}

// The lowest of the first `count` modes that is excited.
std::optional<ExcitedPeriod> period_of_modes(const MechanicalSystem& system, const State& start,
                                             const std::vector<Vector>& forces, Index count) {
  NormalModeOptions options;
  options.count = count;
  const NormalModes found = normal_modes(system, system.mesh().rest_positions(), options);
  std::vector<double> amplitudes;
  for (const NormalMode& mode : found.modes) {
    double amplitude = 0.0;
    if (mode.kind == ModeKind::kElastic) {
      for (const Vector& force : forces) {
        amplitude = std::max(amplitude, part_along(mode, force) / mode.omega_squared);
      }
      const double velocity = part_along(mode, start.momentum);
      amplitude = std::max(amplitude, velocity / std::sqrt(mode.omega_squared));
    }
    amplitudes.push_back(amplitude);
  }
  const double largest =
      amplitudes.empty() ? 0.0 : *std::max_element(amplitudes.begin(), amplitudes.end());
  if (!(largest > 0.0)) return {};
  for (std::size_t i = 0; i < amplitudes.size(); ++i) {
    if (amplitudes[i] < 0.01 * largest) continue;
    const double omega = std::sqrt(found.modes[i].omega_squared);
    return ExcitedPeriod{2.0 * std::numbers::pi / omega,
                         fmt::format("mode {} ({:.4g} Hz)", i + 1, found.modes[i].frequency())};
  }
  return {};
}

}  // namespace

ExcitedPeriod excited_period(const Scene& scene, MechanicalSystem& system) {
  const ExcitedPeriod forced = period_of_amplitudes(scene);
  const State start = make_initial_state(scene, system);
  const std::vector<Vector> forces = forces_over_time(system, start, scene.time.end);
  std::optional<ExcitedPeriod> own;
  std::string reason = "neither the loads nor the start excite one of the lowest normal modes";
  try {
    for (const Index count : {10, 40}) {
      own = period_of_modes(system, start, forces, count);
      if (own) break;
    }
  } catch (const Error& error) {
    reason = fmt::format("the normal modes cannot be computed: {}", error.what());
  }
  if (own && (forced.period == 0.0 || own->period <= forced.period)) return *own;
  if (forced.period > 0.0) return forced;
  return {0.0, reason};
}

}  // namespace tetraction
