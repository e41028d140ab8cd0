#include "tetraction/fem/viscous_potential.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "block_stiffness.h"
#include "element_blocks.h"
#include "element_sums.h"
#include "kernels/viscous_kernels.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

Matrix3 strain_of(const Matrix3& f) {
  return 0.5 * (f.transpose() * f - Matrix3::Identity());
}

// The density c |E − E₀|² of one element, with the interface of a material, c = η/s.
// P = 2c F (E − E₀), dP = 2c dF (E − E₀) + c (F Fᵀ dF + F dFᵀ F).
class ViscousDensity {
 public:
  ViscousDensity(double factor, const Matrix3& initial_strain)
      : factor_(factor), initial_strain_(initial_strain) {}
  static bool admissible(const Matrix3&) { return true; }
  double energy_density(const Matrix3& f) const {
    return factor_ * (strain_of(f) - initial_strain_).squaredNorm();
  }
  Matrix3 first_piola(const Matrix3& f) const {
    return 2.0 * factor_ * f * (strain_of(f) - initial_strain_);
  }
  Matrix9 stiffness(const Matrix3& f) const {
    const Matrix3 stress = 2.0 * factor_ * (strain_of(f) - initial_strain_);
    const Matrix3 left = factor_ * f * f.transpose();
    Matrix9 a;
    for (int l = 0; l < 3; ++l) {
      for (int k = 0; k < 3; ++k) {
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) {
            a(3 * j + i, 3 * l + k) = (i == k ? stress(l, j) : 0.0) + (j == l ? left(i, k) : 0.0) +
                                      factor_ * f(i, l) * f(k, j);
          }
        }
      }
    }
    return a;
  }

 private:
  double factor_;
  Matrix3 initial_strain_;  // E₀
};

static_assert(Material<ViscousDensity>);

}  // namespace

struct ViscousPotential::Impl {
  const RestState& rest;
  const ElementBlocks& blocks;
  const Vector* start = nullptr;  // q_k
  double factor = 0.0;
  bool corrected = false;                 // whether E₀ is not E(q_k)
  AlignedVector<double> correction;       // c of the points (viscous_kernels.h)
  std::vector<std::int32_t> lane_index;   // batch × kBatchLanes + lane of each point
  mutable AlignedVector<double> records;  // forces, per record
  mutable std::vector<double> energies;   // per block

  explicit Impl(const ElasticPotential& elastic)
      : rest(elastic.rest()), blocks(BlockAccess::blocks(elastic)) {}

  const double* correction_of(const ElementBlocks::Block& block) const {
    return corrected ? correction.data() + block.first_batch * kViscousNumbers * kBatchLanes
                     : nullptr;
  }

  // Computes lane_index when it is first needed.
  void find_lane_indices() {
    if (!lane_index.empty()) return;
    lane_index.resize(static_cast<std::size_t>(rest.point_count()));
    for (Index b = 0; b < blocks.block_count(); ++b) {
      blocks.for_each_point(blocks.block(b), [&](Index i, Index batch, int lane) {
        lane_index[static_cast<std::size_t>(i)] =
            static_cast<std::int32_t>(batch * kBatchLanes + lane);
      });
    }
    correction.resize(
        static_cast<std::size_t>(blocks.batch_count() * kViscousNumbers * kBatchLanes));
  }

  // The density of a point.
  ViscousDensity density(Index i) const {
    const auto point = rest.point(i);
    const Matrix3 f = deformation_gradient(point, 0, rest.gather_relative(*start, i));
    Matrix3 strain = strain_of(f);
    if (corrected) {
      const std::int32_t at = lane_index[static_cast<std::size_t>(i)];
      const double* c = correction.data() +
                        Index{at / kBatchLanes} * kViscousNumbers * kBatchLanes + at % kBatchLanes;
      constexpr int kEntries[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
      Matrix3 correction_matrix;
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) correction_matrix(j, k) = c[kEntries[j][k] * kBatchLanes];
      }
      const Matrix3 b = point.gradients[0].rightCols<3>();
      strain -= 0.5 * b * correction_matrix * b.transpose();
    }
    return {factor, strain};
  }

  // Calls body(index, block, records of positions, records of displacements) for all blocks.
  template <class Body>
  void for_each_block(const Vector& positions, const Vector& displacements,
                      const Body& body) const {
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        const auto [from, displacement] = load(b, positions, displacements);
        body(b, blocks.block(b), from, displacement);
      }
    });
  }

  // Returns the records of a block. The next call in the same thread overwrites them.
  std::pair<const double*, const double*> load(Index b, const Vector& positions,
                                               const Vector& displacements) const {
    thread_local AlignedVector<double> position_records;
    thread_local AlignedVector<double> displacement_records;
    const ElementBlocks::Block& block = blocks.block(b);
    position_records.resize(ElementBlocks::local_size(block));
    displacement_records.resize(position_records.size());
    blocks.load_records(block, positions.data(), position_records.data());
    blocks.load_displacements(block, displacements.data(), displacement_records.data());
    return {position_records.data(), displacement_records.data()};
  }

  double* records_of(const ElementBlocks::Block& block) const {
    return records.data() + ElementBlocks::kRecordSize * block.first_record;
  }

  double energy(const Vector& displacement, bool with_gradient) const {
    energies.resize(static_cast<std::size_t>(blocks.block_count()));
    if (with_gradient) make_records();
    for_each_block(*start, displacement,
                   [&](Index b, const ElementBlocks::Block& block, const double* positions,
                       const double* displacements) {
                     const auto run = [&](double* gradients) {
                       return viscous_gradient(
                           blocks.batches(block),
                           {factor, positions, displacements, correction_of(block)}, gradients);
                     };
                     energies[static_cast<std::size_t>(b)] =
                         with_gradient ? blocks.sum_local(block, records_of(block), run)
                                       : run(nullptr);
                   });
    double sum = 0.0;
    for (const double of_block : energies) sum += of_block;
    return sum;
  }

  void make_records() const {
    records.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()));
  }

  template <class T>
  void add_tangent(Index b, const Vector& displacement, TangentForm form, T* state) const {
    const ElementBlocks::Block& block = blocks.block(b);
    const auto [positions, displacements] = load(b, *start, displacement);
    add_viscous_tangent(blocks.batches(block),
                        {factor, positions, displacements, correction_of(block)}, form, state);
  }
};

