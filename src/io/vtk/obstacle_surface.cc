#include "tetraction/io/obstacle_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

constexpr Index kCellsPerDiagonal = 4;
constexpr Index kPlaneCells = 3 * kCellsPerDiagonal;  // along a side
constexpr Index kRoomCells = 8;
constexpr Index kLinesAround = 16;  // of the grid on a round surface

// Edges around a circle, a multiple of those between two lines of the grid. Their chords are r (1 − cos(π/n)) ≈ π² r/(2 n²) away from it.
Index edges_around(double radius, double diagonal) {
  constexpr double kOfOneDiagonal = 40.0;
  constexpr double kFewest = 32.0;
  constexpr double kMost = 256.0;
  const double edges = std::clamp(kOfOneDiagonal * std::sqrt(radius / diagonal), kFewest, kMost);
  return kLinesAround * static_cast<Index>(std::ceil(edges / static_cast<double>(kLinesAround)));
}

// Two unit vectors that are normal to a unit vector and to each other: u × v = n. u is in the plane of n and the
// axis that is most nearly normal to it.
std::pair<Vector3, Vector3> tangents(const Vector3& n) {
  Index axis = 0;
  n.cwiseAbs().minCoeff(&axis);
  const Vector3 u = (Vector3::Unit(axis) - n[axis] * n).normalized();
  return {u, n.cross(u)};
}

class SurfaceMaker {
 public:
  SurfaceMaker(const ObstacleFrame& frame, const BodyPlace& body, int number,
               ObstacleSurface& surface)
      : frame_(frame), body_(body), number_(number), surface_(surface) {}

  void operator()(const PlaneShape& plane) {
    const Vector3 n = plane.normal.normalized();
    const auto [u, v] = tangents(n);
    const Vector3 middle =
        plane.point + near_body(u, plane.point) * u + near_body(v, plane.point) * v;
    const double side = kPlaneCells * body_.diagonal / kCellsPerDiagonal;
    add_grid(middle - 0.5 * side * (u + v), side * u, side * v, kPlaneCells);
  }

