#include "tetraction/fem/viscous_potential.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "block_stiffness.h"
#include "element_blocks.h"
#include "tetraction/core/parallel.h"
#include "viscous_kernels.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

Matrix3 green_strain(const Matrix3& f) {
  return 0.5 * (f.transpose() * f - Matrix3::Identity());
}

// Ψ = c |E − E_k|² with the interface of a material: for one element at a time.
// P = 2c F (E − E_k); dP = 2c dF (E − E_k) + c (F Fᵀ dF + F dFᵀ F).
class ViscousDensity {
 public:
  ViscousDensity(double factor, const Matrix3& start) : factor_(factor), start_(start) {}
  static bool admissible(const Matrix3&) { return true; }
  double energy_density(const Matrix3& f) const {
    return factor_ * (green_strain(f) - start_).squaredNorm();
  }
  Matrix3 first_piola(const Matrix3& f) const {
    return 2.0 * factor_ * f * (green_strain(f) - start_);
  }
  Matrix9 stiffness(const Matrix3& f) const {
    const Matrix3 stress = 2.0 * factor_ * (green_strain(f) - start_);
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
  Matrix3 start_;
};

static_assert(Material<ViscousDensity>);

}  // namespace

struct ViscousPotential::Impl {
  const RestState& rest;
  const ElementBlocks& blocks;
  double factor = 0.0;
  AlignedVector<double> start;           // c₀ of the lanes (viscous_kernels.h)
  std::vector<std::int32_t> place;       // batch × kBatchLanes + lane of each element
  mutable AlignedVector<double> rows;    // forces, per row
  mutable std::vector<double> energies;  // per block

  explicit Impl(const ElasticPotential& elastic) : rest(elastic.rest()), blocks(elastic.blocks()) {}

  const double* start_of(const ElementBlocks::Block& block) const {
    return start.data() + block.first_batch * kViscousNumbers * kBatchLanes;
  }

  // Places of the elements in the lanes, once.
  void find_places() {
    if (!place.empty()) return;
    place.resize(static_cast<std::size_t>(rest.element_count()));
    for (Index b = 0; b < blocks.block_count(); ++b) {
      blocks.for_each_element(blocks.block(b), [&](Index e, Index batch, int lane) {
        place[static_cast<std::size_t>(e)] = static_cast<std::int32_t>(batch * kBatchLanes + lane);
      });
    }
    start.resize(static_cast<std::size_t>(blocks.batch_count() * kViscousNumbers * kBatchLanes));
  }

  // c |E − E₀|² of element e, E₀ = ½ (D⁻ᵀ c₀ D⁻¹ − 1).
  ViscousDensity density(Index e) const {
    const std::int32_t at = place[static_cast<std::size_t>(e)];
    const double* c =
        start.data() + Index{at / kBatchLanes} * kViscousNumbers * kBatchLanes + at % kBatchLanes;
    constexpr int kEntries[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Matrix3 c0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) c0(i, j) = c[kEntries[i][j] * kBatchLanes];
    }
    const Matrix3 b = rest.element(e).gradients[0].rightCols<3>();
    return {factor, 0.5 * (b * c0 * b.transpose() - Matrix3::Identity())};
  }

  // Calls body(number, block, its rows of x) for all blocks.
  template <class Body>
  void for_each_block(const Vector& x, const Body& body) const {
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      thread_local AlignedVector<double> positions;
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        positions.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * block.row_count));
        blocks.load_rows(block, x.data(), positions.data());
        body(b, block, positions.data());
      }
    });
  }

  double* cleared_rows(const ElementBlocks::Block& block) const {
    double* own = rows.data() + ElementBlocks::kRowSize * block.first_row;
    std::fill_n(own, ElementBlocks::kRowSize * block.row_count, 0.0);
    return own;
  }

  double energy(const Vector& x, bool with_gradient) const {
    energies.resize(static_cast<std::size_t>(blocks.block_count()));
    if (with_gradient) make_rows();
    for_each_block(x, [&](Index b, const ElementBlocks::Block& block, const double* positions) {
      energies[static_cast<std::size_t>(b)] =
          viscous_gradient(blocks.batches(block), factor, start_of(block), positions,
                           with_gradient ? cleared_rows(block) : nullptr);
    });
    double sum = 0.0;
    for (const double of_block : energies) sum += of_block;
    return sum;
  }

  void make_rows() const {
    rows.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * blocks.row_count()));
  }

  template <class T>
  void add_tangent(Index b, const double* positions, TangentForm form, T* state) const {
    const ElementBlocks::Block& block = blocks.block(b);
    add_viscous_tangent(blocks.batches(block), factor, start_of(block), positions, form, state);
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
  s.make_rows();
  s.for_each_block(q, [&](Index, const ElementBlocks::Block& block, const double* positions) {
    thread_local AlignedVector<double> velocities;
    velocities.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * block.row_count));
    s.blocks.load_changes(block, v.data(), velocities.data());
    add_viscous_force(s.blocks.batches(block), viscosity, positions, velocities.data(),
                      s.cleared_rows(block));
  });
  s.blocks.add_row_sums(s.rows, force);
}

