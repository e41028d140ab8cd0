#include "element_blocks.h"

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

}  // namespace

ElementBlocks::ElementBlocks(const RestState& rest, const std::vector<int>& material_of_element,
                             std::size_t materials) {
  const Index n = rest.element_count();
  if (n > std::numeric_limits<std::int32_t>::max() / (4 * kRecordSize)) {
    throw InputError("The mesh has more than 2^27 tetrahedra: that is not supported.");
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
  const auto lanes = static_cast<std::size_t>(n + kBatchLanes * materials) +
                     static_cast<std::size_t>(n / kBlockElements + 1) * kBatchLanes;
  rest_numbers_.reserve(lanes * kRestNumbers);
  slots_.reserve(lanes * 4);
  element_.reserve(lanes);
  for (Index begin = 0; begin < n;) {
    const int m = material(order[static_cast<std::size_t>(begin)]);
    const auto same = std::upper_bound(order.begin() + begin, order.end(), m,
                                       [&](int value, Index e) { return value < material(e); });
    const Index count = same - order.begin() - begin;
    const Index parts = (count + kBlockElements - 1) / kBlockElements;
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
  block.first_batch = static_cast<Index>(element_.size()) / kBatchLanes;
  block.batch_count = (end - begin + kBatchLanes - 1) / kBatchLanes;
  block.first_record = record_count();
  const auto lanes = static_cast<std::size_t>(block.batch_count) * kBatchLanes;
  element_.resize(element_.size() + lanes, -1);
  rest_numbers_.resize(element_.size() * kRestNumbers);
  slots_.resize(element_.size() * 4);
  // Records are in the order of their first use. Neighbouring vertices are then near in memory.
  for (Index i = begin; i < end; ++i) {
    for (const Index v : rest.nodes(order[static_cast<std::size_t>(i)])) {
      auto& record = record_of_vertex[static_cast<std::size_t>(v)];
      if (record >= block.first_record) continue;
      record = static_cast<std::int32_t>(record_vertex_.size());
      record_vertex_.push_back(static_cast<std::int32_t>(v));
    }
  }
  const bool padded = end - begin < static_cast<Index>(lanes);
  if (padded) record_vertex_.insert(record_vertex_.end(), 4, -1);
  block.record_count = record_count() - block.first_record;
  for (Index i = 0; i < static_cast<Index>(lanes); ++i) {
    const int lane = static_cast<int>(i / block.batch_count);
    const Index batch = block.first_batch + i % block.batch_count;
    std::array<std::int32_t, 4> records{};
    const Index e = begin + i < end ? order[static_cast<std::size_t>(begin + i)] : -1;
    for (std::size_t a = 0; a < 4; ++a) {
      const std::int32_t record =
          e < 0 ? static_cast<std::int32_t>(record_vertex_.size() - 4 + a)
                : record_of_vertex[static_cast<std::size_t>(rest.nodes(e)[a])];
      records[a] = static_cast<std::int32_t>(record - block.first_record);
    }
    set_lane(rest, batch, lane, e, records);
  }
  blocks_.push_back(block);
}

void ElementBlocks::set_lane(const RestState& rest, Index batch, int lane, Index element,
                             const std::array<std::int32_t, 4>& records) {
  const auto index = static_cast<std::size_t>(batch * kBatchLanes + lane);
  element_[index] = static_cast<std::int32_t>(element);
  for (std::size_t a = 0; a < 4; ++a) {
    slots_[(4 * static_cast<std::size_t>(batch) + a) * kBatchLanes +
           static_cast<std::size_t>(lane)] = static_cast<std::uint16_t>(kRecordSize * records[a]);
  }
  Matrix3 vg = Matrix3::Identity() / 6.0;
  double six_volume = 1.0;
  if (element >= 0) {
    const auto& data = rest.element(element);
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

template <bool kAdd>
void ElementBlocks::gather(const AlignedVector<double>& records, Vector& field) const {
  parallel_for(field.size() / 3, 2048, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (const std::int32_t* r = records_begin(v); r != records_end(v); ++r) {
        sum += Eigen::Map<const Eigen::Vector4d>(records.data() + kRecordSize * *r);
      }
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

void ElementBlocks::add_record_sums(const AlignedVector<double>& records, Vector& field) const {
  gather<true>(records, field);
}

void ElementBlocks::load_positions(const Block& block, const Positions& x, double* records) const {
  load_records(block, x.origin().data(), records);
  if (x.displacement() == nullptr) return;
  thread_local AlignedVector<double> displacements;
  displacements.resize(static_cast<std::size_t>(kRecordSize * block.record_count));
  load_displacements(block, x.displacement()->data(), displacements.data());
  for (std::size_t i = 0; i < displacements.size(); ++i) records[i] += displacements[i];
}

}  // namespace tetraction
