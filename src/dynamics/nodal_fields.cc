#include "tetraction/dynamics/nodal_fields.h"

#include <algorithm>
#include <array>

#include "fem/element_fields.h"
#include "quadratic_element.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/derived_fields.h"

namespace tetraction {
namespace {

PlaceValues values_of(const Matrix3& first_piola, const Matrix3& f) {
  PlaceValues values;
  values.cauchy_stress = cauchy_of(first_piola, f);
  values.green_strain = 0.5 * (f.transpose() * f - Matrix3::Identity());
  values.von_mises = von_mises(values.cauchy_stress);
  values.jacobian = f.determinant();
  return values;
}

PlaceValues values_of(const QuadraticElement& element, const VolumeCoordinates& l) {
  const Matrix3 f = element.deformation_gradient(l);
  return values_of(element.first_piola(f), f);
}

// The places of the ten nodes.
constexpr std::array<VolumeCoordinates, QuadraticPoints::kNodes> node_places() {
  std::array<VolumeCoordinates, QuadraticPoints::kNodes> places{};
  for (int i = 0; i < 4; ++i) {
    places[static_cast<std::size_t>(i)][static_cast<std::size_t>(i)] = 1.0;
    for (int j = 0; j < i; ++j) {
      VolumeCoordinates& middle = places[static_cast<std::size_t>(QuadraticPoints::middle(i, j))];
      middle[static_cast<std::size_t>(i)] = 0.5;
      middle[static_cast<std::size_t>(j)] = 0.5;
    }
  }
  return places;
}

// Stress, strain, von Mises stress and J in one column.
constexpr Index kRows = 14;

void put(const PlaceValues& values, Eigen::Ref<Vector> column) {
  column.segment<6>(0) = six_components(values.cauchy_stress);
  column.segment<6>(6) = six_components(values.green_strain);
  column[12] = values.von_mises;
  column[13] = values.jacobian;
}

}  // namespace

PlaceValues values_at(const MechanicalSystem& system, Index e, const std::array<double, 4>& l,
                      const Vector& q) {
  const RestState& rest = system.rest();
  if (rest.is_quadratic()) return values_of(QuadraticElement(system, e, q), l);
  return values_of(system.first_piola(e, q), deformation_gradient(rest, q, e));
}

NodalFields nodal_fields(const MechanicalSystem& system, const Vector& q) {
  const RestState& rest = system.rest();
  if (!rest.is_quadratic()) {
    const ElementFields fields = element_fields(system, q);
    return {nodal_average(system, fields.cauchy_stress), nodal_average(system, fields.green_strain),
            nodal_average(system, fields.von_mises), nodal_average(system, fields.jacobian)};
  }
  static constexpr auto kPlaces = node_places();
  constexpr auto kNodes = static_cast<Index>(kPlaces.size());
  // So many elements are computed together, before their values are added in their order.
  constexpr Index kTogether = 4096;
  Matrix sums = Matrix::Zero(kRows, system.vertex_count());
  Vector volumes = Vector::Zero(system.vertex_count());
  Matrix values(kRows, kNodes * std::min(kTogether, rest.element_count()));
  for (Index first = 0; first < rest.element_count(); first += kTogether) {
    const Index count = std::min(kTogether, rest.element_count() - first);
    parallel_for(count, 128, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        const QuadraticElement element(system, first + i, q);
        for (Index a = 0; a < kNodes; ++a) {
          put(values_of(element, kPlaces[static_cast<std::size_t>(a)]), values.col(kNodes * i + a));
        }
      }
    });
    for (Index i = 0; i < count; ++i) {
      const double volume = rest.volume(first + i);
      Index column = kNodes * i;
      for (const Index v : rest.nodes(first + i)) {
        sums.col(v) += volume * values.col(column++);
        volumes[v] += volume;
      }
    }
  }
  sums.array().rowwise() /= volumes.transpose().array();
  return {sums.topRows(6), sums.middleRows(6, 6), sums.row(12), sums.row(13)};
}

}  // namespace tetraction
