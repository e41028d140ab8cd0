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
namespace {

constexpr std::array<std::pair<LinearSolver, const char*>, 4> kLinearSolvers{
    {{LinearSolver::kAuto, "auto"},
     {LinearSolver::kMatrixFree, "matrix-free"},
     {LinearSolver::kCg, "cg"},
     {LinearSolver::kFactor, "factor"}}};

constexpr std::array<std::pair<StepAdaptation, const char*>, 3> kStepAdaptations{
    {{StepAdaptation::kNone, "none"},
     {StepAdaptation::kError, "error"},
     {StepAdaptation::kEnergy, "energy"}}};

template <class Table>
std::vector<const char*> names_of(const Table& table) {
  std::vector<const char*> names;
  names.reserve(std::size(table));
  for (const auto& [value, name] : table) names.push_back(name);
  return names;
}

template <class Table, class Value>
std::string name_in(const Table& table, Value value) {
  for (const auto& [entry, name] : table) {
    if (entry == value) return name;
  }
  return "unknown";
}

// `what` completes "is not" in the message.
template <class Table>
auto value_in(const Table& table, const std::string& name, const char* what) {
  std::string known;
  for (const auto& [value, text] : table) {
    if (name == text) return value;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", text);
  }
  throw InputError(fmt::format("{} is not {}; there are {}.", in_quotes(name), what, known));
}

}  // namespace

std::string to_string(GeneratorKind kind) {
  switch (kind) {
    case GeneratorKind::kBeam:
      return "beam";
    case GeneratorKind::kBox:
      return "box";
    case GeneratorKind::kCube:
      return "cube";
    case GeneratorKind::kTetrahedron:
      break;
  }
  return "tetrahedron";
}

std::string to_string(LinearSolver linear) {
  return name_in(kLinearSolvers, linear);
}

LinearSolver linear_solver_from_string(const std::string& name) {
  return value_in(kLinearSolvers, name, "a linear solver");
}

std::string to_string(StepAdaptation adaptation) {
  return name_in(kStepAdaptations, adaptation);
}

StepAdaptation step_adaptation_from_string(const std::string& name) {
  return value_in(kStepAdaptations, name, "a way of adapting steps");
}

std::vector<const char*> step_adaptation_names() {
  return names_of(kStepAdaptations);
}

std::vector<const char*> linear_solver_names() {
  return names_of(kLinearSolvers);
}

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
      "a "
      "new Cholesky factor. Take solver.kind = \"newton\", or leave linear out.",
      to_string(settings.linear));
}

std::string to_string(ConstraintKind kind) {
  switch (kind) {
    case ConstraintKind::kDistance:
      return "distance";
    case ConstraintKind::kPlane:
      return "plane";
    case ConstraintKind::kLine:
      return "line";
    case ConstraintKind::kRigid:
      break;
  }
  return "rigid";
}

std::string to_string(AmplitudeKind kind) {
  switch (kind) {
    case AmplitudeKind::kPoints:
      return "points";
    case AmplitudeKind::kFile:
      return "file";
    case AmplitudeKind::kSine:
      return "sine";
    case AmplitudeKind::kSmoothStep:
      break;
  }
  return "smooth_step";
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

const std::vector<LoadKind>& load_kinds() {
  static const std::vector<LoadKind> kinds{LoadKind::kForce, LoadKind::kMoment, LoadKind::kTraction,
                                           LoadKind::kPressure, LoadKind::kBodyForce};
  return kinds;
}

std::string to_string(LoadKind kind) {
  switch (kind) {
    case LoadKind::kForce:
      return "force";
    case LoadKind::kMoment:
      return "moment";
    case LoadKind::kTraction:
      return "traction";
    case LoadKind::kPressure:
      return "pressure";
    case LoadKind::kBodyForce:
      break;
  }
  return "body_force";
}

std::string to_string(LoadShare share) {
  switch (share) {
    case LoadShare::kAuto:
      return "auto";
    case LoadShare::kSurface:
      return "surface";
    case LoadShare::kVolume:
      return "volume";
    case LoadShare::kVertices:
      break;
  }
  return "vertices";
}

std::vector<ForceSettings>& LoadLists::list(LoadKind kind) {
  return const_cast<std::vector<ForceSettings>&>(std::as_const(*this).list(kind));
}

const std::vector<ForceSettings>& LoadLists::list(LoadKind kind) const {
  switch (kind) {
    case LoadKind::kForce:
      return force;
    case LoadKind::kMoment:
      return moment;
    case LoadKind::kTraction:
      return traction;
    case LoadKind::kPressure:
      return pressure;
    case LoadKind::kBodyForce:
      break;
  }
  return body_force;
}

std::string letters_of(const std::array<bool, 3>& components) {
  std::string letters;
  for (std::size_t i = 0; i < 3; ++i) {
    if (components[i]) letters += static_cast<char>('x' + i);
  }
  return letters;
}

std::string to_string(EnvironmentKind kind) {
  switch (kind) {
    case EnvironmentKind::kNone:
      return "none";
    case EnvironmentKind::kGravity:
      return "gravity";
    case EnvironmentKind::kAttraction:
      return "attraction";
    case EnvironmentKind::kCustom:
      break;
  }
  return "custom";
}

Vector3 unit_direction(const Vector3& direction) {
  constexpr double kRoundOff = 8.0 * std::numeric_limits<double>::epsilon();
  if (std::abs(direction.squaredNorm() - 1.0) <= kRoundOff) return direction;
  return direction.stableNormalized();  // safe with tiny and huge components
}

}  // namespace tetraction
