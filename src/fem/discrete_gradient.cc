#include "discrete_gradient.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "discrete_stress.h"
#include "element_fields.h"
#include "isotropic_model.h"
#include "kernels/discrete_gradient_kernels.h"
#include "kernels/jacobian_kernels.h"
#include "material_at.h"
#include "tetraction/core/parallel.h"
#include "tetraction/material/custom_material.h"

namespace tetraction {
namespace {

// The kernels work on the metric of the edges, whose round-off grows with the cube of the aspect ratio.
constexpr double kLargestAspect = 12.0;

// Stands for a BatchMaterial in computations that ask for its values one by one. The computations are made
// twice. The first time the deformation gradients are noted and all values are zero. After evaluate() the
// same computations in the same order get the right values. It must not depend on values at which deformation
// gradients they ask.
class CollectedValues {
 public:
  // Keeps a reference to `material`, which must live longer.
  explicit CollectedValues(const CustomMaterial& material) : material_(material) {}

  // Where the values are that are noted from now on. For a PlacedMaterial.
  void go_to(const MaterialPlace& place) { place_ = place; }

  double energy_density(const Matrix3& f) const { return next(energies_, f, 0.0); }
  Matrix3 first_piola(const Matrix3& f) const {
    return next(stresses_, f, Matrix3(Matrix3::Zero()));
  }
  Matrix9 stiffness(const Matrix3& f) const {
    return next(stiffnesses_, f, Matrix9(Matrix9::Zero()));
  }
  // Whether the energy is defined is to be found out before.
  static bool admissible(const Matrix3&) { return true; }
  LameParameters initial_lame() const { return material_.initial_lame(); }

  void evaluate() {
    energies_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, values, {}, {}, places});
    });
    stresses_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, values, {}, places});
    });
    stiffnesses_.evaluate([&](const auto& f, const auto& places, auto& flags, auto& values) {
      material_.evaluate({f, flags, {}, {}, values, places});
    });
  }

 private:
  template <class Value>
  struct List {
    std::vector<Matrix3> f;
    std::vector<MaterialPlace> places;
    std::vector<Value> values;
    std::size_t position = 0;

    template <class Call>
    void evaluate(const Call& call) {
      if (f.empty()) return;
      std::vector<char> admissible(f.size(), 0);
      std::vector<Value> computed(f.size());
      call(f, places, admissible, computed);
      values = std::move(computed);
    }
  };

  template <class Value>
  Value next(List<Value>& list, const Matrix3& f, const Value& zero) const {
    if (!list.values.empty()) return list.values[list.position++];
    list.f.push_back(f);
    if (material_.has_places()) list.places.push_back(place_);
    return zero;
  }

  const CustomMaterial& material_;
  MaterialPlace place_;
  mutable List<double> energies_;
  mutable List<Matrix3> stresses_;
  mutable List<Matrix9> stiffnesses_;
};

}  // namespace

DiscreteGradient::DiscreteGradient(const ElasticPotential& elastic)
    : elastic_(elastic), blocks_(BlockAccess::blocks(elastic)) {
  for (Index b = 0; b < blocks_.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    double largest = 0.0;
    blocks_.for_each_element(block, [&](Index e, Index, int) {
      const LameParameters lame = elastic.lame(e);
      largest = std::max(largest, lame.lambda + 2.0 * lame.mu);
    });
    moduli_.push_back(largest);
  }
}

bool DiscreteGradient::all_blocks(const std::function<bool(Index)>& holds) const {
  std::atomic<bool> all{true};
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end && all; ++b) {
      if (!holds(b)) all = false;
    }
  });
  return all;
}

bool DiscreteGradient::way_keeps_volumes(const Vector& q, const Vector& d) const {
  return all_blocks([&](Index b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    thread_local AlignedVector<double> from;
    thread_local AlignedVector<double> way;
    from.resize(ElementBlocks::local_size(block));
    way.resize(from.size());
    blocks_.load_records(block, q.data(), from.data());
    blocks_.load_displacements(block, d.data(), way.data());
    return tetraction::way_keeps_volumes(blocks_.batches(block), from.data(), way.data());
  });
}

bool DiscreteGradient::deforms_more(const Vector& d, double most, double limit) const {
  return !all_blocks([&](Index b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    thread_local AlignedVector<double> displacements;
    displacements.resize(ElementBlocks::local_size(block));
    blocks_.load_displacements(block, d.data(), displacements.data());
    const LargestChanges found = largest_changes(blocks_.batches(block), displacements.data());
    return found.square <= most * most &&
           moduli_[static_cast<std::size_t>(b)] * found.square_by_lengths <= limit;
  });
}

EvaluationStatus DiscreteGradient::add(const Step& step, Vector& gradient) const {
  if (!run(step, nullptr)) {
    // The first element that is not admissible at the end of the step.
    Vector end = step.middle.origin() + step.half_step;
    if (step.middle.displacement() != nullptr) end += *step.middle.displacement();
    const EvaluationStatus found = elastic_.admissible(end);
    return found.ok() ? EvaluationStatus{0} : found;
  }
  blocks_.add_record_sums(records_, gradient);
  return {};
}

