#include "smooth_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kGrain = 512;

}  // namespace

SmoothWall SmoothWall::plane(const Vector3& point, const Vector3& normal) {
  SmoothWall wall;
  wall.center_ = point;
  wall.normal_ = normal.stableNormalized();
  return wall;
}

SmoothWall SmoothWall::sphere(const Vector3& center, double radius, bool inside) {
  SmoothWall wall;
  wall.is_plane_ = false;
  wall.center_ = center;
  wall.radius_ = radius;
  wall.sign_ = inside ? -1.0 : 1.0;
  return wall;
}

SmoothWall SmoothWall::cylinder(const Vector3& point, const Vector3& axis, double radius,
                                bool inside) {
  SmoothWall wall = sphere(point, radius, inside);
  const Vector3 unit = axis.stableNormalized();
  wall.projection_ -= unit * unit.transpose();
  return wall;
}

Vector3 SmoothWall::normal(const Vector3& x) const {
  if (is_plane_) return normal_;
  return sign_ * arm(x).normalized();
}

Matrix3 SmoothWall::curvature(const Vector3& x) const {
  if (is_plane_) return Matrix3::Zero();
  const Vector3 r = arm(x);
  const double length = r.norm();
  const Vector3 unit = r / length;
  return sign_ / length * (projection_ - unit * unit.transpose());
}

Vector3 SmoothWall::mean_normal(const Vector3& a, const Vector3& b) const {
  if (is_plane_) return normal_;
  const Vector3 from = arm(a);
  const Vector3 to = arm(b);
  return sign_ / (from.norm() + to.norm()) * (from + to);
}

Matrix3 SmoothWall::mean_normal_rate(const Vector3& a, const Vector3& b) const {
  if (is_plane_) return Matrix3::Zero();
  const Vector3 from = arm(a);
  const Vector3 to = arm(b);
  const double sum = from.norm() + to.norm();
  return sign_ / sum * (projection_ - (from + to) / sum * to.normalized().transpose());
}

// A round wall: |r + t e|² = R², of which the way out of a ball takes the larger root.
double SmoothWall::first_touch(const Vector3& x, const Vector3& way) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (is_plane_) {
    const double rate = normal_.dot(way);
    return rate < 0.0 ? distance(x) / -rate : kNever;
  }
  const Vector3 r = arm(x);
  const Vector3 e = projection_ * way;
  const double square = e.squaredNorm();
  if (!(square > 0.0)) return kNever;
  const double half = r.dot(e);
  const double rest = (r.norm() - radius_) * (r.norm() + radius_);  // |r|² − R²
  if (sign_ < 0.0) {
    const double root = std::sqrt(std::max(0.0, half * half - square * rest));
    return half > 0.0 ? -rest / (half + root) : (root - half) / square;
  }
  const double discriminant = half * half - square * rest;
  if (!(half < 0.0) || discriminant < 0.0) return kNever;
  return rest / (std::sqrt(discriminant) - half);
}

SmoothContact::SmoothContact(const ObstacleShape& shape, const Barrier& barrier,
                             const ContactSurface& surface)
    : barrier_(barrier), areas_(surface.areas), reaches_(surface.reaches) {
  if (const auto* plane = std::get_if<PlaneShape>(&shape)) {
    walls_.push_back(SmoothWall::plane(plane->point, plane->normal));
  } else if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    walls_.push_back(SmoothWall::sphere(sphere->center, sphere->radius, sphere->inside));
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    walls_.push_back(
        SmoothWall::cylinder(cylinder->point, cylinder->axis, cylinder->radius, cylinder->inside));
  } else if (const auto* room = std::get_if<RoomShape>(&shape)) {
    for (Index axis = 0; axis < 3; ++axis) {
      walls_.push_back(SmoothWall::plane(room->min, Vector3::Unit(axis)));
      walls_.push_back(SmoothWall::plane(room->max, -Vector3::Unit(axis)));
    }
  }
  is_convex_ = std::all_of(walls_.begin(), walls_.end(),
                           [](const SmoothWall& wall) { return wall.has_convex_side(); });
}

