// Loops over the vertices in explicit steps, compiled for several instruction sets.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The change of the momenta of free vertices within dt: p += dt (f + m a − ∇W).
struct VertexKick {
  const double* mass = nullptr;            ///< per vertex, kg
  const double* inverse_mass = nullptr;    ///< per vertex, 1/kg
  const double* gradient = nullptr;        ///< ∇W, 3 per vertex, N
  const double* force = nullptr;           ///< f, 3 per vertex, N; null: none
  Vector3 acceleration = Vector3::Zero();  ///< a, m/s²
  double dt = 0.0;
};

/// p_out = p + kick, v_out = p_out/m, q_out = q + h v_out of the vertices in [begin, end). Returns
/// whether all new positions are finite.
bool kick_and_drift(Index begin, Index end, const VertexKick& kick, double h, const double* q,
                    const double* p, double* p_out, double* v_out, double* q_out);

/// p += kick of the vertices in [begin, end). Returns whether all new momenta are finite.
bool kick_only(Index begin, Index end, const VertexKick& kick, double* p);

/// Sums over vertices.
struct VertexSums {
  Vector3 linear = Vector3::Zero();        ///< Σ p
  Vector3 angular = Vector3::Zero();       ///< Σ q × p
  double linear_scale = 0.0;               ///< Σ |p|
  double angular_scale = 0.0;              ///< Σ |q × p|
  double twice_kinetic = 0.0;              ///< Σ |p|²/m
  Vector3 first_moment = Vector3::Zero();  ///< Σ m q

  VertexSums& operator+=(const VertexSums& other);

  /// The sums as numbers, for sums over the parts of a body.
  static constexpr std::size_t kCount = 12;
  void put(double* values) const;
  void take(const double* values);
};

VertexSums vertex_sums(Index begin, Index end, const double* mass, const double* inverse_mass,
                       const double* q, const double* p);

}  // namespace tetraction
