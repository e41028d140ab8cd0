// An obstacle of a body with its surface, in both frames, or the contact of bodies with each other.
#pragma once

#include <memory>

#include "obstacle_contact.h"
#include "smooth_contact.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

/// One obstacle. The contact of bodies with each other is one, too, which is at rest.
struct Contact::Unit {
  Obstacle obstacle;  // of bodies: with the layer
  ContactSurface surface;
  std::shared_ptr<const ObstacleContact> law;
  const SmoothContact* smooth = nullptr;  // `law`, if it is one
  std::vector<Index> body_of;             // the body of each vertex; empty for obstacles

  /// The contact of bodies. Throws InputError.
  static Unit between(const TetMesh& mesh, const BodyContact& bodies);
  bool is_between_bodies() const { return !body_of.empty(); }
  Index body_count() const;
  /// What is inside another body, or touches one. `x` are positions of the surface.
  std::vector<Penetration> body_penetrations(std::size_t number, const Vector& x) const;

  ObstacleFrame frame(const ForcePoint& at) const {
    return frame_at(obstacle.motion, at.time, at.load_factor);
  }
  /// The positions of the surface as the obstacle sees them.
  Vector local(const ForcePoint& at) const;
  Vector local(const ObstacleFrame& frame, const Vector& x) const;
  /// ∂U/∂x at positions x of the surface, and its mean f̄ over a way, both in the frame of the obstacle.
  Vector gradient(const Vector& x) const;
  Vector mean_gradient(const Vector& from, const Vector& to) const;
  /// gradient += the vectors of the surface's vertices, turned into the frame of the body.
  void scatter(const Matrix3& rotation, const Vector& local, Vector& gradient) const;
  /// function(i, v, x) for each vertex in the layers of smooth walls, in ascending order: i its number of the surface,
  /// v that of the mesh, and x where the obstacle sees it.
  template <class Function>
  void for_each_near(const ObstacleFrame& frame, const Vector& position,
                     const Function& function) const {
    const auto vertex = [&](Index i) { return surface.vertices[static_cast<std::size_t>(i)]; };
    const auto call = [&](Index i, const Vector3& x) { function(i, vertex(i), x); };
    if (frame.rotation == Matrix3::Identity()) {
      smooth->for_each_near(
          [&](Index i) { return Vector3(vertex_block(position, vertex(i)) - frame.shift); }, call);
    } else {
      smooth->for_each_near(
          [&](Index i) { return frame.to_local(vertex_block(position, vertex(i))); }, call);
    }
  }
  /// The first vertex of the mesh that penetrates, or −1.
  Index penetrating_vertex(const ForcePoint& at) const;
  /// The vertex of the mesh that is nearest to the obstacle where the way between two states first touches it; −1 if it
  /// does not. See Contact::crossing() for `only`.
  Index crossing_vertex(const ForcePoint& from, const ForcePoint& to,
                        const std::vector<Index>* only) const;
  /// The sum of minus these vectors as forces at these positions of all vertices.
  ObstacleForce resultant(const Matrix3& rotation, const Vector& local,
                          const Vector& position) const;
};

/// The mean of the rotations at the beginning and at the end of a step: that at the middle of the angle.
Matrix3 middle_rotation(const ObstacleMotion& motion, double begin, double end);

/// Turns blocks of an obstacle's frame, and gives them the numbers of the mesh.
class TurnedBlocks : public SurfaceBlocks {
 public:
  TurnedBlocks(const ContactSurface& surface, const Matrix3& left, const Matrix3& right,
               bool symmetric, HessianBlocks& target)
      : surface_(surface), left_(left), right_(right), symmetric_(symmetric), target_(target) {}
  void add(Index i, const Matrix3& block) override;
  void add_pair(Index i, Index j, const Matrix3& block) override;

 private:
  Index number(Index i) const { return surface_.vertices[static_cast<std::size_t>(i)]; }
  Matrix3 turned(const Matrix3& block) const { return left_ * block * right_.transpose(); }

  const ContactSurface& surface_;
  Matrix3 left_;
  Matrix3 right_;
  bool symmetric_;
  HessianBlocks& target_;
};

}  // namespace tetraction