double SmoothContact::vertex_energy(Index i, const Vector3& x) const {
  const Barrier own = layer(i);
  double sum = 0.0;
  for (const SmoothWall& wall : walls_) sum += area(i) * own.value(wall.distance(x));
  return sum;
}

Vector3 SmoothContact::vertex_gradient(Index i, const Vector3& x) const {
  const Barrier own = layer(i);
  Vector3 sum = Vector3::Zero();
  for (const SmoothWall& wall : walls_) {
    const double d = wall.distance(x);
    if (d >= own.thickness) continue;
    sum += area(i) * own.slope(d) * wall.normal(x);
  }
  return sum;
}

double SmoothContact::energy(const Vector& x) const {
  double sum = 0.0;
  for_each_near([&](Index i) { return Vector3(vertex_block(x, i)); },
                [&](Index i, const Vector3& place) { sum += vertex_energy(i, place); });
  return sum;
}

void SmoothContact::add_gradient(const Vector& x, Vector& gradient) const {
  for_each_near([&](Index i) { return Vector3(vertex_block(x, i)); },
                [&](Index i, const Vector3& place) {
                  vertex_block(gradient, i) += vertex_gradient(i, place);
                });
}

void SmoothContact::add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const {
  for (Index v = 0; v < count(); ++v) {
    const Barrier own = layer(v);
    const Vector3 place = vertex_block(x, v);
    for (const SmoothWall& wall : walls_) {
      const double d = wall.distance(place);
      if (d >= own.thickness) continue;
      const Vector3 n = wall.normal(place);
      Matrix3 block = own.curvature(d) * n * n.transpose();
      const Matrix3 bend = own.slope(d) * wall.curvature(place);
      if (!convex || bend.trace() > 0.0) block += bend;
      blocks.add(v, area(v) * block);
    }
  }
}

void SmoothContact::add_discrete_gradient(const Vector& from, const Vector& to,
                                          Vector& gradient) const {
  parallel_for(count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      const Barrier own = layer(v);
      const Vector3 a = vertex_block(from, v);
      const Vector3 b = vertex_block(to, v);
      for (const SmoothWall& wall : walls_) {
        const double slope = own.mean_slope(wall.distance(a), wall.distance(b));
        if (slope == 0.0) continue;
        vertex_block(gradient, v) += area(v) * slope * wall.mean_normal(a, b);
      }
    }
  });
}

void SmoothContact::add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                         SurfaceBlocks& blocks) const {
  for (Index v = 0; v < count(); ++v) {
    const Barrier own = layer(v);
    const Vector3 a = vertex_block(from, v);
    const Vector3 b = vertex_block(to, v);
    for (const SmoothWall& wall : walls_) {
      const double before = wall.distance(a);
      const double after = wall.distance(b);
      if (before >= own.thickness && after >= own.thickness) continue;
      const double rate = own.mean_slope_rate(before, after);
      const double slope = own.mean_slope(before, after);
      const Vector3 n = wall.normal(b);
      if (convex) {
        Matrix3 block = rate * n * n.transpose();
        const Matrix3 bend = 0.5 * slope * wall.curvature(b);
        if (bend.trace() > 0.0) block += bend;
        blocks.add(v, area(v) * block);
      } else {
        blocks.add(v, area(v) * (rate * wall.mean_normal(a, b) * n.transpose() +
                                 slope * wall.mean_normal_rate(a, b)));
      }
    }
  }
}

Index SmoothContact::penetrating_vertex(const Vector& x) const {
  for (Index v = 0; v < count(); ++v) {
    if (!(distance(vertex_block(x, v)) > 0.0)) return v;
  }
  return -1;
}

double SmoothContact::longest_step(const Vector& x, const Vector& d) const {
  double longest = 1.0;
  for (Index v = 0; v < count(); ++v) {
    for (const SmoothWall& wall : walls_) {
      longest = std::min(longest, wall.first_touch(vertex_block(x, v), vertex_block(d, v)));
    }
  }
  return longest;
}

