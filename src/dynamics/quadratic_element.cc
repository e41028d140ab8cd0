#include "quadratic_element.h"

#include <algorithm>
#include <cmath>

namespace tetraction {

QuadraticElement::QuadraticElement(const MechanicalSystem& system, Index e, const Vector& q)
    : material_(system.elastic().material(e)) {
  const RestState& rest = system.rest();
  const ElementNodes nodes = rest.nodes(e);
  for (std::size_t a = 0; a < rest_.size(); ++a) {
    rest_[a] = rest.position(nodes[a]) - rest.position(nodes[0]);
    present_[a] = vertex_block(q, nodes[a]) - vertex_block(q, nodes[0]);
  }
  constexpr double kSingular = 1e-4;
  least_determinant_ = kSingular * std::abs(rest_determinant({0.25, 0.25, 0.25, 0.25}));
}

Matrix3 QuadraticElement::edges(const Nodes& nodes, const VolumeCoordinates& l) {
  return quadratic_edges(
      l, [&](int a) -> const Vector3& { return nodes[static_cast<std::size_t>(a)]; });
}

double QuadraticElement::rest_determinant(const VolumeCoordinates& l) const {
  return edges(rest_, l).determinant();
}

bool QuadraticElement::is_defined(const Matrix3& f) const {
  return f.determinant() > 0.0 && f.allFinite() &&
         std::visit([&](const auto& material) { return material.admissible(f); }, material_);
}

Matrix3 QuadraticElement::deformation_gradient(const VolumeCoordinates& l) const {
  const Matrix3 at_rest = edges(rest_, l);
  if (at_rest.determinant() > least_determinant_) {
    const Matrix3 f = edges(present_, l) * at_rest.inverse();
    if (is_defined(f)) return f;
  }
  VolumeCoordinates nearest;
  nearest.fill(QuadraticPoints::kFar);
  nearest[static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin())] =
      QuadraticPoints::kNear;
  return edges(present_, nearest) * edges(rest_, nearest).inverse();
}

Matrix3 QuadraticElement::first_piola(const Matrix3& f) const {
  return std::visit([&](const auto& material) -> Matrix3 { return material.first_piola(f); },
                    material_);
}

bool is_curved(const RestState& rest, Index e) {
  if (!rest.is_quadratic()) return false;
  const ElementNodes nodes = rest.nodes(e);
  return !has_straight_edges(
      [&](int a) { return rest.position(nodes[static_cast<std::size_t>(a)]); });
}

Matrix3 cauchy_of(const Matrix3& first_piola, const Matrix3& f) {
  const Matrix3 stress = first_piola * f.transpose() / f.determinant();
  return 0.5 * (stress + stress.transpose());
}

}  // namespace tetraction
