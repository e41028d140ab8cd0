#include "elastic_potential_impl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "block_stiffness.h"
#include "element_sums.h"
#include "isotropic_model.h"
#include "kernels/element_kernels.h"
#include "kernels/tangent_kernels.h"
#include "kernels/volume_kernels.h"
#include "tetraction/core/error.h"

namespace tetraction {
bool loses_digits(const ElementBlocks::Block& block, const IsotropicModel& model) {
  const TangentForm form = tangent_form(model, false);
  const bool has_metric = has(form, TangentForm::kMetric) || has(form, TangentForm::kPrincipal);
  return block.aspect > (has_metric ? 12.0 : 50.0);
}

ElasticPotential::Impl::Impl(const RestState& rest_state, std::vector<MaterialField> models,
                             std::vector<int> index_of_element)
    : rest(rest_state),
      materials(std::move(models)),
      material_of_element(materials.size() < 2 ? std::vector<int>{} : std::move(index_of_element)),
      blocks(rest, material_of_element, materials.size()),
      energies(static_cast<std::size_t>(blocks.block_count())),
      parameters(energies.size()),
      modulus_sums(materials.size()) {
  for (Index b = 0; b < blocks.block_count(); ++b) {
    ElementBlocks::Block& block = blocks.block(b);
    ModulusSums& sums = modulus_sums[static_cast<std::size_t>(block.material)];
    blocks.for_each_point(block, [&](Index i, Index, int) {
      const double edge = longest_edge(i);
      const double largest_gradient = rest.point(i).gradients[0].colwise().squaredNorm().maxCoeff();
      block.aspect = std::max(block.aspect, std::sqrt(edge * largest_gradient));
      sums.add_shape(shape_squared(i), edge);
    });
  }
  for (std::size_t m = 0; m < materials.size(); ++m) take_parameters(m);
}

double ElasticPotential::Impl::shape_squared(Index i) const {
  const auto point = rest.point(i);
  const double shape = point.weights[0] * point.gradients[0].squaredNorm();
  return shape * shape;
}

double ElasticPotential::Impl::longest_edge(Index i) const {
  const Matrix3 edges = rest.point_edges(i);
  double longest = edges.colwise().squaredNorm().maxCoeff();
  for (int a = 0; a < 3; ++a) {
    longest = std::max(longest, (edges.col(a) - edges.col((a + 1) % 3)).squaredNorm());
  }
  return longest;
}

void ElasticPotential::Impl::take_parameters(std::size_t m) {
  const MaterialField& material = materials[m];
  if (material.varies() && material.parameters().cols() != rest.element_count()) {
    throw InputError(fmt::format("A material has parameters for {} elements, but the mesh has {}.",
                                 material.parameters().cols(), rest.element_count()));
  }
  ModulusSums& sums = modulus_sums[m];
  const auto modulus_of = [](const LameParameters& lame) {
    return std::abs(lame.lambda) + 2.0 * lame.mu;
  };
  require_defined_at_rest(m);
  sums.clear_moduli();
  if (!material.varies()) sums.set_modulus(modulus_of(initial_lame(material.model())));
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks.block(b);
    if (block.material != static_cast<int>(m)) continue;
    AlignedVector<double>& values = parameters[static_cast<std::size_t>(b)];
    values.clear();
    if (!material.varies()) continue;
    blocks.for_each_point(block, [&](Index i, Index, int) {
      sums.add_modulus(modulus_of(initial_lame(material.at(rest.element_of(i)))), shape_squared(i),
                       longest_edge(i));
    });
    const Matrix& table = material.parameters();
    const Index count = table.rows();
    values.resize(static_cast<std::size_t>(block.batch_count * count * kBatchLanes));
    for (Index batch = 0; batch < block.batch_count; ++batch) {
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        // Padding gets the parameters of any element.
        const Index e =
            rest.element_of(std::max<Index>(0, blocks.point(block.first_batch + batch, lane)));
        for (Index k = 0; k < count; ++k) {
          values[static_cast<std::size_t>((batch * count + k) * kBatchLanes + lane)] = table(k, e);
        }
      }
    }
  }
}

