#include "tetraction/fem/elastic_potential.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "block_stiffness.h"
#include "element_blocks.h"
#include "element_sums.h"
#include "isotropic_model.h"
#include "kernels/element_kernels.h"
#include "kernels/tangent_kernels.h"
#include "kernels/volume_kernels.h"
#include "material_at.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {
namespace {

constexpr Index kNone = std::numeric_limits<Index>::max();

// Keeps the smallest index of the elements that failed. Several threads may report elements.
class FirstFailure {
 public:
  void report(Index e) {
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

// Σ Cⁿ x² and Σ Cⁿ x² L² for n = 0, 1, 2 over the elements of a material, with the modulus C, the
// shape x = V Σ_a |∇N_a|² and the longest rest edge L.
struct ModulusSums {
  std::array<double, 3> squared{};
  std::array<double, 3> with_edges{};

  // Adds the terms of an element that do not depend on its modulus.
  void add_shape(double shape_squared, double edge_squared) {
    squared[0] += shape_squared;
    with_edges[0] += shape_squared * edge_squared;
  }
  void add_modulus(double modulus, double shape_squared, double edge_squared) {
    for (std::size_t n = 1; n < 3; ++n) {
      shape_squared *= modulus;
      squared[n] += shape_squared;
      with_edges[n] += shape_squared * edge_squared;
    }
  }
  void clear_moduli() {
    for (std::size_t n = 1; n < 3; ++n) squared[n] = with_edges[n] = 0.0;
  }
  // All elements have the same modulus.
  void set_modulus(double modulus) {
    for (std::size_t n = 1; n < 3; ++n) {
      squared[n] = modulus * squared[n - 1];
      with_edges[n] = modulus * with_edges[n - 1];
    }
  }
};

// What a material is asked for.
enum class Order { kAdmissible, kEnergy, kStress, kStiffness };

// The values of a BatchMaterial at one F, which is the only one that its functions are called with.
struct Evaluated {
  bool is_admissible = false;
  double energy = 0.0;
  const Matrix3* stress = nullptr;
  const Matrix9* tangent = nullptr;

  bool admissible(const Matrix3&) const { return is_admissible; }
  double energy_density(const Matrix3&) const { return energy; }
  const Matrix3& first_piola(const Matrix3&) const { return *stress; }
  const Matrix9& stiffness(const Matrix3&) const { return *tangent; }
};

// The lists of the values of a material at some F.
struct ValueLists {
  std::vector<Matrix3> f;
  std::vector<MaterialPlace> places;  // only for materials that need them
  std::vector<char> admissible;
  std::vector<double> energy;
  std::vector<Matrix3> stress;
  std::vector<Matrix9> stiffness;

  void evaluate(const CustomMaterial& material, Order order) {
    admissible.assign(f.size(), 0);
    energy.resize(order >= Order::kEnergy ? f.size() : 0);
    stress.resize(order >= Order::kStress ? f.size() : 0);
    stiffness.resize(order >= Order::kStiffness ? f.size() : 0);
    material.evaluate({f, admissible, energy, stress, stiffness, places});
  }
  Evaluated at(std::size_t k) const {
    return {admissible[k] != 0, energy.empty() ? 0.0 : energy[k],
            stress.empty() ? nullptr : &stress[k], stiffness.empty() ? nullptr : &stiffness[k]};
  }
};

// The blocks that have shared vertices of a part of a body, and the other ones.
struct BlockLists {
  std::vector<Index> outer;
  std::vector<Index> inner;
};

}  // namespace

struct ElasticPotential::Impl {
  const RestState& rest;
  std::vector<MaterialField> materials;
  std::vector<int> material_of_element;  // empty if there is one material only
  ElementBlocks blocks;
  std::vector<double> energies;           // per block
  AlignedVector<double> records;          // gradients, per record
  std::optional<BlockLists> block_lists;  // of a part of a body, made when first needed
  // Per block: the parameters of its elements (BatchView::parameters); empty if they do not vary.
  std::vector<AlignedVector<double>> parameters;
  std::vector<ModulusSums> modulus_sums;  // per material

