#include "tetraction/dynamics/contact/contact.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact_surface.h"
#include "contact_unit.h"
#include "dynamics/contact/mesh/mesh_contact.h"
#include "smooth_contact.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

void check_number(const Obstacle& obstacle, const char* key, double value, bool may_be_zero) {
  if (std::isfinite(value) && (value > 0.0 || (may_be_zero && value == 0.0))) return;
  throw InputError(fmt::format("The obstacle \"{}\" has the {} {}; it must be {} and finite.",
                               obstacle.name, key, value,
                               may_be_zero ? "zero or more" : "above zero"));
}

void check_obstacle(const Obstacle& obstacle) {
  check_number(obstacle, "thickness", obstacle.thickness, false);
  check_number(obstacle, "stiffness", obstacle.stiffness, false);
  check_number(obstacle, "friction", obstacle.friction, true);
  check_number(obstacle, "slip speed", obstacle.slip_speed, false);
}

// Whether the two differ in their motion, their friction and their names at most.
bool has_same_law(const Obstacle& a, const Obstacle& b) {
  return a.removed == b.removed && a.thickness == b.thickness && a.stiffness == b.stiffness &&
         a.surface == b.surface && a.shape == b.shape;
}

// The part of the way after which something touches; 1 if nothing does. longest_step() may end where a gap is much
// smaller than at its start, which a step may do: it goes on from there.
double part_until_touch(const ObstacleContact& law, const Vector& start, const Vector& way) {
  constexpr int kRounds = 12;  // each of which ends at a tenth of the gap or less
  double part = 0.0;
  for (int i = 0; i < kRounds; ++i) {
    const double step = law.longest_step(start + part * way, (1.0 - part) * way);
    if (!(step < 1.0)) return 1.0;
    part += step * (1.0 - part);
  }
  return part;
}

}  // namespace

Vector Contact::Unit::local(const ObstacleFrame& frame, const Vector& x) const {
  Vector result(3 * static_cast<Index>(surface.vertices.size()));
  Index i = 0;
  for (const Index v : surface.vertices) {
    vertex_block(result, i++) = frame.to_local(vertex_block(x, v));
  }
  return result;
}

Vector Contact::Unit::local(const ForcePoint& at) const {
  return local(frame(at), at.position);
}

Vector Contact::Unit::gradient(const Vector& x) const {
  Vector sum = Vector::Zero(x.size());
  law->add_gradient(x, sum);
  return sum;
}

Vector Contact::Unit::mean_gradient(const Vector& from, const Vector& to) const {
  Vector sum = Vector::Zero(from.size());
  law->add_discrete_gradient(from, to, sum);
  return sum;
}

void Contact::Unit::scatter(const Matrix3& rotation, const Vector& local, Vector& gradient) const {
  Index i = 0;
  for (const Index v : surface.vertices) {
    vertex_block(gradient, v) += rotation * vertex_block(local, i++);
  }
}

Index Contact::Unit::penetrating_vertex(const ForcePoint& at) const {
  if (smooth == nullptr) {
    const Index found = law->penetrating_vertex(local(at));
    return found < 0 ? -1 : surface.vertices[static_cast<std::size_t>(found)];
  }
  Index first = -1;
  for_each_near(frame(at), at.position, [&](Index, Index v, const Vector3& x) {
    if (first < 0 && !(smooth->distance(x) > 0.0)) first = v;
  });
  return first;
}

void TurnedBlocks::add(Index i, const Matrix3& block) {
  Matrix3 whole = turned(block);
  if (symmetric_) whole = 0.5 * (whole + whole.transpose().eval());
  target_.add(number(i), whole);
}

void TurnedBlocks::add_pair(Index i, Index j, const Matrix3& block) {
  target_.add_pair(number(i), number(j), turned(block));
}

Contact::Contact(const TetMesh& mesh, std::vector<Obstacle> obstacles, const Contact* earlier,
                 std::optional<BodyContact> between)
    : obstacle_count_(obstacles.size()), between_(std::move(between)) {
  for (Obstacle& obstacle : obstacles) {
    check_obstacle(obstacle);
    Unit unit;
    const Barrier barrier{obstacle.thickness, obstacle.stiffness};
    const std::size_t number = units_.size();
    if (obstacle.removed) {
      // No vertex can touch it.
      unit.law = std::make_shared<SmoothContact>(PlaneShape{}, barrier, ContactSurface{});
    } else if (earlier != nullptr && number < earlier->size() &&
               has_same_law(earlier->units_[number].obstacle, obstacle)) {
      unit.surface = earlier->units_[number].surface;
      unit.law = earlier->units_[number].law;
    } else {
      unit.surface = contact_surface(mesh, obstacle, Corners::kGuarded);
      if (const auto* surface = std::get_if<MeshShape>(&obstacle.shape)) {
        unit.law = std::make_shared<MeshContact>(TriangleMesh(surface->points, surface->triangles),
                                                 unit.surface, barrier);
      } else {
        unit.law = std::make_shared<SmoothContact>(obstacle.shape, barrier, unit.surface);
      }
    }
    unit.smooth = dynamic_cast<const SmoothContact*>(unit.law.get());
    unit.obstacle = std::move(obstacle);
    units_.push_back(std::move(unit));
  }
  if (!between_) return;
  units_.push_back(earlier != nullptr && earlier->between_ == between_
                       ? earlier->units_.back()
                       : Unit::between(mesh, *between_));
  body_count_ = units_.back().body_count();
}

