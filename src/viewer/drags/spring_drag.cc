#include "spring_drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "viewer/snapshot_maker.h"

namespace tetraction::viewer {
namespace {

// Stiffness over mass of the spring as a fraction of ω²_max = (2/h_crit)². With critical damping it
// lowers the stability limit by 5 % at most (docs/theory.md, limit with damping).
constexpr double kStiffnessFraction = 2.5e-3;
// Largest force over shear modulus and cross-section of the area of influence.
constexpr double kLargestStress = 0.5;
constexpr double kUsualRadius = 1.6;  // in mean lengths of the edges at the grabbed vertex

double usual_radius(const RestState& rest, Index vertex) {
  double sum = 0.0;
  int count = 0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    if (std::find(nodes.begin(), nodes.end(), vertex) == nodes.end()) continue;
    for (const Index b : nodes) {
      if (b == vertex) continue;
      sum += (rest.position(vertex) - rest.position(b)).norm();
      ++count;
    }
  }
  return kUsualRadius * sum / std::max(count, 1);
}

}  // namespace

SpringDrag::SpringDrag(const Session& session, std::vector<Index> vertices, double radius,
                       double critical_step, MakeEdit make)
    : session_(session),
      grabbed_(std::move(vertices)),
      radius_(radius > 0.0 ? radius : usual_radius(session.system().rest(), grabbed_.front())),
      critical_step_(critical_step),
      make_(std::move(make)),
      before_(session.settings().pull),
      goal_(vertex_block(session.state().position, grabbed_.front())) {
  const TetMesh& mesh = session_.system().mesh();
  what_ = grabbed_.size() == 1 ? fmt::format("Drag vertex {}", mesh.vertex_id(grabbed_.front()))
                               : fmt::format("Drag {} vertices", grabbed_.size());
  choose_area();
}

void SpringDrag::choose_area() {
  const MechanicalSystem& system = session_.system();
  const TetMesh& mesh = system.mesh();
  const std::vector<std::uint8_t> held = prescribed_vertices(session_);
  const auto at_rest = [&](Index v) { return mesh.vertices[static_cast<std::size_t>(v)]; };
  pulled_.clear();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (held[static_cast<std::size_t>(v)] != 0) continue;
    if (std::any_of(grabbed_.begin(), grabbed_.end(), [&](Index g) {
          return v == g || (at_rest(v) - at_rest(g)).norm() <= radius_;
        })) {
      pulled_.push_back(v);
    }
  }
  mass_ = 0.0;
  spring_.vertices.clear();
  for (const Index v : pulled_) {
    mass_ += system.mass()[v];
    spring_.vertices.push_back(mesh.vertex_id(v));
  }
  const double omega = 2.0 / critical_step_;
  // A body without stiffness has no limit.
  const double rate = std::isfinite(omega) ? kStiffnessFraction * omega * omega : 0.0;
  spring_.stiffness = rate * mass_;
  spring_.damping = 2.0 * std::sqrt(rate) * mass_;
  double modulus = std::numeric_limits<double>::infinity();
  for (const MaterialField& material : system.materials()) {
    modulus = std::min(modulus, material.lame_range().least.mu);
  }
  const double density = system.total_mass() / mesh.total_volume();
  const double section = std::pow(mass_ / density, 2.0 / 3.0);
  longest_ = kLargestStress * modulus * section / spring_.stiffness;
  offset_ =
      mean(session_.state().position) - vertex_block(session_.state().position, grabbed_.front());
}

Vector3 SpringDrag::mean(const Vector& field) const {
  Vector3 sum = Vector3::Zero();
  for (const Index v : pulled_) sum += session_.system().mass()[v] * vertex_block(field, v);
  return sum / mass_;
}

void SpringDrag::make(const Edit& edit) {
  make_(edit, what_, made_);
  made_ = true;
}

void SpringDrag::pull() {
  const Vector3 from = mean(session_.state().position);
  const Vector3 wanted = goal_ + offset_ - from;
  const double length = wanted.norm();
  const Vector3 target = from + (length > longest_ ? longest_ / length : 1.0) * wanted;
  // Edits that change next to nothing would only lengthen the recording.
  constexpr double kRelevant = 0.02;
  if (made_ && (target - spring_.target).norm() <= kRelevant * std::min(longest_, radius_)) return;
  spring_.target = target;
  make(SetPull{spring_});
}

void SpringDrag::drag_to(const Vector3& goal, double duration) {
  mouse_speed_ = duration > 0.0 ? (goal - goal_).norm() / duration : 0.0;
  goal_time_ = session_.time();
  goal_duration_ = duration;
  goal_ = goal;
  has_goal_ = true;
  pull();
}

void SpringDrag::set_radius(double radius) {
  radius_ = radius;
  choose_area();
  if (!has_goal_) return;
  spring_.target = Vector3::Constant(std::numeric_limits<double>::max());
  pull();
}

void SpringDrag::before_step() {
  if (has_goal_) pull();
}

void SpringDrag::release() {
  if (!made_) return;
  make(SetPull{before_});
  const bool rests = session_.time() > goal_time_ + 2.0 * goal_duration_;
  const double allowed = rests ? 0.0 : mouse_speed_;
  Vector3 momentum = Vector3::Zero();
  for (const Index v : pulled_) momentum += vertex_block(session_.state().momentum, v);
  const Vector3 way = goal_ + offset_ - mean(session_.state().position);
  if (way.isZero(0.0)) return;
  const Vector3 direction = way.normalized();
  const double excess = momentum.dot(direction) / mass_ - allowed;
  // Slow motions of a body that hangs on the spring are its own.
  constexpr double kNoticeable = 0.02;
  if (!(excess > kNoticeable * radius_ * std::sqrt(spring_.stiffness / mass_))) return;
  ShiftState brake;
  for (const Index v : pulled_) {
    brake.change.vertices.push_back(session_.system().mesh().vertex_id(v));
    brake.change.impulse.emplace_back(-excess * session_.system().mass()[v] * direction);
  }
  make(brake);
}

}  // namespace tetraction::viewer