  Impl(const RestState& rest_state, std::vector<MaterialField> models,
       std::vector<int> index_of_element)
      : rest(rest_state),
        materials(std::move(models)),
        material_of_element(materials.size() < 2 ? std::vector<int>{}
                                                 : std::move(index_of_element)),
        blocks(rest, material_of_element, materials.size()),
        energies(static_cast<std::size_t>(blocks.block_count())),
        parameters(energies.size()),
        modulus_sums(materials.size()) {
    for (Index b = 0; b < blocks.block_count(); ++b) {
      ElementBlocks::Block& block = blocks.block(b);
      ModulusSums& sums = modulus_sums[static_cast<std::size_t>(block.material)];
      blocks.for_each_point(block, [&](Index i, Index, int) {
        const double edge = longest_edge(i);
        const double largest_gradient =
            rest.point(i).gradients[0].colwise().squaredNorm().maxCoeff();
        block.aspect = std::max(block.aspect, std::sqrt(edge * largest_gradient));
        sums.add_shape(shape_squared(i), edge);
      });
    }
    for (std::size_t m = 0; m < materials.size(); ++m) take_parameters(m);
  }

  // (V Σ_a |∇N_a|²)² of a point, m².
  double shape_squared(Index i) const {
    const auto point = rest.point(i);
    const double shape = point.weights[0] * point.gradients[0].squaredNorm();
    return shape * shape;
  }
  // The square of the longest rest edge of a point, m².
  double longest_edge(Index i) const {
    const Matrix3 edges = rest.point_edges(i);
    double longest = edges.colwise().squaredNorm().maxCoeff();
    for (int a = 0; a < 3; ++a) {
      longest = std::max(longest, (edges.col(a) - edges.col((a + 1) % 3)).squaredNorm());
    }
    return longest;
  }

  // Prepares the blocks of a material after it has changed.
  void take_parameters(std::size_t m) {
    const MaterialField& material = materials[m];
    if (material.varies() && material.parameters().cols() != rest.element_count()) {
      throw InputError(
          fmt::format("A material has parameters for {} elements, but the mesh has {}.",
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
        sums.add_modulus(modulus_of(initial_lame(material.at(rest.element_of(i)))),
                         shape_squared(i), longest_edge(i));
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
            values[static_cast<std::size_t>((batch * count + k) * kBatchLanes + lane)] =
                table(k, e);
          }
        }
      }
    }
  }

  // Throws InputError if the energy of a PlacedMaterial is not defined somewhere at rest.
  void require_defined_at_rest(std::size_t m) const {
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
      if (custom->has_batches()) values.evaluate(*custom, Order::kEnergy);
      for (std::size_t k = 0; k < values.f.size(); ++k) {
        const MaterialPlace& place = values.places[k];
        // Ψ − Ψ(I) is 0, or it is not a number.
        const bool is_defined =
            custom->has_batches()
                ? values.admissible[k] != 0 && std::isfinite(values.energy[k])
                : custom->at(place).admissible(values.f[k]) &&
                      std::isfinite(custom->at(place).energy_density(values.f[k]));
        if (is_defined) continue;
        throw InputError(
            fmt::format("{}: the energy density is not defined at rest, F = I, in element {} (from "
                        "0) at ({:.6g}, "
                        "{:.6g}, {:.6g}) m: the body could not even begin.",
                        custom->name(), place.element, place.position.x(), place.position.y(),
                        place.position.z()));
      }
    }
  }

  const MaterialField& field(const ElementBlocks::Block& block) const {
    return materials[static_cast<std::size_t>(block.material)];
  }
  const MaterialField& field(Index e) const {
    return materials[material_of_element.empty()
                         ? 0
                         : static_cast<std::size_t>(
                               material_of_element[static_cast<std::size_t>(e)])];
  }
  BatchView batches(Index b) const {
    BatchView view = blocks.batches(blocks.block(b));
    const AlignedVector<double>& own = parameters[static_cast<std::size_t>(b)];
    if (!own.empty()) view.parameters = own.data();
    return view;
  }

  // Returns body(material at point i), with the material as its own type.
  template <class Body>
  decltype(auto) with_material_of_point(Index i, const Body& body) const {
    const MaterialField& material = field(rest.element_of(i));
    return std::visit([&](const auto& m) { return with_material_at(material, m, rest, i, body); },
                      material.model());
  }

