#include "inverted_elements.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <variant>

#include "element_blocks.h"
#include "kernels/jacobian_kernels.h"
#include "mesh/quadratic_shapes.h"
#include "tetraction/core/parallel.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {
namespace {

constexpr double kAlwaysExamine = -std::numeric_limits<double>::infinity();
constexpr double kNeverExamine = std::numeric_limits<double>::infinity();

// An energy density below which no principal stretch can be less than 0.7. A stretch of 0 has at
// least the energy density of E = diag(−½, s, s) with the best s. A stretch of √½ has half of this
// strain and therefore at least a quarter of the density, because Ψ is quadratic in E.
double density_threshold(const StVenantKirchhoff& material) {
  const double mu = material.mu();
  const double lambda = material.lambda();
  const double s = lambda / (4.0 * (mu + lambda));
  const double trace = 2.0 * s - 0.5;
  return 0.25 * (mu * (0.25 + 2.0 * s * s) + 0.5 * lambda * trace * trace);
}
// The other built-in materials are defined for J > 0 only, so that no element can be inverted.
template <class M>
requires(!M::kDefinedForAnyJacobian) double density_threshold(const M&) {
  return kNeverExamine;
}
double density_threshold(const CustomMaterial&) {
  return kAlwaysExamine;
}

// Whether J is negative at a point of element e.
bool is_inverted(const RestState& rest, const Vector& q, Index e) {
  const int points = rest.points_per_element();
  for (int p = 0; p < points; ++p) {
    const RestState::Shape::NodeMatrix nodes = rest.gather(q, points * e + p);
    const Matrix3 edges = nodes.rightCols<3>().colwise() - nodes.col(0);
    if (jacobian(edges) < 0.0) return true;
  }
  return false;
}

}  // namespace

InvertedAtNodes inverted_at_nodes(const RestState& rest, const Vector& q) {
  InvertedAtNodes result;
  if (!rest.is_quadratic()) return result;
  std::array<VolumeCoordinates, QuadraticPoints::kNodes> places{};
  for (int i = 0; i < 4; ++i) {
    places[static_cast<std::size_t>(i)][static_cast<std::size_t>(i)] = 1.0;
    for (int j = 0; j < i; ++j) {
      VolumeCoordinates& l = places[static_cast<std::size_t>(QuadraticPoints::middle(i, j))];
      l[static_cast<std::size_t>(i)] = l[static_cast<std::size_t>(j)] = 0.5;
    }
  }
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    const auto vertex = [&](int a) { return nodes[static_cast<std::size_t>(a)]; };
    const auto at_rest = [&](int a) -> Vector3 {
      return rest.position(vertex(a)) - rest.position(vertex(0));
    };
    const auto now = [&](int a) -> Vector3 {
      return vertex_block(q, vertex(a)) - vertex_block(q, vertex(0));
    };
    const bool is_inverted =
        std::any_of(places.begin(), places.end(), [&](const VolumeCoordinates& l) {
          return quadratic_edges(l, now).determinant() < 0.0 &&
                 quadratic_edges(l, at_rest).determinant() > 0.0;
        });
    if (!is_inverted) continue;
    if (result.first < 0) result.first = e;
    ++result.count;
  }
  return result;
}

