#include "obstacle_drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "drag_speed.h"
#include "simulation/session/contact_point.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction::viewer {
namespace {

// The largest way in a step, in thicknesses of the layer. In one step an obstacle should not cross an element, of which
// the layer is usually a tenth.
constexpr double kThicknesses = 2.0;
constexpr double kTolerance = 1e-6;  // relative: of the thickness, and of the speed

ObstacleFrame frame_of(const Session& session, std::size_t number) {
  const ForcePoint at = contact_point(session, session.state());
  return frame_at(session.system().contact()->obstacle(number).motion, at.time, at.load_factor);
}

ObstacleSettings settings_of(const Session& session, std::size_t number) {
  const std::vector<BodyObstacle>& all = session.settings().obstacles;
  if (number >= all.size() || all[number].removed) {
    throw InputError("The obstacle is not there any more.");
  }
  return all[number].settings;
}

}  // namespace

ObstacleDrag::ObstacleDrag(const Session& session, std::size_t number, const Vector3& point,
                           MakeEdit make)
    : session_(session),
      number_(number),
      make_(std::move(make)),
      own_(settings_of(session, number)),
      wave_speed_(slowest_shear_wave(session)),
      goal_(point) {
  what_ = fmt::format("Drag obstacle \"{}\"", own_.name);
  local_ = frame_of(session_, number_).to_local(point);
  ObstacleSettings at_rest = own_;
  at_rest.velocity.setZero();
  at_rest.angular_velocity.setZero();
  at_rest.amplitude.clear();
  make_(SetObstacle{number_, at_rest}, what_, false);
}

Vector3 ObstacleDrag::point() const {
  return frame_of(session_, number_).to_world(local_);
}

double ObstacleDrag::largest_speed() const {
  const double thickness = session_.system().contact()->obstacle(number_).thickness;
  return std::min(kWaveSpeedFraction * wave_speed_,
                  kThicknesses * thickness / session_.time_step());
}

void ObstacleDrag::set(const Vector3& velocity) {
  ObstacleSettings led = own_;
  led.velocity = velocity;
  led.angular_velocity.setZero();
  led.amplitude.clear();
  led.from = 0.0;
  led.until = std::numeric_limits<double>::infinity();
  make_(SetObstacle{number_, led}, what_, true);
  velocity_ = velocity;
}

void ObstacleDrag::drag_to(const Vector3& goal, double duration) {
  goal_ = goal;
  duration_ = duration;
  moving_ = new_goal_ = true;
}

void ObstacleDrag::move_at_once(const Vector3& goal) {
  moving_ = false;
  const Vector3 before = own_.offset;
  own_.offset += goal - point();
  try {
    set(Vector3::Zero());
  } catch (const InputError&) {
    own_.offset = before;
    throw;
  }
  goal_ = goal;
}

void ObstacleDrag::before_step() {
  if (!moving_) return;
  const Vector3 path = goal_ - point();
  const double distance = path.norm();
  const double h = session_.time_step();
  const double thickness = session_.system().contact()->obstacle(number_).thickness;
  if (distance <= kTolerance * thickness) {
    moving_ = false;
    set(Vector3::Zero());
    return;
  }
  if (std::exchange(new_goal_, false)) speed_ = distance / std::max(duration_, h);
  const double speed = std::min({speed_, largest_speed(), distance / h});
  const Vector3 velocity = speed / distance * path;
  // An edit is made only if the velocity changes: at the start, at the end, and with the time step.
  if ((velocity - velocity_).norm() > kTolerance * speed) set(velocity);
}

void ObstacleDrag::release() {
  moving_ = false;
  make_(SetObstacle{number_, own_}, what_, true);
}

}  // namespace tetraction::viewer
