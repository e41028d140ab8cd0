// Scenes of the corner cases: bodies, and every way to solve an implicit step.
#pragma once

#include <algorithm>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "support/runs.h"

namespace tetraction::testing_support {

/// The solvers of implicit steps and equilibria by their names.
inline std::vector<std::pair<std::string, SolverSettings>> all_solvers() {
  std::vector<std::pair<std::string, SolverSettings>> solvers;
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    std::string name = to_string(linear);
    std::replace(name.begin(), name.end(), '-', '_');
    solvers.emplace_back(name, SolverSettings{"newton", linear});
  }
  solvers.emplace_back("ceres", SolverSettings{"ceres", LinearSolver::kAuto});
  return solvers;
}

/// A rule with a solver.
struct RuleWithSolver {
  Integrator integrator = Integrator::kBackwardEuler;
  SolverSettings solver;
  std::string name;
};

inline void PrintTo(const RuleWithSolver& entry, std::ostream* out) {
  *out << entry.name;
}

/// Every implicit rule with every solver.
inline std::vector<RuleWithSolver> implicit_rules_with_solvers() {
  std::vector<RuleWithSolver> rules;
  for (const Integrator rule : all_integrators()) {
    if (!is_implicit(rule)) continue;
    std::string prefix = to_string(rule);
    std::replace(prefix.begin(), prefix.end(), '-', '_');
    for (const auto& [name, solver] : all_solvers()) {
      // Its equations are not those of a minimum.
      if (needs_root_finder(rule) && name == "ceres") continue;
      rules.push_back({rule, solver, prefix + "_" + name});
    }
  }
  return rules;
}

/// Every implicit rule with every solver, and the explicit rules.
inline std::vector<RuleWithSolver> rules_with_solvers() {
  std::vector<RuleWithSolver> rules = implicit_rules_with_solvers();
  for (const Integrator rule : all_integrators()) {
    if (is_implicit(rule)) continue;
    RuleWithSolver& entry = rules.emplace_back();
    entry.integrator = rule;
    entry.name = to_string(rule);
  }
  return rules;
}

inline std::string name_with_solver(const testing::TestParamInfo<RuleWithSolver>& info) {
  return info.param.name;
}

/// A beam along x, held at x = 0, of soft rubber.
inline Scene clamped_beam(const Vector3& size, const std::array<int, 3>& cells) {
  Scene scene = scene_of({GeneratorKind::kBeam, size, cells}, elastic(1e6, 0.4));
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

/// Whether a warning of the session contains this text.
inline bool any_warning(const Session& session, const std::string& part) {
  return std::any_of(session.warnings().begin(), session.warnings().end(),
                     [&](const std::string& w) { return w.find(part) != std::string::npos; });
}

/// The sum of the reactions at the end of the last step, N.
inline Vector3 total_reaction(const Session& session) {
  Vector3 sum = Vector3::Zero();
  const Vector& reaction = session.reaction_force();
  for (Index i = 0; i < reaction.size(); i += 3) sum += reaction.segment<3>(i);
  return sum;
}

}  // namespace tetraction::testing_support