// A vertex that would come too close to a wall keeps a tenth of its distance, and moves along the wall.
void SmoothContact::clear_way(const Vector& from, Vector& x) const {
  constexpr double kShare = 0.1;
  constexpr double kOfWay = 0.9;
  for (Index v = 0; v < count(); ++v) {
    const Vector3 start = vertex_block(from, v);
    for (const SmoothWall& wall : walls_) {
      const Vector3 end = vertex_block(x, v);
      const double least = kShare * std::min(wall.distance(start), barrier_.thickness);
      const double d = wall.distance(end);
      if (d < least) {
        vertex_block(x, v) += (least - d) * wall.normal(end);
        if (!(wall.distance(vertex_block(x, v)) > 0.0)) vertex_block(x, v) = start;
      }
      const Vector3 way = vertex_block(x, v) - start;
      const double touch = wall.first_touch(start, way);
      if (touch <= 1.0) vertex_block(x, v) = start + kOfWay * touch * way;
    }
  }
}

void SmoothContact::add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const {
  const double stiffness = barrier_.stiffness / barrier_.thickness;
  for (Index v = 0; v < count(); ++v) {
    for (const SmoothWall& wall : walls_) {
      if (!(wall.distance(vertex_block(x, v)) < reach * own_reach(v))) continue;
      const Vector3 n = wall.normal(vertex_block(x, v));
      blocks.add(v, area(v) * stiffness * n * n.transpose());
    }
  }
}

double SmoothContact::smallest_gap(const Vector& x) const {
  double least = std::numeric_limits<double>::infinity();
  for (Index v = 0; v < count(); ++v) least = std::min(least, distance(vertex_block(x, v)));
  return least < barrier_.thickness ? least : std::numeric_limits<double>::infinity();
}

void SmoothContact::vertex_gaps(const Vector& x, Vector& gaps) const {
  gaps.resize(count());
  for (Index v = 0; v < count(); ++v) {
    const double d = distance(vertex_block(x, v));
    gaps[v] = d < barrier_.thickness ? d : std::numeric_limits<double>::infinity();
  }
}

void SmoothContact::contact_points(const Vector& x, std::vector<ContactPoint>& points) const {
  for (Index v = 0; v < count(); ++v) {
    const Barrier own = layer(v);
    const Vector3 place = vertex_block(x, v);
    for (const SmoothWall& wall : walls_) {
      const double d = wall.distance(place);
      if (d >= own.thickness) continue;
      points.push_back(place_of_vertex(v, wall.normal(place), -area(v) * own.slope(d),
                                       area(v) * own.curvature(d)));
    }
  }
}

void SmoothContact::mean_contact_points(const Vector& from, const Vector& to,
                                        std::vector<ContactPoint>& points) const {
  for (Index v = 0; v < count(); ++v) {
    const Barrier own = layer(v);
    const Vector3 a = vertex_block(from, v);
    const Vector3 b = vertex_block(to, v);
    for (const SmoothWall& wall : walls_) {
      const double before = wall.distance(a);
      const double after = wall.distance(b);
      if (before >= own.thickness && after >= own.thickness) continue;
      const Vector3 n = wall.mean_normal(a, b);
      const double length = n.norm();
      if (!(length > 0.0)) continue;
      points.push_back(place_of_vertex(v, n / length,
                                       -area(v) * length * own.mean_slope(before, after),
                                       area(v) * length * own.mean_slope_rate(before, after)));
    }
  }
}

void SmoothContact::approaching(const Vector& x, const Vector& v, double reach,
                                std::vector<Approach>& found) const {
  for (Index i = 0; i < count(); ++i) {
    const Vector3 place = vertex_block(x, i);
    for (const SmoothWall& wall : walls_) {
      const double d = wall.distance(place);
      if (d > reach) continue;
      found.push_back({i, area(i), d, -wall.normal(place).dot(vertex_block(v, i)), own_reach(i)});
    }
  }
}

}  // namespace tetraction
