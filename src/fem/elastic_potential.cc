#include "tetraction/fem/elastic_potential.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "block_stiffness.h"
#include "element_blocks.h"
#include "isotropic_model.h"
#include "kernels/element_kernels.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kNone = std::numeric_limits<Index>::max();

// Keeps the smallest number of an element that failed, whichever thread finds it.
class FirstFailure {
 public:
  void note(Index e) {
    Index seen = first_.load(std::memory_order_relaxed);
    while (e < seen && !first_.compare_exchange_weak(seen, e, std::memory_order_relaxed)) {
    }
  }
  EvaluationStatus result() const {
    const Index first = first_.load();
    return first == kNone ? EvaluationStatus{} : EvaluationStatus{first};
  }

 private:
  std::atomic<Index> first_{kNone};
};

}  // namespace

struct ElasticPotential::Impl {
  const RestState& rest;
  std::vector<MaterialModel> materials;
  std::vector<int> material_of_element;  // empty: one material everywhere
  ElementBlocks blocks;
  std::vector<double> energies;       // per block
  AlignedVector<double> rows;         // gradients, per record
  std::vector<ShapeSums> shape_sums;  // per material

  Impl(const RestState& rest_state, std::vector<MaterialModel> models,
       std::vector<int> index_of_element)
      : rest(rest_state),
        materials(std::move(models)),
        material_of_element(materials.size() < 2 ? std::vector<int>{}
                                                 : std::move(index_of_element)),
        blocks(rest, material_of_element, materials.size()),
        energies(static_cast<std::size_t>(blocks.block_count())),
        shape_sums(materials.size()) {
    for (Index b = 0; b < blocks.block_count(); ++b) {
      ElementBlocks::Block& block = blocks.block(b);
      ShapeSums& sums = shape_sums[static_cast<std::size_t>(block.material)];
      blocks.for_each_element(block, [&](Index e, Index, int) {
        const auto element = rest.element(e);
        const double shape = element.weights[0] * element.gradients[0].squaredNorm();
        const auto nodes = rest.nodes(e);
        double longest = 0.0;
        for (std::size_t a = 0; a < nodes.size(); ++a) {
          for (std::size_t c = 0; c < a; ++c) {
            longest = std::max(longest,
                               (rest.position(nodes[a]) - rest.position(nodes[c])).squaredNorm());
          }
        }
        sums.squared += shape * shape;
        sums.with_edges += shape * shape * longest;
        const double steepest = element.gradients[0].colwise().squaredNorm().maxCoeff();
        block.aspect = std::max(block.aspect, std::sqrt(longest * steepest));
      });
    }
  }

  const MaterialModel& material(Index e) const {
    return materials[material_of_element.empty()
                         ? 0
                         : static_cast<std::size_t>(
                               material_of_element[static_cast<std::size_t>(e)])];
  }

