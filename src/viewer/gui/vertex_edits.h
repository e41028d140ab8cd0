// From what the user does with vertices to edits of the simulation.
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

  /// Takes hold of vertices: from now on they are held where drag() says.
  void grab(const std::vector<Index>& vertices);
  /// Wants the held vertices at this displacement from where they were taken hold of, m.
  void drag(const Vector3& displacement);
  /// To be called with every new snapshot while vertices are held. While the simulation runs they move
  /// to the wanted place with a velocity, so that nothing jumps and the reaction means something;
  /// while it is paused they are put there.
  void follow(const Snapshot& snapshot);
  /// Lets go; what was fixed before stays fixed where it now is.
  void release();
  bool holding() const { return !held_.empty(); }

 private:
  SelectVertices ids(const std::vector<Index>& vertices) const;
  std::string names(const std::vector<Index>& vertices) const;
  std::vector<Index> fixed_among(const std::vector<Index>& vertices) const;
  Vector3 mean_position(const std::vector<Index>& vertices) const;

  Simulation& simulation_;
  std::vector<Index> held_;
  std::vector<Index> fixed_before_;
  std::vector<Vector3> start_;        // of the held vertices
  Vector3 wanted_ = Vector3::Zero();  // displacement
  bool moving_ = false;               // whether the hold has a velocity
  std::uint64_t edited_at_ = 0;       // generation of the snapshot that the last edit was made from
};

}  // namespace tetraction::viewer
