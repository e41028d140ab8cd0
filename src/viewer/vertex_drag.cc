#include "vertex_drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "snapshot_maker.h"

namespace tetraction::viewer {
namespace {

// A vertex inverts elements if it is faster than the waves in the body, or if it passes an element
// in one step.
constexpr double kOfSound = 0.25;
constexpr double kOfEdge = 0.2;  // in one step
constexpr double kThere = 1e-6;  // of an edge; within this distance the goal is reached

double shortest_edge_at(const TetMesh& mesh, const std::vector<Index>& vertices) {
  std::vector<bool> chosen(static_cast<std::size_t>(mesh.vertex_count()), false);
  for (const Index v : vertices) chosen[static_cast<std::size_t>(v)] = true;
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& tetrahedron : mesh.tetrahedra) {
    for (std::size_t i = 0; i < 4; ++i) {
      const auto a = static_cast<std::size_t>(tetrahedron[i]);
      if (!chosen[a]) continue;
      for (std::size_t j = 0; j < 4; ++j) {
        const auto b = static_cast<std::size_t>(tetrahedron[j]);
        if (b != a) shortest = std::min(shortest, (mesh.vertices[a] - mesh.vertices[b]).norm());
      }
    }
  }
  return shortest;
}

double slowest_sound(const Session& session) {
  double slowest = std::numeric_limits<double>::infinity();
  for (const MaterialSettings& settings : session.materials()) {
    const LameParameters lame = initial_lame(make_material(settings));
    if (lame.mu > 0.0) slowest = std::min(slowest, std::sqrt(lame.mu / settings.density));
  }
  return slowest;
}

}  // namespace

VertexDrag::VertexDrag(const Session& session, std::vector<Index> vertices, MakeEdit make)
    : session_(session),
      vertices_(std::move(vertices)),
      make_(std::move(make)),
      held_before_(held_among(vertices_)),
      edge_(shortest_edge_at(session.system().mesh(), vertices_)),
      sound_(slowest_sound(session)) {
  const TetMesh& mesh = session_.system().mesh();
  what_ = vertices_.size() == 1 ? fmt::format("Drag vertex {}", mesh.vertex_id(vertices_.front()))
                                : fmt::format("Drag {} vertices", vertices_.size());
  const Vector& position = session_.state().position;
  const Vector3 first = vertex_block(position, vertices_.front());
  for (const Index v : vertices_) beside_.emplace_back(vertex_block(position, v) - first);
  goal_ = first;
  if (!held_before_.empty()) make_(Unfix{ids(held_before_), {}}, what_, false);
  FixSettings hold;
  hold.select = ids(vertices_);
  fix_ = session_.fix_count();
  make_(SetFix{std::nullopt, hold}, what_, !held_before_.empty());
}

std::vector<Index> VertexDrag::held_among(const std::vector<Index>& vertices) const {
  const std::vector<std::uint8_t> held = held_vertices(session_);
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

Vector3 VertexDrag::missing() const {
  return goal_ - vertex_block(session_.state().position, vertices_.front());
}

double VertexDrag::fastest() const {
  return std::min(kOfSound * sound_, kOfEdge * edge_ / session_.time_step());
}

void VertexDrag::move_with(const Vector3& velocity) {
  FixSettings hold;
  hold.select = ids(vertices_);
  hold.velocity = velocity;
  make_(SetFix{fix_, hold}, what_, true);
  velocity_ = velocity;
}

void VertexDrag::lead_to(const Vector3& goal, double duration) {
  goal_ = goal;
  duration_ = duration;
  under_way_ = new_goal_ = true;
}

void VertexDrag::put_at(const Vector3& goal) {
  goal_ = goal;
  under_way_ = false;
  FixSettings hold;
  hold.select = ids(vertices_);
  for (const Vector3& beside : beside_) hold.targets.emplace_back(goal_ + beside);
  make_(SetFix{fix_, hold}, what_, true);
  velocity_.setZero();
}

void VertexDrag::before_step() {
  if (!under_way_) return;
  const Vector3 way = missing();
  const double distance = way.norm();
  const double h = session_.time_step();
  if (distance <= kThere * edge_) {
    under_way_ = false;
    move_with(Vector3::Zero());
    return;
  }
  if (std::exchange(new_goal_, false)) speed_ = distance / std::max(duration_, h);
  const double speed = std::min({speed_, fastest(), distance / h});
  const Vector3 velocity = speed / distance * way;
  // Edits are made only when they change something: at the start, at the end, and when the step
  // changes.
  if ((velocity - velocity_).norm() > kThere * speed) move_with(velocity);
}

void VertexDrag::release() {
  under_way_ = false;
  // The fix has no target of its own any more. From now on it is an ordinary fix of those vertices.
  if (!held_before_.empty() || !velocity_.isZero(0.0)) move_with(Vector3::Zero());
  std::vector<Index> loose;
  for (const Index v : vertices_) {
    if (std::find(held_before_.begin(), held_before_.end(), v) == held_before_.end()) {
      loose.push_back(v);
    }
  }
  if (!loose.empty()) make_(Unfix{ids(loose), {}}, what_, true);
}

}  // namespace tetraction::viewer
