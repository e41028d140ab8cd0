#include "tetraction/simulation/probe.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "core/quoting.h"
#include "point_location.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

// The shape of the value of a quantity.
enum class ValueShape { kVector, kSymmetricTensor, kScalar };
// Over what it is computed.
enum class ValueDomain { kMeanOfVertices, kSumOfVertices, kTetrahedra };

struct QuantityEntry {
  ProbeQuantity quantity;
  const char* unit;
  ValueShape shape;
  ValueDomain domain;
};

constexpr std::array<QuantityEntry, 9> kQuantities{
    {{ProbeQuantity::kDisplacement, "m", ValueShape::kVector, ValueDomain::kMeanOfVertices},
     {ProbeQuantity::kPosition, "m", ValueShape::kVector, ValueDomain::kMeanOfVertices},
     {ProbeQuantity::kVelocity, "m/s", ValueShape::kVector, ValueDomain::kMeanOfVertices},
     {ProbeQuantity::kMomentum, "kg m/s", ValueShape::kVector, ValueDomain::kSumOfVertices},
     {ProbeQuantity::kForce, "N", ValueShape::kVector, ValueDomain::kSumOfVertices},
     {ProbeQuantity::kReaction, "N", ValueShape::kVector, ValueDomain::kSumOfVertices},
     {ProbeQuantity::kCauchyStress, "Pa", ValueShape::kSymmetricTensor, ValueDomain::kTetrahedra},
     {ProbeQuantity::kVonMises, "Pa", ValueShape::kScalar, ValueDomain::kTetrahedra},
     {ProbeQuantity::kJacobian, "", ValueShape::kScalar, ValueDomain::kTetrahedra}}};

const QuantityEntry& entry_of(ProbeQuantity quantity) {
  return *std::find_if(kQuantities.begin(), kQuantities.end(),
                       [&](const QuantityEntry& entry) { return entry.quantity == quantity; });
}

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

const char* unit_of(ProbeQuantity quantity) {
  return entry_of(quantity).unit;
}

bool is_sum(ProbeQuantity quantity) {
  return entry_of(quantity).domain == ValueDomain::kSumOfVertices;
}

const std::vector<const char*>& column_endings(ProbeQuantity quantity) {
  static const std::vector<const char*> vector{"_x", "_y", "_z"};
  static const std::vector<const char*> tensor{"_xx", "_yy", "_zz", "_xy", "_yz", "_xz"};
  static const std::vector<const char*> scalar{""};
  switch (entry_of(quantity).shape) {
    case ValueShape::kVector:
      return vector;
    case ValueShape::kSymmetricTensor:
      return tensor;
    case ValueShape::kScalar:
      break;
  }
  return scalar;
}

struct ProbeSet::Impl {
  // Where a probe is. The vertices or the tetrahedra are those of its quantity; the other list is
  // empty. A mean has weights that add up to 1, a sum has none.
  struct Place {
    std::vector<Index> vertices;
    std::vector<Index> tetrahedra;
    std::vector<double> weights;  // of the nodes of a point's tetrahedron, or of tetrahedra
    std::vector<std::array<double, 4>> coordinates;  // of a point in quadratic tetrahedra
    std::vector<Vector3> positions;                  // of the vertices at rest, if they are needed
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
    const bool of_tetrahedra = entry_of(probe.quantity).domain == ValueDomain::kTetrahedra;
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
    if (probe.quantity == ProbeQuantity::kDisplacement) {
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

  template <class Value>
  double mean_of_tetrahedra(const Place& place, const Value& value) const {
    double total = 0.0;
    for (std::size_t i = 0; i < place.tetrahedra.size(); ++i) total += place.weights[i] * value(i);
    return total;
  }

  Matrix3 stress_of(const Place& place, std::size_t i, const Vector& q) const {
    const Index e = place.tetrahedra[i];
    if (place.coordinates.empty()) return cauchy_stress(system, e, q);
    return values_at(system, e, place.coordinates[i], q).cauchy_stress;
  }

  double jacobian_of(const Place& place, std::size_t i, const Vector& q) const {
    const Index e = place.tetrahedra[i];
    if (place.coordinates.empty()) return volume_ratio(system, e, q);
    return values_at(system, e, place.coordinates[i], q).jacobian;
  }

  void evaluate(std::size_t probe, const Session& session, double* values) const {
    evaluate_part(probe, session, values);
    const ProbeColumns& columns = probes[probe];
    sum_over_parts(system.part(), values + columns.first, static_cast<Index>(columns.size()));
  }

  void evaluate_part(std::size_t probe, const Session& session, double* values) const {
    const Place& place = places[probe];
    const ProbeColumns& columns = probes[probe];
    double* out = values + columns.first;
    const State& state = session.present_state();
    const auto put = [out](const Vector3& vector) {
      std::copy(vector.data(), vector.data() + 3, out);
    };
    switch (columns.quantity) {
      case ProbeQuantity::kDisplacement:
      case ProbeQuantity::kPosition:
        return put(mean(place, state.position));
      case ProbeQuantity::kVelocity:
        return put(mean(place, state.velocity));
      case ProbeQuantity::kMomentum:
        return put(total(place, state.momentum));
      case ProbeQuantity::kForce:
        return put(total(place, session.present_external_force()));
      case ProbeQuantity::kReaction:
        return put(total(place, session.reaction_force()));
      case ProbeQuantity::kCauchyStress: {
        Vector6 total = Vector6::Zero();
        for (std::size_t i = 0; i < place.tetrahedra.size(); ++i) {
          total += place.weights[i] * six_components(stress_of(place, i, state.position));
        }
        std::copy(total.data(), total.data() + 6, out);
        return;
      }
      case ProbeQuantity::kVonMises:
        *out = mean_of_tetrahedra(
            place, [&](std::size_t i) { return von_mises(stress_of(place, i, state.position)); });
        return;
      case ProbeQuantity::kJacobian:
        *out = mean_of_tetrahedra(
            place, [&](std::size_t i) { return jacobian_of(place, i, state.position); });
        return;
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
      for (const char* ending : column_endings(probe.quantity)) {
        columns.columns.push_back(probe.name + ending);
        if (!taken.insert(columns.columns.back()).second) {
          throw InputError(
              fmt::format("the column {} of the probe {} exists already: give the probe "
                          "another name.",
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