Contact::~Contact() = default;
Contact::Contact(Contact&&) noexcept = default;
Contact& Contact::operator=(Contact&&) noexcept = default;

const Obstacle& Contact::obstacle(std::size_t i) const {
  return units_.at(i).obstacle;
}

std::vector<Index> Contact::vertices() const {
  std::vector<Index> all;
  for (const Unit& unit : units_) {
    all.insert(all.end(), unit.surface.vertices.begin(), unit.surface.vertices.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

bool Contact::has_friction() const {
  return std::any_of(units_.begin(), units_.end(),
                     [](const Unit& unit) { return unit.obstacle.friction > 0.0; });
}

bool Contact::moves() const {
  return std::any_of(units_.begin(), units_.end(),
                     [](const Unit& unit) { return !unit.obstacle.motion.at_rest(); });
}

bool Contact::couples_vertices() const {
  return std::any_of(units_.begin(), units_.end(),
                     [](const Unit& unit) { return unit.law->couples_vertices(); });
}

Index Contact::undefined_vertex(const ForcePoint& at) const {
  for (const Unit& unit : units_) {
    const Index found = unit.penetrating_vertex(at);
    if (found >= 0) return found;
  }
  return -1;
}

double Contact::longest_step(const ForcePoint& from, const Vector& displacement) const {
  double longest = kFar;
  for (const Unit& unit : units_) {
    const ObstacleFrame frame = unit.frame(from);
    const Vector x = unit.local(frame, from.position);
    const Vector d = unit.local({frame.rotation, Vector3::Zero()}, displacement);
    const double step = unit.law->longest_step(x, d);
    if (step < 1.0) longest = std::min(longest, step);
  }
  return longest;
}

double Contact::energy(const ForcePoint& at) const {
  double sum = 0.0;
  for (const Unit& unit : units_) {
    if (unit.smooth == nullptr) {
      sum += unit.law->energy(unit.local(at));
      continue;
    }
    unit.for_each_near(unit.frame(at), at.position, [&](Index i, Index, const Vector3& x) {
      sum += unit.smooth->vertex_energy(i, x);
    });
  }
  return sum;
}

void Contact::add_gradient(const ForcePoint& at, Vector& gradient) const {
  for (const Unit& unit : units_) {
    const ObstacleFrame frame = unit.frame(at);
    if (unit.smooth == nullptr) {
      unit.scatter(frame.rotation, unit.gradient(unit.local(frame, at.position)), gradient);
      continue;
    }
    unit.for_each_near(frame, at.position, [&](Index i, Index v, const Vector3& x) {
      vertex_block(gradient, v) += frame.rotation * unit.smooth->vertex_gradient(i, x);
    });
  }
}

void Contact::add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const {
  for (const Unit& unit : units_) {
    const ObstacleFrame frame = unit.frame(at);
    TurnedBlocks blocks(unit.surface, frame.rotation, frame.rotation, true, hessian);
    unit.law->add_hessian(unit.local(frame, at.position), form == HessianForm::kConvex, blocks);
  }
}

void Contact::add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                    Vector& gradient) const {
  for (const Unit& unit : units_) {
    unit.scatter(middle_rotation(unit.obstacle.motion, from.time, to.time),
                 unit.mean_gradient(unit.local(from), unit.local(to)), gradient);
  }
}

void Contact::add_discrete_hessian(const ForcePoint& from, const ForcePoint& to, HessianForm form,
                                   bool symmetric, HessianBlocks& hessian) const {
  for (const Unit& unit : units_) {
    const Matrix3 rotation = middle_rotation(unit.obstacle.motion, from.time, to.time);
    const ObstacleFrame end = unit.frame(to);
    // With two rotations the symmetric part of a block n nᵀ has a negative eigenvalue, −sin²(φ/2) for the angle φ
    // between them.
    const Matrix3& right = form == HessianForm::kConvex ? rotation : end.rotation;
    TurnedBlocks blocks(unit.surface, rotation, right, symmetric, hessian);
    unit.law->add_discrete_hessian(unit.local(from), unit.local(end, to.position),
                                   form == HessianForm::kConvex, blocks);
  }
}

Index Contact::Unit::crossing_vertex(const ForcePoint& from, const ForcePoint& to,
                                     const std::vector<Index>* only) const {
  const Vector start = local(from);
  Vector way = local(to) - start;
  if (only != nullptr) {
    Index i = 0;
    for (const Index v : surface.vertices) {
      if (!std::binary_search(only->begin(), only->end(), v)) vertex_block(way, i).setZero();
      ++i;
    }
  }
  const double longest = part_until_touch(*law, start, way);
  const bool crosses = longest < 1.0;
  if (!crosses && only == nullptr && penetrating_vertex(to) < 0) return -1;
  // The vertex that is nearest to the obstacle where the way ends. A way may end exactly on the obstacle.
  Vector gaps;
  law->vertex_gaps(crosses ? Vector(start + 0.999 * longest * way) : Vector(start + way), gaps);
  Index nearest = -1;
  for (Index i = 0; i < gaps.size(); ++i) {
    if (only != nullptr && vertex_block(way, i).isZero(0.0)) continue;
    if (!crosses && gaps[i] > 0.0) continue;
    if (nearest < 0 || gaps[i] < gaps[nearest]) nearest = i;
  }
  return nearest < 0 ? -1 : surface.vertices[static_cast<std::size_t>(nearest)];
}

std::optional<Contact::Crossing> Contact::crossing(const ForcePoint& from, const ForcePoint& to,
                                                   const std::vector<Index>* only) const {
  for (std::size_t k = 0; k < units_.size(); ++k) {
    const Unit& unit = units_[k];
    const bool is_convex = unit.smooth != nullptr && unit.smooth->has_convex_side();
    if (is_convex && only == nullptr && unit.penetrating_vertex(to) < 0) continue;
    const Index vertex = unit.crossing_vertex(from, to, only);
    if (vertex >= 0) return Crossing{k, vertex};
  }
  return std::nullopt;
}

std::optional<Contact::Crossing> Contact::crossing_without_inside(const ForcePoint& from,
                                                                  const ForcePoint& to) const {
  for (std::size_t k = 0; k < units_.size(); ++k) {
    if (units_[k].smooth != nullptr) continue;
    const Index vertex = units_[k].crossing_vertex(from, to, nullptr);
    if (vertex >= 0) return Crossing{k, vertex};
  }
  return std::nullopt;
}

bool Contact::clear_way(const ForcePoint& from, const ForcePoint& to, Vector& x) const {
  bool moved = false;
  for (const Unit& unit : units_) {
    const ObstacleFrame frame = unit.frame(to);
    const Vector start = unit.local(from);
    const Vector wanted = unit.local(frame, x);
    Vector end = wanted;
    unit.law->clear_way(start, end);
    Index i = 0;
    for (const Index v : unit.surface.vertices) {
      const Vector3 place = vertex_block(end, i);
      if (place != vertex_block(wanted, i)) {
        vertex_block(x, v) = frame.to_world(place);
        moved = true;
      }
      ++i;
    }
  }
  return moved;
}

void Contact::add_support(const ForcePoint& at, Support support, HessianBlocks& hessian) const {
  for (const Unit& unit : units_) {
    const ObstacleFrame frame = unit.frame(at);
    TurnedBlocks blocks(unit.surface, frame.rotation, frame.rotation, true, hessian);
    unit.law->add_support(unit.local(frame, at.position),
                          support == Support::kPossible ? kFar : unit.obstacle.thickness, blocks);
  }
}

double Contact::round_off(const ForcePoint& at) const {
  HessianBlocks blocks;
  blocks.reset(at.position.size() / 3);
  add_hessian(at, HessianForm::kConvex, blocks);
  double sum = 0.0;
  for (const Unit& unit : units_) {
    for (const Index v : unit.surface.vertices) {
      sum += blocks.diagonal(v).squaredNorm() * vertex_block(at.position, v).squaredNorm();
    }
  }
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

double Contact::smallest_gap(const ForcePoint& at) const {
  double least = kFar;
  for (std::size_t i = 0; i < units_.size(); ++i) least = std::min(least, smallest_gap(at, i));
  return least;
}

double Contact::smallest_gap(const ForcePoint& at, std::size_t i) const {
  const Unit& unit = units_.at(i);
  return unit.law->smallest_gap(unit.local(at));
}

void Contact::fields(const ForcePoint& at, Vector& pressure, Vector& gap) const {
  const Index count = at.position.size() / 3;
  pressure.setZero(count);
  gap.setConstant(count, kFar);
  Vector gaps;
  for (const Unit& unit : units_) {
    const Vector x = unit.local(at);
    const Vector local = unit.gradient(x);
    unit.law->vertex_gaps(x, gaps);
    const Barrier layer{unit.obstacle.thickness, unit.obstacle.stiffness};
    Index i = 0;
    for (const Index v : unit.surface.vertices) {
      const double area = unit.surface.areas[static_cast<std::size_t>(i)];
      // Corners that feel a part of the layer have the pressure that the whole of it has there.
      pressure[v] += unit.surface.reach(i) < 1.0 ? -layer.slope(gaps[i])
                                                 : vertex_block(local, i).norm() / area;
      gap[v] = std::min(gap[v], gaps[i]);
      ++i;
    }
  }
}

}  // namespace tetraction
