// Stresses of the elements from the kernels of the gradient. With the gradients g_k = ∂W/∂e_k at the ends of the edges
// e_k of an element of the present volume v, the virial gives
//
//     σ = Σ_k g_k e_kᵀ / v,
//
// because ∂W/∂e = V P D_m⁻ᵀ, P Fᵀ = J σ and e = F D_m. Every lane has nodes of its own here, so that the gradients of
// different elements are not added up.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <optional>

#include "elastic_potential_impl.h"
#include "isotropic_model.h"
#include "kernels/element_kernels.h"

namespace tetraction {
namespace {

// The numbers of the four records of a lane. Node 0 stands at the origin.
constexpr std::size_t kNodeNumbers = ElementBlocks::kRecordSize;
constexpr std::size_t kLaneNumbers = 4 * kNodeNumbers;
constexpr std::size_t kBatchNumbers = kLaneNumbers * kBatchLanes;
// A block has fewer batches; the slots of so many fit into their type.
constexpr std::size_t kMostBatches = 128;

using Slots = std::array<std::uint16_t, 4 * kBatchLanes * kMostBatches>;

Slots own_slots() {
  Slots slots{};
  std::size_t next = 0;
  for (std::size_t batch = 0; batch < kMostBatches; ++batch) {
    for (std::size_t node = 0; node < 4; ++node) {
      for (std::size_t lane = 0; lane < kBatchLanes; ++lane) {
        slots[next++] = static_cast<std::uint16_t>(batch * kBatchNumbers + lane * kLaneNumbers +
                                                   node * kNodeNumbers);
      }
    }
  }
  return slots;
}

using Record = Eigen::Map<const Eigen::Matrix<double, kNodeNumbers, 1>, Eigen::Aligned32>;
using Edges = Eigen::Map<Eigen::Matrix<double, kNodeNumbers, 3>, Eigen::Aligned32>;

void put_symmetric(const Matrix3& s, double* to) {
  const std::array<double, 6> six{s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)};
  std::ranges::copy(six, to);
}

}  // namespace

Matrix BlockAccess::cauchy_stresses(const ElasticPotential& elastic, const Vector& q) {
  using Shape = ElasticPotential::Shape;
  static const Slots kSlots = own_slots();
  const ElasticPotential::Impl& s = *elastic.impl_;
  Matrix stresses(6, s.rest.point_count());
  parallel_for(s.blocks.block_count(), 1, [&](Index first, Index last) {
    thread_local AlignedVector<double> records;
    thread_local AlignedVector<double> positions;
    thread_local AlignedVector<double> gradients;
    for (Index b = first; b < last; ++b) {
      const ElementBlocks::Block& block = s.blocks.block(b);
      const std::optional<IsotropicModel> model = isotropic_model(s.field(block).model());
      const auto batches = static_cast<std::size_t>(block.batch_count);
      if (!model || loses_digits(block, *model) || batches > kMostBatches) {
        s.for_each_at(block, q, MaterialOrder::kStress,
                      [&](Index i, const Shape::NodeMatrix& local, const auto& m, Index, int) {
                        const Matrix3 f = deformation_gradient(s.rest.point(i), 0, local);
                        const Matrix3 stress = m.first_piola(f) * f.transpose() / f.determinant();
                        put_symmetric(stress, stresses.col(i).data());
                      });
        continue;
      }
      // Only the edges are written: the other numbers stay 0.
      positions.resize(std::max(positions.size(), batches * kBatchNumbers));
      gradients.assign(batches * kBatchNumbers, 0.0);
      const auto numbers_of = [&](Index batch, int lane) {
        return static_cast<std::size_t>(batch - block.first_batch) * kBatchNumbers +
               static_cast<std::size_t>(lane) * kLaneNumbers + kNodeNumbers;
      };
      records.resize(ElementBlocks::local_size(block));
      s.blocks.load_records(block, q.data(), records.data());
      s.blocks.for_each_point(block, [&](Index, Index batch, int lane) {
        const auto node = [&](int a) {
          return Record(records.data() + s.blocks.slot(batch, a, lane));
        };
        Edges edges(positions.data() + numbers_of(batch, lane));
        for (int k = 0; k < 3; ++k) edges.col(k) = node(k + 1) - node(0);
      });
      BatchView view = s.batches(b);
      view.slots = kSlots.data();
      elastic_gradient(view, *model, positions.data(), nullptr, gradients.data());
      s.blocks.for_each_point(block, [&](Index i, Index batch, int lane) {
        const std::size_t numbers = numbers_of(batch, lane);
        const auto e = Edges(positions.data() + numbers).topRows<3>();
        const auto g = Edges(gradients.data() + numbers).topRows<3>();
        const double volume = Matrix3(e).determinant() / 6.0;
        put_symmetric(g * e.transpose() / volume, stresses.col(i).data());
      });
    }
  });
  return stresses;
}

}  // namespace tetraction
