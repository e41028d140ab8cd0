#include "tetraction/simulation/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "core/quoting.h"
#include "core/spelling.h"
#include "tetraction/core/error.h"

namespace tetraction {
const std::vector<LengthUnit>& length_units() {
  static const std::vector<LengthUnit> units{
      {"m", 1.0}, {"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}, {"in", 0.0254}};
  return units;
}

double coordinate_scale(const MeshSettings& mesh) {
  std::string known;
  for (const LengthUnit& unit : length_units()) {
    if (mesh.unit == unit.name) return mesh.scale * unit.metres;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", unit.name);
  }
  throw InputError(
      fmt::format("{} is not a unit of length; there are {}.", in_quotes(mesh.unit), known));
}

std::string solver_conflict(const SolverSettings& settings) {
  if (settings.kind != "ceres" || settings.linear == LinearSolver::kAuto) return {};
  return fmt::format(
      "= \"{}\" has no effect with solver.kind = \"ceres\", which solves every linear system with "
      "a new Cholesky factor. Take solver.kind = \"newton\", or leave linear out.",
      to_string(settings.linear));
}

std::shared_ptr<const Amplitude> find_amplitude(const std::vector<AmplitudeSettings>& amplitudes,
                                                const std::string& name, const std::string& where) {
  if (name.empty()) return nullptr;
  std::vector<std::string_view> names;
  for (const AmplitudeSettings& amplitude : amplitudes) {
    if (amplitude.name == name) return std::make_shared<const Amplitude>(make_amplitude(amplitude));
    names.push_back(amplitude.name);
  }
  throw InputError(fmt::format(
      "{}{}amplitude = {} is not defined{}", where, where.empty() ? "" : ": ", in_quotes(name),
      names.empty() ? ": the scene has no [[amplitude]]." : ": " + advice(name, names)));
}

Amplitude make_amplitude(const AmplitudeSettings& settings) {
  try {
    switch (settings.kind) {
      case AmplitudeKind::kPoints:
      case AmplitudeKind::kFile:
        break;
      case AmplitudeKind::kSine:
        return Amplitude::sine(settings.frequency, settings.phase, settings.offset);
      case AmplitudeKind::kSmoothStep:
        return Amplitude::smooth_step(settings.from, settings.until);
    }
    return Amplitude::piecewise_linear(settings.points);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}{}{}", settings.where, settings.where.empty() ? "" : ": ", error.what()));
  }
}

std::string letters_of(const std::array<bool, 3>& components) {
  std::string letters;
  for (std::size_t i = 0; i < 3; ++i) {
    if (components[i]) letters += static_cast<char>('x' + i);
  }
  return letters;
}

Vector3 unit_direction(const Vector3& direction) {
  constexpr double kRoundOff = 8.0 * std::numeric_limits<double>::epsilon();
  if (std::abs(direction.squaredNorm() - 1.0) <= kRoundOff) return direction;
  return direction.stableNormalized();  // safe with tiny and huge components
}

}  // namespace tetraction
