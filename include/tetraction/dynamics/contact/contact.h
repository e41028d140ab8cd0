// Contact of a body with rigid obstacles, and of bodies with each other.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/dynamics/contact/body_contact.h"
#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

class ExplicitFriction;
class FrictionStep;

/// The contact of a mesh with all of its obstacles, and of its bodies with each other, as a potential that keeps them
/// apart:
///
///     U(x) = Σ w_v U_b(d(x_v))
///
/// over vertices of the surface and obstacles, with the distance d, the barrier U_b (contact/barrier.h) and the
/// area w_v of the vertex: a third of the rest areas of the faces around it. A uniform pressure on a flat face of
/// linear tetrahedra is then −U_b′ exactly. In faces of quadratic tetrahedra the middles of the edges have the areas,
/// because the consistent weights of the corners are zero. The corners have a twelfth of the face, but feel the inner
/// half of the layer only, which keeps them out.
///
/// Of bodies with each other, and with themselves, it is the potential of SelfContact
/// (src/dynamics/contact/self_contact.h).
///
/// U is infinite where a vertex penetrates. No step may end there. Steps that take a mean of forces
/// (`energy-momentum`, and `midpoint`, for contact only) take a discrete gradient, so that U(q_{k+1}) is
/// part of the balance and cannot be jumped over.
///
/// The energy of the body contains U. Moving obstacles do work, driven_work() or work_of_motion(), which counts as
/// work of constraints. Friction is a FrictionStep (src/dynamics/contact/friction/friction_step.h).
class Contact : public ForceTerm {
 public:
  /// Throws InputError, with the name of the obstacle, for numbers out of range, for a surface without
  /// faces, and for a face that the mesh does not have. Obstacles that `earlier` has with the same numbers, shapes,
  /// layers and surfaces share what was computed for them.
  Contact(const TetMesh& mesh, std::vector<Obstacle> obstacles, const Contact* earlier = nullptr,
          std::optional<BodyContact> between = std::nullopt);
  ~Contact() override;
  Contact(Contact&&) noexcept;
  Contact& operator=(Contact&&) noexcept;

  /// The number of obstacles.
  std::size_t size() const { return obstacle_count_; }
  const Obstacle& obstacle(std::size_t i) const;
  /// The contact of bodies with each other; null without it.
  const BodyContact* between() const { return between_ ? &*between_ : nullptr; }
  /// Number of bodies whose surfaces may touch; 0 without between().
  Index body_count() const { return body_count_; }
  /// What a number names that a Crossing or a Penetration has: an obstacle, or size() for another body or another part
  /// of the surface. In text: the obstacle "floor", another body.
  std::string partner(std::size_t i) const;
  /// The thickness of its layer, m.
  double thickness(std::size_t i) const;
  /// The thinnest of all layers, m; infinite without any.
  double least_thickness() const;
  bool has_friction() const;
  /// The vertices that may touch something, ascending.
  std::vector<Index> vertices() const;
  /// Whether an obstacle moves.
  bool moves() const;

