#include "tetraction/simulation/probe.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "core/quoting.h"
#include "point_location.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

template <class Add>
Vector3 sum(const std::vector<Index>& vertices, const Vector& field, const Add& add) {
  Vector3 total = Vector3::Zero();
  if (field.size() == 0) return total;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    total += add(i, field.segment<3>(3 * vertices[i]));
  }
  return total;
}

}  // namespace

struct ProbeSet::Impl {
  // Where a probe is. The vertices or the tetrahedra are those of its quantity; the other list is
  // empty. A mean has weights that add up to 1, a sum has none.
  struct Place {
    std::vector<Index> vertices;
    std::vector<Index> tetrahedra;
    std::vector<double> weights;  // of the nodes of a point's tetrahedron, or of tetrahedra
    std::vector<std::array<double, 4>> coordinates;  // of a point in quadratic tetrahedra
    std::vector<Vector3> positions;                  // of the vertices at rest, if they are needed
    std::optional<std::string> obstacle;             // in place of vertices and tetrahedra
    Vector3 about = Vector3::Zero();                 // of a moment
  };

  const MechanicalSystem& system;
  std::vector<ProbeColumns> probes;
  std::vector<Place> places;
  std::size_t value_count = 0;

  // Keeps the own vertices of the part, with the weights of a mean over the whole body.
  void take_own_vertices(Place& place) const {
    const TetMesh& mesh = system.mesh();
    std::erase_if(place.vertices, [&](Index v) { return v >= mesh.part->owned_vertices; });
    const double count =
        sum_over_parts(mesh.part.get(), static_cast<double>(place.vertices.size()));
    place.weights.assign(place.vertices.size(), 1.0 / count);
  }

  // The weights of a mean over the volume of the tetrahedra.
  void take_volumes(Place& place) const {
    const TetMesh& mesh = system.mesh();
    double volume = 0.0;
    for (const Index e : place.tetrahedra) volume += mesh.volume(e);
    volume = sum_over_parts(mesh.part.get(), volume);
    for (const Index e : place.tetrahedra) place.weights.push_back(mesh.volume(e) / volume);
  }

  Place place_of(const ProbeSettings& probe) const {
    const TetMesh& mesh = system.mesh();
    Place place;
    const Quantity& quantity = quantity_of(probe.quantity);
    const bool of_tetrahedra = quantity.domain == ValueDomain::kTetrahedra;
    if (quantity.is_of_obstacle) {
      if (system.contact() == nullptr) {
        throw InputError(
            fmt::format("the probe {} is of the obstacle {}, but the scene has no [[obstacle]].",
                        in_quotes(probe.name), in_quotes(probe.obstacle)));
      }
      place.obstacle = probe.obstacle;
      place.about = probe.about;
      return place;
    }
    if (probe.point && of_tetrahedra && mesh.is_quadratic()) {
      for (const PointInMesh& found : locate_all(mesh, *probe.point)) {
        place.tetrahedra.push_back(found.tetrahedron);
        place.coordinates.push_back(found.weights);
      }
      take_volumes(place);
    } else if (probe.point) {
      const PointInMesh found = locate(mesh, *probe.point);
      if (found.tetrahedron < 0) return place;  // in another part
      if (of_tetrahedra) {
        place.tetrahedra = {found.tetrahedron};
        place.weights = {1.0};
      } else {
        const ElementNodes nodes = system.rest().nodes(found.tetrahedron);
        place.vertices.assign(nodes.begin(), nodes.end());
        place.weights = shape_functions(found.weights, nodes.size());
      }
    } else if (of_tetrahedra) {
      place.tetrahedra = select_tetrahedra(mesh, probe.select);
      take_volumes(place);
    } else {
      place.vertices = select_vertices(mesh, probe.select);
      if (mesh.part) take_own_vertices(place);
    }
    if (quantity.is_relative) {
      for (const Index v : place.vertices) {
        place.positions.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
      }
    }
    return place;
  }

  // Σ w_i (u_i − X_i), or the mean if the place has no weights. X_i is zero without positions.
  static Vector3 mean(const Place& place, const Vector& field) {
    const auto value = [&](std::size_t i, const auto& u) -> Vector3 {
      if (place.positions.empty()) return u;
      return u - place.positions[i];
    };
    if (place.weights.empty()) {
      if (place.vertices.empty()) return Vector3::Zero();  // the probe is in another part
      return sum(place.vertices, field, value) / static_cast<double>(place.vertices.size());
    }
    return sum(place.vertices, field, [&](std::size_t i, const auto& u) -> Vector3 {
      return place.weights[i] * value(i, u);
    });
  }

