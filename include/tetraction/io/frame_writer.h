// Writes states of a run as VTU files and the .pvd collection that ParaView opens.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/frame_format.h"

namespace tetraction {

struct ObstacleSurface;

/// One array of a frame: components × vertices, or components × tetrahedra.
/// Components of a symmetric tensor come in ParaView's order XX YY ZZ XY YZ XZ.
struct FrameField {
  std::string name;
  Matrix values;
  bool integral = false;  ///< written as 32-bit integers (flags, ids, regions)
};

/// The data of one state that are written. The points of the file are always the rest positions.
struct Frame {
  double time = 0.0;  ///< s, written as TimeValue
  Index step = 0;
  std::vector<FrameField> point_fields;
  std::vector<FrameField> cell_fields;
  std::shared_ptr<const ObstacleSurface> obstacles{};  ///< that are drawn with it; may be null
};

/// How the arrays of frames are stored.
struct FrameFormat {
  FramePrecision precision = FramePrecision::kFloat64;
  FrameCompression compression = FrameCompression::kLz4;
};

/// Writes `frames/frame_NNNNNN.vtu` (NNNNNN: the step) below a directory. `frames.pvd` beside that
/// folder is valid after every frame: it is written again and renamed into place.
///
/// The obstacles of a frame are another part of the collection at its time, frames/obstacles_NNNNNN.vtu. A frame whose
/// obstacles are as those of the frame before has the same file.
///
/// If the body is in parts (TetMesh::part), each process has a writer, all functions are collective, and a frame is one
/// piece of each process, frames/frame_NNNNNN_PPPP.vtu (PPPP: the process), and the file frame_NNNNNN.pvtu that names
/// the pieces. A vertex that several processes share is a point of each of their pieces; no tetrahedron is in two.
class FrameWriter {
 public:
  /// Makes the directory, and removes the frames and the collection of an earlier run from it.
  /// Copies the arrays of the mesh that it needs, but refers to those of a part, which must stay as they are. Throws
  /// OutputError if the directory cannot be prepared.
  FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format = {});
  /// Goes on after frames that are there: the lines `kept_entries` of the collection, whose frames and obstacles
  /// are the files `kept_names` in the folder `frames`, the frames of `kept_sizes` bytes; only process 0 reads these. Removes all
  /// others. Throws OutputError.
  FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format,
              std::string kept_entries, const std::vector<std::string>& kept_names,
              std::vector<std::uint64_t> kept_sizes);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// Writes a binary VTU in the writer's format and returns its path. Throws OutputError if the file
  /// cannot be written, for example because the disk is full.
  std::string write(const Frame& frame);
  /// Writes one file to `path` in full double precision, with the writer's compression. Its pieces, if it has any,
  /// are frames/frame_final_PPPP.vtu, so that it must be in the writer's directory. Throws OutputError.
  void write_single(const Frame& frame, const std::string& path) const;
  /// Number of frames written.
  Index frame_count() const;
  /// Their sizes in bytes, with those of their pieces; on process 0.
  const std::vector<std::uint64_t>& frame_sizes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
