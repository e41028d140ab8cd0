#include "obstacle_notes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "failure_measures.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Two instants of a step beside obstacles.
struct StepBesideObstacles {
  const MechanicalSystem& system;
  const State& from;
  double end = 0.0;
  bool is_static = false;

  ForcePoint point(const Vector& x, double at) const {
    ForcePoint result = system.force_point(x, is_static ? 0.0 : at);
    if (is_static) result.load_factor = at;
    return result;
  }
  ForcePoint begin_point() const { return point(from.position, from.time); }
};

// The name of what holds or leads a vertex, in the directions in which it cannot give way to an obstacle; empty if it
// can.
std::string holder_of(const StepBesideObstacles& step, Index v) {
  const MechanicalSystem& system = step.system;
  if (system.coordinates().is_free(v) || system.coordinates().set_of(v) >= 0) return {};
  constexpr double kNothing = 1e-9;
  HessianBlocks support;
  support.reset(system.vertex_count());
  system.contact()->add_support(step.begin_point(), Contact::Support::kPossible, support);
  const Matrix3 block = support.diagonal(v);
  const Matrix columns = system.coordinates().map(v).columns;
  if (columns.cols() > 0 &&
      (columns.transpose() * block * columns).norm() > kNothing * block.norm())
    return {};
  for (const PrescribedVertices& held : system.constraints().list().held) {
    if (std::find(held.vertices.begin(), held.vertices.end(), v) != held.vertices.end()) {
      return held.name;
    }
  }
  return "a constraint";
}

std::optional<ObstacleNote> held_vertex_note(const StepBesideObstacles& step,
                                             const Vector& prescribed) {
  constexpr int kMostTried = 64;
  const MechanicalSystem& system = step.system;
  std::vector<Index> held;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    if (!system.coordinates().is_free(v)) held.push_back(v);
  }
  for (int i = 0; i < kMostTried && !held.empty(); ++i) {
    const auto crossing =
        system.contact()->crossing(step.begin_point(), step.point(prescribed, step.end), &held);
    if (!crossing) return std::nullopt;
    const Contact& contact = *system.contact();
    const bool is_body = crossing->obstacle == contact.size();
    const std::string partner = contact.partner(crossing->obstacle);
    if (const std::string holder = holder_of(step, crossing->vertex); !holder.empty()) {
      return ObstacleNote{
          fmt::format("vertex {} cannot give way to {}, because it moves as {} prescribes",
                      system.mesh().vertex_id(crossing->vertex), partner, holder),
          fmt::format("End the run or the motion before they meet, move {} or the support aside, "
                      "or leave this part of the surface out with the key select of {}.",
                      is_body ? "the other body" : "the obstacle",
                      is_body ? "[contact]" : partner)};
    }
    held.erase(std::find(held.begin(), held.end(), crossing->vertex));
  }
  return std::nullopt;
}

// How far an obstacle moves towards or away from a place that it sees at `from` and then at `to`. What slides along
// itself, as a drum that turns about its axis, does not move.
double normal_motion(const ObstacleShape& shape, const Vector3& from, const Vector3& to) {
  if (const auto* plane = std::get_if<PlaneShape>(&shape)) {
    return std::abs(plane->normal.stableNormalized().dot(to - from));
  }
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    return std::abs((to - sphere->center).norm() - (from - sphere->center).norm());
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    const Vector3 axis = cylinder->axis.stableNormalized();
    const auto radius = [&](const Vector3& x) { return (x - cylinder->point).cross(axis).norm(); };
    return std::abs(radius(to) - radius(from));
  }
  if (std::holds_alternative<RoomShape>(shape)) return (to - from).cwiseAbs().maxCoeff();
  return (to - from).norm();
}