  // Runs body(element, material) over all elements; the material's type is resolved outside the
  // inner loop.
  template <class Body>
  void for_each(const Body& body) const {
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        std::visit(
            [&](const auto& m) {
              blocks.for_each_element(block, [&](Index e, Index, int) { body(e, m); });
            },
            materials[static_cast<std::size_t>(block.material)]);
      }
    });
  }

  // Runs body(element, element positions, material) over all elements where the energy is defined.
  template <class Body>
  EvaluationStatus for_each_admissible(const Positions& q, const Body& body) const {
    FirstFailure failure;
    for_each([&](Index e, const auto& m) {
      const Shape::NodeMatrix local = rest.gather_relative(q, e);
      if (element_admissible<Shape>(rest.element(e), m, local)) {
        body(e, local, m);
      } else {
        failure.note(e);
      }
    });
    return failure.result();
  }

  // The loop for blocks that the isotropic kernels cannot process: one element after the other.
  // local(e, positions, material, energy) gives the element's gradient and its energy.
  template <class Local>
  BlockSums scalar_block(const ElementBlocks::Block& block, const Positions& q, double* gradients,
                         const Local& local) const {
    BlockSums sums;
    std::visit(
        [&](const auto& m) {
          blocks.for_each_element(block, [&](Index e, Index batch, int lane) {
            const Shape::NodeMatrix positions = rest.gather_relative(q, e);
            if (!element_admissible<Shape>(rest.element(e), m, positions)) {
              sums.admissible = false;
              return;
            }
            const Shape::NodeMatrix g = local(e, positions, m, sums.energy);
            if (gradients == nullptr) return;
            for (int a = 0; a < Shape::kNodes; ++a) {
              Eigen::Map<Vector3>(gradients + blocks.slot(batch, a, lane)) += g.col(a);
            }
          });
        },
        materials[static_cast<std::size_t>(block.material)]);
    return sums;
  }

  // Computes the energies of all blocks and, if `with_gradient`, their records of gradients.
  bool run_blocks(const Positions& q, bool with_gradient) {
    if (with_gradient)
      rows.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()));
    std::atomic<bool> admissible{true};
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        double* gradients = nullptr;
        if (with_gradient) {
          gradients = rows.data() + ElementBlocks::kRecordSize * block.first_record;
          std::fill_n(gradients, ElementBlocks::kRecordSize * block.record_count, 0.0);
        }
        const BlockSums sums = run_block(block, q, gradients);
        energies[static_cast<std::size_t>(b)] = sums.energy;
        if (!sums.admissible) admissible = false;
      }
    });
    return admissible;
  }

  // The kernels on edges lose digits: det F in proportion to the square of the elements' aspect
  // ratio, the metric terms of St Venant–Kirchhoff and Mooney–Rivlin in proportion to its cube. The
  // loop over single elements uses F, and its forces lose digits in proportion to the ratio only.
  // This matters if positions are given as a sum, because the caller then needs the digits.
  static bool loses_digits(const ElementBlocks::Block& block, const IsotropicModel& model) {
    const bool has_metric = has(tangent_form(model, false), TangentForm::kMetric);
    return block.aspect > (has_metric ? 12.0 : 50.0);
  }

  BlockSums run_block(const ElementBlocks::Block& block, const Positions& q,
                      double* gradients) const {
    const std::optional<IsotropicModel> model =
        isotropic_model(materials[static_cast<std::size_t>(block.material)]);
    if (!model || (q.displacement() != nullptr && loses_digits(block, *model))) {
      return scalar_block(block, q, gradients,
                          [&](Index e, const Shape::NodeMatrix& local, const auto& m,
                              double& energy) -> Shape::NodeMatrix {
                            const auto element = rest.element(e);
                            energy += element_energy<Shape>(element, m, local);
                            return element_gradient<Shape>(element, m, local);
                          });
    }
    thread_local AlignedVector<double> positions;
    positions.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * block.record_count));
    blocks.load_records(block, q.origin().data(), positions.data());
    thread_local AlignedVector<double> changes;
    if (q.displacement() != nullptr) {
      changes.resize(positions.size());
      blocks.load_changes(block, q.displacement()->data(), changes.data());
    }
    const double* change = q.displacement() == nullptr ? nullptr : changes.data();
    return gradients == nullptr
               ? elastic_energy(blocks.batches(block), *model, positions.data(), change)
               : elastic_gradient(blocks.batches(block), *model, positions.data(), change,
                                  gradients);
  }

  void add_block_hessian(const ElementBlocks::Block& block, const Positions& q,
                         const SparsityPattern& pattern, double* values) const {
    const MaterialModel& material = materials[static_cast<std::size_t>(block.material)];
    const std::optional<IsotropicModel> model = isotropic_model(material);
    const auto add_one = [&](Index e) {
      std::visit(
          [&](const auto& m) {
            pattern.scatter(
                e, element_hessian<Shape>(rest.element(e), m, rest.gather_relative(q, e)), values);
          },
          material);
    };
    if (!model) {
      blocks.for_each_element(block, [&](Index e, Index, int) { add_one(e); });
      return;
    }
    const TangentForm form = tangent_form(*model, false);
    thread_local AlignedVector<double> positions;
    thread_local AlignedVector<double> state;
    positions.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * block.record_count));
    const auto numbers = static_cast<std::size_t>(tangent_numbers(form)) * kBatchLanes;
    state.resize(numbers * static_cast<std::size_t>(block.batch_count));
    blocks.load_positions(block, q, positions.data());
    prepare_tangent(blocks.batches(block), *model, form, positions.data(), state.data());
    add_block_stiffness(blocks, block, form, state.data(), pattern, values, add_one);
  }

  double total_energy() const {
    double sum = 0.0;
    for (const double energy : energies) sum += energy;
    return sum;
  }

  // The first element where the energy is not defined. Called after a block reported that there is
  // one.
  EvaluationStatus failure(const Positions& q) const {
    const EvaluationStatus found = for_each_admissible(q, [](Index, const auto&, const auto&) {});
    return found.ok() ? EvaluationStatus{0} : found;  // on the very edge the kernels may differ
  }
};

ElasticPotential::ElasticPotential(const RestState& rest, const MaterialModel& material)
    : ElasticPotential(rest, std::vector<MaterialModel>{material}, {}) {}
