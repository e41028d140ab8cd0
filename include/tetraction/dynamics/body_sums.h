// Sums over a body and over what acts on it: energies, momenta, the centre of mass. In several processes they are
// those of the whole body where a comment does not say otherwise.
#pragma once

#include <vector>

#include "tetraction/dynamics/energies.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Linear and angular momentum about the origin, and the sums of magnitudes to which drifts are
/// relative.
struct Momenta {
  Vector3 linear = Vector3::Zero();   ///< Σ p, kg m/s
  Vector3 angular = Vector3::Zero();  ///< Σ q × p, kg m²/s
  double linear_scale = 0.0;          ///< Σ |p|
  double angular_scale = 0.0;         ///< Σ |q × p|
};

/// Mass-weighted mean of positions, m.
Vector3 center_of_mass(const Body& body, const Vector& q);
/// Σ m q over the own vertices of a part, kg m; of a whole mesh, over all.
Vector3 own_first_moment(const Body& body, const Vector& q);
/// ½ Σ |p|²/m, J.
double kinetic_energy(const Body& body, const Vector& momentum);
/// ½ Σ m_r|p/m|² of each region, with m_r the region's share in the mass of a vertex, J.
Vector kinetic_energies_by_region(const Body& body, const Vector& momentum);
Momenta momenta_of(const Body& body, const State& state);

/// energies = those of all accounts. Fails where the elastic energy is not defined.
EvaluationStatus evaluate_energies(const MechanicalSystem& system, const State& state,
                                   Energies& energies);
/// Kinetic energy, the energies of all terms and the momenta; the elastic energy is left alone. `springs` ←
/// the sum of the magnitudes of the energies of terms that stand for constraints, J. `sums`: what
/// the balance_shares() of all parts add up to, if that is known already.
void vertex_balance(const MechanicalSystem& system, const State& state, Energies& energies,
                    Momenta& momenta, double& springs, const std::vector<double>& sums = {});
/// The share of this part of the body in the numbers of vertex_balance(), for a sum over all parts.
std::vector<double> balance_shares(const MechanicalSystem& system, const State& state);
/// The number of these numbers, the same in all parts.
std::size_t balance_share_count(const MechanicalSystem& system);

/// The number of vertices of the body.
Index global_vertex_count(const MechanicalSystem& system);
/// The number of tetrahedra of the body.
Index global_tetrahedron_count(const MechanicalSystem& system);
/// The number of free coordinates of the body (FreeCoordinates::count()).
Index global_freedom_count(const MechanicalSystem& system);
/// The sum of a field (3 per vertex) over the vertices of the body.
Vector3 global_resultant(const MechanicalSystem& system, const Vector& field);

/// The number of free coordinates of the own vertices. They come first.
Index own_freedom_count(const MechanicalSystem& system);
/// a·b over the own vertices (3 per vertex), also of expressions.
template <class A, class B>
double own_dot(const MechanicalSystem& system, const Eigen::MatrixBase<A>& a,
               const Eigen::MatrixBase<B>& b) {
  if (system.part() == nullptr) return a.dot(b);
  const Index size = 3 * system.owned_vertex_count();
  return a.head(size).dot(b.head(size));
}

}  // namespace tetraction