std::optional<ObstacleNote> fast_obstacle_note(const StepBesideObstacles& step) {
  constexpr double kShare = 0.5;  // of an element
  const MechanicalSystem& system = step.system;
  const double length = step.end - step.from.time;
  Vector velocity = Vector::Zero(system.dof_count());
  if (!step.is_static) system.velocity_of(step.from.momentum, velocity);
  const Vector x = step.from.position + length * velocity;
  const auto crossing = system.contact()->crossing(step.begin_point(), step.point(x, step.end));
  if (!crossing || crossing->obstacle == system.contact()->size()) return std::nullopt;
  const Obstacle& obstacle = system.contact()->obstacle(crossing->obstacle);
  const auto frame = [&](double at) {
    return step.is_static ? frame_at(obstacle.motion, 0.0, at) : frame_at(obstacle.motion, at);
  };
  const Vector3 place = vertex_block(step.from.position, crossing->vertex);
  const double moved = normal_motion(obstacle.shape, frame(step.from.time).to_local(place),
                                     frame(step.end).to_local(place));
  const double element = length_of_vertex(system);
  if (!(moved > kShare * element)) return std::nullopt;
  const double shorter = kShare * element / moved * length;
  ObstacleNote note{
      fmt::format("the obstacle \"{}\" moves by {:.3g} m in this step, {:.2g} times the size of an "
                  "element, and meets vertex {} on its way",
                  obstacle.name, moved, moved / element, system.mesh().vertex_id(crossing->vertex)),
      ""};
  note.remedy = step.is_static
                    ? fmt::format(
                          "Take load steps of {:.2g} or less, or move the obstacle by a smaller "
                          "offset.",
                          shorter)
                    : fmt::format(
                          "Take a time.step of {:.2g} s or less, in which it moves by half of an "
                          "element, time.retry = {}, or a slower motion of the obstacle.",
                          shorter, static_cast<int>(std::ceil(std::log2(moved / element))) + 2);
  return note;
}

// A body whose obstacles press it so that no material is between them any more.
std::optional<ObstacleNote> crushed_body_note(const StepBesideObstacles& step) {
  const MechanicalSystem& system = step.system;
  Vector pressing = Vector::Zero(system.dof_count());
  system.contact()->add_gradient(step.begin_point(), pressing);
  const double strain = strain_of(system, pressing);
  if (!(strain > kAbsurdStrain)) return std::nullopt;
  double sum = 0.0;
  for (Index v = 0; v < system.vertex_count(); ++v) sum += vertex_block(pressing, v).norm();
  return ObstacleNote{
      fmt::format("contact crushes the body: it presses with {:.3g} N altogether, which would "
                  "strain the stiffest material {:.2g} times its length",
                  sum, strain),
      fmt::format(
          "What moves a body faster than the pressure waves of its material, at {:.3g} m/s, "
          "crushes it with any size of the steps. Make obstacles and bodies slower, leave "
          "more room between obstacles, or take a stiffer material.",
          wave_speed(system))};
}

}  // namespace

std::optional<ObstacleNote> obstacle_note(const MechanicalSystem& system, const State& from,
                                          double end, const Vector& prescribed,
                                          const Vector& attempted, bool is_static) {
  const Contact* contact = system.contact();
  if (contact == nullptr || !from.position.allFinite() || !prescribed.allFinite()) {
    return std::nullopt;
  }
  const StepBesideObstacles step{system, from, end, is_static};
  if (contact->undefined_vertex(step.begin_point()) >= 0) return std::nullopt;
  if (auto note = held_vertex_note(step, prescribed)) return note;
  if (auto note = fast_obstacle_note(step)) return note;
  if (auto note = crushed_body_note(step)) return note;
  if (is_static || attempted.size() == 0 || !attempted.allFinite()) return std::nullopt;
  const auto crossing = contact->crossing(step.begin_point(), step.point(attempted, end));
  if (!crossing) return std::nullopt;
  const double thickness = contact->thickness(crossing->obstacle);
  const bool is_body = crossing->obstacle == contact->size();
  Vector velocity;
  system.velocity_of(from.momentum, velocity);
  const double speed =
      is_body ? fastest(system, from.momentum) : vertex_block(velocity, crossing->vertex).norm();
  return ObstacleNote{
      fmt::format("vertex {} would penetrate {} or pass through it",
                  system.mesh().vertex_id(crossing->vertex), contact->partner(crossing->obstacle)),
      fmt::format("{} at {:.3g} m/s, and should take ten steps to cross the layer of {:.3g} m: "
                  "take {}a larger thickness of {}; if the layer gives way under the impact, raise "
                  "its stiffness.",
                  is_body ? "Vertices move" : "It moves", speed, thickness,
                  speed > 0.0
                      ? fmt::format("a time.step of {:.2g} s or less, or ", 0.1 * thickness / speed)
                      : "a smaller time.step, or ",
                  is_body ? "the layer (contact.thickness)" : "the obstacle")};
}

}  // namespace tetraction
