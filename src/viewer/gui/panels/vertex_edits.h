// Turns the user's actions on vertices into edits of the simulation.
#pragma once

#include <memory>
#include <vector>

#include "viewer/simulation.h"

namespace tetraction::viewer {

/// Edits of some vertices. No widgets; in the window's thread.
class VertexEdits {
 public:
  explicit VertexEdits(Simulation& simulation) : simulation_(simulation) {}

  /// Holds the vertices where they are.
  void fix(const std::vector<Index>& vertices);
  void unfix(const std::vector<Index>& vertices);
  /// Moves the vertices' mean position to `target` (m); their shape stays. Fixed ones stay fixed.
  void move_to(const std::vector<Index>& vertices, const Vector3& target);
  /// The same, and holds them there.
  void fix_at(const std::vector<Index>& vertices, const Vector3& target);
  /// kg m/s, of each of the vertices.
  void set_momentum(const std::vector<Index>& vertices, const Vector3& value);
  /// N, on each of the vertices, instead of what acts on them now.
  void set_force(const std::vector<Index>& vertices, const Vector3& value);

  /// Grips vertices, of which the mouse leads one. lead_to() gives its goal, m.
  void grab(std::vector<Index> vertices, Index led);
  void lead_to(const Vector3& place);
  /// Releases the vertices. Vertices that were fixed before stay fixed at their present positions.
  void release();

 private:
  SelectVertices ids(const std::vector<Index>& vertices) const;
  std::string names(const std::vector<Index>& vertices) const;
  std::vector<Index> fixed_among(const std::vector<Index>& vertices) const;
  Vector3 mean_position(const std::vector<Index>& vertices) const;

  Simulation& simulation_;
  bool holding_ = false;
};

}  // namespace tetraction::viewer
