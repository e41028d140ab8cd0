// Coulomb friction in a step.
#pragma once

#include <utility>
#include <vector>

#include "dynamics/contact/obstacle_contact.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

/// Which normal forces friction takes.
enum class NormalForces {
  kEnd,  ///< those at the end of the step
  kMean  ///< the mean forces of the discrete gradient
};

/// The powers of friction in a step, W.
struct FrictionPower {
  double dissipated = 0.0;    ///< heat
  double of_obstacles = 0.0;  ///< that moving obstacles give to the body
};

/// The friction of a step from q_k to q_{k+1} = q_k + h v. A place of contact Σ w_i x_i with the normal force λ moves
/// along the obstacle with the velocity u, the tangential part of its displacement in the frame of the obstacle,
/// divided by h. Between bodies u is the slip of a ContactPoint, so that the forces have neither a resultant nor, with
/// the positions in the middle of the step as levers, a moment. The dissipation potential is
///
///     D(v) = Σ μ λ f₀(|u|),   f₀′(y) = f₁(y) = 2y/ε − y²/ε² for y < ε, 1 beyond
///
/// (Li et al. 2020), with ε = slip_speed. λ and the normals are kept; take() renews them.
class FrictionStep {
 public:
  /// Keeps references to all arguments, of which `start` must not change in the step.
  void begin(const Contact& contact, const Vector& start, double begin, double end,
             NormalForces forces);
  /// Forgets the step: there is no friction.
  void clear() { contact_ = nullptr; }
  bool exists() const { return contact_ != nullptr; }
  /// Takes normals and normal forces of a step that ends at these positions.
  void take(const Vector& mass, const Vector& end_position);
  /// Whether no place has a normal force.
  bool is_idle() const { return points_.empty(); }

  /// D, W.
  double potential(const Vector& v) const;
  /// gradient += ∂D/∂v, N: minus the force.
  void add_gradient(const Vector& v, Vector& gradient) const;
  /// hessian += ∂²D/∂v², kg/s; positive semidefinite.
  void add_hessian(const Vector& v, HessianBlocks& hessian) const;
  /// stiffness += `rate` times the part of ∂(∂D/∂v)/∂q_{k+1} that λ has, N/m. The rate is
  /// ∂q_{k+1}/∂x of the solver's unknown.
  void add_force_stiffness(const Vector& v, double rate, LoadStiffness& stiffness) const;
  FrictionPower power(const Vector& v) const;
  /// The friction force on every vertex that is in contact, by obstacles: add(obstacle, vertex, force). Between bodies
  /// the number is that of all obstacles.
  template <class Add>
  void for_each_force(const Vector& v, const Add& add) const;

 private:
  struct Point {
    std::size_t obstacle = 0;
    ContactPoint
        place;  // vertices are those of the mesh; the normal is in the frame of the obstacle
    double limit = 0.0;               // μ λ
    Vector3 shift = Vector3::Zero();  // of the slip at v = 0, m
  };
  // Σ (w_i + L_i) v_i.
  static Vector3 velocity(const Point& point, const Vector& v) {
    return point.place.slip([&](Index i) { return vertex_block(v, i); });
  }
  // u and the factor f₁(|u|)/|u| of the force −μ λ f₁(|u|)/|u| u.
  Vector3 slip(const Point& point, const Vector& v) const;
  double factor(const Point& point, double speed) const;
  // The force on the place, in the frame of the body.
  Vector3 force(const Point& point, const Vector3& u) const {
    return -(point.limit * factor(point, u.norm())) * (rotation(point) * u);
  }
  const Matrix3& rotation(const Point& point) const { return frames_[point.obstacle].rotation; }

  const Contact* contact_ = nullptr;
  const Vector* start_ = nullptr;
  double begin_ = 0.0;
  double end_ = 0.0;
  NormalForces forces_ = NormalForces::kEnd;
  std::vector<ObstacleFrame> frames_;  // of each obstacle at the end
  std::vector<Point> points_;
};

template <class Add>
void FrictionStep::for_each_force(const Vector& v, const Add& add) const {
  for (const Point& point : points_) {
    const Vector3 whole = force(point, slip(point, v));
    for (int i = 0; i < point.place.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      add(point.obstacle, point.place.vertices.at(k), point.place.part(k, whole));
    }
  }
}

}  // namespace tetraction
