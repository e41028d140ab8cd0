// The implementation of ElasticPotential: its data, and its loops over blocks of elements.
#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "element_blocks.h"
#include "material_at.h"
#include "tetraction/core/parallel.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

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
  static constexpr Index kNone = std::numeric_limits<Index>::max();

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

// The values that are asked of a material.
enum class MaterialOrder { kAdmissible, kEnergy, kStress, kStiffness };

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

  void evaluate(const CustomMaterial& material, MaterialOrder order) {
    admissible.assign(f.size(), 0);
    energy.resize(order >= MaterialOrder::kEnergy ? f.size() : 0);
    stress.resize(order >= MaterialOrder::kStress ? f.size() : 0);
    stiffness.resize(order >= MaterialOrder::kStiffness ? f.size() : 0);
    material.evaluate({f, admissible, energy, stress, stiffness, places});
  }
  Evaluated at(std::size_t k) const {
    return {admissible[k] != 0, energy.empty() ? 0.0 : energy[k],
            stress.empty() ? nullptr : &stress[k], stiffness.empty() ? nullptr : &stiffness[k]};
  }
};

// Whether the kernels are too inaccurate for the shapes of the block's elements. The kernels work
// on edges. Their round-off in det F grows with the square of the aspect ratio, and that of the
// metric terms of Saint Venant–Kirchhoff, Mooney–Rivlin and Ogden with its cube. The loop over single
// elements works on F, and its round-off grows with the ratio itself. The difference matters where
// small strains are computed from positions that are given as a sum, and to stresses.
bool loses_digits(const ElementBlocks::Block& block, const IsotropicModel& model);

// The blocks that have shared vertices of a part of a body, and the other ones.
struct BlockLists {
  std::vector<Index> outer;
  std::vector<Index> inner;
};

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
       std::vector<int> index_of_element);

  // (V Σ_a |∇N_a|²)² of a point, m².
  double shape_squared(Index i) const;
  // The square of the longest rest edge of a point, m².
  double longest_edge(Index i) const;

  // Prepares the blocks of a material after it has changed.
  void take_parameters(std::size_t m);

  // Throws InputError if the energy of a PlacedMaterial is not defined somewhere at rest.
  void require_defined_at_rest(std::size_t m) const;

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
  void for_each_at(const ElementBlocks::Block& block, const Positions& q, MaterialOrder order,
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
  EvaluationStatus for_each_admissible(const Positions& q, MaterialOrder order,
                                       const Body& body) const {
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
                         MaterialOrder order, const Local& local) const {
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

  BlockSums run_block(Index b, const Positions& q, double* gradients, const double* tensions) const;

  void add_block_hessian(Index b, const Positions& q, const double* tensions,
                         const SparsityPattern& pattern, double* values) const;

  // See ElasticPotential::element_terms().
  bool element_terms(Index e, const Positions& q, bool with_hessian, ElementTerms& terms) const;

  double total_energy() const {
    double sum = 0.0;
    for (const double energy : energies) sum += energy;
    return sum;
  }

  EvaluationStatus value_and_gradient(const Positions& q, const double* tensions, double& energy,
                                      Vector& gradient);

  const BlockLists& lists_for(const MeshPart& part);

  EvaluationStatus value_and_gradient(const Positions& q, const MeshPart& part, double& energy,
                                      Vector& gradient);

  // Finds the first element where the energy is not defined, after a block reported that there is
  // one.
  EvaluationStatus failure(const Positions& q) const;
};

}  // namespace tetraction
