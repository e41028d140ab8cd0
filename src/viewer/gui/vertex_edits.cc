#include "vertex_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace tetraction::viewer {
namespace {

constexpr double kCatchUp = 0.08;  // s of wall clock in which a held vertex reaches the mouse

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
  // A vertex that is fixed already keeps its own motion.
  const std::vector<Index> fixed = fixed_among(vertices);
  std::vector<Index> loose;
  for (const Index v : vertices) {
    if (std::find(fixed.begin(), fixed.end(), v) == fixed.end()) loose.push_back(v);
  }
  if (loose.empty()) return;
  FixSettings settings;
  settings.select = ids(loose);
  simulation_.edit(SetFix{std::nullopt, settings}, "Fix " + names(loose));
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
  if (!fixed.empty()) simulation_.edit(Unfix{ids(fixed), {}}, what);
  FixSettings settings;
  settings.select = ids(vertices);
  settings.offset = target - mean_position(vertices);
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
  // Forces add up: what is missing to the wanted one is added, for all with the same force at once.
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

void VertexEdits::grab(const std::vector<Index>& vertices) {
  if (vertices.empty()) return;
  const auto snapshot = simulation_.snapshot();
  fixed_before_ = fixed_among(vertices);
  held_ = vertices;
  start_.clear();
  for (const Index v : held_) start_.emplace_back(vertex_block(snapshot->position, v));
  wanted_.setZero();
  const std::string what = "Drag " + names(held_);
  if (!fixed_before_.empty()) simulation_.edit(Unfix{ids(fixed_before_), {}}, what);
  FixSettings settings;
  settings.select = ids(held_);
  simulation_.edit(SetFix{std::nullopt, settings}, what, !fixed_before_.empty());
  moving_ = false;
  edited_at_ = snapshot->generation;
}

void VertexEdits::drag(const Vector3& displacement) {
  wanted_ = displacement;
}

void VertexEdits::follow(const Snapshot& snapshot) {
  // One edit a snapshot: more would pile up before a solver that is slower than the mouse.
  if (held_.empty() || snapshot.generation <= edited_at_) return;
  const Vector3 now = vertex_block(snapshot.position, held_.front());
  const Vector3 missing = start_.front() + wanted_ - now;
  const bool there = missing.norm() <= 1e-6 * (1.0 + now.norm());
  if (there && !moving_) return;
  FixSettings settings;
  settings.select = ids(held_);
  if (!snapshot.running) {
    for (const Vector3& start : start_) settings.targets.emplace_back(start + wanted_);
    moving_ = false;
  } else {
    const double h = simulation_.settings().time.step;
    const double time = std::max(2.0 * h, kCatchUp * snapshot.real_time_factor);
    if (!there) settings.velocity = missing / time;
    moving_ = !there;
  }
  simulation_.edit(SetFix{kNewest, settings}, "Drag " + names(held_), true);
  edited_at_ = snapshot.generation;
}

void VertexEdits::release() {
  if (held_.empty()) return;
  const std::vector<Index> held = std::exchange(held_, {});
  const std::string what = "Drag " + names(held);
  if (moving_) {
    FixSettings still;
    still.select = ids(held);
    simulation_.edit(SetFix{kNewest, still}, what, true);
  }
  std::vector<Index> loose;
  for (const Index v : held) {
    if (std::find(fixed_before_.begin(), fixed_before_.end(), v) == fixed_before_.end()) {
      loose.push_back(v);
    }
  }
  if (!loose.empty()) simulation_.edit(Unfix{ids(loose), {}}, what, true);
}

}  // namespace tetraction::viewer