ElasticPotential::ElasticPotential(const RestState& rest, std::vector<MaterialModel> materials,
                                   std::vector<int> material_of_element)
    : impl_(std::make_unique<Impl>(rest, std::move(materials), std::move(material_of_element))) {}
ElasticPotential::~ElasticPotential() = default;
ElasticPotential::ElasticPotential(ElasticPotential&&) noexcept = default;

const ElasticPotential::ShapeSums& ElasticPotential::shape_sums(std::size_t material) const {
  return impl_->shape_sums.at(material);
}
const ElementBlocks& BlockAccess::blocks(const ElasticPotential& elastic) {
  return elastic.impl_->blocks;
}
const RestState& ElasticPotential::rest() const {
  return impl_->rest;
}
const std::vector<MaterialModel>& ElasticPotential::materials() const {
  return impl_->materials;
}
int ElasticPotential::material_index(Index e) const {
  return impl_->material_of_element.empty()
             ? 0
             : impl_->material_of_element[static_cast<std::size_t>(e)];
}
LameParameters ElasticPotential::lame(Index e) const {
  return initial_lame(impl_->material(e));
}
void ElasticPotential::set_material(std::size_t index, const MaterialModel& material) {
  impl_->materials.at(index) = material;
}

EvaluationStatus ElasticPotential::admissible(const Positions& q) const {
  return impl_->for_each_admissible(q, [](Index, const auto&, const auto&) {});
}

EvaluationStatus ElasticPotential::value(const Positions& q, double& energy) const {
  if (!impl_->run_blocks(q, false)) return impl_->failure(q);
  energy = impl_->total_energy();
  return {};
}

EvaluationStatus ElasticPotential::value_and_gradient(const Positions& q, double& energy,
                                                      Vector& gradient) const {
  if (!impl_->run_blocks(q, true)) return impl_->failure(q);
  energy = impl_->total_energy();
  impl_->blocks.sum_records(impl_->rows, gradient);
  return {};
}

// Blocks of one colour share no vertex. The colours are processed one after the other.
EvaluationStatus ElasticPotential::add_hessian(const Positions& q, const SparsityPattern& pattern,
                                               double* values) const {
  if (!impl_->run_blocks(q, false)) return impl_->failure(q);
  for (const std::vector<Index>& color : BlockAccess::colors(pattern, impl_->blocks)) {
    parallel_for(static_cast<Index>(color.size()), 1, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        impl_->add_block_hessian(impl_->blocks.block(color[static_cast<std::size_t>(i)]), q,
                                 pattern, values);
      }
    });
  }
  return {};
}

void ElasticPotential::product(const Vector& q, const Vector& x, Vector& result) const {
  Impl& s = *impl_;
  s.rows.assign(static_cast<std::size_t>(ElementBlocks::kRecordSize * s.blocks.record_count()),
                0.0);
  parallel_for(s.blocks.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = s.blocks.block(b);
      s.scalar_block(block, q, s.rows.data() + ElementBlocks::kRecordSize * block.first_record,
                     [&](Index e, const Shape::NodeMatrix& local, const auto& m,
                         double&) -> Shape::NodeMatrix {
                       return element_product<Shape>(s.rest.element(e), m, local,
                                                     s.rest.gather(x, e));
                     });
    }
  });
  s.blocks.sum_records(s.rows, result);
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
  return std::visit(
      [&](const auto& material) {
        const Shape::NodeMatrix local = impl_->rest.gather_relative(q, e);
        const auto rest = impl_->rest.element(e);
        if (!element_admissible<Shape>(rest, material, local)) return false;
        terms.energy = element_energy<Shape>(rest, material, local);
        terms.gradient = element_gradient<Shape>(rest, material, local);
        if (with_hessian) terms.hessian = element_hessian<Shape>(rest, material, local);
        return true;
      },
      impl_->material(e));
}

void ElasticPotential::energy_densities(const Vector& q, Vector& densities) const {
  densities.setZero(impl_->rest.element_count());
  impl_->for_each_admissible(q, [&](Index e, const Shape::NodeMatrix& local, const auto& material) {
    densities[e] = material.energy_density(deformation_gradient(impl_->rest.element(e), 0, local));
  });
}

Matrix3 ElasticPotential::first_piola(Index e, const Vector& q) const {
  return std::visit(
      [&](const auto& material) -> Matrix3 {
        return material.first_piola(
            deformation_gradient(impl_->rest.element(e), 0, impl_->rest.gather(q, e)));
      },
      impl_->material(e));
}

}  // namespace tetraction
