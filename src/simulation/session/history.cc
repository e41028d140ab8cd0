#include "tetraction/simulation/history.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "contact_point.h"
#include "simulation/stepping/adaptations.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

void add(std::vector<double>& row, const Vector3& vector) {
  row.insert(row.end(), vector.data(), vector.data() + 3);
}

// The tension of a distance, or the resultant of the forces of the constraint and their moment about the
// centre of its vertices. The forces act at several times of the step, each where the vertices are then:
// Σ (x − c) × f with x and c of these times, which go back from those of the end with the mean velocity.
void add_constraint(const Session& session, std::size_t i, std::vector<double>& row) {
  if (session.scene().constraint[i].kind == ConstraintKind::kDistance) {
    row.push_back(session.tension(i));
    return;
  }
  const Vector& reaction = session.reaction_force();
  const Vector& delay = session.reaction_delay();
  const State& state = session.state();
  const std::vector<Index>& vertices = session.constraint_vertices(i);
  double mass = 0.0;
  Vector3 center = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  for (const Index v : vertices) {
    const double m = session.system().mass()[v];
    mass += m;
    center += m * vertex_block(state.position, v);
    velocity += m * vertex_block(state.velocity, v);
  }
  if (mass > 0.0) {
    center /= mass;
    velocity /= mass;
  }
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  for (const Index v : vertices) {
    force += vertex_block(reaction, v);
    moment += (vertex_block(state.position, v) - center).cross(vertex_block(reaction, v)) -
              (vertex_block(state.velocity, v) - velocity).cross(vertex_block(delay, v));
  }
  add(row, force);
  add(row, moment);
}

}  // namespace

HistoryColumns::HistoryColumns(const Session& session)
    : has_inverted_(session.may_invert()), has_repeated_(session.may_repeat_steps()) {
  const bool is_static = session.load_path() != nullptr;
  const auto name = [this](auto... names) { (names_.emplace_back(names), ...); };
  name("step", "time");
  // An equilibrium has no motion, and what entered depends on how the loads were applied.
  if (!is_static) name("kinetic_energy");
  name("elastic_energy", "environment_energy", "total_energy");
  if (!is_static) {
    name("external_work", "dissipated_energy", "constraint_work", "edit_work", "energy_error", "px",
         "py", "pz", "lx", "ly", "lz");
  }
  name("max_constraint_error", "iterations", "reaction_x", "reaction_y", "reaction_z", "time_step");
  if (is_static) name("max_displacement", "residual");
  if (has_inverted_) name("inverted_elements");
  for (std::size_t i = 0; i < session.scene().constraint.size(); ++i) {
    if (session.scene().constraint[i].kind == ConstraintKind::kDistance) {
      name(fmt::format("constraint_{}_tension", i));
      continue;
    }
    for (const char* part : {"fx", "fy", "fz", "mx", "my", "mz"}) {
      name(fmt::format("constraint_{}_{}", i, part));
    }
  }
  const Index regions = session.system().region_count();
  for (Index r = 0; r < regions && regions > 1; ++r) {
    if (!is_static) name(fmt::format("kinetic_energy_{}", r));
    name(fmt::format("elastic_energy_{}", r));
  }
  const Energies& energies = session.balance().energies();
  for (std::size_t i = 0; i < energies.extra_count(); ++i) {
    name(fmt::format("{}_energy", energies.extra(i).name));
  }
  if (session.system().contact() != nullptr) {
    if (!is_static) name("friction_dissipation");
    name("min_gap");
  }
  if (has_repeated_) name("rejected", "substeps");
  for (const Adaptation& kind : adaptations()) {
    if (!session.may_adapt(kind.name)) continue;
    for (const Adaptation::Column& column : kind.columns) {
      name(column.name);
      adaptation_values_.push_back(column.value);
    }
  }
}

std::vector<double> HistoryColumns::values(const Session& session) const {
  const Balance& balance = session.balance();
  const Energies& e = balance.energies();
  const LoadPath* path = session.load_path();
  std::vector<double> row;
  row.reserve(names_.size());
  const auto push = [&row](auto... values) { (row.push_back(static_cast<double>(values)), ...); };
  push(session.step_number(), session.time());
  if (path == nullptr) push(e.kinetic());
  push(e.elastic(), e.environment(), e.total());
  if (path == nullptr) {
    push(balance.external_work(), balance.dissipated_energy(), balance.constraint_work(),
         balance.edit_work(), balance.energy_error());
    add(row, balance.momenta().linear);
    add(row, balance.momenta().angular);
  }
  push(session.constraint_error(), session.last_iterations());
  add(row, global_resultant(session.system(), session.reaction_force()));
  push(session.steps().last);
  if (path != nullptr) {
    push(largest_displacement(session.system(), session.state().position).length, path->residual);
  }
  if (has_inverted_) push(session.inverted_elements().now);
  for (std::size_t i = 0; i < session.scene().constraint.size(); ++i) {
    add_constraint(session, i, row);
  }
  if (session.system().region_count() > 1) {
    const State& state = session.state();
    const Vector kinetic = kinetic_energies_by_region(session.system(), state.momentum);
    const Vector elastic = session.system().elastic_energies_by_region(state.position);
    for (Index r = 0; r < kinetic.size(); ++r) {
      if (path == nullptr) push(kinetic[r]);
      push(elastic[r]);
    }
  }
  for (std::size_t i = 0; i < e.extra_count(); ++i) push(e.extra(i).value);
  if (const Contact* contact = session.system().contact(); contact != nullptr) {
    if (path == nullptr) push(balance.friction_dissipation());
    push(contact->smallest_gap(contact_point(session, session.present_state())));
  }
  const StepControl& control = session.step_control();
  if (has_repeated_) push(control.last_rejected, control.last_substeps);
  for (const auto value : adaptation_values_) push(control.*value);
  return row;
}

}  // namespace tetraction
