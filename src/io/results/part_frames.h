// Frames of a body that several processes hold together.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kept_files.h"
#include "tetraction/io/frame_writer.h"

namespace tetraction {

/// Writes a frame as one piece of each process, frames/frame_NNNNNN_PPPP.vtu (NNNNNN: the step, PPPP: the
/// process), and the file frames/frame_NNNNNN.pvtu that names the pieces. A vertex that several processes
/// share is a point of each of their pieces; no tetrahedron is in two. frames.pvd names the .pvtu files.
/// All functions are collective and throw OutputError.
class PartFrames {
 public:
  /// `mesh` has a part, and must stay as it is as long as frames are written. The directory must be there, without frames of an earlier run.
  PartFrames(const TetMesh& mesh, std::string directory, FrameFormat format);
  ~PartFrames();
  PartFrames(const PartFrames&) = delete;
  PartFrames& operator=(const PartFrames&) = delete;

  /// Goes on after frames that are there (FrameWriter). Only process 0 reads `kept` and `kept_sizes`.
  PartFrames(const TetMesh& mesh, std::string directory, FrameFormat format, const KeptFrames& kept,
             std::vector<std::uint64_t> kept_sizes);

  void write(const Frame& frame);
  /// Writes final.pvtu in full double precision. Its pieces are frames/frame_final_PPPP.vtu.
  void write_final(const Frame& frame) const;
  /// On process 0 the sizes of the frames in bytes, with those of their pieces.
  const std::vector<std::uint64_t>& frame_sizes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
