#include "tetraction/simulation/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/dynamics/environment.h"

namespace tetraction {
namespace {

constexpr std::array<std::pair<Integrator, const char*>, 4> kIntegrators{
    {{Integrator::kExplicit, "explicit"},
     {Integrator::kVerlet, "verlet"},
     {Integrator::kMidpoint, "midpoint"},
     {Integrator::kBackwardEuler, "backward-euler"}}};

constexpr std::array<std::pair<LinearSolver, const char*>, 4> kLinearSolvers{
    {{LinearSolver::kAuto, "auto"},
     {LinearSolver::kMatrixFree, "matrix-free"},
     {LinearSolver::kCg, "cg"},
     {LinearSolver::kFactor, "factor"}}};

template <class Table>
std::vector<const char*> names_of(const Table& table) {
  std::vector<const char*> names;
  for (const auto& [value, name] : table) names.push_back(name);
  return names;
}

using Parameter = std::pair<const char*, const std::optional<double>*>;

// Everything in `needed` must be given, nothing in `foreign`.
void require(const std::string& model, const std::vector<Parameter>& needed,
             const std::vector<Parameter>& foreign, const char* wanted) {
  for (const auto& [name, value] : foreign) {
    if (value->has_value()) {
      throw InputError(
          fmt::format("material.{} does not go with the other parameters of the {} "
                      "model: give {}.",
                      name, model, wanted));
    }
  }
  for (const auto& [name, value] : needed) {
    if (!value->has_value()) {
      throw InputError(
          fmt::format("material.{} is missing: the {} model needs {}.", name, model, wanted));
    }
  }
}

}  // namespace

std::string to_string(Integrator integrator) {
  for (const auto& [value, name] : kIntegrators) {
    if (value == integrator) return name;
  }
  return "unknown";
}

Integrator integrator_from_string(const std::string& name) {
  std::string known;
  for (const auto& [value, text] : kIntegrators) {
    if (name == text) return value;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", text);
  }
  throw InputError(fmt::format("\"{}\" is not an integrator; there are {}.", name, known));
}

std::vector<const char*> integrator_names() {
  return names_of(kIntegrators);
}

std::string to_string(LinearSolver linear) {
  for (const auto& [value, name] : kLinearSolvers) {
    if (value == linear) return name;
  }
  return "unknown";
}

LinearSolver linear_solver_from_string(const std::string& name) {
  std::string known;
  for (const auto& [value, text] : kLinearSolvers) {
    if (name == text) return value;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", text);
  }
  throw InputError(fmt::format("\"{}\" is not a linear solver; there are {}.", name, known));
}

std::vector<const char*> linear_solver_names() {
  return names_of(kLinearSolvers);
}

std::string solver_conflict(const SolverSettings& settings) {
  if (settings.kind != "ceres" || settings.linear == LinearSolver::kAuto) return {};
  return fmt::format(
      "= \"{}\" does not go with solver.kind = \"ceres\": Ceres has its own way with linear "
      "systems, a Cholesky factor for each. Take solver.kind = \"newton\", or leave linear out.",
      to_string(settings.linear));
}

bool is_implicit(Integrator integrator) {
  return integrator == Integrator::kMidpoint || integrator == Integrator::kBackwardEuler;
}

int order(Integrator integrator) {
  return integrator == Integrator::kMidpoint || integrator == Integrator::kVerlet ? 2 : 1;
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
  return direction.stableNormalized();  // neither tiny nor huge components spoil it
}

Environment make_environment(const EnvironmentSettings& settings) {
  switch (settings.kind) {
    case EnvironmentKind::kNone:
      break;
    case EnvironmentKind::kGravity:
      return Environment::uniform(settings.strength * settings.direction);
    case EnvironmentKind::kAttraction:
      return Environment::attraction(settings.strength, settings.softening);
    case EnvironmentKind::kCustom:
      return Environment::custom(settings.field);
  }
  return {};
}

MaterialModel make_material(const MaterialSettings& s) {
  if (s.custom) return *s.custom;
  const Parameter young{"youngs_modulus", &s.youngs_modulus};
  const Parameter poisson{"poissons_ratio", &s.poissons_ratio};
  const Parameter mu{"mu", &s.mu};
  const Parameter lambda{"lambda", &s.lambda};
  const Parameter mu1{"mu1", &s.mu1};
  const Parameter mu2{"mu2", &s.mu2};
  const Parameter ratio{"ratio", &s.ratio};
  const bool by_young = s.youngs_modulus || s.poissons_ratio;

  if (s.model == MooneyRivlin::kName) {
    if (by_young) {
      require(s.model, {young, poisson, ratio}, {mu, lambda, mu1, mu2},
              "youngs_modulus, poissons_ratio and ratio (mu2/mu1), or mu1, mu2 and lambda");
      return mooney_rivlin_from_young(*s.youngs_modulus, *s.poissons_ratio, *s.ratio);
    }
    require(s.model, {mu1, mu2, lambda}, {mu, ratio},
            "mu1, mu2 and lambda, or youngs_modulus, poissons_ratio and ratio (mu2/mu1)");
    return MooneyRivlin(*s.mu1, *s.mu2, *s.lambda);
  }
  if (s.model != NeoHookean::kName && s.model != StVenantKirchhoff::kName) {
    throw InputError(fmt::format("material.model = \"{}\" is not a material; there are {}, {}, {}.",
                                 s.model, StVenantKirchhoff::kName, NeoHookean::kName,
                                 MooneyRivlin::kName));
  }
  LameParameters lame;
  if (by_young) {
    require(s.model, {young, poisson}, {mu, lambda, mu1, mu2, ratio},
            "youngs_modulus and poissons_ratio, or mu and lambda");
    lame = lame_from_young(*s.youngs_modulus, *s.poissons_ratio);
  } else {
    require(s.model, {mu, lambda}, {mu1, mu2, ratio},
            "mu and lambda, or youngs_modulus and poissons_ratio");
    lame = {*s.mu, *s.lambda};
  }
  if (s.model == StVenantKirchhoff::kName) return StVenantKirchhoff(lame.mu, lame.lambda);
  return NeoHookean(lame.mu, lame.lambda);
}

}  // namespace tetraction
