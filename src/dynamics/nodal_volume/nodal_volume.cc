#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

#include <algorithm>

#include "fem/kernels/volume_kernels.h"
#include "nodal_volume_impl.h"
#include "six_volume.h"

namespace tetraction {

NodalVolume::Impl::Impl(const ElasticPotential& in_elements,
                        const std::vector<MaterialField>& whole)
    : elastic(in_elements),
      rest(in_elements.rest()),
      patches(in_elements),
      materials(whole),
      laws(static_cast<std::size_t>(patches.count())),
      ratio_change(patches.count()),
      tension(patches.count()),
      energies(patches.count()) {
  for (std::size_t m = 0; m < materials.size(); ++m) take_material(m);
  sum_stiffness();
}

void NodalVolume::Impl::take_material(std::size_t m) {
  is_evaluated_ = false;
  const MaterialField& material = materials[m];
  const VolumetricLaw own = volumetric_law(material);
  patches.for_each([&](Index p) {
    if (patches.material(p) != static_cast<int>(m)) return;
    VolumetricLaw& law = laws[static_cast<std::size_t>(p)];
    law = own;
    if (!material.varies()) return;
    double sum = 0.0;
    for (const std::int32_t number : patches.lanes(p)) {
      const auto lane = static_cast<std::size_t>(number);
      sum += patches.rest_volumes()[lane] * volumetric_modulus(material, patches.element(lane));
    }
    law.modulus = sum / patches.rest_volume(p);
  });
}

void NodalVolume::Impl::sum_stiffness() {
  stiffness = {};
  for (Index e = 0; e < rest.element_count(); ++e) {
    const auto element = rest.point(e);
    const auto nodes = rest.nodes(e);
    double longest = 0.0;
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (std::size_t c = 0; c < a; ++c) {
        longest =
            std::max(longest, (rest.position(nodes[a]) - rest.position(nodes[c])).squaredNorm());
      }
    }
    const MaterialField& material = materials[static_cast<std::size_t>(elastic.material_index(e))];
    const double k =
        volumetric_modulus(material, e) * element.weights[0] * element.gradients[0].squaredNorm();
    stiffness.squared += k * k;
    stiffness.with_edges += k * k * longest;
  }
}

bool NodalVolume::Impl::is_at(const Positions& x) const {
  if (!is_evaluated_ || has_displacement_ != (x.displacement() != nullptr)) return false;
  return (!has_displacement_ || displacement_ == *x.displacement()) && origin_ == x.origin();
}

void NodalVolume::Impl::evaluate(const Positions& x) {
  if (is_at(x)) return;
  is_evaluated_ = true;
  has_lane_tensions_ = false;
  origin_ = x.origin();
  has_displacement_ = x.displacement() != nullptr;
  if (has_displacement_) displacement_ = *x.displacement();
  patches.find_volumes(x, volumes);
  patches.for_each([&](Index p) {
    // The sum is that of rest_volume(), so that the change is exactly zero at rest.
    double sum = 0.0;
    for (const std::int32_t lane : patches.lanes(p)) sum += volumes[static_cast<std::size_t>(lane)];
    ratio_change[p] = (sum - patches.rest_volume(p)) / patches.rest_volume(p);
    energies[p] = weight(p) * law(p).energy_and_first(ratio_change[p], tension[p]);
  });
}

const AlignedVector<double>& NodalVolume::Impl::lane_tensions() {
  if (has_lane_tensions_) return lane_tensions_;
  has_lane_tensions_ = true;
  lane_tensions_.resize(patches.lane_count());
  parallel_for(static_cast<Index>(lane_tensions_.size()), 512 * kBatchLanes,
               [&](Index begin, Index end) {
                 for (Index i = begin; i < end; ++i) {
                   const auto lane = static_cast<std::size_t>(i);
                   lane_tensions_[lane] = patches.mean(tension, lane);
                 }
               });
  return lane_tensions_;
}

double NodalVolume::Impl::sum_energies() const {
  double sum = 0.0;
  for (Index p = 0; p < patches.count(); ++p) sum += energies[p];
  return sum;
}

NodalVolume::NodalVolume(const ElasticPotential& elastic,
                         const std::vector<MaterialField>& materials)
    : impl_(std::make_unique<Impl>(elastic, materials)) {}
NodalVolume::~NodalVolume() = default;

