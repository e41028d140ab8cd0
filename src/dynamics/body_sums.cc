#include "tetraction/dynamics/body_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "dynamics/terms/vertex_kernels.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/derived_fields.h"

namespace tetraction {
namespace {

// The sums over the own vertices, in an order that does not depend on the number of threads.
VertexSums own_sums(const Body& body, const Vector& q, const Vector& p) {
  constexpr Index kRange = 2048;
  const Index count = body.owned_vertex_count();
  const Index ranges = (count + kRange - 1) / kRange;
  std::vector<VertexSums> parts(static_cast<std::size_t>(ranges));
  parallel_for(ranges, 1, [&](Index begin, Index end) {
    for (Index r = begin; r < end; ++r) {
      parts[static_cast<std::size_t>(r)] =
          vertex_sums(r * kRange, std::min(count, (r + 1) * kRange), body.mass().data(),
                      body.inverse_mass().data(), q.data(), p.data());
    }
  });
  VertexSums total;
  for (const VertexSums& part : parts) total += part;
  return total;
}

VertexSums sums(const Body& body, const Vector& q, const Vector& p) {
  VertexSums total = own_sums(body, q, p);
  if (body.part() == nullptr) return total;
  std::array<double, VertexSums::kCount> values{};
  total.put(values.data());
  body.part()->sum(values.data(), VertexSums::kCount);
  total.take(values.data());
  return total;
}

double spring_energies(const MechanicalSystem& system, const State& state) {
  double sum = 0.0;
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->account() != EnergyAccount::kConstraintWork) continue;
    sum += std::abs(term->energy(system.energy_point(state.position, state.time)));
  }
  return sum;
}

}  // namespace

Vector3 center_of_mass(const Body& body, const Vector& q) {
  return sums(body, q, q).first_moment / body.total_mass();
}

Vector3 own_first_moment(const Body& body, const Vector& q) {
  return own_sums(body, q, q).first_moment;
}

double kinetic_energy(const Body& body, const Vector& momentum) {
  return 0.5 * sums(body, momentum, momentum).twice_kinetic;
}

Vector kinetic_energies_by_region(const Body& body, const Vector& momentum) {
  Vector energies = Vector::Zero(body.region_count());
  for (Index e = 0; e < body.rest().element_count(); ++e) {
    int a = 0;
    for (const Index v : body.rest().nodes(e)) {
      energies[body.region(e)] += 0.5 * body.mass_share(e, a++) *
                                  (vertex_block(momentum, v) / body.mass()[v]).squaredNorm();
    }
  }
  sum_over_parts(body.part(), energies.data(), energies.size());
  return energies;
}

EvaluationStatus evaluate_energies(const MechanicalSystem& system, const State& state,
                                   Energies& energies) {
  Momenta ignored;
  double springs = 0.0;
  vertex_balance(system, state, energies, ignored, springs);
  double elastic = 0.0;
  EvaluationStatus status = system.elastic_energy(state.position, elastic);
  elastic = sum_over_parts(system.part(), elastic);
  energies.set_elastic(elastic);
  if (!everywhere(system.part(), status.ok()) && status.ok()) status.failed_element = 0;
  return status;
}

Momenta momenta_of(const Body& body, const State& state) {
  const VertexSums total = sums(body, state.position, state.momentum);
  return {total.linear, total.angular, total.linear_scale, total.angular_scale};
}

std::size_t balance_share_count(const MechanicalSystem& system) {
  std::size_t count = VertexSums::kCount + 1;
  for (const ForceTerm* term : system.force_terms()) {
    if (term->account() == EnergyAccount::kStored && term->has_potential()) ++count;
  }
  return count;
}

// The sums over vertices, the energies of the terms, and at the end those of springs, of which a part may have none.
std::vector<double> balance_shares(const MechanicalSystem& system, const State& state) {
  std::vector<double> own(VertexSums::kCount, 0.0);
  own_sums(system, state.position, state.momentum).put(own.data());
  for (const ForceTerm* term : system.force_terms()) {
    if (term->account() != EnergyAccount::kStored || !term->has_potential()) continue;
    own.push_back(term->energy(system.energy_point(state.position, state.time)));
  }
  own.push_back(spring_energies(system, state));
  return own;
}

void vertex_balance(const MechanicalSystem& system, const State& state, Energies& energies,
                    Momenta& momenta, double& springs, const std::vector<double>& sums) {
  VertexSums total;
  std::vector<double> own = sums;
  if (system.part() == nullptr) {
    total = own_sums(system, state.position, state.momentum);
    springs = spring_energies(system, state);
  } else {
    if (own.empty()) {
      own = balance_shares(system, state);
      system.part()->sum(own.data(), static_cast<Index>(own.size()));
    }
    total.take(own.data());
    springs = own.back();
  }
  std::size_t next = VertexSums::kCount;
  momenta = {total.linear, total.angular, total.linear_scale, total.angular_scale};
  energies.set_kinetic(0.5 * total.twice_kinetic);
  std::size_t extra = 0;
  for (const ForceTerm* term : system.force_terms()) {
    if (term->account() != EnergyAccount::kStored) continue;
    double energy = 0.0;
    const std::optional<Vector3> acceleration = term->uniform_acceleration();
    if (!own.empty()) {
      energy = term->has_potential() ? own[next++] : 0.0;
    } else if (acceleration && !system.has_consistent_weights()) {
      // A difference, as minus zero would be written where there is no energy.
      energy = 0.0 - acceleration->dot(total.first_moment);
    } else if (term->has_potential()) {
      energy = term->energy(system.force_point(state.position, state.time));
    }
    if (term == &system.environment()) {
      energies.set_environment(energy);
    } else {
      energies.set_extra(extra++, term->name(), energy);
    }
  }
}

Index global_vertex_count(const MechanicalSystem& system) {
  return system.part() != nullptr ? system.part()->whole.vertices : system.vertex_count();
}

Index global_tetrahedron_count(const MechanicalSystem& system) {
  return system.part() != nullptr ? system.part()->whole.tetrahedra
                                  : system.mesh().tetrahedron_count();
}

Index own_freedom_count(const MechanicalSystem& system) {
  if (system.part() == nullptr) return system.coordinates().count();
  Index own = 0;
  for (Index v = 0; v < system.owned_vertex_count(); ++v) {
    own += system.coordinates().is_free(v) ? 3 : system.coordinates().map(v).count;
  }
  return own;
}

Index global_freedom_count(const MechanicalSystem& system) {
  return static_cast<Index>(
      sum_over_parts(system.part(), static_cast<double>(own_freedom_count(system))));
}

Vector3 global_resultant(const MechanicalSystem& system, const Vector& field) {
  if (system.part() == nullptr) return resultant(field);
  Vector3 sum = resultant(field.head(3 * system.owned_vertex_count()));
  system.part()->sum(sum.data(), 3);
  return sum;
}

}  // namespace tetraction