ViscousPotential::ViscousPotential(const ElasticPotential& elastic)
    : impl_(std::make_unique<Impl>(elastic)) {}
ViscousPotential::~ViscousPotential() = default;
ViscousPotential::ViscousPotential(ViscousPotential&&) noexcept = default;

double ViscousPotential::factor() const {
  return impl_->factor;
}

void ViscousPotential::add_force(double viscosity, const Vector& q, const Vector& v,
                                 Vector& force) const {
  const Impl& s = *impl_;
  s.make_records();
  s.for_each_block(q, v,
                   [&](Index, const ElementBlocks::Block& block, const double* positions,
                       const double* velocities) {
                     s.blocks.sum_local(block, s.records_of(block), [&](double* forces) {
                       add_viscous_force(s.blocks.batches(block), viscosity, positions, velocities,
                                         forces);
                     });
                   });
  s.blocks.add_record_sums(s.records, force);
}

void ViscousPotential::begin(const Vector& q, double factor) {
  impl_->start = &q;
  impl_->factor = factor;
  impl_->corrected = false;
}

void ViscousPotential::set_estimate(const Vector& displacement) {
  Impl& s = *impl_;
  if (s.factor == 0.0) return;
  s.find_lane_indices();
  s.corrected = true;
  s.for_each_block(
      *s.start, displacement,
      [&](Index, const ElementBlocks::Block& block, const double*, const double* displacements) {
        viscous_correction(s.blocks.batches(block), displacements,
                           s.correction.data() + block.first_batch * kViscousNumbers * kBatchLanes);
      });
}

void ViscousPotential::add_value(const Vector& displacement, double& value) const {
  if (impl_->factor != 0.0) value += impl_->energy(displacement, false);
}

void ViscousPotential::add_value_and_gradient(const Vector& displacement, double& value,
                                              Vector& gradient) const {
  if (impl_->factor == 0.0) return;
  value += impl_->energy(displacement, true);
  impl_->blocks.add_record_sums(impl_->records, gradient);
}

// Blocks of one colour share no vertex. The colours are processed one after the other.
void ViscousPotential::add_hessian(const Vector& displacement, const SparsityPattern& pattern,
                                   double* values) const {
  const Impl& s = *impl_;
  if (s.factor == 0.0) return;
  constexpr TangentForm kForm = TangentForm::kMetric;
  for (const std::vector<Index>& color : BlockAccess::colors(pattern, s.blocks)) {
    parallel_for(static_cast<Index>(color.size()), 1, [&](Index begin, Index end) {
      thread_local AlignedVector<double> positions;
      thread_local AlignedVector<double> state;
      for (Index i = begin; i < end; ++i) {
        const Index b = color[static_cast<std::size_t>(i)];
        const ElementBlocks::Block& block = s.blocks.block(b);
        positions.resize(ElementBlocks::local_size(block));
        s.blocks.load_positions(block, Positions(*s.start, displacement), positions.data());
        state.resize(static_cast<std::size_t>(block.batch_count * tangent_numbers(kForm)) *
                     kBatchLanes);
        prepare_empty_tangent(s.blocks.batches(block), positions.data(), state.data());
        s.add_tangent(b, displacement, kForm, state.data());
        add_block_stiffness(s.blocks, block, kForm, state.data(), pattern, values);
      }
    });
  }
}

void ViscousPotential::add_element_terms(Index e, const Positions& x, bool with_hessian,
                                         ElasticPotential::ElementTerms& terms) const {
  const Impl& s = *impl_;
  if (s.factor == 0.0) return;
  const int points = s.rest.points_per_element();
  for (int p = 0; p < points; ++p) {
    const Index i = points * e + p;
    add_point(p, s.rest.point(i), s.density(i), s.rest.gather_relative(x, i), with_hessian, terms);
  }
}

void BlockAccess::add_tangent(const ViscousPotential& viscous, Index block,
                              const Vector& displacement, TangentForm form, float* state) {
  viscous.impl_->add_tangent(block, displacement, form, state);
}
void BlockAccess::add_tangent(const ViscousPotential& viscous, Index block,
                              const Vector& displacement, TangentForm form, double* state) {
  viscous.impl_->add_tangent(block, displacement, form, state);
}

}  // namespace tetraction
