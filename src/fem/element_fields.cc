// Fields of all elements from the kernels, block by block.
#include "element_fields.h"

#include <Eigen/LU>
#include <optional>

#include "core/symmetric_tensor.h"
#include "elastic_potential_impl.h"
#include "isotropic_model.h"
#include "kernels/element_values.h"

namespace tetraction {
namespace {

using Block = ElementBlocks::Block;
// What a kernel sets for a point: a number and the six components of a symmetric tensor.
using PointValues = Eigen::Map<const Eigen::Matrix<double, kValueNumbers, 1>, Eigen::Unaligned,
                               Eigen::InnerStride<kBatchLanes>>;

// Lets kernel(values) set the values of a block, and calls take(point, PointValues) for its points.
template <class Kernel, class Take>
void take_values(const ElementBlocks& blocks, const Block& block, const Kernel& kernel,
                 const Take& take) {
  thread_local AlignedVector<double> values;
  values.resize(static_cast<std::size_t>(block.batch_count * kValueNumbers * kBatchLanes));
  kernel(values.data());
  blocks.for_each_point(block, [&](Index i, Index batch, int lane) {
    take(i, PointValues(values.data() + (batch - block.first_batch) * kValueNumbers * kBatchLanes +
                        lane));
  });
}

template <class Body>
void for_each_block(const ElementBlocks& blocks, const Body& body) {
  parallel_for(blocks.block_count(), 1, [&](Index first, Index last) {
    for (Index b = first; b < last; ++b) body(b, blocks.block(b));
  });
}

// Calls take(point, PointValues with Ψ and σ) for all points of the blocks that the kernels can compute, and
// single(point, F, material) for those of the others.
template <class Impl, class Take, class Single>
void for_each_value(const Impl& s, const Vector& q, MaterialOrder order, const Take& take,
                    const Single& single) {
  for_each_block(s.blocks, [&](Index b, const Block& block) {
    const std::optional<IsotropicModel> model = isotropic_model(s.field(block).model());
    if (!model || loses_digits(block, *model)) {
      s.for_each_at(block, q, order,
                    [&](Index i, const RestState::Shape::NodeMatrix&, const auto& m, Index, int) {
                      single(i, deformation_gradient(s.rest, q, i), m);
                    });
      return;
    }
    thread_local AlignedVector<double> positions;
    positions.resize(ElementBlocks::local_size(block));
    s.blocks.load_records(block, q.data(), positions.data());
    const auto kernel = [&](double* values) {
      element_values(s.batches(b), *model, positions.data(), values);
    };
    take_values(s.blocks, block, kernel, take);
  });
}

// Calls take(point, PointValues with J and E) for all points.
template <class Take>
void for_each_deformation(const ElasticPotential& elastic, const Vector& q, const Take& take) {
  const RestState& rest = elastic.rest();
  const ElementBlocks& blocks = BlockAccess::blocks(elastic);
  Vector at_rest(q.size());
  for (Index v = 0; v < rest.vertex_count(); ++v) vertex_block(at_rest, v) = rest.position(v);
  for_each_block(blocks, [&](Index, const Block& block) {
    thread_local AlignedVector<double> start;
    thread_local AlignedVector<double> end;
    start.resize(ElementBlocks::local_size(block));
    end.resize(start.size());
    blocks.load_records(block, at_rest.data(), start.data());
    blocks.load_records(block, q.data(), end.data());
    const auto kernel = [&](double* values) {
      element_deformations(blocks.batches(block), start.data(), end.data(), values);
    };
    take_values(blocks, block, kernel, take);
  });
}

}  // namespace

Matrix3 deformation_gradient(const RestState& rest, const Positions& x, Index i) {
  return rest.gather_relative(x, i).rightCols<3>() * rest.point_edges(i).inverse();
}

Matrix BlockAccess::cauchy_stresses(const ElasticPotential& elastic, const Vector& q,
                                    Vector* energies) {
  Matrix stresses(6, elastic.rest().point_count());
  if (energies != nullptr) energies->setZero(stresses.cols());
  for_each_value(
      *elastic.impl_, q, MaterialOrder::kStress,
      [&](Index i, const PointValues& values) {
        stresses.col(i) = values.tail<6>();
        if (energies != nullptr) (*energies)[i] = values[0];
      },
      [&](Index i, const Matrix3& f, const auto& m) {
        stresses.col(i) = symmetric_components(m.first_piola(f) * f.transpose() / f.determinant());
        if (energies != nullptr && m.admissible(f)) (*energies)[i] = m.energy_density(f);
      });
  return stresses;
}

void ElasticPotential::energy_densities(const Vector& q, Vector& densities) const {
  densities.setZero(rest().point_count());
  for_each_value(
      *impl_, q, MaterialOrder::kEnergy,
      [&](Index i, const PointValues& values) { densities[i] = values[0]; },
      [&](Index i, const Matrix3& f, const auto& m) {
        if (m.admissible(f)) densities[i] = m.energy_density(f);
      });
}

Matrix green_strains(const ElasticPotential& elastic, const Vector& q, Vector* ratios) {
  Matrix strains(6, elastic.rest().point_count());
  if (ratios != nullptr) ratios->resize(strains.cols());
  for_each_deformation(elastic, q, [&](Index i, const PointValues& values) {
    strains.col(i) = values.tail<6>();
    if (ratios != nullptr) (*ratios)[i] = values[0];
  });
  return strains;
}

Vector volume_ratios(const ElasticPotential& elastic, const Vector& q) {
  Vector ratios(elastic.rest().point_count());
  for_each_deformation(elastic, q,
                       [&](Index i, const PointValues& values) { ratios[i] = values[0]; });
  return ratios;
}

}  // namespace tetraction
