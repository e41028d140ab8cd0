// Vertices that are dragged with the mouse.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Prescribes the motion of vertices towards a goal, which may change at any time. While the body moves,
/// the vertices get a velocity, so that their positions are continuous and their reactions are those of
/// a motion. The velocity is bounded, and the vertices stop at the goal. While the body does not move,
/// the vertices are moved at once. Used in the solver's thread.
class VertexDrag {
 public:
  /// Makes an edit of the session. Throws InputError if it is refused; then nothing has changed.
  using MakeEdit =
      std::function<void(const Edit&, const std::string& what, bool continues_previous)>;

  /// Fixes the vertices at their present positions. The goal is that of the first vertex; the others
  /// keep their positions relative to it. Throws InputError.
  VertexDrag(const Session& session, std::vector<Index> vertices, MakeEdit make);

  /// Sets the goal of the first vertex, m. The vertex reaches it after `duration` (simulated seconds),
  /// or later if the velocity would be too large.
  void drag_to(const Vector3& goal, double duration);
  /// Moves the vertices to the goal at once. Throws InputError if an element would be inverted or the
  /// session refuses the edit for another reason. The vertices then stay where they are, and the drag
  /// can go on.
  void move_at_once(const Vector3& goal);
  /// Must be called before each step.
  void before_step();
  /// Releases the vertices with the velocity of the mouse. Those that were prescribed before the drag
  /// are fixed at their present positions.
  void release();

 private:
  std::vector<Index> prescribed_among(const std::vector<Index>& vertices) const;
  SelectVertices ids(const std::vector<Index>& vertices) const;
  Vector3 remaining_path() const;
  double largest_speed() const;
  void set_velocity(const Vector3& velocity);

  const Session& session_;
  std::vector<Index> vertices_;
  MakeEdit make_;
  std::string what_;
  std::vector<Index> prescribed_before_;
  std::size_t fix_ = 0;                 // index of the fix that prescribes the motion
  std::vector<Vector3> offsets_;        // of the vertices relative to the first, m
  double shortest_edge_ = 0.0;          // of the edges at the vertices, at rest, m
  double wave_speed_ = 0.0;             // of shear waves, m/s
  Vector3 goal_ = Vector3::Zero();      // of the first vertex
  Vector3 velocity_ = Vector3::Zero();  // prescribed, m/s
  double duration_ = 0.0;               // until the goal shall be reached, s
  double speed_ = 0.0;                  // that is needed for this duration, m/s
  bool moving_ = false;                 // whether the goal has not been reached yet
  bool new_goal_ = false;               // whether no step has been made since the goal was set
};

}  // namespace tetraction::viewer