  void operator()(const SphereShape& sphere) {
    const Index around = edges_around(sphere.radius, body_.diagonal);
    const Index rows = around / 2;
    // The poles are points of their own: all that is between them is a grid that is closed around the axis.
    const Index first = begin();
    add_point(sphere.center + sphere.radius * Vector3::UnitY());
    for (Index i = 1; i < rows; ++i) {
      const double polar = std::numbers::pi * static_cast<double>(i) / static_cast<double>(rows);
      for (Index j = 0; j < around; ++j) {
        const auto [x, z] = on_circle(j, around);
        add_point(sphere.center + sphere.radius * Vector3(std::sin(polar) * x, std::cos(polar),
                                                          std::sin(polar) * z));
      }
    }
    add_point(sphere.center - sphere.radius * Vector3::UnitY());
    const Index last = begin() - 1;
    const auto at = [&](Index i, Index j) { return first + 1 + (i - 1) * around + j % around; };
    for (Index j = 0; j < around; ++j) {
      add({first, at(1, j + 1), at(1, j), -1}, sphere.inside);
      for (Index i = 1; i + 1 < rows; ++i) {
        add({at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)}, sphere.inside);
      }
      add({last, at(rows - 1, j), at(rows - 1, j + 1), -1}, sphere.inside);
    }
    const Index stride = around / kLinesAround;
    for (Index j = 0; j < around; j += stride) {
      add_line(first, at(1, j));
      for (Index i = 1; i + 1 < rows; ++i) add_line(at(i, j), at(i + 1, j));
      add_line(at(rows - 1, j), last);
    }
    for (Index i = stride; i < rows; i += stride) {
      for (Index j = 0; j < around; ++j) add_line(at(i, j), at(i, j + 1));
    }
  }

  void operator()(const CylinderShape& cylinder) {
    const Vector3 axis = cylinder.axis.normalized();
    const auto [u, v] = tangents(axis);
    const Index around = edges_around(cylinder.radius, body_.diagonal);
    const double length = kPlaneCells * body_.diagonal / kCellsPerDiagonal;
    const Vector3 low = cylinder.point + (near_body(axis, cylinder.point) - 0.5 * length) * axis;
    const Index first = begin();
    for (Index i = 0; i <= kPlaneCells; ++i) {
      const double along = length * static_cast<double>(i) / kPlaneCells;
      for (Index j = 0; j < around; ++j) {
        const auto [a, b] = on_circle(j, around);
        add_point(low + along * axis + cylinder.radius * (a * u + b * v));
      }
    }
    const auto at = [&](Index i, Index j) { return first + i * around + j % around; };
    for (Index i = 0; i < kPlaneCells; ++i) {
      for (Index j = 0; j < around; ++j) {
        add({at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)}, cylinder.inside);
      }
    }
    for (Index i = 0; i <= kPlaneCells; ++i) {
      for (Index j = 0; j < around; ++j) add_line(at(i, j), at(i, j + 1));
      for (Index j = 0; i < kPlaneCells && j < around; j += around / kLinesAround) {
        add_line(at(i, j), at(i + 1, j));
      }
    }
  }

  void operator()(const RoomShape& room) {
    const Vector3 size = room.max - room.min;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 u = size[(axis + 1) % 3] * Vector3::Unit((axis + 1) % 3);
      const Vector3 v = size[(axis + 2) % 3] * Vector3::Unit((axis + 2) % 3);
      add_grid(room.min, u, v, kRoomCells);
      add_grid(room.min + size[axis] * Vector3::Unit(axis), v, u, kRoomCells);
    }
  }

  void operator()(const MeshShape& mesh) {
    const Index first = begin();
    for (const Vector3& point : mesh.points) add_point(point);
    for (const auto& [a, b, c] : mesh.triangles) {
      for (const bool turned : {false, true}) add({first + a, first + b, first + c, -1}, turned);
    }
    // More lines would hide the surface.
    constexpr std::size_t kMostTriangles = 2000;
    if (mesh.triangles.size() > kMostTriangles) return;
    std::set<std::pair<Index, Index>> edges;
    for (const auto& triangle : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        edges.insert(std::minmax({triangle.at(k), triangle.at((k + 1) % 3)}));
      }
    }
    for (const auto& [a, b] : edges) add_line(first + a, first + b);
  }

 private:
  // How far along a direction through `point` the body is: exactly at rest, and from there in whole diagonals.
  double near_body(const Vector3& direction, const Vector3& point) const {
    const double rest = direction.dot(body_.rest_middle - point);
    const double now = direction.dot(frame_.to_local(body_.middle) - point);
    return rest + body_.diagonal * std::round((now - rest) / body_.diagonal);
  }

  static std::pair<double, double> on_circle(Index j, Index around) {
    const double angle =
        2.0 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(around);
    return {std::cos(angle), std::sin(angle)};
  }

  Index begin() const { return static_cast<Index>(surface_.points.size()); }
  void add_point(const Vector3& local) { surface_.points.push_back(frame_.to_world(local)); }

  // With `turned` the polygon is seen from its other side.
  void add(std::array<Index, 4> polygon, bool turned) {
    if (turned) std::swap(polygon[0], polygon[2]);
    surface_.cells.push_back(polygon);
    surface_.obstacle.push_back(number_);
  }

  void add_line(Index a, Index b) {
    surface_.cells.push_back({a, b, -1, -1});
    surface_.obstacle.push_back(number_);
  }

  // A parallelogram with one corner at `origin`, seen from the side of u × v.
  void add_grid(const Vector3& origin, const Vector3& u, const Vector3& v, Index cells) {
    const Index first = begin();
    for (Index i = 0; i <= cells; ++i) {
      for (Index j = 0; j <= cells; ++j) {
        add_point(origin + static_cast<double>(i) / static_cast<double>(cells) * u +
                  static_cast<double>(j) / static_cast<double>(cells) * v);
      }
    }
    const auto at = [&](Index i, Index j) { return first + i * (cells + 1) + j; };
    for (Index i = 0; i < cells; ++i) {
      for (Index j = 0; j < cells; ++j) {
        add({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, false);
      }
    }
    for (Index i = 0; i <= cells; ++i) {
      for (Index j = 0; j < cells; ++j) {
        add_line(at(i, j), at(i, j + 1));
        add_line(at(j, i), at(j + 1, i));
      }
    }
  }

  const ObstacleFrame& frame_;
  const BodyPlace& body_;
  int number_;
  ObstacleSurface& surface_;
};

}  // namespace

BodyPlace body_place(const Vector& rest, const Vector& position) {
  const auto box = [](const Vector& x) {
    const auto places = x.reshaped(3, x.size() / 3);
    return std::pair<Vector3, Vector3>(places.rowwise().minCoeff(), places.rowwise().maxCoeff());
  };
  const auto [low, high] = box(rest);
  BodyPlace place;
  place.rest_middle = place.middle = 0.5 * (low + high);
  place.diagonal = (high - low).norm();
  if (!position.allFinite()) return place;
  const auto [least, most] = box(position);
  place.middle = 0.5 * (least + most);
  return place;
}

void add_obstacle_surface(const ObstacleShape& shape, const ObstacleFrame& frame,
                          const BodyPlace& body, int number, ObstacleSurface& surface) {
  std::visit(SurfaceMaker(frame, body, number, surface), shape);
}

std::shared_ptr<const ObstacleSurface> obstacle_surface(const Contact& contact,
                                                        const BodyPlace& body, double time,
                                                        double load_factor) {
  auto surface = std::make_shared<ObstacleSurface>();
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const Obstacle& obstacle = contact.obstacle(i);
    if (obstacle.removed) continue;
    add_obstacle_surface(obstacle.shape, frame_at(obstacle.motion, time, load_factor), body,
                         static_cast<int>(i), *surface);
  }
  return surface;
}

}  // namespace tetraction