  // Calls body(point, material, batch, lane) for all points of a block. The type of the material is
  // resolved once.
  template <class Body>
  void for_each_of(const ElementBlocks::Block& block, const Body& body) const {
    const MaterialField& material = field(block);
    std::visit(
        [&](const auto& m) {
          blocks.for_each_point(block, [&](Index i, Index batch, int lane) {
            with_material_at(material, m, rest, i,
                             [&](const auto& own) { body(i, own, batch, lane); });
          });
        },
        material.model());
  }

  // Calls body(point, positions of its nodes, material, batch, lane) for all points of a block. A
  // BatchMaterial is evaluated for all of them in one call before, up to `order`.
  template <class Body>
  void for_each_at(const ElementBlocks::Block& block, const Positions& q, Order order,
                   const Body& body) const {
    const auto* custom = std::get_if<CustomMaterial>(&field(block).model());
    if (custom == nullptr || !custom->has_batches()) {
      for_each_of(block, [&](Index i, const auto& m, Index batch, int lane) {
        body(i, rest.gather_relative(q, i), m, batch, lane);
      });
      return;
    }
    ValueLists values;
    blocks.for_each_point(block, [&](Index i, Index, int) {
      Shape::NodeMatrix displacements = rest.gather_relative(q, i);
      displacements.rightCols<3>() -= rest.point_edges(i);
      values.f.push_back(Matrix3::Identity() +
                         deformation_gradient(rest.point(i), 0, displacements));
      if (custom->has_places()) values.places.push_back(place_of(rest, i));
    });
    values.evaluate(*custom, order);
    std::size_t k = 0;
    blocks.for_each_point(block, [&](Index i, Index batch, int lane) {
      body(i, rest.gather_relative(q, i), values.at(k++), batch, lane);
    });
  }

