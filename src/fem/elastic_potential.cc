#include "tetraction/fem/elastic_potential.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>
#include <variant>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Elements worth a task of their own.
constexpr Index kGrain = 512;

constexpr Index kNone = std::numeric_limits<Index>::max();

// Keeps the least element number that failed, whichever thread finds it.
class FirstFailure {
 public:
  void note(Index e) {
    Index seen = first_.load(std::memory_order_relaxed);
    while (e < seen && !first_.compare_exchange_weak(seen, e, std::memory_order_relaxed)) {
    }
  }
  Evaluation result() const {
    const Index first = first_.load();
    return first == kNone ? Evaluation{} : Evaluation{first};
  }

 private:
  std::atomic<Index> first_{kNone};
};

}  // namespace

struct ElasticPotential::Impl {
  const RestState& rest;
  std::vector<MaterialModel> materials;
  std::vector<int> material_of_element;      // empty: one material everywhere
  std::vector<std::vector<Index>> elements;  // of each material; empty: one material everywhere
  std::vector<double> energies;              // per element
  std::vector<Shape::NodeMatrix> gradients;  // per element

  Impl(const RestState& rest_state, std::vector<MaterialModel> models,
       std::vector<int> index_of_element)
      : rest(rest_state),
        materials(std::move(models)),
        material_of_element(std::move(index_of_element)),
        energies(static_cast<std::size_t>(rest.element_count())),
        gradients(static_cast<std::size_t>(rest.element_count())) {
    if (materials.size() < 2) {
      material_of_element.clear();
      return;
    }
    elements.resize(materials.size());
    for (std::size_t e = 0; e < material_of_element.size(); ++e) {
      elements[static_cast<std::size_t>(material_of_element[e])].push_back(static_cast<Index>(e));
    }
  }

  const MaterialModel& material(Index e) const {
    return materials[material_of_element.empty()
                         ? 0
                         : static_cast<std::size_t>(
                               material_of_element[static_cast<std::size_t>(e)])];
  }

  // Runs body(element, material) over all elements; the material's type is resolved outside the
  // loop.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t m = 0; m < materials.size(); ++m) {
      const bool all = elements.empty();
      const Index count = all ? rest.element_count() : static_cast<Index>(elements[m].size());
      std::visit(
          [&](const auto& material) {
            parallel_for(count, kGrain, [&](Index begin, Index end) {
              for (Index i = begin; i < end; ++i) {
                body(all ? i : elements[m][static_cast<std::size_t>(i)], material);
              }
            });
          },
          materials[m]);
    }
  }

  // Runs body(element, element positions, material) over all elements where the energy is defined.
  template <class Body>
  Evaluation for_each_admissible(const Vector& q, const Body& body) const {
    FirstFailure failure;
    for_each([&](Index e, const auto& m) {
      const Shape::NodeMatrix local = rest.gather(q, e);
      if (element_admissible<Shape>(rest.element(e), m, local)) {
        body(e, local, m);
      } else {
        failure.note(e);
      }
    });
    return failure.result();
  }

  double total_energy() const {
    return parallel_sum(rest.element_count(), [&](Index begin, Index end) {
      double sum = 0.0;
      for (Index e = begin; e < end; ++e) sum += energies[static_cast<std::size_t>(e)];
      return sum;
    });
  }
};

ElasticPotential::ElasticPotential(const RestState& rest, const MaterialModel& material)
    : ElasticPotential(rest, std::vector<MaterialModel>{material}, {}) {}
ElasticPotential::ElasticPotential(const RestState& rest, std::vector<MaterialModel> materials,
                                   std::vector<int> material_of_element)
    : impl_(std::make_unique<Impl>(rest, std::move(materials), std::move(material_of_element))) {}
ElasticPotential::~ElasticPotential() = default;
ElasticPotential::ElasticPotential(ElasticPotential&&) noexcept = default;

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

Evaluation ElasticPotential::admissible(const Vector& q) const {
  return impl_->for_each_admissible(q, [](Index, const auto&, const auto&) {});
}

Evaluation ElasticPotential::value(const Vector& q, double& energy) const {
  const Evaluation status = impl_->for_each_admissible(
      q, [this](Index e, const Shape::NodeMatrix& local, const auto& material) {
        impl_->energies[static_cast<std::size_t>(e)] =
            element_energy<Shape>(impl_->rest.element(e), material, local);
      });
  if (status.ok()) energy = impl_->total_energy();
  return status;
}

Evaluation ElasticPotential::value_and_gradient(const Vector& q, double& energy,
                                                Vector& gradient) const {
  const Evaluation status = impl_->for_each_admissible(
      q, [this](Index e, const Shape::NodeMatrix& local, const auto& material) {
        const auto& rest = impl_->rest.element(e);
        impl_->energies[static_cast<std::size_t>(e)] = element_energy<Shape>(rest, material, local);
        impl_->gradients[static_cast<std::size_t>(e)] =
            element_gradient<Shape>(rest, material, local);
      });
  if (!status.ok()) return status;
  energy = impl_->total_energy();
  gradient.setZero(3 * impl_->rest.vertex_count());
  impl_->rest.add_gathered(impl_->gradients, gradient);
  return status;
}

Evaluation ElasticPotential::add_hessian(const Vector& q, const SparsityPattern& pattern,
                                         double* values) const {
  FirstFailure failure;
  for (const std::vector<Index>& color : pattern.colors()) {
    parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        const Index e = color[static_cast<std::size_t>(i)];
        const Shape::NodeMatrix local = impl_->rest.gather(q, e);
        const auto& rest = impl_->rest.element(e);
        std::visit(
            [&](const auto& material) {
              if (element_admissible<Shape>(rest, material, local)) {
                pattern.scatter(e, element_hessian<Shape>(rest, material, local), values);
              } else {
                failure.note(e);
              }
            },
            impl_->material(e));
      }
    });
  }
  return failure.result();
}

void ElasticPotential::product(const Vector& q, const Vector& x, Vector& result) const {
  impl_->for_each([&](Index e, const auto& material) {
    impl_->gradients[static_cast<std::size_t>(e)] = element_product<Shape>(
        impl_->rest.element(e), material, impl_->rest.gather(q, e), impl_->rest.gather(x, e));
  });
  result.setZero(3 * impl_->rest.vertex_count());
  impl_->rest.add_gathered(impl_->gradients, result);
}

Vector ElasticPotential::energies_by_material(const Vector& q) const {
  Vector sums = Vector::Zero(static_cast<Index>(impl_->materials.size()));
  double total = 0.0;
  if (!value(q, total).ok()) return sums;
  for (Index e = 0; e < impl_->rest.element_count(); ++e) {
    sums[material_index(e)] += impl_->energies[static_cast<std::size_t>(e)];
  }
  return sums;
}

bool ElasticPotential::element_terms(Index e, const Vector& q, bool with_hessian,
                                     ElementTerms& terms) const {
  return std::visit(
      [&](const auto& material) {
        const Shape::NodeMatrix local = impl_->rest.gather(q, e);
        const auto& rest = impl_->rest.element(e);
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
