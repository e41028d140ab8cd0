#include "inverted_elements.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <variant>

#include "element_blocks.h"
#include "kernels/jacobian_kernels.h"
#include "tetraction/core/parallel.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {
namespace {

constexpr double kAlways = -std::numeric_limits<double>::infinity();
constexpr double kNever = std::numeric_limits<double>::infinity();

// The energy density below which no stretch is below 0.7. It is a quarter of the least density with
// a vanishing stretch, E = diag(−½, s, s), because Ψ is quadratic in E.
double least_density(const StVenantKirchhoff& material) {
  const double mu = material.mu();
  const double lambda = material.lambda();
  const double s = lambda / (4.0 * (mu + lambda));
  const double trace = 2.0 * s - 0.5;
  return 0.25 * (mu * (0.25 + 2.0 * s * s) + 0.5 * lambda * trace * trace);
}
// The other materials are defined for J > 0 only.
template <class M>
requires(!M::kDefinedForAnyJacobian) double least_density(const M&) {
  return kNever;
}
double least_density(const CustomMaterial&) {
  return kAlways;
}

}  // namespace

InversionCounter::InversionCounter(const ElasticPotential& elastic) : elastic_(elastic) {
  const ElementBlocks& blocks = BlockAccess::blocks(elastic);
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks.block(b);
    double volume = kNever;
    blocks.for_each_element(
        block, [&](Index e, Index, int) { volume = std::min(volume, elastic.rest().volume(e)); });
    const double density =
        std::visit([](const auto& material) { return least_density(material); },
                   elastic.materials()[static_cast<std::size_t>(block.material)]);
    least_energy_.push_back(volume * density);
  }
}

Index InversionCounter::count(const Vector& q) {
  return count(q, false);
}

Index InversionCounter::count_after_step(const Vector& q, double energy) {
  // If the energy was evaluated elsewhere since then, the sum differs.
  double sum = 0.0;
  const Index count_of_blocks = BlockAccess::blocks(elastic_).block_count();
  for (Index b = 0; b < count_of_blocks; ++b) sum += BlockAccess::energy(elastic_, b);
  return count(q, sum == energy);
}

Index InversionCounter::count(const Vector& q, bool is_small_step) {
  constexpr int kPause = 3;
  const ElementBlocks& blocks = BlockAccess::blocks(elastic_);
  pause_.resize(least_energy_.size(), 0);
  std::atomic<Index> count{0};
  parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
    thread_local AlignedVector<double> positions;
    Index own = 0;
    for (Index b = begin; b < end; ++b) {
      const auto i = static_cast<std::size_t>(b);
      if (is_small_step && BlockAccess::energy(elastic_, b) < least_energy_[i]) continue;
      if (is_small_step && pause_[i] > 0) {
        --pause_[i];
        continue;
      }
      const ElementBlocks::Block& block = blocks.block(b);
      positions.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * block.record_count));
      blocks.load_records(block, q.data(), positions.data());
      const JacobianSigns signs = jacobian_signs(blocks.batches(block), positions.data());
      own += signs.negative;
      pause_[i] = signs.all_above_half ? kPause : 0;
    }
    count += own;
  });
  return count;
}

Index InversionCounter::first(const Vector& q) const {
  const RestState& rest = elastic_.rest();
  for (Index e = 0; e < rest.element_count(); ++e) {
    const RestState::Shape::NodeMatrix nodes = rest.gather(q, e);
    const Matrix3 edges = nodes.rightCols<3>().colwise() - nodes.col(0);
    if (jacobian(edges) < 0.0) return e;
  }
  return -1;
}

}  // namespace tetraction
