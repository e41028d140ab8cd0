// The layout of the elements that the fast element loops use: blocks that fit the first-level cache.
//
// Elements of one material are sorted along a Hilbert curve and cut into blocks of about a thousand
// neighbours. Each block copies the data of its vertices to *records* of four numbers, and it adds
// the forces of its elements to records of its own. Afterwards the records of every vertex are added
// up in the order of the blocks. This needs no atomic operations, the results are bitwise the same
// for any number of threads, and the speed does not depend on the numbering of the mesh.
//
// A batch has one element in each of its kBatchLanes lanes. Lane l of batch b has the element
// l × batches + b of the block. The elements of a batch are therefore far apart, and its lanes
// seldom add to the same record.
#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/element_kernels.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/rest_state.h"
#include "tetraction/fem/sparsity_pattern.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

enum class TangentForm;

/// A vector that begins on a cache line.
template <class T>
using AlignedVector = std::vector<T, tbb::cache_aligned_allocator<T>>;

class ElementBlocks {
 public:
  static constexpr int kRecordSize = 4;

  struct Block {
    Index first_batch = 0;
    Index batch_count = 0;
    Index first_record = 0;
    Index record_count = 0;  ///< with the records of padding elements
    int material = 0;
    double aspect = 0.0;  ///< largest ratio of the longest edge to the least height of an element
  };

  /// `material_of_element` may be empty if there is one material only.
  ElementBlocks(const RestState& rest, const std::vector<int>& material_of_element,
                std::size_t materials);

