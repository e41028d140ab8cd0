#include "snapshot_maker.h"

#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"

namespace tetraction::viewer {
namespace {

std::vector<float> floats(const Vector& values) {
  std::vector<float> result(static_cast<std::size_t>(values.size()));
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = static_cast<float>(values[static_cast<Index>(i)]);
  }
  return result;
}

Vector magnitudes(const Vector& field) {
  return field.reshaped(3, field.size() / 3).colwise().norm().transpose();
}

Vector regions(const MechanicalSystem& system) {
  Vector values(system.mesh().tetrahedron_count());
  for (Index e = 0; e < values.size(); ++e) {
    values[e] = system.region_count() > 1 ? system.region(e)
                                          : system.mesh().regions[static_cast<std::size_t>(e)];
  }
  return values;
}

// Strain and stress vary inside quadratic tetrahedra, whose colours are those of the vertices.
bool on_cells(const Session& session, ColorField field) {
  switch (field) {
    case ColorField::kVonMises:
    case ColorField::kJacobian:
      return !session.system().mesh().is_quadratic();
    case ColorField::kEnergyDensity:
    case ColorField::kRegion:
      return true;
    default:
      return false;
  }
}

Vector color_values(const Session& session, ColorField field) {
  const MechanicalSystem& system = session.system();
  const State& state = session.state();
  Vector values;
  switch (field) {
    case ColorField::kNone:
      break;
    case ColorField::kDisplacement:
      return magnitudes(state.position - system.mesh().rest_positions());
    case ColorField::kSpeed:
      return magnitudes(state.velocity);
    case ColorField::kVonMises:
      if (!on_cells(session, field)) return nodal_fields(system, state.position).von_mises.row(0);
      return von_mises_stress(system, state.position);
    case ColorField::kEnergyDensity:
      system.elastic_energy_densities(state.position, values);
      break;
    case ColorField::kJacobian:
      if (!on_cells(session, field)) return nodal_fields(system, state.position).jacobian.row(0);
      return volume_ratios(system, state.position);
    case ColorField::kRegion:
      return regions(system);
  }
  return values;
}

}  // namespace

std::vector<std::uint8_t> prescribed_vertices(const Session& session) {
  const MechanicalSystem& system = session.system();
  std::vector<std::uint8_t> is_prescribed(static_cast<std::size_t>(system.vertex_count()), 0);
  for (const PrescribedVertices& list : system.constraints().list().held) {
    for (const Index v : list.vertices) is_prescribed[static_cast<std::size_t>(v)] = 1;
  }
  return is_prescribed;
}

Snapshot make_snapshot(const Session& session, ColorField field) {
  const State& state = session.state();
  Snapshot snapshot;
  snapshot.time = state.time;
  snapshot.step = state.step;
  snapshot.status = session.status();
  snapshot.message = session.message();
  snapshot.position = state.position;
  snapshot.velocity = state.velocity;
  snapshot.momentum = state.momentum;
  snapshot.external_force = session.next_external_force();
  snapshot.reaction_force = session.reaction_force();
  snapshot.fixed = prescribed_vertices(session);
  snapshot.field = field;
  snapshot.field_on_cells = on_cells(session, field);
  snapshot.field_values = floats(color_values(session, field));
  return snapshot;
}

}  // namespace tetraction::viewer
