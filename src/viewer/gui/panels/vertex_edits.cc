#include "vertex_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace tetraction::viewer {
namespace {

std::string text(const Vector3& x, const char* unit) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) {}", x.x(), x.y(), x.z(), unit);
}

}  // namespace

SelectVertices VertexEdits::ids(const std::vector<Index>& vertices) const {
  SelectVertices select;
  for (const Index v : vertices) {
    select.ids.push_back(simulation_.mesh().vertex_id(v));
  }
  return select;
}

std::string VertexEdits::names(const std::vector<Index>& vertices) const {
  if (vertices.size() != 1) return fmt::format("{} vertices", vertices.size());
  return fmt::format("vertex {}", simulation_.mesh().vertex_id(vertices.front()));
}

std::vector<Index> VertexEdits::fixed_among(const std::vector<Index>& vertices) const {
  const auto snapshot = simulation_.snapshot();
  std::vector<Index> fixed;
  for (const Index v : vertices) {
    if (snapshot->fixed[static_cast<std::size_t>(v)] != 0) fixed.push_back(v);
  }
  return fixed;
}

void VertexEdits::fix(const std::vector<Index>& vertices) {
  // A vertex that is already fixed keeps its prescribed motion.
  const std::vector<Index> fixed = fixed_among(vertices);
  std::vector<Index> to_fix;
  for (const Index v : vertices) {
    if (std::find(fixed.begin(), fixed.end(), v) == fixed.end()) to_fix.push_back(v);
  }
  if (to_fix.empty()) return;
  FixSettings settings;
  settings.select = ids(to_fix);
  simulation_.edit(SetFix{std::nullopt, settings}, "Fix " + names(to_fix));
}

void VertexEdits::unfix(const std::vector<Index>& vertices) {
  const std::vector<Index> fixed = fixed_among(vertices);
  if (!fixed.empty()) simulation_.edit(Unfix{ids(fixed), {}}, "Unfix " + names(fixed));
}

Vector3 VertexEdits::mean_position(const std::vector<Index>& vertices) const {
  const auto snapshot = simulation_.snapshot();
  Vector3 sum = Vector3::Zero();
  for (const Index v : vertices) sum += vertex_block(snapshot->position, v);
  return sum / static_cast<double>(vertices.size());
}

void VertexEdits::move_to(const std::vector<Index>& vertices, const Vector3& target) {
  if (vertices.empty()) return;
  if (!fixed_among(vertices).empty()) {
    fix_at(vertices, target);
    return;
  }
  ShiftState edit;
  edit.shift.vertices = ids(vertices).ids;
  edit.shift.displacement.assign(vertices.size(), target - mean_position(vertices));
  simulation_.edit(edit, fmt::format("Move {} to {}", names(vertices), text(target, "m")));
}

void VertexEdits::fix_at(const std::vector<Index>& vertices, const Vector3& target) {
  if (vertices.empty()) return;
  const std::string what = fmt::format("Fix {} at {}", names(vertices), text(target, "m"));
  const std::vector<Index> fixed = fixed_among(vertices);
  const auto snapshot = simulation_.snapshot();
  const Vector3 offset = target - mean_position(vertices);
  if (!fixed.empty()) simulation_.edit(Unfix{ids(fixed), {}}, what);
  FixSettings settings;
  settings.select = ids(vertices);
  for (const Index v : vertices) {
    settings.targets.emplace_back(vertex_block(snapshot->position, v) + offset);
  }
  simulation_.edit(SetFix{std::nullopt, settings}, what, !fixed.empty());
}

void VertexEdits::set_momentum(const std::vector<Index>& vertices, const Vector3& value) {
  if (vertices.empty()) return;
  MomentumSettings settings;
  settings.select = ids(vertices);
  settings.value = value;
  simulation_.edit(SetMomentum{settings},
                   fmt::format("Momentum {} of {}", text(value, "kg m/s"), names(vertices)));
}

void VertexEdits::set_force(const std::vector<Index>& vertices, const Vector3& value) {
  // Forces on a vertex are added. Therefore this adds the difference to the wanted force, with one edit
  // for all vertices that have the same difference.
  const auto snapshot = simulation_.snapshot();
  std::map<std::array<double, 3>, std::vector<Index>> by_force;
  for (const Index v : vertices) {
    const Vector3 now = vertex_block(snapshot->external_force, v);
    by_force[{now.x(), now.y(), now.z()}].push_back(v);
  }
  for (const auto& [now, members] : by_force) {
    ForceSettings settings;
    settings.select = ids(members);
    settings.vector = value - Vector3(now[0], now[1], now[2]);
    if (settings.vector.isZero(0.0)) continue;
    simulation_.edit(SetForce{std::nullopt, settings},
                     fmt::format("Force {} on {}", text(value, "N"), names(members)));
  }
}

void VertexEdits::grab(std::vector<Index> vertices, Index dragged) {
  const auto first = std::find(vertices.begin(), vertices.end(), dragged);
  if (first == vertices.end()) return;
  std::iter_swap(vertices.begin(), first);
  simulation_.grab(std::move(vertices));
  dragging_ = true;
}

void VertexEdits::drag_to(const Vector3& position) {
  if (dragging_) simulation_.drag_to(position);
}

void VertexEdits::release() {
  if (std::exchange(dragging_, false)) simulation_.release();
}

}  // namespace tetraction::viewer