void ViscousPotential::begin(const Vector& q, const Vector& displacement, double factor) {
  Impl& s = *impl_;
  s.factor = factor;
  if (factor == 0.0) return;
  s.find_places();
  s.for_each_block(q, [&](Index, const ElementBlocks::Block& block, const double* positions) {
    thread_local AlignedVector<double> changes;
    const double* displacements = nullptr;
    if (displacement.size() > 0) {
      changes.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * block.row_count));
      s.blocks.load_changes(block, displacement.data(), changes.data());
      displacements = changes.data();
    }
    begin_viscous_step(s.blocks.batches(block), positions, displacements,
                       s.start.data() + block.first_batch * kViscousNumbers * kBatchLanes);
  });
}

void ViscousPotential::add_value(const Vector& x, double& value) const {
  if (impl_->factor != 0.0) value += impl_->energy(x, false);
}

void ViscousPotential::add_value_and_gradient(const Vector& x, double& value,
                                              Vector& gradient) const {
  if (impl_->factor == 0.0) return;
  value += impl_->energy(x, true);
  impl_->blocks.add_row_sums(impl_->rows, gradient);
}

// Blocks of one colour share no vertex, and colours come one after the other.
void ViscousPotential::add_hessian(const Vector& x, const SparsityPattern& pattern,
                                   double* values) const {
  const Impl& s = *impl_;
  if (s.factor == 0.0) return;
  constexpr IsotropicModuli kNothing{MaterialKind::kStVenantKirchhoff};
  constexpr TangentForm kForm = TangentForm::kMetric;
  for (const std::vector<Index>& color : pattern.block_colors(s.blocks)) {
    parallel_for(static_cast<Index>(color.size()), 1, [&](Index begin, Index end) {
      thread_local AlignedVector<double> positions;
      thread_local AlignedVector<double> state;
      for (Index i = begin; i < end; ++i) {
        const Index b = color[static_cast<std::size_t>(i)];
        const ElementBlocks::Block& block = s.blocks.block(b);
        positions.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * block.row_count));
        s.blocks.load_rows(block, x.data(), positions.data());
        state.resize(static_cast<std::size_t>(block.batch_count * tangent_numbers(kForm)) *
                     kBatchLanes);
        prepare_tangent(s.blocks.batches(block), kNothing, kForm, positions.data(), state.data());
        s.add_tangent(b, positions.data(), kForm, state.data());
        add_block_stiffness(s.blocks, block, kForm, state.data(), pattern, values, [&](Index e) {
          pattern.scatter(
              e, element_hessian<Shape>(s.rest.element(e), s.density(e), s.rest.gather(x, e)),
              values);
        });
      }
    });
  }
}

void ViscousPotential::add_element_terms(Index e, const Vector& x, bool with_hessian,
                                         ElasticPotential::ElementTerms& terms) const {
  const Impl& s = *impl_;
  if (s.factor == 0.0) return;
  const auto element = s.rest.element(e);
  const ViscousDensity density = s.density(e);
  const Shape::NodeMatrix local = s.rest.gather(x, e);
  terms.energy += element_energy<Shape>(element, density, local);
  terms.gradient += element_gradient<Shape>(element, density, local);
  if (with_hessian) terms.hessian += element_hessian<Shape>(element, density, local);
}

void ViscousPotential::add_tangent(Index block, const double* positions, TangentForm form,
                                   float* state) const {
  impl_->add_tangent(block, positions, form, state);
}
void ViscousPotential::add_tangent(Index block, const double* positions, TangentForm form,
                                   double* state) const {
  impl_->add_tangent(block, positions, form, state);
}

}  // namespace tetraction
