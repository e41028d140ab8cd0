// Writes states of a run as VTU files and the .pvd collection that ParaView opens.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// One array of a frame: components × vertices, or components × tetrahedra.
/// Components of a symmetric tensor come in ParaView's order XX YY ZZ XY YZ XZ.
struct FrameField {
  std::string name;
  Matrix values;
  bool integral = false;  ///< written as 32-bit integers (flags, ids, regions)
};

/// What is written of one state; points are always the rest positions.
struct Frame {
  double time = 0.0;  ///< s, written as TimeValue
  Index step = 0;
  std::vector<FrameField> point_fields;
  std::vector<FrameField> cell_fields;
};

/// Writes `frames/frame_NNNNNN.vtu` (NNNNNN: the step) below a directory and keeps `frames.pvd`
/// beside the folder valid after every frame (written anew and renamed into place).
class FrameWriter {
 public:
  /// Makes the directory and removes frames and collection of an earlier run from it. OutputError if that fails. Copies what it needs of the mesh.
  FrameWriter(const TetMesh& mesh, const std::string& directory);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// Compressed binary VTU. Throws OutputError if the file cannot be written (also: disk full).
  void write(const Frame& frame);
  /// One VTU at `path`, in full double precision. Throws OutputError.
  void write_single(const Frame& frame, const std::string& path) const;
  /// Number of frames written.
  Index frame_count() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