  // Calls body(point, positions of its nodes, material) for all points where the energy is defined.
  template <class Body>
  EvaluationStatus for_each_admissible(const Positions& q, Order order, const Body& body) const {
    FirstFailure failure;
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        for_each_at(blocks.block(b), q, order,
                    [&](Index i, const Shape::NodeMatrix& local, const auto& m, Index, int) {
                      if (element_admissible<Shape>(rest.point(i), m, local)) {
                        body(i, local, m);
                      } else {
                        failure.report(rest.element_of(i));
                      }
                    });
      }
    });
    return failure.result();
  }

  // Processes a block one point after the other, where the isotropic kernels cannot be used.
  // local(point, positions, material, energy) returns the gradient of a point and adds to the energy.
  template <class Local>
  BlockSums scalar_block(const ElementBlocks::Block& block, const Positions& q, double* gradients,
                         Order order, const Local& local) const {
    BlockSums sums;
    for_each_at(
        block, q, order,
        [&](Index i, const Shape::NodeMatrix& positions, const auto& m, Index batch, int lane) {
          if (!element_admissible<Shape>(rest.point(i), m, positions)) {
            sums.admissible = false;
            return;
          }
          const Shape::NodeMatrix g = local(i, positions, m, sums.energy);
          if (gradients == nullptr) return;
          for (int a = 0; a < Shape::kNodes; ++a) {
            Eigen::Map<Vector3>(gradients + blocks.slot(batch, a, lane)) += g.col(a);
          }
        });
    return sums;
  }

  // Computes the energies of all blocks and, if `with_gradient` is true, the records of their
  // gradients, with tensions of the lanes unless they are null. Returns whether the energy is defined
  // in all elements.
  bool run_blocks(const Positions& q, bool with_gradient, const double* tensions = nullptr) {
    return run_blocks(
        blocks.block_count(), [](Index i) { return i; }, q, with_gradient, tensions);
  }

  // The blocks block_at(i) for i < count.
  template <class BlockAt>
  bool run_blocks(Index count, const BlockAt& block_at, const Positions& q, bool with_gradient,
                  const double* tensions) {
    if (with_gradient)
      records.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()));
    std::atomic<bool> admissible{true};
    parallel_for(count, 1, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        const Index b = block_at(i);
        const ElementBlocks::Block& block = blocks.block(b);
        const BlockSums sums =
            with_gradient
                ? blocks.sum_local(
                      block, records.data() + ElementBlocks::kRecordSize * block.first_record,
                      [&](double* gradients) { return run_block(b, q, gradients, tensions); })
                : run_block(b, q, nullptr, nullptr);
        energies[static_cast<std::size_t>(b)] = sums.energy;
        if (!sums.admissible) admissible = false;
      }
    });
    return admissible;
  }

  // Whether the kernels are too inaccurate for the shapes of the block's elements. The kernels work
  // on edges. Their round-off in det F grows with the square of the aspect ratio, and that of the
  // metric terms of Saint Venant–Kirchhoff and Mooney–Rivlin with its cube. The loop over single
  // elements works on F, and its round-off grows with the ratio itself. The difference matters to
  // callers that give positions as a sum for the sake of accuracy.
  static bool loses_digits(const ElementBlocks::Block& block, const IsotropicModel& model) {
    const bool has_metric = has(tangent_form(model, false), TangentForm::kMetric);
    return block.aspect > (has_metric ? 12.0 : 50.0);
  }

  BlockSums run_block(Index b, const Positions& q, double* gradients,
                      const double* tensions) const {
    const ElementBlocks::Block& block = blocks.block(b);
    const std::optional<IsotropicModel> model = isotropic_model(field(block).model());
    const bool is_scalar = !model || (q.displacement() != nullptr && loses_digits(block, *model));
    BlockSums sums;
    if (is_scalar) {
      sums =
          scalar_block(block, q, gradients, gradients == nullptr ? Order::kEnergy : Order::kStress,
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

  void add_block_hessian(Index b, const Positions& q, const double* tensions,
                         const SparsityPattern& pattern, double* values) const {
    const ElementBlocks::Block& block = blocks.block(b);
    const std::optional<IsotropicModel> model = isotropic_model(field(block).model());
    if (!model) {
      // The points of an element follow one another.
      const int points = rest.points_per_element();
      ElementMatrix sum =
          ElementMatrix::Zero(3 * rest.nodes_per_element(), 3 * rest.nodes_per_element());
      for_each_at(block, q, Order::kStiffness,
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

  // See ElasticPotential::element_terms().
  bool element_terms(Index e, const Positions& q, bool with_hessian, ElementTerms& terms) const {
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

  double total_energy() const {
    double sum = 0.0;
    for (const double energy : energies) sum += energy;
    return sum;
  }

  EvaluationStatus value_and_gradient(const Positions& q, const double* tensions, double& energy,
                                      Vector& gradient) {
    if (!run_blocks(q, true, tensions)) return failure(q);
    energy = total_energy();
    blocks.sum_records(records, gradient);
    return {};
  }

  const BlockLists& lists_for(const MeshPart& part) {
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

  EvaluationStatus value_and_gradient(const Positions& q, const MeshPart& part, double& energy,
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

  // Finds the first element where the energy is not defined, after a block reported that there is
  // one.
  EvaluationStatus failure(const Positions& q) const {
    const EvaluationStatus found =
        for_each_admissible(q, Order::kAdmissible, [](Index, const auto&, const auto&) {});
    // If J is zero up to round-off, this loop may find no failure although the kernels found one.
    return found.ok() ? EvaluationStatus{0} : found;
  }
};

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
  return impl_->for_each_admissible(q, Order::kAdmissible, [](Index, const auto&, const auto&) {});
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
        s.scalar_block(block, q, local_records, Order::kStiffness,
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
  densities.setZero(impl_->rest.point_count());
  impl_->for_each_admissible(
      q, Order::kEnergy, [&](Index i, const Shape::NodeMatrix& local, const auto& material) {
        densities[i] =
            material.energy_density(deformation_gradient(impl_->rest.point(i), 0, local));
      });
}

Matrix3 ElasticPotential::first_piola(Index point, const Vector& q) const {
  const RestState& rest = impl_->rest;
  return impl_->with_material_of_point(point, [&](const auto& material) -> Matrix3 {
    return material.first_piola(deformation_gradient(rest.point(point), 0, rest.gather(q, point)));
  });
}

}  // namespace tetraction
