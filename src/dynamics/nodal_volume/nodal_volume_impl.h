// The members of NodalVolume (tetraction/dynamics/nodal_volume/nodal_volume.h): patches, laws and work space.
#pragma once

#include <memory>
#include <vector>

#include "nodal_patches.h"
#include "patch_gradients.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "volumetric_law.h"

namespace tetraction {

struct NodalVolume::Impl {
  const ElasticPotential& elastic;
  const RestState& rest;
  NodalPatches patches;
  std::vector<MaterialField> materials;
  std::vector<VolumetricLaw> laws;  // of every patch
  ElasticPotential::StiffnessSums stiffness;

  // At the positions of the last evaluate().
  Vector ratio_change;  // J_a − 1 of every patch
  Vector tension;       // U' of every patch, Pa
  Vector energies;      // of every patch, J

  // Work space.
  AlignedVector<double> volumes;  // of every lane
  AlignedVector<double> records;
  Vector outer_factors;
  std::unique_ptr<PatchGradients<double>> gradients;  // made when it is first needed

  Impl(const ElasticPotential& in_elements, const std::vector<MaterialField>& whole);

  const VolumetricLaw& law(Index patch) const { return laws[static_cast<std::size_t>(patch)]; }
  // W of a patch is its share of the rest volume times U.
  double weight(Index patch) const { return patches.rest_volume(patch) / 24.0; }

  void take_material(std::size_t m);
  void sum_stiffness();

  // Sets ratio_change, tension and energies at x, unless x was that of the last call.
  void evaluate(const Positions& x);
  // The mean of `tension` over the nodes of every lane.
  const AlignedVector<double>& lane_tensions();
  double sum_energies() const;

  // Adds force(e, lane), the forces of the nodes of every element, to a field.
  template <class Force>
  void add_forces(Vector& field, const Force& force) {
    const ElementBlocks& blocks = patches.blocks();
    records.assign(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()),
                   0.0);
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        double* own = records.data() + ElementBlocks::kRecordSize * block.first_record;
        blocks.for_each_point(block, [&](Index e, Index batch, int lane) {
          const RestState::Shape::NodeMatrix f =
              force(e, static_cast<std::size_t>(batch * kBatchLanes + lane));
          for (int a = 0; a < RestState::Shape::kNodes; ++a) {
            Eigen::Map<Vector3>(own + blocks.slot(batch, a, lane)) += f.col(a);
          }
        });
      }
    });
    blocks.add_record_sums(records, field);
  }

 private:
  bool is_at(const Positions& x) const;

  // The positions of the last evaluate().
  bool is_evaluated_ = false;
  bool has_displacement_ = false;
  Vector origin_;
  Vector displacement_;
  bool has_lane_tensions_ = false;
  AlignedVector<double> lane_tensions_;
};

}  // namespace tetraction