  static Vector3 total(const Place& place, const Vector& field) {
    return sum(place.vertices, field, [](std::size_t, const auto& u) -> Vector3 { return u; });
  }

  // The moment about the point p is M − p × F.
  static Vector3 of_obstacle(const ObstacleForce& total, const Place& place,
                             ProbeQuantity quantity) {
    if (quantity == ProbeQuantity::kContactForce) return total.force;
    return total.moment - place.about.cross(total.force);
  }

  // Zero for one that an event has not added yet, or has removed.
  ObstacleForce force_of_obstacle(const std::string& name, const Session& session) const {
    const Contact& contact = *system.contact();
    const std::vector<ObstacleForce>& forces = session.obstacle_forces();
    for (std::size_t i = 0; i < std::min(contact.size(), forces.size()); ++i) {
      const Obstacle& obstacle = contact.obstacle(i);
      if (obstacle.name == name && !obstacle.removed) return forces[i];
    }
    return {};
  }

  void evaluate(std::size_t probe, const Session& session, double* values) const {
    if (const Place& place = places[probe]; place.obstacle) {
      // It is that of the whole body in every part.
      Eigen::Map<Vector3>{values + probes[probe].first} =
          of_obstacle(force_of_obstacle(*place.obstacle, session), place, probes[probe].quantity);
      return;
    }
    evaluate_part(probe, session, values);
    const ProbeColumns& columns = probes[probe];
    sum_over_parts(system.part(), values + columns.first, static_cast<Index>(columns.size()));
  }

  void evaluate_part(std::size_t probe, const Session& session, double* values) const {
    const Place& place = places[probe];
    const ProbeColumns& columns = probes[probe];
    const Quantity& quantity = quantity_of(columns.quantity);
    double* out = values + columns.first;
    if (quantity.domain == ValueDomain::kVertices) {
      const Vector& field = quantity.of_vertices(session);
      Eigen::Map<Vector3>{out} = quantity.is_sum ? total(place, field) : mean(place, field);
      return;
    }
    std::array<double, 9> own{};
    std::fill_n(out, columns.size(), 0.0);
    for (std::size_t i = 0; i < place.tetrahedra.size(); ++i) {
      const auto* point = place.coordinates.empty() ? nullptr : &place.coordinates[i];
      quantity.of_element({system, place.tetrahedra[i], session.present_state().position, point},
                          own.data());
      for (std::size_t c = 0; c < columns.size(); ++c) out[c] += place.weights[i] * own[c];
    }
  }
};

ProbeSet::ProbeSet(const std::vector<ProbeSettings>& probes, const MechanicalSystem& system)
    : impl_(new Impl{system, {}, {}, 0}) {
  std::set<std::string> taken{"step", "time"};
  for (const ProbeSettings& probe : probes) {
    ProbeColumns columns;
    columns.name = probe.name;
    columns.quantity = probe.quantity;
    columns.first = impl_->value_count;
    columns.every = probe.every;
    try {
      check_settings(probe);
      for (const char* ending : component_endings(quantity_of(probe.quantity).shape)) {
        columns.columns.push_back(probe.name + ending);
        if (!taken.insert(columns.columns.back()).second) {
          throw InputError(fmt::format(
              "the column {} of the probe {} exists already: give the probe another name.",
              in_quotes(columns.columns.back()), in_quotes(probe.name)));
        }
      }
      impl_->places.push_back(impl_->place_of(probe));
    } catch (const InputError& error) {
      throw InputError(probe.where.empty() ? error.what() : probe.where + ": " + error.what());
    }
    impl_->value_count += columns.size();
    impl_->probes.push_back(std::move(columns));
  }
}

ProbeSet::~ProbeSet() = default;

const std::vector<ProbeColumns>& ProbeSet::probes() const {
  return impl_->probes;
}

std::size_t ProbeSet::value_count() const {
  return impl_->value_count;
}

bool ProbeSet::is_due(std::size_t probe, Index step) const {
  return step % impl_->probes[probe].every == 0;
}

void ProbeSet::evaluate(std::size_t probe, const Session& session, double* values) const {
  impl_->evaluate(probe, session, values);
}

void ProbeSet::evaluate(const Session& session, double* values) const {
  for (std::size_t i = 0; i < impl_->probes.size(); ++i) impl_->evaluate(i, session, values);
}

}  // namespace tetraction