void ElasticPotential::Impl::require_defined_at_rest(std::size_t m) const {
  const auto* custom = std::get_if<CustomMaterial>(&materials[m].model());
  if (custom == nullptr || !custom->has_places()) return;
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks.block(b);
    if (block.material != static_cast<int>(m)) continue;
    ValueLists values;
    blocks.for_each_point(block, [&](Index i, Index, int) {
      values.f.push_back(Matrix3::Identity());
      values.places.push_back(place_of(rest, i));
    });
    if (custom->has_batches()) values.evaluate(*custom, MaterialOrder::kEnergy);
    for (std::size_t k = 0; k < values.f.size(); ++k) {
      const MaterialPlace& place = values.places[k];
      // Ψ − Ψ(I) is 0, or it is not a number.
      const bool is_defined =
          custom->has_batches() ? values.admissible[k] != 0 && std::isfinite(values.energy[k])
                                : custom->at(place).admissible(values.f[k]) &&
                                      std::isfinite(custom->at(place).energy_density(values.f[k]));
      if (is_defined) continue;
      throw InputError(
          fmt::format("{}: the energy density is not defined at rest, F = I, in element {} (from "
                      "0) at ({:.6g}, {:.6g}, {:.6g}) m: the body could not even begin.",
                      custom->name(), place.element, place.position.x(), place.position.y(),
                      place.position.z()));
    }
  }
}

BlockSums ElasticPotential::Impl::run_block(Index b, const Positions& q, double* gradients,
                                            const double* tensions) const {
  const ElementBlocks::Block& block = blocks.block(b);
  const std::optional<IsotropicModel> model = isotropic_model(field(block).model());
  const bool is_scalar = !model || (q.displacement() != nullptr && loses_digits(block, *model));
  BlockSums sums;
  if (is_scalar) {
    sums = scalar_block(block, q, gradients,
                        gradients == nullptr ? MaterialOrder::kEnergy : MaterialOrder::kStress,
                        [&](Index i, const Shape::NodeMatrix& local, const auto& m,
                            double& energy) -> Shape::NodeMatrix {
                          const auto point = rest.point(i);
                          energy += element_energy<Shape>(point, m, local);
                          if (gradients == nullptr) return Shape::NodeMatrix::Zero();
                          return element_gradient<Shape>(point, m, local);
                        });
    if (tensions == nullptr) return sums;
  }
  thread_local AlignedVector<double> positions;
  positions.resize(ElementBlocks::local_size(block));
  blocks.load_records(block, q.origin().data(), positions.data());
  thread_local AlignedVector<double> displacements;
  if (q.displacement() != nullptr) {
    displacements.resize(positions.size());
    blocks.load_displacements(block, q.displacement()->data(), displacements.data());
  }
  const double* displacement = q.displacement() == nullptr ? nullptr : displacements.data();
  BatchView view = batches(b);
  if (tensions != nullptr) view.tensions = tensions + block.first_batch * kBatchLanes;
  if (is_scalar) {
    add_volume_gradient(view, positions.data(), displacement, gradients);
    return sums;
  }
  return gradients == nullptr
             ? elastic_energy(view, *model, positions.data(), displacement)
             : elastic_gradient(view, *model, positions.data(), displacement, gradients);
}

