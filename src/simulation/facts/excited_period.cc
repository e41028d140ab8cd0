#include "tetraction/simulation/excited_period.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
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
  for (const ObstacleSettings& obstacle : scene.obstacle) names.insert(obstacle.amplitude);
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

// The excitations of a body, as forces on the vertices.
struct Excitations {
  std::vector<Vector> forces;  // at times of the run, N
  std::vector<Vector> rates;   // of the forces that prescribed vertices cause by their motions, N/s
};

// All forces at these positions. Empty where the energy is not defined.
Vector force_at(const MechanicalSystem& system, const Vector& position, const TimeSpan& span) {
  double energy = 0.0;
  Vector gradient;
  if (!system.elastic_energy_and_gradient(position, energy, gradient).ok()) return {};
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) {
      term->add_gradient(system.force_point(position, span.begin), gradient);
    }
  }
  Vector loads;
  system.external_force(position, span.begin, span.length(), loads);
  if (loads.size() > 0) gradient -= loads;
  return -gradient;
}

Excitations excitations_over_time(const MechanicalSystem& system, const State& start, double end) {
  constexpr int kTimes = 32;
  const double spacing = (end - start.time) / kTimes;
  Excitations found;
  Vector last;  // force that the motions cause
  for (int i = 0; i < kTimes; ++i) {
    const double time = start.time + i * spacing;
    const TimeSpan span{time, time + spacing};
    Vector force = force_at(system, start.position, span);
    if (force.size() == 0) break;
    if (system.constraints().moving()) {
      Vector moved = start.position;
      system.constraints().prescribe(time, moved);
      Vector caused = force_at(system, moved, span);
      if (caused.size() > 0) {
        caused -= force;
        if (last.size() > 0) found.rates.emplace_back((caused - last) / spacing);
      }
      last = std::move(caused);
    }
    found.forces.push_back(std::move(force));
  }
  return found;
}

// The motion of the vertex that moves most in a mode, m, and the square root of the energy.
std::pair<double, double> motion_and_root_energy(const NormalMode& mode, const State& start,
                                                 const Excitations& excitations) {
  if (mode.kind != ModeKind::kElastic) return {};
  const double omega = std::sqrt(mode.omega_squared);
  double root_energy = std::abs(mode.shape.dot(start.momentum));
  for (const Vector& force : excitations.forces) {
    root_energy = std::max(root_energy, std::abs(mode.shape.dot(force)) / omega);
  }
  for (const Vector& rate : excitations.rates) {
    root_energy = std::max(root_energy, std::abs(mode.shape.dot(rate)) / mode.omega_squared);
  }
  return {root_energy / omega * mode.shape.lpNorm<Eigen::Infinity>(), root_energy};
}

// The lowest of the first `count` modes that is excited. `with_loads`: on the spring of [pull], on which a body may
// swing as a whole.
std::optional<ExcitedPeriod> period_of_modes(const MechanicalSystem& system, const State& start,
                                             const Excitations& excitations, Index count,
                                             bool with_loads) {
  NormalModeOptions options;
  options.count = count;
  options.with_loads = with_loads;
  const Vector rest = system.mesh().rest_positions();
  const std::vector<NormalMode> modes = normal_modes(system, rest, options).modes;
  // Smaller motions are round-off of the forces at rest.
  const double least = 1e-9 * (rest.maxCoeff() - rest.minCoeff());
  std::vector<double> found;
  for (const NormalMode& mode : modes) {
    const auto [motion, root_energy] = motion_and_root_energy(mode, start, excitations);
    found.push_back(motion > least ? root_energy : 0.0);
  }
  const double largest = found.empty() ? 0.0 : *std::max_element(found.begin(), found.end());
  if (!(largest > 0.0)) return {};
  const auto lowest = std::find_if(found.begin(), found.end(), [&](double root) {
    return root * root >= 0.05 * largest * largest;
  });
  const auto place = static_cast<std::size_t>(lowest - found.begin());
  return ExcitedPeriod{1.0 / modes[place].frequency(),
                       fmt::format("mode {} ({:.4g} Hz)", place + 1, modes[place].frequency())};
}

}  // namespace

ExcitedPeriod excited_period(const Scene& scene, MechanicalSystem& system) {
  const ExcitedPeriod forced = period_of_amplitudes(scene);
  const State start = make_initial_state(scene, system);
  const Excitations excitations = excitations_over_time(system, start, scene.time.end);
  std::optional<ExcitedPeriod> own;
  std::string reason = "neither the loads nor the start excite one of the lowest normal modes";
  try {
    for (const Index count : {10, 40}) {
      own = period_of_modes(system, start, excitations, count, scene.pull.stiffness > 0.0);
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
