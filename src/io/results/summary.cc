// summary.json: the account of one run for people and programs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/text/foreign_json.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/process.h"
#include "tetraction/core/version.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

// JSON has no infinity and no NaN: absent numbers are null.
nlohmann::ordered_json number(double value) {
  if (std::isfinite(value)) return value;
  return nullptr;
}

nlohmann::ordered_json mesh_json(const MechanicalSystem& system) {
  const TetMesh& mesh = system.mesh();
  nlohmann::ordered_json skipped = nlohmann::ordered_json::object();
  for (const auto& [type, count] : mesh.report.skipped_cells) skipped[to_string(type)] = count;
  return {{"source", mesh.source},
          {"vertices", global_vertex_count(system)},
          {"tetrahedra", global_tetrahedron_count(system)},
          {"volume", mesh.total_volume()},
          {"reoriented_tetrahedra", mesh.report.reoriented},
          {"dropped_vertices", mesh.report.dropped_vertices},
          {"skipped_cells", skipped}};
}

nlohmann::ordered_json solver_json(const Session& session) {
  const SolverSettings& solver = session.solver_settings();
  nlohmann::ordered_json json{{"kind", solver.kind}, {"linear", to_string(solver.linear)}};
  json["linear_used"] = nullptr;
  if (!session.linear_solver().empty()) json["linear_used"] = session.linear_solver();
  json["iterations"] = session.total_iterations();
  json["factorizations"] = session.total_factorizations();
  json["cg_iterations"] = session.total_cg_iterations();
  json["message"] = session.solver_message();
  if (session.load_path() != nullptr) return json;
  const Balance& balance = session.balance();
  json["steps_limited_by_round_off"] = balance.steps_limited_by_round_off();
  json["tolerance_reached"] = solver.tolerance * std::max(1.0, balance.residual_over_tolerance());
  return json;
}

nlohmann::ordered_json motion_energy_json(const Balance& balance) {
  return {{"kinetic", balance.energies().kinetic()},
          {"elastic", balance.energies().elastic()},
          {"environment", balance.energies().environment()},
          {"total", balance.energies().total()},
          {"external_work", balance.external_work()},
          {"dissipated", balance.dissipated_energy()},
          {"constraint_work", balance.constraint_work()},
          {"edit_work", balance.edit_work()},
          {"error", balance.energy_error()},
          {"scale", balance.energy_scale()}};
}

nlohmann::ordered_json obstacles_json(const Session& session) {
  const Contact& contact = *session.system().contact();
  const std::vector<ObstacleImpulse>& all = session.balance().sums().obstacles;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const ObstacleImpulse impulse = i < all.size() ? all[i] : ObstacleImpulse{};
    const Vector3& linear = impulse.linear;
    const Vector3& angular = impulse.angular;
    const Obstacle& obstacle = contact.obstacle(i);
    const std::string name =
        obstacle.removed ? fmt::format("{} (removed, number {})", obstacle.name, i) : obstacle.name;
    json[name] = {{"impulse", {linear.x(), linear.y(), linear.z()}},
                  {"angular_impulse", {angular.x(), angular.y(), angular.z()}},
                  {"largest_force", impulse.largest_force}};
  }
  return json;
}

// Of an equilibrium: the forces on the body.
nlohmann::ordered_json obstacle_forces_json(const Session& session) {
  const Contact& contact = *session.system().contact();
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const auto& [force, moment] = session.obstacle_forces().at(i);
    json[contact.obstacle(i).name] = {{"force", {force.x(), force.y(), force.z()}},
                                      {"moment", {moment.x(), moment.y(), moment.z()}}};
  }
  return json;
}

nlohmann::ordered_json equilibrium_json(const Session& session, const LoadPath& path) {
  const Displacement largest = largest_displacement(session.system(), session.state().position);
  const Vector3 reaction = resultant(session.reaction_force());
  nlohmann::ordered_json json{
      {"load_factor", path.factor},
      {"cuts", path.cuts},
      {"max_displacement", largest.length},
      {"max_displacement_vertex", session.system().mesh().vertex_id(largest.vertex)},
      {"reaction", {reaction.x(), reaction.y(), reaction.z()}},
      {"residual", path.residual},
      {"residual_limit", path.residual_limit}};
  json["limit_points"] = nlohmann::ordered_json::array();
  for (const LimitPoint& limit : path.limit_points) {
    json["limit_points"].push_back(
        {{"below", limit.below}, {"above", limit.above}, {"passed", limit.passed}});
  }
  json["stability_examined"] = path.is_examined;
  json["loss_of_stability"] = nullptr;
  if (path.loss) {
    json["loss_of_stability"] = {{"below", path.loss->below},
                                 {"above", path.loss->above},
                                 {"flutter", path.loss->is_flutter},
                                 {"growth_rate", path.loss->growth_rate},
                                 {"damping_ratio", path.loss->damping_ratio},
                                 {"is_over", path.loss->is_over}};
  }
  return json;
}

nlohmann::ordered_json probes_json(const ProbeSet& probes, const ProbeTraces& traces) {
  const std::vector<ProbeStatistics> statistics = traces.statistics();
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const ProbeColumns& probe : probes.probes()) {
    for (std::size_t c = 0; c < probe.size(); ++c) {
      const ProbeStatistics& s = statistics[probe.first + c];
      nlohmann::ordered_json entry{
          {"unit", quantity_of(probe.quantity).unit}, {"min", number(s.min)},
          {"min_time", number(s.min_time)},           {"max", number(s.max)},
          {"max_time", number(s.max_time)},           {"final", number(s.last)}};
      if (std::isfinite(s.frequency)) entry["frequency"] = s.frequency;
      json[probe.columns[c]] = std::move(entry);
    }
  }
  return json;
}

}  // namespace

