#include "tetraction/fem/elastic_potential.h"

#include <algorithm>
#include <atomic>
#include <limits>
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
  MaterialModel material;
  std::vector<double> energies;              // per element
  std::vector<Shape::NodeMatrix> gradients;  // per element

  Impl(const RestState& rest_state, const MaterialModel& model)
      : rest(rest_state),
        material(model),
        energies(static_cast<std::size_t>(rest.element_count())),
        gradients(static_cast<std::size_t>(rest.element_count())) {}

  // Runs body(element, element positions, material) over all elements where the energy is defined.
  template <class Body>
  Evaluation for_each_admissible(const Vector& q, const Body& body) const {
    FirstFailure failure;
    std::visit(
        [&](const auto& m) {
          parallel_for(rest.element_count(), kGrain, [&](Index begin, Index end) {
            for (Index e = begin; e < end; ++e) {
              const Shape::NodeMatrix local = rest.gather(q, e);
              if (element_admissible<Shape>(rest.element(e), m, local)) {
                body(e, local, m);
              } else {
                failure.note(e);
              }
            }
          });
        },
        material);
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
    : impl_(std::make_unique<Impl>(rest, material)) {}
ElasticPotential::~ElasticPotential() = default;
ElasticPotential::ElasticPotential(ElasticPotential&&) noexcept = default;

const RestState& ElasticPotential::rest() const {
  return impl_->rest;
}
const MaterialModel& ElasticPotential::material() const {
  return impl_->material;
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
  std::visit(
      [&](const auto& material) {
        for (const std::vector<Index>& color : pattern.colors()) {
          parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
            for (Index i = begin; i < end; ++i) {
              const Index e = color[static_cast<std::size_t>(i)];
              const Shape::NodeMatrix local = impl_->rest.gather(q, e);
              const auto& rest = impl_->rest.element(e);
              if (element_admissible<Shape>(rest, material, local)) {
                pattern.scatter(e, element_hessian<Shape>(rest, material, local), values);
              } else {
                failure.note(e);
              }
            }
          });
        }
      },
      impl_->material);
  return failure.result();
}

void ElasticPotential::product(const Vector& q, const Vector& x, Vector& result) const {
  std::visit(
      [&](const auto& material) {
        parallel_for(impl_->rest.element_count(), kGrain, [&](Index begin, Index end) {
          for (Index e = begin; e < end; ++e) {
            impl_->gradients[static_cast<std::size_t>(e)] =
                element_product<Shape>(impl_->rest.element(e), material, impl_->rest.gather(q, e),
                                       impl_->rest.gather(x, e));
          }
        });
      },
      impl_->material);
  result.setZero(3 * impl_->rest.vertex_count());
  impl_->rest.add_gathered(impl_->gradients, result);
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
      impl_->material);
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
      impl_->material);
}

}  // namespace tetraction
