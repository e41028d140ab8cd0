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
//
// A quadratic element has four lanes of a batch, one for each of its quadrature points. The kernels
// see a point as a linear tetrahedron (quadratic_points.h). Therefore a block has two kinds of
// records: those of its vertices, and the *local* records that the kernels work on. For linear
// elements they are the same. For quadratic ones the local records are the edges of the points, with a
// record of zeros as their common first node, and the functions that load records form them.
#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "kernels/edge_kernels.h"
#include "kernels/element_kernels.h"
#include "mesh/quadratic_points.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/rest_state.h"
#include "tetraction/fem/sparsity_pattern.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

class MeshPart;
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
    Index local_count = 0;   ///< number of local records
    Index first_element =
        0;  ///< quadratic elements only: their place in the list of records of nodes
    Index element_count = 0;
    int material = 0;
    double aspect = 0.0;  ///< largest ratio of the longest edge to the least height of an element
  };

  /// `material_of_element` may be empty if there is one material only. Keeps no reference.
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
  /// The quadrature point in a lane (RestState), or −1 for padding. The points of an element are in
  /// neighbouring lanes of one batch.
  Index point(Index batch, int lane) const {
    return point_[static_cast<std::size_t>(batch * kBatchLanes + lane)];
  }
  Index batch_count() const { return static_cast<Index>(point_.size()) / kBatchLanes; }
  bool is_quadratic() const { return points_ > 1; }
  int points_per_element() const { return points_; }
  int nodes_per_element() const { return is_quadratic() ? QuadraticPoints::kNodes : 4; }
  /// Calls body(point, batch, lane) for the points of a block, without the padding.
  template <class Body>
  void for_each_point(const Block& block, const Body& body) const {
    for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        if (const Index i = point(batch, lane); i >= 0) body(i, batch, lane);
      }
    }
  }
  /// Calls body(element, batch, lane of its first point) for the elements of a block.
  template <class Body>
  void for_each_element(const Block& block, const Body& body) const {
    for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
      for (int lane = 0; lane < kBatchLanes; lane += points_) {
        if (const Index i = point(batch, lane); i >= 0) body(i / points_, batch, lane);
      }
    }
  }
  /// The slot of a node of the point in a lane: the index of the first number of the node's record
  /// among the numbers of the block's local records.
  Index slot(Index batch, int node, int lane) const {
    return slots_[static_cast<std::size_t>((4 * batch + node) * kBatchLanes + lane)];
  }
  /// The record, counted over all blocks, of node a of the element that has this lane.
  Index record_of_node(const Block& block, Index batch, int lane, int a) const {
    if (!is_quadratic()) return block.first_record + slot(batch, a, lane) / kRecordSize;
    const Index element = block.first_element + (kBatchLanes * (batch - block.first_batch) + lane) /
                                                    QuadraticPoints::kPoints;
    return block.first_record +
           node_records_[static_cast<std::size_t>(element)][static_cast<std::size_t>(a)];
  }
  /// The number of numbers in the local records of a block.
  static std::size_t local_size(const Block& block) {
    return static_cast<std::size_t>(kRecordSize * block.local_count);
  }

  /// Fills the local records of the block from a field with 3 numbers per vertex. Padding elements
  /// get the nodes of a tetrahedron at rest that is too small to matter.
  template <class T, class Source>
  void load_records(const Block& block, const Source* field, T* records) const {
    const std::int32_t* vertex = record_vertex_.data() + block.first_record;
    if (is_quadratic()) {
      form_local_records(block, records, [&](Index r) {
        const Source* value = field + 3 * static_cast<Index>(vertex[r]);
        return Eigen::Matrix<T, kRecordSize, 1>(static_cast<T>(value[0]), static_cast<T>(value[1]),
                                                static_cast<T>(value[2]), T(0));
      });
      return;
    }
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
    if (is_padded(block)) {
      std::fill_n(records + kRecordSize * (block.local_count - 4), 4 * kRecordSize, T(0));
    }
  }

  /// Fills the local records of the block with the positions x.
  void load_positions(const Block& block, const Positions& x, double* records) const;

  /// Fills the local records of the block from a field that has one record of kRecordSize numbers per
  /// vertex. If `places` is null, the field is in the order of the vertices. Otherwise places[r] is
  /// the index in the field of the vertex that record r of all blocks belongs to, or −1 for padding.
  template <class T>
  void copy_records(const Block& block, const T* field, T* records,
                    const std::int32_t* places = nullptr) const {
    using Record = Eigen::Matrix<T, kRecordSize, 1>;
    const std::int32_t* vertex =
        (places == nullptr ? record_vertex_.data() : places) + block.first_record;
    if (is_quadratic()) {
      form_local_records(block, records, [&](Index r) {
        return Record(Eigen::Map<const Record, Eigen::Aligned16>(
            field + kRecordSize * static_cast<Index>(vertex[r])));
      });
      return;
    }
    for (Index r = 0; r < block.record_count; ++r, records += kRecordSize) {
      const T* source = field + kRecordSize * static_cast<Index>(vertex[r] < 0 ? 0 : vertex[r]);
      Eigen::Map<Record, Eigen::Aligned16>{records} =
          Eigen::Map<const Record, Eigen::Aligned16>(source);
    }
    if (block.record_count > 0 && vertex[block.record_count - 1] < 0) fill_padding(records);
  }

  /// Lets body(local) add to local records of the block, which are zero before, and stores what they
  /// amount to in the block's records of vertices. Returns what the body returns.
  template <class T, class Body>
  auto sum_local(const Block& block, T* records, const Body& body) const {
    if (!is_quadratic()) {
      std::fill_n(records, kRecordSize * block.record_count, T(0));
      return body(records);
    }
    thread_local AlignedVector<T> local;
    local.assign(local_size(block), T(0));
    if constexpr (std::is_void_v<decltype(body(records))>) {
      body(local.data());
      hand_to_nodes(block, local.data(), records);
    } else {
      const auto result = body(local.data());
      hand_to_nodes(block, local.data(), records);
      return result;
    }
  }

  /// Sets the field at every vertex to the sum of the vertex's records, or adds this sum to the field.
  /// The field has 3 numbers per vertex.
  void sum_records(const AlignedVector<double>& records, Vector& field) const;
  /// The same for these vertices only. The size of the field must be right.
  void sum_records(const AlignedVector<double>& records, const std::vector<Index>& vertices,
                   Vector& field) const;
  void add_record_sums(const AlignedVector<double>& records, Vector& field) const;

  /// Begin and end of the ascending list of the records of a vertex.
  const std::int32_t* records_begin(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex)];
  }
  const std::int32_t* records_end(Index vertex) const {
    return vertex_records_.data() + vertex_record_begin_[static_cast<std::size_t>(vertex) + 1];
  }

 private:
  // Local records of a quadratic block: one record of zeros for each lane, the edges of the elements,
  // and four of padding. One for each lane, because lanes that add to the same record wait for one
  // another.
  static constexpr Index kFirstEdge = kBatchLanes;
  // The length of the edges of padding elements, m. The energy of their round-off is in the sum of all
  // energies, and must be far below that of real elements.
  static constexpr double kPaddingEdge = 0x1p-30;

  bool is_padded(const Block& block) const {
    return block.batch_count * kBatchLanes > points_ * block.element_count;
  }

  std::span<const NodeRecords> elements(const Block& block) const {
    return std::span(node_records_)
        .subspan(static_cast<std::size_t>(block.first_element),
                 static_cast<std::size_t>(block.element_count));
  }

  // Forms the local records of a quadratic block; node(r) is the value of the vertex of its record r.
  template <class T, class Node>
  void form_local_records(const Block& block, T* records, const Node& node) const {
    using Record = Eigen::Matrix<T, kRecordSize, 1>;
    thread_local AlignedVector<T> values;
    values.resize(static_cast<std::size_t>(kRecordSize * block.record_count));
    for (Index r = 0; r < block.record_count; ++r) {
      Eigen::Map<Record, Eigen::Aligned16>{values.data() + kRecordSize* r} = node(r);
    }
    std::fill_n(records, kFirstEdge * kRecordSize, T(0));
    form_edges(elements(block), values.data(), records + kFirstEdge * kRecordSize);
    if (is_padded(block)) fill_padding(records + kRecordSize * block.local_count);
  }

  // The transpose of form_local_records(): sets the records of vertices.
  template <class T>
  void hand_to_nodes(const Block& block, const T* local, T* records) const {
    std::fill_n(records, kRecordSize * block.record_count, T(0));
    add_edge_forces(elements(block), local + kFirstEdge * kRecordSize, records);
  }

  Eigen::Vector4d record_sum(const AlignedVector<double>& records, Index v) const;
  template <bool kAdd>
  void gather(const AlignedVector<double>& records, Vector& field) const;

  // Sets the last four records of the block to the nodes of the padding elements, which are small
  // tetrahedra at rest.
  template <class T>
  static void fill_padding(T* end) {
    for (T* r = end - 4 * kRecordSize; r != end; ++r) *r = T(0);
    for (int k = 0; k < 3; ++k) end[(k - 3) * kRecordSize + k] = T(kPaddingEdge);
  }
  void add_block(const RestState& rest, const std::vector<Index>& order, Index begin, Index end,
                 int material, std::vector<std::int32_t>& record_of_vertex);
  void set_lane(const RestState& rest, Index batch, int lane, Index point,
                const std::array<Index, 4>& records);

  std::vector<Block> blocks_;
  AlignedVector<double> rest_numbers_;
  AlignedVector<std::uint16_t> slots_;
  std::vector<std::int32_t> point_;
  std::vector<std::int32_t> record_vertex_;  // −1 for padding
  int points_ = 1;                           // per element
  // Quadratic elements have, in the order of the lanes, the records of their nodes, counted from the
  // first of the block.
  std::vector<NodeRecords> node_records_;
  std::vector<std::int32_t> vertex_record_begin_;
  std::vector<std::int32_t> vertex_records_;
};