std::string summary_json(const Session& session, const std::string& directory,
                         const ProbeTraces* probes, const RunEnd* end) {
  const MechanicalSystem& system = session.system();
  const Balance& balance = session.balance();
  const StabilityLimit& limit = session.initial_limit();
  const BlasInfo blas = blas_info();

  nlohmann::ordered_json json;
  json["version"] = version();
  json["status"] = end != nullptr ? end->status : to_string(session.status());
  json["exit_status"] = end != nullptr ? end->exit_status : exit_code(session.status());
  json["message"] = end != nullptr ? end->message : session.message();
  json["warnings"] = session.warnings();
  json["mesh"] = mesh_json(system);
  json["mass"] = system.total_mass();
  json["degrees_of_freedom"] = {{"all", 3 * global_vertex_count(system)},
                                {"free", global_freedom_count(system)}};
  const LoadPath* path = session.load_path();
  if (path == nullptr) {
    json["integrator"] = to_string(session.time_settings().integrator);
    json["time_step"] = session.time_step();
    json["stable_step"] = number(limit.critical_step);
    json["omega_max"] = limit.omega_max;
  }
  json["steps"] = session.step_number();
  if (path == nullptr) {
    const bool is_endless = std::isinf(session.time_settings().end);
    json["steps_planned"] = is_endless ? session.step_number() : session.step_count();
  }
  const StepRange& steps = session.steps();
  json["time_steps"] = {{"smallest", steps.smallest},
                        {"largest", steps.largest},
                        {"last", steps.last},
                        {"changes", steps.changes}};
  if (path == nullptr && session.may_repeat_steps()) {
    const StepControl& control = session.step_control();
    json["time_steps"]["adapt"] = to_string(session.time_settings().adapt);
    json["time_steps"]["retried"] = control.retried;
    json["time_steps"]["rejected"] = control.rejected;
    json["time_steps"]["failed"] = control.failed;
    json["time_steps"]["above_tolerance"] = control.above_tolerance;
    json["time_steps"]["without_solution"] = control.without_solution;
  }
  json["time"] = session.time();
  json["solver"] = solver_json(session);
  if (path != nullptr) {
    json["equilibrium"] = equilibrium_json(session, *path);
    json["energy"] = {{"elastic", balance.energies().elastic()},
                      {"environment", balance.energies().environment()},
                      {"total", balance.energies().total()}};
  } else {
    json["energy"] = motion_energy_json(balance);
  }
  for (std::size_t i = 0; i < balance.energies().extra_count(); ++i) {
    json["energy"]["terms"][balance.energies().extra(i).name] = balance.energies().extra(i).value;
  }
  if (system.contact() != nullptr && path == nullptr) {
    json["energy"]["friction_dissipation"] = balance.friction_dissipation();
    if (system.contact()->size() > 0) json["obstacles"] = obstacles_json(session);
  } else if (system.contact() != nullptr && system.contact()->size() > 0) {
    json["obstacles"] = obstacle_forces_json(session);
  }
  if (path == nullptr) {
    json["max_relative_energy_drift"] = balance.max_relative_energy_drift();
    json["linear_momentum_drift"] = balance.linear_momentum_drift();
    json["angular_momentum_drift"] = balance.angular_momentum_drift();
    json["angular_momentum_drift_allowed"] = balance.allowed_angular_momentum_drift();
  }
  json["max_constraint_error"] = session.constraint_error();
  if (session.may_invert()) {
    const InvertedElements& inverted = session.inverted_elements();
    json["inverted_elements"] = {{"now", inverted.now},
                                 {"most", inverted.most},
                                 {"most_at_step", nullptr},
                                 {"first", nullptr},
                                 {"first_time", nullptr}};
    if (inverted.first >= 0) {
      json["inverted_elements"]["most_at_step"] = inverted.most_step;
      json["inverted_elements"]["first"] = inverted.first;
      json["inverted_elements"]["first_time"] = inverted.first_time;
    }
  }
  json["events"] = nlohmann::ordered_json::array();
  for (const AppliedEdit& edit : session.edits()) {
    nlohmann::ordered_json entry{{"at", edit.at},
                                 {"time", edit.time},
                                 {"step", edit.step},
                                 {"energy_jump", edit.energy_jump}};
    entry["what"] = parse_foreign_json<nlohmann::ordered_json>(edit.what);
    if (entry["what"].is_discarded()) entry["what"] = edit.what;
    if (!edit.warning.empty()) entry["warning"] = edit.warning;
    json["events"].push_back(std::move(entry));
  }
  if (probes != nullptr) json["probes"] = probes_json(session.probes(), *probes);
  const PhaseTimes times = session.times();
  json["wall_seconds"] = {{"mesh", times.mesh},           {"setup", times.setup},
                          {"stability", times.stability}, {"stepping", times.stepping},
                          {"output", times.output},       {"total", times.total()}};
  // The largest of several processes.
  json["peak_memory_bytes"] = static_cast<std::uint64_t>(
      largest_of_parts(system.part(), static_cast<double>(peak_memory_bytes())));
  if (system.part() != nullptr) json["processes"] = system.part()->count();
  json["threads"] = thread_count();
  json["blas"] = {{"library", blas.library}, {"core", blas.core}};
  json["scene"] = nlohmann::ordered_json::object();
  if (!session.scene().echo.empty()) {
    json["scene"] = nlohmann::ordered_json::parse(session.scene().echo);
    // A program may have been told another directory than the scene's.
    json["scene"]["output"]["directory"] = directory;
  }
  // The names of files, which stand in messages as well, need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace tetraction
