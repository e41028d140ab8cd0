#include "volumetric_pressure.h"

#include <algorithm>

#include "dynamics/nodal_volume/nodal_patches.h"
#include "dynamics/nodal_volume/six_volume.h"
#include "fem/element_sums.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
bool VolumetricPressure::dominates(const MechanicalSystem& system, double ratio) {
  const std::vector<MaterialField>& materials = system.materials();
  if (!std::all_of(materials.begin(), materials.end(), has_volumetric_law)) return false;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const LameParameters lame = system.lame(e);
    if (lame.lambda >= ratio * lame.mu) return true;
  }
  return false;
}

VolumetricPressure::VolumetricPressure(const MechanicalSystem& system)
    : system_(system),
      patches_(system.nodal_volume() == nullptr ? nullptr : &system.nodal_volume()->patches()) {
  const RestState& rest = system.rest();
  const auto material = [&](Index e) -> const MaterialField& {
    return system.materials()[static_cast<std::size_t>(system.elastic().material_index(e))];
  };
  const Index points = rest.point_count();
  Vector six_volumes(points);
  Vector weighted(points);
  for (Index i = 0; i < points; ++i) {
    six_volumes[i] = 6.0 * rest.point_volume(i);
    const Index e = rest.element_of(i);
    weighted[i] = six_volumes[i] * volumetric_modulus(material(e), e);
  }
  rest_six_volume_ = sum_over_sites([&](Index i) { return six_volumes[i]; });
  const Vector moduli = sum_over_sites([&](Index i) { return weighted[i]; });
  for (Index s = 0; s < moduli.size(); ++s) {
    const Index e = patches_ == nullptr
                        ? rest.element_of(s)
                        : patches_->element(static_cast<std::size_t>(patches_->lanes(s).front()));
    laws_.push_back({moduli[s] / rest_six_volume_[s], volumetric_law(material(e)).logarithmic});
  }
}

// The sums of numbers of points over the points of every site.
template <class Each>
Vector VolumetricPressure::sum_over_sites(const Each& each) const {
  const Index points = system_.rest().point_count();
  Vector of_points(points);
  parallel_for(points, 512, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) of_points[i] = each(i);
  });
  if (patches_ == nullptr) return of_points;
  Vector sums = Vector::Zero(patches_->count());
  patches_->for_each([&](Index p) {
    for (const std::int32_t lane : patches_->lanes(p)) {
      sums[p] += of_points[patches_->element(static_cast<std::size_t>(lane))];
    }
  });
  return sums;
}

void VolumetricPressure::derivatives(const Vector& x, Vector& first, Vector& second) const {
  const RestState& rest = system_.rest();
  first = sum_over_sites([&](Index i) { return six_volume(rest.gather_relative(x, i)); });
  second.resize(first.size());
  for (Index s = 0; s < first.size(); ++s) {
    const double change = (first[s] - rest_six_volume_[s]) / rest_six_volume_[s];
    const VolumetricLaw& law = laws_[static_cast<std::size_t>(s)];
    first[s] = law.first(change);
    second[s] = law.second(change);
  }
}

Vector VolumetricPressure::rates(const Vector& x, const Vector& d) const {
  const RestState& rest = system_.rest();
  return sum_over_sites([&](Index i) {
           return six_volume_gradient(rest.gather_relative(x, i))
               .cwiseProduct(rest.gather_relative(d, i))
               .sum();
         })
      .cwiseQuotient(rest_six_volume_);
}

// The tension of the sites of a point.
double VolumetricPressure::tension(const Vector& p, Index point) const {
  return patches_ == nullptr ? p[point] : patches_->mean(p, patches_->lane(point));
}

void VolumetricPressure::add_forces(const Vector& x, const Vector& p, Vector& forces) const {
  const RestState& rest = system_.rest();
  for (Index e = 0; e < rest.element_count(); ++e) {
    NodeGradient sum = NodeGradient::Zero(3, rest.nodes_per_element());
    for (int k = 0; k < rest.points_per_element(); ++k) {
      const Index i = rest.points_per_element() * e + k;
      add_point_gradient(k, tension(p, i) / 6.0 * six_volume_gradient(rest.gather_relative(x, i)),
                         sum);
    }
    Index a = 0;
    for (const Index v : rest.nodes(e)) vertex_block(forces, v) += sum.col(a++);
  }
}

void VolumetricPressure::add_curvature(const Vector& x, const Vector& p,
                                       const SparsityPattern& pattern, double* values) const {
  const RestState& rest = system_.rest();
  for (const std::vector<Index>& color : pattern.colors()) {
    parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
      ElementMatrix sum;
      const int size = 3 * rest.nodes_per_element();
      for (Index c = begin; c < end; ++c) {
        const Index e = color[static_cast<std::size_t>(c)];
        sum.setZero(size, size);
        for (int k = 0; k < rest.points_per_element(); ++k) {
          const Index i = rest.points_per_element() * e + k;
          add_point_matrix(k, tension(p, i) / 6.0 * six_volume_hessian(rest.gather_relative(x, i)),
                           sum);
        }
        pattern.scatter(e, sum, values);
      }
    });
  }
}

}  // namespace tetraction