  Index block_count() const { return static_cast<Index>(blocks_.size()); }
  const Block& block(Index b) const { return blocks_[static_cast<std::size_t>(b)]; }
  Block& block(Index b) { return blocks_[static_cast<std::size_t>(b)]; }
  Index record_count() const { return static_cast<Index>(record_vertex_.size()); }
  /// The vertex of a record, or −1 for padding.
  Index record_vertex(Index record) const {
    return record_vertex_[static_cast<std::size_t>(record)];
  }
  BatchView batches(const Block& block) const {
    const auto first = static_cast<std::size_t>(block.first_batch) * kBatchLanes;
    return {rest_numbers_.data() + first * kRestNumbers, slots_.data() + 4 * first,
            static_cast<std::ptrdiff_t>(block.batch_count)};
  }
  /// The element in a lane, or −1 for padding.
  Index element(Index batch, int lane) const {
    return element_[static_cast<std::size_t>(batch * kBatchLanes + lane)];
  }
  Index batch_count() const { return static_cast<Index>(element_.size()) / kBatchLanes; }
  /// Calls body(element, batch, lane) for the elements of a block, without the padding.
  template <class Body>
  void for_each_element(const Block& block, const Body& body) const {
    for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        if (const Index e = element(batch, lane); e >= 0) body(e, batch, lane);
      }
    }
  }
  /// The slot of a node of the element in a lane: the index of the first number of the node's
  /// record among the numbers of the block's records.
  Index slot(Index batch, int node, int lane) const {
    return slots_[static_cast<std::size_t>((4 * batch + node) * kBatchLanes + lane)];
  }

  /// Fills the records of the block from a field with 3 numbers per vertex. Padding elements get the
  /// nodes of a unit tetrahedron.
  template <class T, class Source>
  void load_records(const Block& block, const Source* field, T* records) const {
    const std::int32_t* vertex = record_vertex_.data() + block.first_record;
    for (Index r = 0; r < block.record_count; ++r, records += kRecordSize) {
      const Source* value = field + 3 * static_cast<Index>(vertex[r] < 0 ? 0 : vertex[r]);
      records[0] = static_cast<T>(value[0]);
      records[1] = static_cast<T>(value[1]);
      records[2] = static_cast<T>(value[2]);
      records[3] = T(0);
    }
    if (block.record_count > 0 && vertex[block.record_count - 1] < 0) fill_padding(records);
  }

  /// Does the same for a field of displacements or velocities. The records of padding are zero.
  template <class T, class Source>
  void load_displacements(const Block& block, const Source* field, T* records) const {
    load_records(block, field, records);
    const Index last = block.record_count - 1;
    if (last >= 0 && record_vertex(block.first_record + last) < 0) {
      std::fill_n(records + kRecordSize * (last - 3), 4 * kRecordSize, T(0));
    }
  }

  /// Fills the records of the block with the positions x.
  void load_positions(const Block& block, const Positions& x, double* records) const;

  /// Fills the records of the block from a field that has one record of kRecordSize numbers per
  /// vertex. If `places` is null, the field is in the order of the vertices. Otherwise places[r] is
  /// the index in the field of the vertex that record r of all blocks belongs to, or −1 for padding.
  template <class T>
  void copy_records(const Block& block, const T* field, T* records,
                    const std::int32_t* places = nullptr) const {
    using Record = Eigen::Matrix<T, kRecordSize, 1>;
    const std::int32_t* vertex =
        (places == nullptr ? record_vertex_.data() : places) + block.first_record;
    for (Index r = 0; r < block.record_count; ++r, records += kRecordSize) {
      const T* source = field + kRecordSize * static_cast<Index>(vertex[r] < 0 ? 0 : vertex[r]);
      Eigen::Map<Record, Eigen::Aligned16>{records} =
          Eigen::Map<const Record, Eigen::Aligned16>(source);
    }
    if (block.record_count > 0 && vertex[block.record_count - 1] < 0) fill_padding(records);
  }

  /// Sets the field at every vertex to the sum of the vertex's records, or adds this sum to the field.
  /// The field has 3 numbers per vertex.
  void sum_records(const AlignedVector<double>& records, Vector& field) const;
  void add_record_sums(const AlignedVector<double>& records, Vector& field) const;

  /// Begin and end of the ascending list of the records of a vertex.
  const std::int32_t* records_begin(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex)];
  }
  const std::int32_t* records_end(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex) + 1];
  }

 private:
  template <bool kAdd>
  void gather(const AlignedVector<double>& records, Vector& field) const;

  // Sets the last four records of the block to the nodes of the padding elements, which are unit
  // tetrahedra at rest.
  template <class T>
  static void fill_padding(T* end) {
    for (T* r = end - 4 * kRecordSize; r != end; ++r) *r = T(0);
    for (int k = 0; k < 3; ++k) end[(k - 3) * kRecordSize + k] = T(1);
  }
  void add_block(const RestState& rest, const std::vector<Index>& order, Index begin, Index end,
                 int material, std::vector<std::int32_t>& record_of_vertex);
  void set_lane(const RestState& rest, Index batch, int lane, Index element,
                const std::array<std::int32_t, 4>& records);

  std::vector<Block> blocks_;
  AlignedVector<double> rest_numbers_;
  AlignedVector<std::uint16_t> slots_;
  std::vector<std::int32_t> element_;
  std::vector<std::int32_t> record_vertex_;  // −1 for padding
  std::vector<std::int32_t> vertex_record_begin_;
  std::vector<std::int32_t> vertex_records_;
};

/// Gives the loops of the library access to the blocks of public classes.
struct BlockAccess {
  /// The blocks of the elements of the whole body.
  static const ElementBlocks& blocks(const ElasticPotential& elastic);
  /// The batches of a block with the parameters of their material.
  static BatchView batches(const ElasticPotential& elastic, Index block);
  /// The energy of a block at the positions where W was evaluated last, J.
  static double energy(const ElasticPotential& elastic, Index block);
  /// The blocks by colour. No two blocks of a colour share a free coordinate of the pattern.
  static const std::vector<std::vector<Index>>& colors(const SparsityPattern& pattern,
                                                       const ElementBlocks& blocks);
  /// Adds the tangent of viscosity in a block to a state with metric terms
  /// (kernels/tangent_kernels.h).
  static void add_tangent(const ViscousPotential& viscous, Index block, const Vector& displacement,
                          TangentForm form, float* state);
  static void add_tangent(const ViscousPotential& viscous, Index block, const Vector& displacement,
                          TangentForm form, double* state);
};

}  // namespace tetraction