void DiscreteGradient::add_product(const Step& step, const Vector& d, Vector& product) const {
  run(step, &d);
  blocks_.add_record_sums(records_, product);
}

bool DiscreteGradient::run(const Step& step, const Vector* direction) const {
  records_.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks_.record_count()));
  std::atomic<bool> admissible{true};
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      double* records = records_.data() + ElementBlocks::kRecordSize * block.first_record;
      if (!blocks_.sum_local(block, records,
                             [&](double* local) { return run_block(b, step, direction, local); })) {
        admissible = false;
      }
    }
  });
  return admissible;
}

bool DiscreteGradient::run_block(Index b, const Step& step, const Vector* direction,
                                 double* records) const {
  const ElementBlocks::Block& block = blocks_.block(b);
  const MaterialField& material = elastic_.materials()[static_cast<std::size_t>(block.material)];
  const std::optional<IsotropicModel> model = isotropic_model(material.model());
  if (model && block.aspect <= kLargestAspect) {
    thread_local AlignedVector<double> fields[4];
    for (AlignedVector<double>& field : fields) {
      field.resize(ElementBlocks::local_size(block));
    }
    StepRecords at;
    at.viscous = step.viscous;
    blocks_.load_records(block, step.middle.origin().data(), fields[0].data());
    at.positions = fields[0].data();
    if (step.middle.displacement() != nullptr) {
      blocks_.load_displacements(block, step.middle.displacement()->data(), fields[1].data());
    } else {
      std::fill(fields[1].begin(), fields[1].end(), 0.0);
    }
    at.displacements = fields[1].data();
    blocks_.load_displacements(block, step.half_step.data(), fields[2].data());
    at.half_steps = fields[2].data();
    if (direction == nullptr) {
      return add_discrete_gradient(BlockAccess::batches(elastic_, b), *model, at, records);
    }
    blocks_.load_displacements(block, direction->data(), fields[3].data());
    add_discrete_gradient_product(BlockAccess::batches(elastic_, b), *model, at, fields[3].data(),
                                  records);
    return true;
  }

  bool admissible = true;
  const RestState& rest = elastic_.rest();
  const auto gradient_of = [&](const Positions& field, Index i) {
    return deformation_gradient(rest, field, i);
  };
  const auto deformation_at = [&](Index i) {
    return DeformationStep{gradient_of(step.middle, i), gradient_of(step.half_step, i),
                           step.viscous};
  };
  // P̄, or its derivative in the direction.
  const auto stress_at = [&](Index i, const auto& m,
                             const DeformationStep& deformation) -> Matrix3 {
    const MeanStress mean(m, deformation);
    return direction == nullptr ? mean.first_piola() : mean.derivative(gradient_of(*direction, i));
  };
  const auto add_forces = [&](Index i, const Matrix3& p, Index batch, int lane) {
    const auto point = rest.point(i);
    const RestState::Shape::NodeMatrix forces = point.weights[0] * p * point.gradients[0];
    for (int a = 0; a < RestState::Shape::kNodes; ++a) {
      Eigen::Map<Vector3>(records + blocks_.slot(batch, a, lane)) += forces.col(a);
    }
  };
  const auto* custom = std::get_if<CustomMaterial>(&material.model());
  if (custom != nullptr && custom->has_batches()) {
    std::vector<Matrix3> ends;
    std::vector<MaterialPlace> places;  // only for materials that need them
    blocks_.for_each_point(block, [&](Index i, Index, int) {
      ends.push_back(deformation_at(i).end());
      if (custom->has_places()) places.push_back(place_of(rest, i));
    });
    std::vector<char> is_admissible(ends.size(), 0);
    custom->evaluate({ends, is_admissible, {}, {}, {}, places});
    if (std::count(is_admissible.begin(), is_admissible.end(), 0) > 0) return false;
    CollectedValues values(*custom);
    std::size_t next = 0;
    blocks_.for_each_point(block, [&](Index i, Index, int) {
      if (!places.empty()) values.go_to(places[next++]);
      stress_at(i, values, deformation_at(i));
    });
    values.evaluate();
    blocks_.for_each_point(block, [&](Index i, Index batch, int lane) {
      add_forces(i, stress_at(i, values, deformation_at(i)), batch, lane);
    });
    return true;
  }
  const auto add = [&](Index i, const auto& m, Index batch, int lane) {
    const DeformationStep deformation = deformation_at(i);
    if (!m.admissible(deformation.end())) {
      admissible = false;
      return;
    }
    add_forces(i, stress_at(i, m, deformation), batch, lane);
  };
  std::visit(
      [&](const auto& m) {
        blocks_.for_each_point(block, [&](Index i, Index batch, int lane) {
          with_material_at(material, m, rest, i,
                           [&](const auto& own) { add(i, own, batch, lane); });
        });
      },
      material.model());
  return admissible;
}

}  // namespace tetraction
