// The natural modes that tetraction modes has written, and the motion of one of them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "io/study/study_grid.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::viewer {

/// A mode as summary.json has it. Numbers that are not known are NaN.
struct StoredMode {
  std::string kind;        ///< "elastic", "rigid", …
  double frequency = 0.0;  ///< Hz; negative for unstable modes
  Vector3 effective_mass = Vector3::Zero();
  double damping_ratio = std::numeric_limits<double>::quiet_NaN();
};

/// A body that swings in a mode about a position.
struct ModeMotion {
  Vector middle;           ///< 3 per vertex, m
  Vector shape;            ///< with the largest displacement 1
  double diagonal = 0.0;   ///< of the body in the middle position, m
  double amplitude = 0.1;  ///< the largest displacement as a part of the diagonal

  /// The displacement from the middle position at a part of the period, m.
  Vector displacement(double phase) const;
};

/// Reads the directory of tetraction modes. Not thread-safe.
class StoredModes {
 public:
  /// Throws FileError if summary.json or the file of the first mode is missing or malformed.
  explicit StoredModes(std::string directory);

  const std::string& directory() const { return directory_; }
  const std::vector<StoredMode>& modes() const { return modes_; }
  const TetMesh& mesh() const { return mesh_; }
  /// Throws FileError if the file of the mode is missing or malformed.
  ModeMotion motion(std::size_t mode) const;

 private:
  std::string file_of(std::size_t mode) const;

  std::string directory_;
  std::vector<StoredMode> modes_;
  TetMesh mesh_;
};

/// The table of the modes, with a row for each of them in their order.
StudyGrid grid_of_modes(const std::vector<StoredMode>& modes);

}  // namespace tetraction::viewer
