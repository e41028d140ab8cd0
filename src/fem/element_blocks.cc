#include "element_blocks.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "hilbert_order.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// A block of this size has about 300 vertices. Their positions and forces take 20 KiB, which fits the
// first-level cache.
constexpr Index kBlockElements = 1024;
// The local records of such a block take 100 KiB, which fits the second-level cache. They are used in
// their order; smaller blocks are slower, because they share more vertices with others.
constexpr Index kQuadraticBlockElements = 256;

}  // namespace

ElementBlocks::ElementBlocks(const RestState& rest, const std::vector<int>& material_of_element,
                             std::size_t materials)
    : points_(rest.points_per_element()) {
  const Index n = rest.element_count();
  if (points_ * n > std::numeric_limits<std::int32_t>::max() / (4 * kRecordSize)) {
    throw InputError(fmt::format("The mesh has more than 2^{} tetrahedra: that is not supported.",
                                 is_quadratic() ? 25 : 27));
  }
  std::vector<Index> order;
  {
    Eigen::Matrix<float, 3, Eigen::Dynamic> centers(3, n);
    for (Index e = 0; e < n; ++e) centers.col(e) = rest.center(e).cast<float>();
    order = hilbert_order(centers);
  }
  const auto material = [&](Index e) {
    return material_of_element.empty() ? 0 : material_of_element[static_cast<std::size_t>(e)];
  };
  if (materials > 1) {
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return material(a) < material(b); });
  }
  std::vector<std::int32_t> record_of_vertex(static_cast<std::size_t>(rest.vertex_count()), -1);
  const Index most = is_quadratic() ? kQuadraticBlockElements : kBlockElements;
  const auto lanes = static_cast<std::size_t>(points_ * n) +
                     (materials + static_cast<std::size_t>(n / most + 1)) * kBatchLanes;
  rest_numbers_.reserve(lanes * kRestNumbers);
  slots_.reserve(lanes * 4);
  point_.reserve(lanes);
  if (is_quadratic()) node_records_.reserve(static_cast<std::size_t>(n));
  for (Index begin = 0; begin < n;) {
    const int m = material(order[static_cast<std::size_t>(begin)]);
    const auto same = std::upper_bound(order.begin() + begin, order.end(), m,
                                       [&](int value, Index e) { return value < material(e); });
    const Index count = same - order.begin() - begin;
    const Index parts = (count + most - 1) / most;
    for (Index p = 0; p < parts; ++p) {
      add_block(rest, order, begin + count * p / parts, begin + count * (p + 1) / parts, m,
                record_of_vertex);
    }
    begin += count;
  }

  vertex_record_begin_.assign(static_cast<std::size_t>(rest.vertex_count()) + 1, 0);
  for (const std::int32_t v : record_vertex_) {
    if (v >= 0) ++vertex_record_begin_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 1; v < vertex_record_begin_.size(); ++v) {
    vertex_record_begin_[v] += vertex_record_begin_[v - 1];
  }
  vertex_records_.resize(static_cast<std::size_t>(vertex_record_begin_.back()));
  std::vector<std::int32_t> next(vertex_record_begin_.begin(), vertex_record_begin_.end() - 1);
  for (std::size_t r = 0; r < record_vertex_.size(); ++r) {
    if (record_vertex_[r] < 0) continue;
    vertex_records_[static_cast<std::size_t>(next[static_cast<std::size_t>(record_vertex_[r])]++)] =
        static_cast<std::int32_t>(r);
  }
}

void ElementBlocks::add_block(const RestState& rest, const std::vector<Index>& order, Index begin,
                              Index end, int material,
                              std::vector<std::int32_t>& record_of_vertex) {
  Block block;
  block.material = material;
  block.first_batch = batch_count();
  block.element_count = end - begin;
  block.batch_count = (points_ * block.element_count + kBatchLanes - 1) / kBatchLanes;
  block.first_record = record_count();
  block.first_element = static_cast<Index>(node_records_.size());
  const Index lanes = block.batch_count * kBatchLanes;
  point_.resize(point_.size() + static_cast<std::size_t>(lanes), -1);
  rest_numbers_.resize(point_.size() * kRestNumbers);
  slots_.resize(point_.size() * 4);
  // Records are in the order of their first use. Neighbouring vertices are then near in memory.
  for (Index i = begin; i < end; ++i) {
    for (const Index v : rest.nodes(order[static_cast<std::size_t>(i)])) {
      auto& record = record_of_vertex[static_cast<std::size_t>(v)];
      if (record >= block.first_record) continue;
      record = static_cast<std::int32_t>(record_vertex_.size());
      record_vertex_.push_back(static_cast<std::int32_t>(v));
    }
  }
  const auto record = [&](Index v) {
    return record_of_vertex[static_cast<std::size_t>(v)] - block.first_record;
  };
  const Index padding = is_padded(block) ? 4 : 0;
  if (is_quadratic()) {
    for (Index i = begin; i < end; ++i) {
      const ElementNodes nodes = rest.nodes(order[static_cast<std::size_t>(i)]);
      auto& own = node_records_.emplace_back();
      for (std::size_t a = 0; a < own.size(); ++a) {
        own[a] = static_cast<std::uint16_t>(record(nodes[a]));
      }
    }
    block.local_count = kFirstEdge + QuadraticPoints::kEdges * block.element_count + padding;
  } else {
    record_vertex_.insert(record_vertex_.end(), static_cast<std::size_t>(padding), -1);
    block.local_count = record_count() - block.first_record;
  }
  block.record_count = record_count() - block.first_record;
  for (Index i = 0; i < lanes; ++i) {
    std::array<Index, 4> records{};
    for (Index a = 0; a < 4; ++a) {
      records[static_cast<std::size_t>(a)] = block.local_count - 4 + a;
    }
    if (is_quadratic()) {
      const Index m = i / points_;
      if (m < block.element_count) {
        const Index edge = kFirstEdge + 3 * i;
        records = {i % kBatchLanes, edge, edge + 1, edge + 2};
      }
      const Index point = m < block.element_count
                              ? points_ * order[static_cast<std::size_t>(begin + m)] + i % points_
                              : -1;
      set_lane(rest, block.first_batch + i / kBatchLanes, static_cast<int>(i % kBatchLanes), point,
               records);
      continue;
    }
    const Index e = i < block.element_count ? order[static_cast<std::size_t>(begin + i)] : -1;
    if (e >= 0) {
      const ElementNodes nodes = rest.nodes(e);
      for (std::size_t a = 0; a < 4; ++a) records[a] = record(nodes[a]);
    }
    set_lane(rest, block.first_batch + i % block.batch_count,
             static_cast<int>(i / block.batch_count), e, records);
  }
  blocks_.push_back(block);
}

