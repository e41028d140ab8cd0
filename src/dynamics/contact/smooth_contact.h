// Contact with obstacles whose distance is a smooth function: planes, spheres, cylinders, rooms.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "obstacle_contact.h"
#include "tetraction/dynamics/contact/obstacle.h"

namespace tetraction {

/// A wall without edges, with the signed distance d(x) of its free side. With the projection P and a
/// center c,
///
///     plane: d = n·(x − c)      round: d = ±(|P(x − c)| − R)
///
/// where P = I for a sphere and I − aaᵀ for a cylinder of the axis a.
class SmoothWall {
 public:
  static SmoothWall plane(const Vector3& point, const Vector3& normal);
  static SmoothWall sphere(const Vector3& center, double radius, bool inside);
  static SmoothWall cylinder(const Vector3& point, const Vector3& axis, double radius, bool inside);

  /// d, m.
  double distance(const Vector3& x) const {
    return is_plane_ ? normal_.dot(x - center_) : sign_ * (arm(x).norm() - radius_);
  }
  /// ∂d/∂x, of length 1.
  Vector3 normal(const Vector3& x) const;
  /// ∂²d/∂x², 1/m.
  Matrix3 curvature(const Vector3& x) const;
  /// A vector n̄ near the normal with n̄·(b − a) = d(b) − d(a).
  Vector3 mean_normal(const Vector3& a, const Vector3& b) const;
  /// ∂n̄/∂b, 1/m.
  Matrix3 mean_normal_rate(const Vector3& a, const Vector3& b) const;
  /// The smallest t ≥ 0 at which d(x + t way) = 0, or infinity. d(x) must be positive.
  double first_touch(const Vector3& x, const Vector3& way) const;
  /// Whether the free side is convex, so that a straight way between two places of it crosses nothing.
  bool has_convex_side() const { return is_plane_ || sign_ < 0.0; }

 private:
  Vector3 arm(const Vector3& x) const { return projection_ * (x - center_); }

  bool is_plane_ = true;
  Vector3 center_ = Vector3::Zero();
  Vector3 normal_ = Vector3::UnitY();  // of a plane
  Matrix3 projection_ = Matrix3::Identity();
  double radius_ = 0.0;
  double sign_ = 1.0;  // −1 inside
};

/// Contact of the vertices of a surface with one or more smooth walls: U(x) = Σ_v w_v Σ U_b(d(x_v)) with
/// the area w_v of vertex v, and the layer as it feels it.
class SmoothContact : public ObstacleContact {
 public:
  /// Of the surface it takes the areas and the layers.
  SmoothContact(const ObstacleShape& shape, const Barrier& barrier, const ContactSurface& surface);

  bool couples_vertices() const override { return false; }
  double energy(const Vector& x) const override;
  void add_gradient(const Vector& x, Vector& gradient) const override;
  void add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const override;
  void add_discrete_gradient(const Vector& from, const Vector& to, Vector& gradient) const override;
  void add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                            SurfaceBlocks& blocks) const override;
  Index penetrating_vertex(const Vector& x) const override;
  double longest_step(const Vector& x, const Vector& d) const override;
  void clear_way(const Vector& from, Vector& x) const override;
  void add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const override;
  double smallest_gap(const Vector& x) const override;
  void vertex_gaps(const Vector& x, Vector& gaps) const override;
  void contact_points(const Vector& x, std::vector<ContactPoint>& points) const override;
  void mean_contact_points(const Vector& from, const Vector& to,
                           std::vector<ContactPoint>& points) const override;
  void approaching(const Vector& x, const Vector& v, double reach,
                   std::vector<Approach>& found) const override;

  /// Whether the free side is convex: a way whose ends do not penetrate crosses nothing.
  bool has_convex_side() const { return is_convex_; }
  /// The smallest distance of a place to a wall.
  double distance(const Vector3& x) const {
    double least = walls_.front().distance(x);
    for (std::size_t i = 1; i < walls_.size(); ++i) least = std::min(least, walls_[i].distance(x));
    return least;
  }
  /// function(i, x) for vertex i of the surface at x that is in the layer or penetrates a wall, in ascending order.
  /// place(i) is its place. Nothing is copied, because most of a surface is usually far away.
  template <class Place, class Function>
  void for_each_near(const Place& place, const Function& function) const {
    for (Index i = 0; i < count(); ++i) {
      const Vector3 x = place(i);
      if (!(distance(x) >= barrier_.thickness)) function(i, x);
    }
  }
  /// The energy of vertex i at x, J, and its derivative, N.
  double vertex_energy(Index i, const Vector3& x) const;
  Vector3 vertex_gradient(Index i, const Vector3& x) const;

 private:
  Index count() const { return static_cast<Index>(areas_.size()); }
  double area(Index v) const { return areas_[static_cast<std::size_t>(v)]; }
  double own_reach(Index v) const {
    return reaches_.empty() ? 1.0 : reaches_[static_cast<std::size_t>(v)];
  }
  Barrier layer(Index v) const { return {own_reach(v) * barrier_.thickness, barrier_.stiffness}; }
  std::vector<SmoothWall> walls_;
  Barrier barrier_;  // of vertices that feel the whole layer
  std::vector<double> areas_;
  std::vector<double> reaches_;
  bool is_convex_ = true;
};

}  // namespace tetraction