void ElasticPotential::Impl::add_block_hessian(Index b, const Positions& q, const double* tensions,
                                               const SparsityPattern& pattern,
                                               double* values) const {
  const ElementBlocks::Block& block = blocks.block(b);
  const std::optional<IsotropicModel> model = isotropic_model(field(block).model());
  if (!model) {
    // The points of an element follow one another.
    const int points = rest.points_per_element();
    ElementMatrix sum =
        ElementMatrix::Zero(3 * rest.nodes_per_element(), 3 * rest.nodes_per_element());
    for_each_at(block, q, MaterialOrder::kStiffness,
                [&](Index i, const Shape::NodeMatrix& local, const auto& m, Index, int) {
                  const auto p = static_cast<int>(i % points);
                  add_point_matrix(p, element_hessian<Shape>(rest.point(i), m, local), sum);
                  if (p < points - 1) return;
                  pattern.scatter(rest.element_of(i), sum, values);
                  sum.setZero();
                });
    return;
  }
  const TangentForm form = tangent_form(*model, false);
  thread_local AlignedVector<double> positions;
  thread_local AlignedVector<double> state;
  positions.resize(ElementBlocks::local_size(block));
  const auto numbers = static_cast<std::size_t>(tangent_numbers(form)) * kBatchLanes;
  state.resize(numbers * static_cast<std::size_t>(block.batch_count));
  blocks.load_positions(block, q, positions.data());
  BatchView view = batches(b);
  if (tensions != nullptr) view.tensions = tensions + block.first_batch * kBatchLanes;
  prepare_tangent(view, *model, form, positions.data(), state.data());
  add_block_stiffness(blocks, block, form, state.data(), pattern, values);
}

bool ElasticPotential::Impl::element_terms(Index e, const Positions& q, bool with_hessian,
                                           ElementTerms& terms) const {
  clear(rest, with_hessian, terms);
  const int points = rest.points_per_element();
  for (int p = 0; p < points; ++p) {
    const Index i = points * e + p;
    const bool is_admissible = with_material_of_point(i, [&](const auto& material) {
      const Shape::NodeMatrix local = rest.gather_relative(q, i);
      const auto point = rest.point(i);
      if (!element_admissible<Shape>(point, material, local)) return false;
      add_point(p, point, material, local, with_hessian, terms);
      return true;
    });
    if (!is_admissible) return false;
  }
  return true;
}

EvaluationStatus ElasticPotential::Impl::value_and_gradient(const Positions& q,
                                                            const double* tensions, double& energy,
                                                            Vector& gradient) {
  if (!run_blocks(q, true, tensions)) return failure(q);
  energy = total_energy();
  blocks.sum_records(records, gradient);
  return {};
}

const BlockLists& ElasticPotential::Impl::lists_for(const MeshPart& part) {
  if (block_lists) return *block_lists;
  block_lists.emplace();
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks.block(b);
    bool is_outer = false;
    for (Index r = 0; r < block.record_count && !is_outer; ++r) {
      is_outer = std::ranges::binary_search(part.shared_vertices,
                                            blocks.record_vertex(block.first_record + r));
    }
    (is_outer ? block_lists->outer : block_lists->inner).push_back(b);
  }
  return *block_lists;
}

EvaluationStatus ElasticPotential::Impl::value_and_gradient(const Positions& q,
                                                            const MeshPart& part, double& energy,
                                                            Vector& gradient) {
  const BlockLists& lists = lists_for(part);
  const auto run = [&](const std::vector<Index>& list) {
    const auto block_at = [&](Index i) { return list[static_cast<std::size_t>(i)]; };
    return run_blocks(static_cast<Index>(list.size()), block_at, q, true, nullptr);
  };
  gradient.resize(q.origin().size());
  bool is_admissible = run(lists.outer);
  if (is_admissible) {
    blocks.sum_records(records, part.shared_vertices, gradient);
  } else {
    gradient.setZero();  // The other parts wait for numbers nevertheless.
  }
  part.begin_adding(gradient.data(), 3);
  is_admissible = run(lists.inner) && is_admissible;
  // This computes the same numbers for shared vertices once more.
  if (is_admissible) blocks.sum_records(records, gradient);
  part.end_adding(gradient.data(), 3);
  if (!is_admissible) {
    gradient.setZero();
    return failure(q);
  }
  energy = total_energy();
  return {};
}

EvaluationStatus ElasticPotential::Impl::failure(const Positions& q) const {
  const EvaluationStatus found =
      for_each_admissible(q, MaterialOrder::kAdmissible, [](Index, const auto&, const auto&) {});
  // If J is zero up to round-off, this loop may find no failure although the kernels found one.
  return found.ok() ? EvaluationStatus{0} : found;
}

}  // namespace tetraction
