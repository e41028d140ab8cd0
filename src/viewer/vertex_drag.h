// Vertices that the mouse holds and leads.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Holds vertices and leads them to a goal, which may change at any time: by a velocity while the body
/// moves, so that nothing jumps and the reaction means something, at once while it does not. The
/// velocity is bounded and ends at the goal, whenever the next one may come. For the solver's thread.
class VertexDrag {
 public:
  /// Makes an edit of the session. Throws InputError, with everything as it was.
  using MakeEdit = std::function<void(const Edit&, const std::string& what, bool goes_on)>;

  /// Takes hold of the vertices where they are. The first one is led; the others keep their places
  /// beside it. Throws InputError.
  VertexDrag(const Session& session, std::vector<Index> vertices, MakeEdit make);

  /// The goal of the first vertex, m, which it is to reach in `duration` (s of simulated time) or
  /// later, if that would be too fast.
  void lead_to(const Vector3& goal, double duration);
  /// The same, at once.
  void put_at(const Vector3& goal);
  /// To be called before each step.
  void before_step();
  /// Lets go; what was held before stays held where it now is.
  void release();

 private:
  std::vector<Index> held_among(const std::vector<Index>& vertices) const;
  SelectVertices ids(const std::vector<Index>& vertices) const;
  Vector3 missing() const;
  double fastest() const;
  void move_with(const Vector3& velocity);

  const Session& session_;
  std::vector<Index> vertices_;
  MakeEdit make_;
  std::string what_;
  std::vector<Index> held_before_;
  std::size_t fix_ = 0;                 // number of the hold
  std::vector<Vector3> beside_;         // of each vertex, from the first one, m
  double edge_ = 0.0;                   // shortest at the vertices at rest, m
  double sound_ = 0.0;                  // of shear waves, m/s
  Vector3 goal_ = Vector3::Zero();      // of the first vertex
  Vector3 velocity_ = Vector3::Zero();  // of the hold
  double duration_ = 0.0;               // s, in which the goal is wanted to be reached …
  double speed_ = 0.0;                  // … and the speed that takes, m/s
  bool under_way_ = false;              // the goal may not be reached yet
  bool new_goal_ = false;               // none of the steps has gone there
};

}  // namespace tetraction::viewer
