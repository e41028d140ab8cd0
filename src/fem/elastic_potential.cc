#include "tetraction/fem/elastic_potential.h"

#include <Eigen/LU>
#include <utility>

#include "block_stiffness.h"
#include "elastic_potential_impl.h"

namespace tetraction {

ElasticPotential::ElasticPotential(const RestState& rest, const MaterialField& material)
    : ElasticPotential(rest, std::vector<MaterialField>{material}, {}) {}
ElasticPotential::ElasticPotential(const RestState& rest,
                                   const std::vector<MaterialModel>& materials,
                                   std::vector<int> material_of_element)
    : ElasticPotential(rest, std::vector<MaterialField>(materials.begin(), materials.end()),
                       std::move(material_of_element)) {}
ElasticPotential::ElasticPotential(const RestState& rest, std::vector<MaterialField> materials,
                                   std::vector<int> material_of_element)
    : impl_(std::make_unique<Impl>(rest, std::move(materials), std::move(material_of_element))) {}
ElasticPotential::~ElasticPotential() = default;
ElasticPotential::ElasticPotential(ElasticPotential&&) noexcept = default;

// Σ (C + c)² x² = Σ C² x² + 2 c Σ C x² + c² Σ x².
ElasticPotential::StiffnessSums ElasticPotential::stiffness_sums(double extra_modulus) const {
  StiffnessSums total;
  for (const ModulusSums& m : impl_->modulus_sums) {
    const auto at = [&](const std::array<double, 3>& powers) {
      return powers[2] + extra_modulus * (2.0 * powers[1] + extra_modulus * powers[0]);
    };
    total.squared += at(m.squared);
    total.with_edges += at(m.with_edges);
  }
  return total;
}
const ElementBlocks& BlockAccess::blocks(const ElasticPotential& elastic) {
  return elastic.impl_->blocks;
}
BatchView BlockAccess::batches(const ElasticPotential& elastic, Index block) {
  return elastic.impl_->batches(block);
}
const RestState& ElasticPotential::rest() const {
  return impl_->rest;
}
const std::vector<MaterialField>& ElasticPotential::materials() const {
  return impl_->materials;
}
MaterialModel ElasticPotential::material(Index e) const {
  return impl_->field(e).at(e);
}
int ElasticPotential::material_index(Index e) const {
  return impl_->material_of_element.empty()
             ? 0
             : impl_->material_of_element[static_cast<std::size_t>(e)];
}
LameParameters ElasticPotential::lame(Index e) const {
  return initial_lame(material(e));
}
void ElasticPotential::set_material(std::size_t index, const MaterialField& material) {
  impl_->materials.at(index) = material;
  impl_->take_parameters(index);
}

EvaluationStatus ElasticPotential::admissible(const Positions& q) const {
  return impl_->for_each_admissible(q, MaterialOrder::kAdmissible,
                                    [](Index, const auto&, const auto&) {});
}

EvaluationStatus ElasticPotential::value(const Positions& q, double& energy) const {
  if (!impl_->run_blocks(q, false)) return impl_->failure(q);
  energy = impl_->total_energy();
  return {};
}

EvaluationStatus ElasticPotential::value_and_gradient(const Positions& q, double& energy,
                                                      Vector& gradient) const {
  return impl_->value_and_gradient(q, nullptr, energy, gradient);
}
EvaluationStatus BlockAccess::value_and_gradient(const ElasticPotential& elastic,
                                                 const Positions& q,
                                                 const AlignedVector<double>& tensions,
                                                 double& energy, Vector& gradient) {
  return elastic.impl_->value_and_gradient(q, tensions.data(), energy, gradient);
}

EvaluationStatus BlockAccess::value_and_gradient(const ElasticPotential& elastic,
                                                 const Positions& q, const MeshPart& part,
                                                 double& energy, Vector& gradient) {
  return elastic.impl_->value_and_gradient(q, part, energy, gradient);
}

// Blocks of one colour share no vertex. The colours are processed one after the other.
EvaluationStatus ElasticPotential::add_hessian(const Positions& q, const SparsityPattern& pattern,
                                               double* values) const {
  return BlockAccess::add_hessian(*this, q, nullptr, pattern, values);
}
EvaluationStatus BlockAccess::add_hessian(const ElasticPotential& elastic, const Positions& q,
                                          const double* tensions, const SparsityPattern& pattern,
                                          double* values) {
  ElasticPotential::Impl& s = *elastic.impl_;
  if (!s.run_blocks(q, false)) return s.failure(q);
  for (const std::vector<Index>& color : colors(pattern, s.blocks)) {
    parallel_for(static_cast<Index>(color.size()), 1, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        s.add_block_hessian(color[static_cast<std::size_t>(i)], q, tensions, pattern, values);
      }
    });
  }
  return {};
}

void ElasticPotential::product(const Vector& q, const Vector& x, Vector& result) const {
  Impl& s = *impl_;
  s.records.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * s.blocks.record_count()));
  parallel_for(s.blocks.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = s.blocks.block(b);
      double* records = s.records.data() + ElementBlocks::kRecordSize * block.first_record;
      s.blocks.sum_local(block, records, [&](double* local_records) {
        s.scalar_block(block, q, local_records, MaterialOrder::kStiffness,
                       [&](Index i, const Shape::NodeMatrix& local, const auto& m,
                           double&) -> Shape::NodeMatrix {
                         // Relative displacements keep the digits of small strains in a large
                         // motion.
                         Shape::NodeMatrix displacements = local;
                         displacements.rightCols<3>() -= s.rest.point_edges(i);
                         return element_product<Shape>(s.rest.point(i), m, displacements,
                                                       s.rest.gather_relative(x, i));
                       });
      });
    }
  });
  s.blocks.sum_records(s.records, result);
}

Vector ElasticPotential::energies_by_material(const Vector& q) const {
  Vector sums = Vector::Zero(static_cast<Index>(impl_->materials.size()));
  if (!impl_->run_blocks(q, false)) return sums;
  for (Index b = 0; b < impl_->blocks.block_count(); ++b) {
    sums[impl_->blocks.block(b).material] += impl_->energies[static_cast<std::size_t>(b)];
  }
  return sums;
}

double BlockAccess::energy(const ElasticPotential& elastic, Index block) {
  return elastic.impl_->energies[static_cast<std::size_t>(block)];
}

bool ElasticPotential::element_terms(Index e, const Positions& q, bool with_hessian,
                                     ElementTerms& terms) const {
  return impl_->element_terms(e, q, with_hessian, terms);
}

void ElasticPotential::energy_densities(const Vector& q, Vector& densities) const {
  const Impl& s = *impl_;
  densities.setZero(s.rest.point_count());
  parallel_for(s.blocks.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      s.for_each_at(s.blocks.block(b), q, MaterialOrder::kEnergy,
                    [&](Index i, const Shape::NodeMatrix& local, const auto& material, Index, int) {
                      const Matrix3 f = local.rightCols<3>() * s.rest.point_edges(i).inverse();
                      if (material.admissible(f)) densities[i] = material.energy_density(f);
                    });
    }
  });
}

Matrix3 ElasticPotential::first_piola(Index point, const Vector& q) const {
  const RestState& rest = impl_->rest;
  return impl_->with_material_of_point(point, [&](const auto& material) -> Matrix3 {
    return material.first_piola(deformation_gradient(rest.point(point), 0, rest.gather(q, point)));
  });
}

}  // namespace tetraction