void ElementBlocks::set_lane(const RestState& rest, Index batch, int lane, Index point,
                             const std::array<Index, 4>& records) {
  const auto index = static_cast<std::size_t>(batch * kBatchLanes + lane);
  point_[index] = static_cast<std::int32_t>(point);
  for (std::size_t a = 0; a < 4; ++a) {
    slots_[(4 * static_cast<std::size_t>(batch) + a) * kBatchLanes +
           static_cast<std::size_t>(lane)] = static_cast<std::uint16_t>(kRecordSize * records[a]);
  }
  Matrix3 vg = kPaddingEdge / 6.0 * Matrix3::Identity();
  double six_volume = kPaddingEdge * kPaddingEdge * kPaddingEdge;
  if (point >= 0) {
    const auto& data = rest.point(point);
    const auto inverse_transpose = data.gradients[0].rightCols<3>();  // D_m⁻ᵀ
    vg = data.weights[0] * inverse_transpose.transpose() * inverse_transpose;
    six_volume = 6.0 * data.weights[0];
  }
  double* numbers = rest_numbers_.data() +
                    static_cast<std::size_t>(batch) * kRestNumbers * kBatchLanes +
                    static_cast<std::size_t>(lane);
  constexpr int kEntries[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
  for (const auto& [i, j] : kEntries) {
    *numbers = vg(i, j);
    numbers += kBatchLanes;
  }
  *numbers = 1.0 / six_volume;
}

// The sum of the records of a vertex, in the order of the blocks.
Eigen::Vector4d ElementBlocks::record_sum(const AlignedVector<double>& records, Index v) const {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const std::int32_t* r = records_begin(v); r != records_end(v); ++r) {
    sum += Eigen::Map<const Eigen::Vector4d>(records.data() + kRecordSize * *r);
  }
  return sum;
}

template <bool kAdd>
void ElementBlocks::gather(const AlignedVector<double>& records, Vector& field) const {
  // The records of a vertex lie in different blocks, far apart. The processor gets those of a few vertices at a time.
  constexpr Index kAhead = 32;
  const std::int32_t* const last = vertex_records_.data() + vertex_records_.size() - 1;
  parallel_for(field.size() / 3, 2048, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      for (const std::int32_t* r = records_begin(v); r != records_end(v); ++r) {
        const std::int32_t ahead = last - r > kAhead ? r[kAhead] : *r;
        __builtin_prefetch(records.data() + kRecordSize * static_cast<Index>(ahead));
      }
      const Eigen::Vector4d sum = record_sum(records, v);
      if constexpr (kAdd) {
        field.segment<3>(3 * v) += sum.head<3>();
      } else {
        field.segment<3>(3 * v) = sum.head<3>();
      }
    }
  });
}

void ElementBlocks::sum_records(const AlignedVector<double>& records, Vector& field) const {
  field.resize(3 * static_cast<Index>(vertex_record_begin_.size() - 1));
  gather<false>(records, field);
}

void ElementBlocks::sum_records(const AlignedVector<double>& records,
                                const std::vector<Index>& vertices, Vector& field) const {
  for (const Index v : vertices) field.segment<3>(3 * v) = record_sum(records, v).head<3>();
}

void ElementBlocks::add_record_sums(const AlignedVector<double>& records, Vector& field) const {
  gather<true>(records, field);
}

void ElementBlocks::load_positions(const Block& block, const Positions& x, double* records) const {
  load_records(block, x.origin().data(), records);
  if (x.displacement() == nullptr) return;
  thread_local AlignedVector<double> displacements;
  displacements.resize(local_size(block));
  load_displacements(block, x.displacement()->data(), displacements.data());
  for (std::size_t i = 0; i < displacements.size(); ++i) records[i] += displacements[i];
}

}  // namespace tetraction
