#include "vertex_drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "drag_speed.h"
#include "tetraction/core/error.h"
#include "viewer/snapshot_maker.h"

namespace tetraction::viewer {
namespace {

// Largest displacement in a step as a fraction of an edge. A vertex that moves by more than an element in one step
// inverts elements.
constexpr double kEdgeFraction = 0.2;
constexpr double kTolerance = 1e-6;  // relative: of an edge, and of the speed

double shortest_edge_at(const TetMesh& mesh, const std::vector<Index>& vertices) {
  const RestState rest(mesh);
  std::vector<bool> chosen(static_cast<std::size_t>(mesh.vertex_count()), false);
  for (const Index v : vertices) chosen[static_cast<std::size_t>(v)] = true;
  double shortest = std::numeric_limits<double>::infinity();
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    for (const Index a : nodes) {
      if (!chosen[static_cast<std::size_t>(a)]) continue;
      for (const Index b : nodes) {
        if (b != a) shortest = std::min(shortest, (rest.position(a) - rest.position(b)).norm());
      }
    }
  }
  return shortest;
}

}  // namespace

VertexDrag::VertexDrag(const Session& session, std::vector<Index> vertices, MakeEdit make)
    : session_(session),
      vertices_(std::move(vertices)),
      make_(std::move(make)),
      prescribed_before_(prescribed_among(vertices_)),
      shortest_edge_(shortest_edge_at(session.system().mesh(), vertices_)),
      wave_speed_(slowest_shear_wave(session)) {
  const TetMesh& mesh = session_.system().mesh();
  what_ = vertices_.size() == 1 ? fmt::format("Drag vertex {}", mesh.vertex_id(vertices_.front()))
                                : fmt::format("Drag {} vertices", vertices_.size());
  const Vector& position = session_.state().position;
  const Vector3 first = vertex_block(position, vertices_.front());
  for (const Index v : vertices_) offsets_.emplace_back(vertex_block(position, v) - first);
  goal_ = first;
  if (!prescribed_before_.empty()) make_(Unfix{ids(prescribed_before_), {}}, what_, false);
  FixSettings hold;
  hold.select = ids(vertices_);
  fix_ = session_.fix_count();
  make_(SetFix{std::nullopt, hold}, what_, !prescribed_before_.empty());
}

std::vector<Index> VertexDrag::prescribed_among(const std::vector<Index>& vertices) const {
  const std::vector<std::uint8_t> held = prescribed_vertices(session_);
  std::vector<Index> found;
  for (const Index v : vertices) {
    if (held[static_cast<std::size_t>(v)] != 0) found.push_back(v);
  }
  return found;
}

SelectVertices VertexDrag::ids(const std::vector<Index>& vertices) const {
  SelectVertices select;
  for (const Index v : vertices) select.ids.push_back(session_.system().mesh().vertex_id(v));
  return select;
}

Vector3 VertexDrag::remaining_path() const {
  return goal_ - vertex_block(session_.state().position, vertices_.front());
}

double VertexDrag::largest_speed() const {
  return std::min(kWaveSpeedFraction * wave_speed_,
                  kEdgeFraction * shortest_edge_ / session_.time_step());
}

void VertexDrag::set_velocity(const Vector3& velocity) {
  FixSettings hold;
  hold.select = ids(vertices_);
  hold.velocity = velocity;
  make_(SetFix{fix_, hold}, what_, true);
  velocity_ = velocity;
}

void VertexDrag::drag_to(const Vector3& goal, double duration) {
  goal_ = goal;
  duration_ = duration;
  moving_ = new_goal_ = true;
}

void VertexDrag::move_at_once(const Vector3& goal) {
  moving_ = false;
  FixSettings hold;
  hold.select = ids(vertices_);
  Vector moved = session_.state().position;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    hold.targets.emplace_back(goal + offsets_[i]);
    vertex_block(moved, vertices_[i]) = hold.targets.back();
  }
  const MechanicalSystem& system = session_.system();
  if (const EvaluationStatus status = system.elastic().admissible(moved); !status.ok()) {
    throw InputError(fmt::format(
        "The drag stops here: farther on, element {} would be inverted. While the simulation runs, "
        "the body follows a drag.",
        system.mesh().tetrahedron_id(status.failed_element)));
  }
  make_(SetFix{fix_, hold}, what_, true);
  goal_ = goal;
  velocity_.setZero();
}

void VertexDrag::before_step() {
  if (!moving_) return;
  const Vector3 path = remaining_path();
  const double distance = path.norm();
  const double h = session_.time_step();
  if (distance <= kTolerance * shortest_edge_) {
    moving_ = false;
    set_velocity(Vector3::Zero());
    return;
  }
  if (std::exchange(new_goal_, false)) speed_ = distance / std::max(duration_, h);
  const double speed = std::min({speed_, largest_speed(), distance / h});
  const Vector3 velocity = speed / distance * path;
  // An edit is made only if the velocity changes: at the start, at the end, and with the time step.
  if ((velocity - velocity_).norm() > kTolerance * speed) set_velocity(velocity);
}

void VertexDrag::release() {
  const Vector3 velocity = moving_ ? velocity_ : Vector3::Zero();  // that of the mouse
  moving_ = false;
  // Without velocity the fix is an ordinary fix of these vertices at their present positions.
  if (!prescribed_before_.empty() || !velocity_.isZero(0.0)) set_velocity(Vector3::Zero());
  std::vector<Index> to_release;
  for (const Index v : vertices_) {
    if (std::find(prescribed_before_.begin(), prescribed_before_.end(), v) ==
        prescribed_before_.end()) {
      to_release.push_back(v);
    }
  }
  if (to_release.empty()) return;
  make_(Unfix{ids(to_release), {}}, what_, true);
  // The momenta of some rules swing about those of a prescribed motion.
  ShiftState brake;
  for (const Index v : to_release) {
    const Vector3 impulse =
        session_.system().mass()[v] * velocity - vertex_block(session_.state().momentum, v);
    if (impulse.isZero(0.0)) continue;
    brake.change.vertices.push_back(session_.system().mesh().vertex_id(v));
    brake.change.impulse.push_back(impulse);
  }
  if (!brake.change.vertices.empty()) make_(brake, what_, true);
}

}  // namespace tetraction::viewer