MaterialField NodalVolume::without_volumetric_part(const MaterialField& material) {
  return tetraction::without_volumetric_part(material);
}

void NodalVolume::set_material(std::size_t index, const MaterialField& material) {
  volumetric_law(material);  // throws before anything has changed
  impl_->materials.at(index) = material;
  impl_->take_material(index);
  impl_->sum_stiffness();
}

const NodalPatches& NodalVolume::patches() const {
  return impl_->patches;
}

double NodalVolume::energy(const Positions& x) const {
  impl_->evaluate(x);
  return impl_->sum_energies();
}

double NodalVolume::add_gradient(const Positions& x, Vector& gradient) const {
  Impl& s = *impl_;
  s.evaluate(x);
  const double* tensions = s.lane_tensions().data();
  const ElementBlocks& blocks = s.patches.blocks();
  s.records.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()));
  s.patches.for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                              const double* displacements) {
    double* own = s.records.data() + ElementBlocks::kRecordSize * block.first_record;
    std::fill_n(own, ElementBlocks::kRecordSize * block.record_count, 0.0);
    BatchView view = blocks.batches(block);
    view.tensions = tensions + block.first_batch * kBatchLanes;
    add_volume_gradient(view, positions, displacements, own);
  });
  blocks.add_record_sums(s.records, gradient);
  return s.sum_energies();
}

EvaluationStatus NodalVolume::elastic_energy_and_gradient(const Positions& x, double& energy,
                                                          Vector& gradient) const {
  Impl& s = *impl_;
  s.evaluate(x);
  const EvaluationStatus status =
      BlockAccess::value_and_gradient(s.elastic, x, s.lane_tensions(), energy, gradient);
  if (status.ok()) energy += s.sum_energies();
  return status;
}

Vector NodalVolume::energies_by_material(const Vector& q) const {
  Impl& s = *impl_;
  s.evaluate(q);
  Vector sums = Vector::Zero(static_cast<Index>(s.materials.size()));
  for (Index p = 0; p < s.patches.count(); ++p) sums[s.patches.material(p)] += s.energies[p];
  return sums;
}

void NodalVolume::add_energy_densities(const Vector& q, Vector& densities) const {
  Impl& s = *impl_;
  s.evaluate(q);
  Vector density(s.patches.count());
  s.patches.for_each([&](Index p) { density[p] = s.law(p).energy(s.ratio_change[p]); });
  s.patches.for_elements(
      [&](Index e, std::size_t lane) { densities[e] += s.patches.mean(density, lane); });
}

Vector NodalVolume::mean_tensions(const Vector& q) const {
  Impl& s = *impl_;
  s.evaluate(q);
  Vector tension(s.patches.count());
  s.patches.for_each([&](Index p) { tension[p] = s.law(p).first(s.ratio_change[p]); });
  Vector means(s.rest.element_count());
  s.patches.for_elements(
      [&](Index e, std::size_t lane) { means[e] = s.patches.mean(tension, lane); });
  return means;
}

double NodalVolume::mean_tension(Index e, const Vector& q) const {
  const Impl& s = *impl_;
  double sum = 0.0;
  for (const std::int32_t p : s.patches.patches(s.patches.lane(e))) {
    double change = 0.0;
    for (const std::int32_t number : s.patches.lanes(p)) {
      const auto lane = static_cast<std::size_t>(number);
      change +=
          six_volume(s.rest.gather(q, s.patches.element(lane))) - s.patches.rest_volumes()[lane];
    }
    sum += s.law(p).first(change / s.patches.rest_volume(p));
  }
  return 0.25 * sum;
}

Vector NodalVolume::ratios(const Vector& q) const {
  Impl& s = *impl_;
  s.evaluate(q);
  Vector change = Vector::Zero(s.rest.vertex_count());
  Vector volume = Vector::Zero(s.rest.vertex_count());
  for (Index p = 0; p < s.patches.count(); ++p) {
    change[s.patches.vertex(p)] += s.patches.rest_volume(p) * s.ratio_change[p];
    volume[s.patches.vertex(p)] += s.patches.rest_volume(p);
  }
  return Vector::Ones(change.size()) + change.cwiseQuotient(volume);
}

ElasticPotential::StiffnessSums NodalVolume::stiffness_sums() const {
  return impl_->stiffness;
}

}  // namespace tetraction