InversionCounter::InversionCounter(const ElasticPotential& elastic) : elastic_(elastic) {
  const ElementBlocks& blocks = BlockAccess::blocks(elastic);
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks.block(b);
    const MaterialField& field = elastic.materials()[static_cast<std::size_t>(block.material)];
    double least_energy = kNeverExamine;
    std::visit(
        [&](const auto& material) {
          const RestState& rest = elastic.rest();
          blocks.for_each_point(block, [&](Index i, Index, int) {
            const double density = field.with_element(
                material, rest.element_of(i), [](const auto& m) { return density_threshold(m); });
            least_energy = std::min(least_energy, rest.point_volume(i) * density);
          });
        },
        field.model());
    energy_threshold_.push_back(least_energy);
  }
  // If all vertices move by at most d relative to the first one, an edge changes by at most c d, and
  // |ΔF| <= |ΔD_s| |D_m⁻¹| <= √3 c d |D_m⁻¹| in Frobenius norms. c is 2 for the edges of a linear element.
  // At a point of a quadratic one c is the sum of the derivatives of its shape functions, which is below 8.
  constexpr double kLargestChange = 0.1;
  const RestState& rest = elastic.rest();
  Vector q(3 * rest.vertex_count());
  for (Index v = 0; v < rest.vertex_count(); ++v) vertex_block(q, v) = rest.position(v);
  double largest_inverse = 0.0;
  for (Index i = 0; i < rest.points_per_element() * rest.element_count(); ++i) {
    const RestState::Shape::NodeMatrix nodes = rest.gather(q, i);
    const Matrix3 edges = nodes.rightCols<3>().colwise() - nodes.col(0);
    largest_inverse = std::max(largest_inverse, edges.inverse().norm());
  }
  const double edge_factor = rest.is_quadratic() ? 8.0 : 2.0;
  small_motion_ = kLargestChange / (std::sqrt(3.0) * edge_factor * largest_inverse);
}

bool InversionCounter::is_small(const Vector& before, const Vector& q) const {
  const Vector3 first = vertex_block(q, 0) - vertex_block(before, 0);
  const double limit = small_motion_ * small_motion_;
  for (Index v = 0; v < q.size() / 3; ++v) {
    const Vector3 motion = vertex_block(q, v) - vertex_block(before, v) - first;
    if (!(motion.squaredNorm() <= limit)) return false;
  }
  return true;
}

Index InversionCounter::count(const Vector& q) {
  return count(q, false);
}

Index InversionCounter::count_after_step(const Vector& before, const Vector& q, double energy) {
  // If the energy was evaluated at other positions in the meantime, the sum differs, and the block
  // energies cannot be used.
  double sum = 0.0;
  const Index count_of_blocks = BlockAccess::blocks(elastic_).block_count();
  for (Index b = 0; b < count_of_blocks; ++b) sum += BlockAccess::energy(elastic_, b);
  return count(q, sum == energy && is_small(before, q));
}

Index InversionCounter::count(const Vector& q, bool is_small_step) {
  constexpr int kStepsToSkip = 3;
  const ElementBlocks& blocks = BlockAccess::blocks(elastic_);
  steps_to_skip_.resize(energy_threshold_.size(), 0);
  std::atomic<Index> count{0};
  parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
    thread_local AlignedVector<double> positions;
    Index count_of_range = 0;
    for (Index b = begin; b < end; ++b) {
      const auto i = static_cast<std::size_t>(b);
      if (is_small_step && BlockAccess::energy(elastic_, b) < energy_threshold_[i]) continue;
      if (is_small_step && steps_to_skip_[i] > 0) {
        --steps_to_skip_[i];
        continue;
      }
      const ElementBlocks::Block& block = blocks.block(b);
      positions.resize(ElementBlocks::local_size(block));
      blocks.load_records(block, q.data(), positions.data());
      const JacobianSigns signs = jacobian_signs(blocks.batches(block), positions.data());
      if (blocks.is_quadratic() && signs.negative > 0) {
        blocks.for_each_element(block, [&](Index e, Index, int) {
          count_of_range += is_inverted(elastic_.rest(), q, e) ? 1 : 0;
        });
      } else {
        count_of_range += signs.negative;
      }
      steps_to_skip_[i] = signs.all_above_half ? kStepsToSkip : 0;
    }
    count += count_of_range;
  });
  return count;
}

Index InversionCounter::first(const Vector& q) const {
  const RestState& rest = elastic_.rest();
  for (Index e = 0; e < rest.element_count(); ++e) {
    if (is_inverted(rest, q, e)) return e;
  }
  return -1;
}

}  // namespace tetraction
