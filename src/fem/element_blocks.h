// The elements in blocks that fit the first-level cache. The fast element loops use this layout.
//
// Elements of one material are sorted along a Hilbert curve and cut into blocks of about a thousand
// neighbours. A block works on copies of its vertices, *records* of four numbers, and writes its
// share of the forces to records of its own. Afterwards every vertex adds up its records in the
// order of the blocks. So no atomic operations are needed, results are bitwise the same for any
// number of threads, and the numbering of the mesh does not matter for speed.
//
// The lanes of a batch take elements that are far apart in the block (lane l of batch b has element
// l × batches + b), so that the lanes of a batch seldom add to the same record.
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
    Index record_count = 0;  ///< including those of padding elements
    int material = 0;
    double aspect = 0.0;  ///< largest ratio of an element's longest edge to its least height
  };

  /// `material_of_element` may be empty if there is one material only.
  ElementBlocks(const RestState& rest, const std::vector<int>& material_of_element,
                std::size_t materials);

  Index block_count() const { return static_cast<Index>(blocks_.size()); }
  const Block& block(Index b) const { return blocks_[static_cast<std::size_t>(b)]; }
  Block& block(Index b) { return blocks_[static_cast<std::size_t>(b)]; }
  Index record_count() const { return static_cast<Index>(record_vertex_.size()); }
  /// The vertex of a record, or −1 for padding.
  Index record_vertex(Index row) const { return record_vertex_[static_cast<std::size_t>(row)]; }
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

  /// rows ← the records of the block, from a field with 3 numbers per vertex.
  template <class T, class Source>
  void load_records(const Block& block, const Source* field, T* rows) const {
    const std::int32_t* vertex = record_vertex_.data() + block.first_record;
    for (Index r = 0; r < block.record_count; ++r, rows += kRecordSize) {
      const Source* value = field + 3 * static_cast<Index>(vertex[r] < 0 ? 0 : vertex[r]);
      rows[0] = static_cast<T>(value[0]);
      rows[1] = static_cast<T>(value[1]);
      rows[2] = static_cast<T>(value[2]);
      rows[3] = T(0);
    }
    if (block.record_count > 0 && vertex[block.record_count - 1] < 0) fill_padding(rows);
  }

  /// As load_records(), for a field of displacements: the records of padding are zero.
  template <class T, class Source>
  void load_changes(const Block& block, const Source* field, T* rows) const {
    load_records(block, field, rows);
    const Index last = block.record_count - 1;
    if (last >= 0 && record_vertex(block.first_record + last) < 0) {
      std::fill_n(rows + kRecordSize * (last - 3), 4 * kRecordSize, T(0));
    }
  }

  /// As load_records(), for the positions x.
  void load_positions(const Block& block, const Positions& x, double* rows) const;

  /// As load_records(), for a field that has records of kRecordSize numbers itself, one per vertex.
  /// They are in the order of the vertices. If they are in another order, `places` gives the place
  /// of the vertex of each record of all blocks, or −1 for padding.
  template <class T>
  void copy_records(const Block& block, const T* field, T* rows,
                    const std::int32_t* places = nullptr) const {
    using Row = Eigen::Matrix<T, kRecordSize, 1>;
    const std::int32_t* vertex =
        (places == nullptr ? record_vertex_.data() : places) + block.first_record;
    for (Index r = 0; r < block.record_count; ++r, rows += kRecordSize) {
      const T* row = field + kRecordSize * static_cast<Index>(vertex[r] < 0 ? 0 : vertex[r]);
      Eigen::Map<Row, Eigen::Aligned16>{rows} = Eigen::Map<const Row, Eigen::Aligned16>(row);
    }
    if (block.record_count > 0 && vertex[block.record_count - 1] < 0) fill_padding(rows);
  }

  /// For every vertex v, field(v) ← the sum of its records, or field(v) += this sum. The field has
  /// 3 numbers per vertex.
  void sum_records(const AlignedVector<double>& rows, Vector& field) const;
  void add_record_sums(const AlignedVector<double>& rows, Vector& field) const;

  /// Begin and end of the list of the records of a vertex, which is ascending.
  const std::int32_t* rows_begin(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex)];
  }
  const std::int32_t* rows_end(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex) + 1];
  }

 private:
  template <bool kAdd>
  void gather(const AlignedVector<double>& rows, Vector& field) const;

  // Padding elements are unit tetrahedra at rest. The last four records of the block are their
  // nodes.
  template <class T>
  static void fill_padding(T* end) {
    for (T* r = end - 4 * kRecordSize; r != end; ++r) *r = T(0);
    for (int k = 0; k < 3; ++k) end[(k - 3) * kRecordSize + k] = T(1);
  }
  void add_block(const RestState& rest, const std::vector<Index>& order, Index begin, Index end,
                 int material, std::vector<std::int32_t>& record_of_vertex);
  void set_lane(const RestState& rest, Index batch, int lane, Index element,
                const std::array<std::int32_t, 4>& rows);

  std::vector<Block> blocks_;
  AlignedVector<double> rest_numbers_;
  AlignedVector<std::uint16_t> slots_;
  std::vector<std::int32_t> element_;
  std::vector<std::int32_t> record_vertex_;  // −1: padding
  std::vector<std::int32_t> vertex_record_begin_;
  std::vector<std::int32_t> vertex_records_;
};

/// Gives the loops of the library access to the blocks of public classes.
struct BlockAccess {
  /// The blocks of the elements of the whole body.
  static const ElementBlocks& blocks(const ElasticPotential& elastic);
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