  std::string name() const override { return "contact"; }
  bool has_potential() const override { return true; }
  bool couples_vertices() const override;
  bool couples_only_neighbors() const override { return !between_; }
  Index undefined_vertex(const ForcePoint& at) const override;
  double longest_step(const ForcePoint& from, const Vector& displacement) const override;
  double energy(const ForcePoint& at) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  /// The work, J, of moving obstacles whose forces are those of add_discrete_gradient().
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override;
  void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                             Vector& gradient) const override;
  /// hessian += ∂f̄/∂q_{k+1} of the discrete gradient f̄, N/m. With kConvex and `symmetric` it is a
  /// symmetric matrix near it.
  void add_discrete_hessian(const ForcePoint& from, const ForcePoint& to, HessianForm form,
                            bool symmetric, HessianBlocks& hessian) const;

  /// A vertex whose straight way between two states, seen from an obstacle, crosses the obstacle. Of faces
  /// and edges that cross it, it may be any vertex of the surface.
  struct Crossing {
    std::size_t obstacle;  ///< or size(): see partner()
    Index vertex;
  };
  /// The first one, if there is one. With `only`, sorted, all other vertices go with the obstacle.
  std::optional<Crossing> crossing(const ForcePoint& from, const ForcePoint& to,
                                   const std::vector<Index>* only = nullptr) const;
  /// The first one of an obstacle without an inside, whose potential is the same on both of its sides. States at which
  /// undefined_vertex() finds nothing may lie on two sides of it.
  std::optional<Crossing> crossing_without_inside(const ForcePoint& from,
                                                  const ForcePoint& to) const;
  /// Moves vertices of x, the positions at the end of a way that begins at `from`, so that the way crosses no
  /// obstacle. `to` has the time of x. Returns whether anything was moved.
  bool clear_way(const ForcePoint& from, const ForcePoint& to, Vector& x) const;

  /// Which places of the surface obstacles support.
  enum class Support {
    kPossible,  ///< all that may touch them, however far away
    kPresent    ///< those in their layers
  };
  /// hessian += a stiffness, N/m, in the directions in which obstacles support the surface where it touches them.
  void add_support(const ForcePoint& at, Support support, HessianBlocks& hessian) const;
  /// An estimate of the round-off of the forces' norm in double precision, N: that of the positions, times the
  /// stiffness of the layers.
  double round_off(const ForcePoint& at) const;
  /// The smallest distance between body and obstacles that is below a layer's thickness, m; infinite without one.
  double smallest_gap(const ForcePoint& at) const;
  /// The same of one obstacle.
  double smallest_gap(const ForcePoint& at, std::size_t i) const;
  /// Fields on all vertices: the pressure, Pa, and the distance to the nearest obstacle, m (infinite where no obstacle
  /// is near). The pressure in corners of quadratic faces is that of the layer at their distance.
  void fields(const ForcePoint& at, Vector& pressure, Vector& gap) const;
  /// The force of each obstacle at an instant, without friction.
  std::vector<ObstacleForce> forces(const ForcePoint& at) const;
  /// The same as the means of a step, from the discrete gradient.
  std::vector<ObstacleForce> mean_forces(const ForcePoint& from, const ForcePoint& to) const;
  /// The work, J, of obstacles that act on the body with the forces F and moments M about the origin at an instant t of
  /// a step, for the time dt. An obstacle turns about b(t) = c + A(t) v + offset, and moves by ΔA of its path A in the step of
  /// the length h:
  ///
  ///     Σ ΔA dt/h [F·v + (M − b × F)·ω]
  ///
  /// Rules that take forces at instants do this work: the energy error of a step is then the same for every observer in
  /// uniform motion, and an obstacle that moves along its own surface does none.
  double work_of_motion(const std::vector<ObstacleForce>& forces, double time, const TimeSpan& step,
                        double dt) const;
  /// A vertex that penetrates an obstacle or another body.
  struct Penetration {
    std::size_t obstacle;  ///< or size(): see partner()
    Index vertex;
    double depth;  ///< m; NaN where the obstacle has no inside, and where only edges cross faces
  };
  std::vector<Penetration> penetrations(const ForcePoint& at) const;
  /// What the layers do to explicit steps.
  struct ImpactForecast {
    double limit = 0.0;      ///< the stability limit with the layers, s
    double valid_for = 0.0;  ///< nothing else can come into a layer for this time, s
  };
  /// The stability limit of explicit rules for a body with the velocities v (3 per vertex, m/s) that goes on in steps
  /// of the length `step`, s. `critical_step` is the limit of the body alone, and `impedance` ρc, Pa s/m. Only
  /// vertices count that are in a layer, or may be after two steps. A vertex of the mass m and the area w that
  /// comes nearer with the speed s from the distance d presses the layer at most until the layer has its energy, or the
  /// pressure of the impact of a half-space:
  ///
  ///     U_b(d₁) = U_b(d) + m s²/(2w),   −U_b′(d₂) = −U_b′(d) + ρ c s.
  ///
  /// With the stiffness k = w U_b″ at the smaller one of both distances,
  ///
  ///     h⁻² = h_body⁻² + k/(4m),   h ≤ d̂/(kCrossing s).
  ImpactForecast impact_forecast(const ForcePoint& at, const Vector& v, double impedance,
                                 double critical_step, double step) const;

 private:
  friend class ExplicitFriction;
  friend class FrictionStep;
  struct Unit;
  std::vector<Unit> units_;  // of obstacles; the last one may be that of bodies with each other
  std::size_t obstacle_count_ = 0;
  std::optional<BodyContact> between_;
  Index body_count_ = 0;
};

}  // namespace tetraction
