#include "vertex_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

// The vector with a dash for each component that was not typed.
std::string text(const EnteredVector& x, const char* unit) {
  const DisplayUnit shown = display_unit(unit);
  const auto component = [&](std::size_t i) {
    const double value = shown.from_si(x.value[static_cast<Index>(i)]);
    return x.typed[i] ? fmt::format("{:.4g}", value) : std::string("–");
  };
  return fmt::format("({}, {}, {}) {}", component(0), component(1), component(2), shown.text);
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

// The translation that brings the mean position of the vertices to the target.
Vector3 VertexEdits::offset_to(const std::vector<Index>& vertices,
                               const EnteredVector& target) const {
  const auto snapshot = simulation_.snapshot();
  Vector3 sum = Vector3::Zero();
  for (const Index v : vertices) sum += vertex_block(snapshot->position, v);
  const Vector3 mean = sum / static_cast<double>(vertices.size());
  return target.over(mean) - mean;
}

void VertexEdits::move_to(const std::vector<Index>& vertices, const EnteredVector& target) {
  if (vertices.empty()) return;
  if (!fixed_among(vertices).empty()) {
    fix_at(vertices, target);
    return;
  }
  ShiftState edit;
  edit.change.vertices = ids(vertices).ids;
  edit.change.displacement.assign(vertices.size(), offset_to(vertices, target));
  simulation_.edit(edit, fmt::format("Move {} to {}", names(vertices), text(target, "m")));
}

void VertexEdits::fix_at(const std::vector<Index>& vertices, const EnteredVector& target) {
  if (vertices.empty()) return;
  const std::string what = fmt::format("Fix {} at {}", names(vertices), text(target, "m"));
  const std::vector<Index> fixed = fixed_among(vertices);
  const auto snapshot = simulation_.snapshot();
  const Vector3 offset = offset_to(vertices, target);
  if (!fixed.empty()) simulation_.edit(Unfix{ids(fixed), {}}, what);
  FixSettings settings;
  settings.select = ids(vertices);
  for (const Index v : vertices) {
    settings.targets.emplace_back(vertex_block(snapshot->position, v) + offset);
  }
  simulation_.edit(SetFix{std::nullopt, settings}, what, !fixed.empty());
}

void VertexEdits::set_momentum(const std::vector<Index>& vertices, const EnteredVector& value) {
  if (vertices.empty()) return;
  const std::string what = fmt::format("Momentum {} of {}", text(value, "kg m/s"), names(vertices));
  if (value.is_whole()) {
    MomentumSettings settings;
    settings.select = ids(vertices);
    settings.value = value.value;
    simulation_.edit(SetMomentum{settings}, what);
    return;
  }
  const auto snapshot = simulation_.snapshot();
  ShiftState edit;
  edit.change.vertices = ids(vertices).ids;
  for (const Index v : vertices) {
    const Vector3 now = vertex_block(snapshot->momentum, v);
    edit.change.impulse.emplace_back(value.over(now) - now);
  }
  simulation_.edit(edit, what);
}

void VertexEdits::set_force(const std::vector<Index>& vertices, const EnteredVector& value) {
  // Forces on a vertex are added. Therefore this adds the difference to the wanted force, with one edit
  // for all vertices that have the same difference. Other loads, such as a pressure, stay.
  const auto snapshot = simulation_.snapshot();
  std::map<std::array<double, 3>, std::vector<Index>> by_difference;
  for (const Index v : vertices) {
    const Vector3 now = vertex_block(snapshot->user_force, v);
    const Vector3 difference = value.over(now) - now;
    if (difference.isZero(0.0)) continue;
    by_difference[{difference.x(), difference.y(), difference.z()}].push_back(v);
  }
  bool continues_previous = false;  // all are undone together
  for (const auto& [difference, members] : by_difference) {
    ForceSettings settings;
    settings.select = ids(members);
    settings.vector = Vector3(difference[0], difference[1], difference[2]);
    simulation_.edit(SetForce{std::nullopt, settings},
                     fmt::format("Force {} on {}", text(value, "N"), names(vertices)),
                     std::exchange(continues_previous, true));
  }
}

void VertexEdits::grab(std::vector<Index> vertices, Index dragged, bool exact) {
  const auto first = std::find(vertices.begin(), vertices.end(), dragged);
  if (first == vertices.end()) return;
  std::iter_swap(vertices.begin(), first);
  // The spring pulls free vertices. A vertex that is held is led to another place.
  if (exact || !fixed_among(vertices).empty()) {
    simulation_.grab(std::move(vertices));
  } else {
    simulation_.pull(std::move(vertices), radius_);
  }
  dragging_ = true;
}

void VertexEdits::grab_obstacle(std::size_t number, const Vector3& point) {
  simulation_.grab_obstacle(number, point);
  dragging_ = true;
}

double VertexEdits::scale_area(double factor) {
  const double now = simulation_.snapshot()->pull_radius;
  if (!dragging_ || !(now > 0.0)) return 0.0;
  radius_ = factor * now;
  simulation_.set_pull_radius(radius_);
  return radius_;
}

void VertexEdits::drag_to(const Vector3& position) {
  if (dragging_) simulation_.drag_to(position);
}

void VertexEdits::release() {
  if (std::exchange(dragging_, false)) simulation_.release();
}

}  // namespace tetraction::viewer
