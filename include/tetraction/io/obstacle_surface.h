// The surfaces of obstacles near a body, as polygons that can be drawn.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "tetraction/dynamics/contact/obstacle.h"

namespace tetraction {

class Contact;

/// Polygons with three or four corners, which are counter-clockwise where they are seen from the side of the body, and the
/// lines of a grid on them. A triangle of a mesh, both of whose sides act, is there twice.
struct ObstacleSurface {
  std::vector<Vector3> points;  ///< m
  /// The points of each cell: four, or −1 from the third on for a line, and in the last place for a triangle.
  std::vector<std::array<Index, 4>> cells;
  std::vector<int> obstacle;  ///< of each cell: the number of its obstacle

  static bool is_line(const std::array<Index, 4>& cell) { return cell[2] < 0; }

  bool operator==(const ObstacleSurface&) const = default;
};

/// Where a body is, for the parts of endless obstacles that are drawn around it.
struct BodyPlace {
  Vector3 rest_middle = Vector3::Zero();  ///< of the box around the body at rest, m
  double diagonal = 1.0;                  ///< of that box, m; above 0
  Vector3 middle = Vector3::Zero();       ///< of the box around the body now, m
};
/// `rest`, `position`: 3 per vertex, m, at least one vertex. A position that is not finite counts as that at rest.
BodyPlace body_place(const Vector& rest, const Vector& position);

/// Adds the surface of a shape that has moved as `frame` says. A plane is a square with sides of three diagonals of
/// the body, and a cylinder is as long. They are centred on the body at rest, and follow it in steps of a diagonal, so
/// that their edges stay where they are on the obstacle. Spheres and cylinders have their corners on the surface:
/// the chords are a few thousandths of the diagonal away from it, unless the radius is above some fifty diagonals.
void add_obstacle_surface(const ObstacleShape& shape, const ObstacleFrame& frame,
                          const BodyPlace& body, int number, ObstacleSurface& surface);

/// The surfaces of all obstacles of a contact at a time, s, with the factor of the loads of an equilibrium.
std::shared_ptr<const ObstacleSurface> obstacle_surface(const Contact& contact,
                                                        const BodyPlace& body, double time,
                                                        double load_factor = 1.0);

}  // namespace tetraction
