// Contact of a body with rigid obstacles.
#pragma once

#include <memory>
#include <vector>

#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

class ExplicitFriction;
class FrictionStep;

/// The contact of a body with all of its obstacles, as a potential that keeps them apart:
///
///     U(x) = Σ w_v U_b(d(x_v))
///
/// over vertices of the surface and obstacles, with the distance d, the barrier U_b (contact/barrier.h) and the
/// area w_v of the vertex: a third of the rest areas of the faces around it. A uniform pressure on a flat face of
/// linear tetrahedra is then −U_b′ exactly. In faces of quadratic tetrahedra the middles of the edges have the areas,
/// because the consistent weights of the corners are zero; the corners have a small share, which keeps them
/// out.
///
/// U is infinite where a vertex penetrates. No step may end there. Steps that take a mean of forces
/// (`energy-momentum`, and `midpoint`, for contact only) take a discrete gradient, so that U(q_{k+1}) is
/// part of the balance and cannot be jumped over.
///
/// The energy of the body contains U. Moving obstacles do work, driven_work(), which counts as
/// work of constraints. Friction is a FrictionStep (src/dynamics/contact/friction_step.h).
class Contact : public ForceTerm {
 public:
  /// Throws InputError, with the name of the obstacle, for numbers out of range, for a surface without
  /// faces, and for a face that the mesh does not have.
  Contact(const TetMesh& mesh, std::vector<Obstacle> obstacles);
  ~Contact() override;
  Contact(Contact&&) noexcept;
  Contact& operator=(Contact&&) noexcept;

  std::size_t size() const;
  const Obstacle& obstacle(std::size_t i) const;
  bool has_friction() const;
  /// The vertices that may touch an obstacle, ascending.
  std::vector<Index> vertices() const;
  /// Whether an obstacle moves.
  bool moves() const;

  std::string name() const override { return "contact"; }
  bool has_potential() const override { return true; }
  bool couples_vertices() const override;
  bool couples_only_neighbors() const override { return true; }
  Index undefined_vertex(const ForcePoint& at) const override;
  double longest_step(const ForcePoint& from, const Vector& displacement) const override;
  double energy(const ForcePoint& at) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override;
  void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                             Vector& gradient) const override;
  /// hessian += ∂f̄/∂q_{k+1} of the discrete gradient f̄, N/m. With kConvex and `symmetric` it is a
  /// symmetric matrix near it.
  void add_discrete_hessian(const ForcePoint& from, const ForcePoint& to, HessianForm form,
                            bool symmetric, HessianBlocks& hessian) const;

  /// A vertex whose straight way between two states, seen from an obstacle, crosses the obstacle, or −1. Of faces
  /// and edges that cross it, it may be any vertex of the surface.
  Index crossing_vertex(const ForcePoint& from, const ForcePoint& to) const;
  /// Moves vertices of x, the positions at the end of a way that begins at `from`, so that the way crosses no
  /// obstacle. `to` has the time of x. Returns whether anything was moved.
  bool clear_way(const ForcePoint& from, const ForcePoint& to, Vector& x) const;

  /// hessian += a stiffness, N/m, in the directions in which obstacles support the surface where it touches them.
  void add_support(const ForcePoint& at, HessianBlocks& hessian) const;
  /// An estimate of the round-off of the forces' norm in double precision, N: that of the positions, times the
  /// stiffness of the layers.
  double round_off(const ForcePoint& at) const;
  /// The smallest distance between body and obstacles that is below a layer's thickness, m; infinite without one.
  double smallest_gap(const ForcePoint& at) const;
  /// Fields on all vertices: the pressure, Pa, and the distance to the nearest obstacle, m (infinite where no obstacle
  /// is near).
  void fields(const ForcePoint& at, Vector& pressure, Vector& gap) const;
  /// The force of each obstacle at an instant, without friction.
  std::vector<ObstacleForce> forces(const ForcePoint& at) const;
  /// The same as the means of a step, from the discrete gradient.
  std::vector<ObstacleForce> mean_forces(const ForcePoint& from, const ForcePoint& to) const;
  /// A vertex that penetrates an obstacle.
  struct Penetration {
    std::size_t obstacle;
    Index vertex;
    double depth;  ///< m; NaN where the obstacle has no inside
  };
  std::vector<Penetration> penetrations(const ForcePoint& at) const;
  /// The stability limit of explicit rules, s, for a body that hits the obstacles with its present velocities
  /// v (3 per vertex, m/s). `critical_step` is the limit of the body alone, and `impedance` ρc, Pa s/m. The
  /// pressure of the impact of a half-space, p = ρ c v, gives the stiffness k of the layers, and with the mass m of a
  /// vertex
  ///
  ///     h⁻² = h_body⁻² + k/(4m),   h ≤ d̂/(2v).
  double impact_limit(const ForcePoint& at, const Vector& v, double impedance,
                      double critical_step) const;

 private:
  friend class ExplicitFriction;
  friend class FrictionStep;
  struct Unit;
  std::vector<Unit> units_;
};

}  // namespace tetraction
