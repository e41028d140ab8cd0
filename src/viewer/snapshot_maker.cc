#include "snapshot_maker.h"

#include "tetraction/simulation/step_failure.h"

namespace tetraction::viewer {

std::vector<std::uint8_t> prescribed_vertices(const Session& session) {
  const MechanicalSystem& system = session.system();
  std::vector<std::uint8_t> is_prescribed(static_cast<std::size_t>(system.vertex_count()), 0);
  for (const PrescribedVertices& list : system.constraints().list().held) {
    for (const Index v : list.vertices) is_prescribed[static_cast<std::size_t>(v)] = 1;
  }
  return is_prescribed;
}

namespace {

void add_obstacles(const Session& session, const State& state, Snapshot& snapshot) {
  const MechanicalSystem& system = session.system();
  const Contact* contact = system.contact();
  if (contact == nullptr) return;
  snapshot.obstacles = obstacle_surface(
      *contact, body_place(system.mesh().rest_positions(), state.position), state.time);
  snapshot.contact_force = values_of(session, *find_quantity("contact_force"), state).reshaped();
}

Snapshot snapshot_at(const Session& session, ColorField field, const State& state) {
  Snapshot snapshot;
  snapshot.time = state.time;
  snapshot.step = state.step;
  snapshot.newest = session.time();
  snapshot.status = session.status();
  snapshot.message = session.message();
  if (const StepFailure* failure = session.failure();
      failure != nullptr && !failure->elements.empty()) {
    snapshot.failed_element = failure->elements.front();
  }
  snapshot.position = state.position;
  snapshot.velocity = state.velocity;
  snapshot.momentum = state.momentum;
  add_obstacles(session, state, snapshot);
  snapshot.field = field;
  if (field == nullptr) return snapshot;
  const Quantity& drawn = drawn_quantity(*field, session.system().mesh().is_quadratic());
  snapshot.field_on_cells = drawn.domain == ValueDomain::kTetrahedra;
  snapshot.field_values = color_values(values_of(session, drawn, state), field.component);
  return snapshot;
}

}  // namespace

Snapshot make_snapshot(const Session& session, ColorField field) {
  Snapshot snapshot = snapshot_at(session, field, session.state());
  snapshot.external_force = session.next_external_force();
  snapshot.reaction_force = session.reaction_force();
  snapshot.fixed = prescribed_vertices(session);
  return snapshot;
}

Snapshot make_snapshot(const Session& session, ColorField field, const KeptState& kept) {
  Snapshot snapshot = snapshot_at(session, field, kept.state);
  snapshot.earlier = true;
  snapshot.external_force = snapshot.reaction_force = snapshot.user_force =
      Vector::Zero(kept.state.position.size());
  snapshot.fixed = kept.settings->fixed;
  return snapshot;
}

}  // namespace tetraction::viewer
