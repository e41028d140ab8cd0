// Turns the user's actions on vertices into edits of the simulation.
#pragma once

#include <memory>
#include <vector>

#include "viewer/gui/widgets/vector_fields.h"
#include "viewer/simulation.h"

namespace tetraction::viewer {

/// Makes edits of vertices. It is used in the window's thread. Components of a vector that were not typed
/// keep the value that each vertex has.
class VertexEdits {
 public:
  explicit VertexEdits(Simulation& simulation) : simulation_(simulation) {}

  /// Fixes the vertices at their present positions.
  void fix(const std::vector<Index>& vertices);
  void unfix(const std::vector<Index>& vertices);
  /// Translates the vertices such that their mean position is `target` (m). Fixed vertices stay fixed.
  void move_to(const std::vector<Index>& vertices, const EnteredVector& target);
  /// Translates the vertices such that their mean position is `target` (m), and fixes them there.
  void fix_at(const std::vector<Index>& vertices, const EnteredVector& target);
  /// Sets the momentum of each of the vertices, kg m/s.
  void set_momentum(const std::vector<Index>& vertices, const EnteredVector& value);
  /// Sets the external force on each of the vertices, N. It replaces the present force.
  void set_force(const std::vector<Index>& vertices, const EnteredVector& value);

  /// Begins to drag vertices. `dragged` is the one that follows the mouse. drag_to() sets its goal, m.
  void grab(std::vector<Index> vertices, Index dragged, bool exact);
  /// Begins to drag an obstacle at this point, m.
  void grab_obstacle(std::size_t number, const Vector3& point);
  /// Multiplies the radius of the area that a drag pulls, and returns it, m. 0 without such a drag.
  double scale_area(double factor);
  void drag_to(const Vector3& position);
  /// Releases the vertices. Vertices that were fixed before stay fixed at their present positions.
  void release();

 private:
  SelectVertices ids(const std::vector<Index>& vertices) const;
  std::string names(const std::vector<Index>& vertices) const;
  std::vector<Index> fixed_among(const std::vector<Index>& vertices) const;
  Vector3 offset_to(const std::vector<Index>& vertices, const EnteredVector& target) const;

  Simulation& simulation_;
  double radius_ = 0.0;  // of the area that the user has chosen, m; 0: the usual one
  bool dragging_ = false;
};

}  // namespace tetraction::viewer
