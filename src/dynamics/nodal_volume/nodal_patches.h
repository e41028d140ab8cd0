// The tetrahedra at every vertex, for averages of their volumes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fem/element_blocks.h"
#include "tetraction/core/parallel.h"

namespace tetraction {

/// A patch is the set of the tetrahedra of one material at one vertex. Tetrahedra have the numbers of
/// their lanes in the blocks of the elastic potential (fem/element_blocks.h). Patches are sorted by their
/// first tetrahedra in the order of the blocks, so that neighbours are near in memory.
class NodalPatches {
 public:
  /// Keeps a reference to `elastic`, which must have linear tetrahedra.
  explicit NodalPatches(const ElasticPotential& elastic);

  Index count() const { return static_cast<Index>(vertex_.size()); }
  Index vertex(Index patch) const { return vertex_[static_cast<std::size_t>(patch)]; }
  int material(Index patch) const { return material_[static_cast<std::size_t>(patch)]; }
  /// The lanes of the tetrahedra of a patch, in ascending order of the tetrahedra.
  std::span<const std::int32_t> lanes(Index patch) const {
    const auto i = static_cast<std::size_t>(patch);
    return std::span(lanes_).subspan(begin_[i], begin_[i + 1] - begin_[i]);
  }
  std::size_t lane_count() const { return element_of_lane_.size(); }
  /// The element in a lane, or −1 for padding.
  Index element(std::size_t lane) const { return element_of_lane_[lane]; }
  std::size_t lane(Index element) const {
    return static_cast<std::size_t>(lane_of_element_[static_cast<std::size_t>(element)]);
  }
  /// The place of the tetrahedron in a lane in the order of the blocks, in which neighbours follow one
  /// another.
  Index position(std::size_t lane) const { return position_of_lane_[lane]; }
  /// The patches of the nodes of the tetrahedron in a lane, −1 for padding.
  const std::array<std::int32_t, 4>& patches(std::size_t lane) const {
    return patches_of_lane_[lane];
  }

  /// 6V of every lane at rest, m³.
  const AlignedVector<double>& rest_volumes() const { return rest_volumes_; }
  /// Σ 6V of the tetrahedra of a patch at rest, m³.
  double rest_volume(Index patch) const { return patch_volumes_[patch]; }
  /// volumes ← 6v of every lane at x, m³.
  void find_volumes(const Positions& x, AlignedVector<double>& volumes) const;

  /// The mean of a field of patches over the nodes of a lane; 0 for padding.
  double mean(const Vector& field, std::size_t lane) const {
    const auto& p = patches_of_lane_[lane];
    return p[0] < 0 ? 0.0 : 0.25 * (field[p[0]] + field[p[1]] + field[p[2]] + field[p[3]]);
  }

  /// body(p) for all patches, in parallel.
  template <class Body>
  void for_each(const Body& body) const {
    parallel_for(count(), kGrain, [&](Index begin, Index end) {
      for (Index p = begin; p < end; ++p) body(p);
    });
  }
  /// body(e, lane) for all elements, in parallel.
  template <class Body>
  void for_elements(const Body& body) const {
    parallel_for(static_cast<Index>(lane_of_element_.size()), kGrain, [&](Index begin, Index end) {
      for (Index e = begin; e < end; ++e) body(e, lane(e));
    });
  }
  /// body(block, positions, displacements) for all blocks with the records of x, in parallel;
  /// displacements may be null.
  template <class Body>
  void for_blocks(const Positions& x, const Body& body) const {
    parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
      thread_local AlignedVector<double> positions;
      thread_local AlignedVector<double> displacements;
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks_.block(b);
        const std::size_t size = ElementBlocks::local_size(block);
        positions.resize(size);
        blocks_.load_records(block, x.origin().data(), positions.data());
        const double* second = nullptr;
        if (x.displacement() != nullptr) {
          displacements.resize(size);
          blocks_.load_displacements(block, x.displacement()->data(), displacements.data());
          second = displacements.data();
        }
        body(block, positions.data(), second);
      }
    });
  }
  const ElementBlocks& blocks() const { return blocks_; }

  /// The gradient of the volume of a patch with respect to one vertex, as a sum over the tetrahedra that
  /// have this vertex. If the tetrahedra of the patch at an edge surround it, the volume depends on the
  /// difference of both ends alone. So the gradient of the patch of the other end has the opposite
  /// sign, and needs no sum of its own.
  struct GradientSum {
    std::int32_t patch = -1;
    std::int32_t entry = -1;
    std::int32_t other_patch = -1;  ///< which has minus this gradient; −1: none
    std::int32_t other_entry = -1;
    std::uint32_t corner_begin = 0;  ///< its corners end where those of the next sum begin
  };
  /// The vertices of the tetrahedra of every patch in ascending order, entries begin[p] to begin[p + 1],
  /// and the sums that give the gradients of all entries.
  struct Rows {
    std::vector<std::size_t> begin;  ///< of each patch in `vertices`
    std::vector<Index> vertices;
    std::vector<GradientSum> sums;      ///< with one more at the end
    std::vector<std::int32_t> corners;  ///< 4 position() + node
  };
  /// They are made when they are first asked for.
  const Rows& rows() const;

 private:
  static constexpr Index kGrain = 512;

  struct Corner {
    Index vertex = 0;
    std::int32_t lane = 0;
    std::int32_t node = 0;
    auto operator<=>(const Corner&) const = default;  // NOLINT(modernize-use-nullptr)
  };

  std::vector<Corner> corners_of(Index patch) const;
  bool surround_edge(std::span<const Corner> corners, Index vertex) const;
  void list_vertices() const;
  void list_sums() const;
  void list_lanes();
  std::vector<std::int32_t> order_of_vertices() const;
  void list_patches(const ElasticPotential& elastic);

  const RestState& rest_;
  const ElementBlocks& blocks_;
  std::vector<Index> element_of_lane_;
  std::vector<std::int32_t> lane_of_element_;
  std::vector<std::int32_t> position_of_lane_;
  std::vector<std::array<std::int32_t, 4>> patches_of_lane_;
  std::vector<Index> vertex_;
  std::vector<int> material_;
  std::vector<std::size_t> begin_;
  std::vector<std::int32_t> lanes_;
  AlignedVector<double> rest_volumes_;
  Vector patch_volumes_;
  mutable Rows rows_;
};

}  // namespace tetraction
