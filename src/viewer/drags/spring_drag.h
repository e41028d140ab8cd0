// Vertices that the mouse pulls with a damped spring.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Pulls vertices with the spring of the section [pull], so that the body gives way and its motion is
/// that of a user's force. The spring pulls the mean of all vertices in an area of influence around
/// those that were grabbed, except prescribed ones. Its stiffness is limited such that the stability
/// limit of the explicit rules stays, and its force such that it does not tear elements. Used in the
/// solver's thread.
class SpringDrag {
 public:
  /// Makes an edit of the session. Throws InputError if it is refused; then nothing has changed.
  using MakeEdit =
      std::function<void(const Edit&, const std::string& what, bool continues_previous)>;

  /// The first vertex is the one under the mouse. `radius` of the area at rest, m; 0 or less: the
  /// usual one. `critical_step` is the stability limit now, s.
  SpringDrag(const Session& session, std::vector<Index> vertices, double radius,
             double critical_step, MakeEdit make);

  /// Sets the place of the mouse, m. `duration` is the simulated time since the place before, s.
  void drag_to(const Vector3& goal, double duration);
  void set_radius(double radius);
  /// Must be called before each step: the end of the spring follows the body while the mouse is far.
  void before_step();
  /// Brings the scene's own spring back, and takes away the velocity in the direction of the mouse that the mouse did not have.
  void release();

  double radius() const { return radius_; }
  const std::vector<Index>& pulled() const { return pulled_; }

 private:
  void choose_area();
  Vector3 mean(const Vector& field) const;
  void pull();
  void make(const Edit& edit);

  const Session& session_;
  std::vector<Index> grabbed_;
  double radius_;
  double critical_step_;
  MakeEdit make_;
  std::string what_;
  bool made_ = false;  // whether an edit of this drag has been made
  std::vector<Index> pulled_;
  PullSettings before_;  // the spring of the scene, which comes back
  PullSettings spring_;
  double mass_ = 0.0;         // of the area, kg
  double longest_ = 0.0;      // length of the spring at its largest force, m
  Vector3 offset_;            // of the area's mean from the grabbed vertex, m
  Vector3 goal_;              // of the grabbed vertex, m
  bool has_goal_ = false;     // whether the mouse has moved
  double mouse_speed_ = 0.0;  // m per simulated s
  double goal_time_ = 0.0;    // when the goal was set, simulated s
  double goal_duration_ = 0.0;
};

}  // namespace tetraction::viewer