/// Gives the loops of the library access to the blocks of public classes.
struct BlockAccess {
  /// The blocks of the elements of the whole body.
  static const ElementBlocks& blocks(const ElasticPotential& elastic);
  /// The batches of a block with the parameters of their material.
  static BatchView batches(const ElasticPotential& elastic, Index block);
  /// ElasticPotential::value_and_gradient() with the gradient of W + Σ t_e v_e instead: t, Pa, is a
  /// tension for every lane of all batches, and v_e are the present volumes of the elements.
  static EvaluationStatus value_and_gradient(const ElasticPotential& elastic, const Positions& q,
                                             const AlignedVector<double>& tensions, double& energy,
                                             Vector& gradient);
  /// The same for a part of a body. The gradient at shared vertices is the sum over all parts: it is on its way to the
  /// other processes while the blocks without such vertices are computed. Collective, also if it fails in some part.
  static EvaluationStatus value_and_gradient(const ElasticPotential& elastic, const Positions& q,
                                             const MeshPart& part, double& energy,
                                             Vector& gradient);
  /// ElasticPotential::add_hessian() of W + Σ t_e v_e at constant tensions, which may be null.
  static EvaluationStatus add_hessian(const ElasticPotential& elastic, const Positions& q,
                                      const double* tensions, const SparsityPattern& pattern,
                                      double* values);
  /// σ at every quadrature point, Pa (6 × points, in the order XX YY ZZ XY YZ XZ); W must be defined at q. Unless
  /// `energies` is null, it becomes what ElasticPotential::energy_densities() sets, bit for bit.
  static Matrix cauchy_stresses(const ElasticPotential& elastic, const Vector& q,
                                Vector* energies = nullptr);
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
