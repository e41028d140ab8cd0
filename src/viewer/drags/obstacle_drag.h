// An obstacle that is dragged with the mouse.
#pragma once

#include <functional>
#include <string>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Moves an obstacle towards a goal, which may change at any time. While the body moves, the obstacle gets a bounded
/// velocity, so that contact feels a motion and the balance has its work, and it stops at the goal. While the body
/// does not move, the obstacle is moved at once. Used in the solver's thread.
class ObstacleDrag {
 public:
  /// Makes an edit of the session. Throws InputError if it is refused; then nothing has changed.
  using MakeEdit =
      std::function<void(const Edit&, const std::string& what, bool continues_previous)>;

  /// `point` is the point of the obstacle under the mouse, m. Its own motion rests during the drag. Throws InputError
  /// if there is no such obstacle.
  ObstacleDrag(const Session& session, std::size_t number, const Vector3& point, MakeEdit make);

  /// Sets the goal of the point, m. It is reached after `duration` (simulated seconds), or later if the velocity would
  /// be too large.
  void drag_to(const Vector3& goal, double duration);
  /// Moves the obstacle to the goal at once. Throws InputError if the body would penetrate it. It then stays where it
  /// is, and the drag can go on.
  void move_at_once(const Vector3& goal);
  /// Must be called before each step.
  void before_step();
  /// Ends the drag. The obstacle goes on with its own motion from where it is.
  void release();

 private:
  Vector3 point() const;
  double largest_speed() const;
  void set(const Vector3& velocity);

  const Session& session_;
  std::size_t number_;
  MakeEdit make_;
  std::string what_;
  ObstacleSettings own_;                // before the drag, with the present offset
  Vector3 local_ = Vector3::Zero();     // the point, in the frame of the obstacle
  double wave_speed_ = 0.0;             // of shear waves in the body, m/s
  Vector3 goal_ = Vector3::Zero();      // of the point
  Vector3 velocity_ = Vector3::Zero();  // m/s
  double duration_ = 0.0;               // until the goal shall be reached, s
  double speed_ = 0.0;                  // that is needed for this duration, m/s
  bool moving_ = false;                 // whether the goal has not been reached yet
  bool new_goal_ = false;               // whether no step has been made since the goal was set
};

}  // namespace tetraction::viewer
