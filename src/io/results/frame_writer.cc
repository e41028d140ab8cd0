#include "tetraction/io/frame_writer.h"

#include <fmt/format.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <utility>

#include "frame_grid.h"
#include "io/text/output_file.h"
#include "io/vtk/vtk_grid.h"
#include "run_files.h"
#include "tetraction/core/error.h"

namespace tetraction {

struct FrameWriter::Impl {
  std::string directory;
  vtkSmartPointer<vtkUnstructuredGrid> grid;  // points and cells, made once
  FrameFormat format;
  std::string entries;               // of the collection
  std::vector<std::uint64_t> sizes;  // of the frames
};

FrameWriter::FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format)
    : impl_(std::make_unique<Impl>()) {
  impl_->directory = directory;
  impl_->format = format;
  impl_->grid = make_grid(mesh);
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) {
    throw OutputError(fmt::format("{}: cannot be made ({}). Choose another directory.", directory,
                                  error.message()));
  }
  // Frames of an earlier run would look like frames of this one.
  remove_frames(directory);
}

FrameWriter::FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format,
                         std::string kept_entries, const std::vector<std::string>& kept_names,
                         std::vector<std::uint64_t> kept_sizes)
    : impl_(std::make_unique<Impl>()) {
  impl_->directory = directory;
  impl_->format = format;
  impl_->grid = make_grid(mesh);
  impl_->entries = std::move(kept_entries);
  impl_->sizes = std::move(kept_sizes);
  // The collection goes first, because it must not name frames that are not there.
  if (!kept_names.empty()) write_collection(impl_->entries, directory + "/frames.pvd");
  remove_frames(directory, kept_names);
}

FrameWriter::~FrameWriter() = default;

std::string FrameWriter::write(const Frame& frame) {
  make_own_directory(impl_->directory + "/frames");
  const std::string name = fmt::format("frames/frame_{:06}.vtu", frame.step);
  std::string path = impl_->directory + "/" + name;
  write_vtu(grid_of(impl_->grid, frame, impl_->format.precision), path, impl_->format.compression);
  impl_->entries += collection_entry(frame.time, name);
  std::error_code unknown;
  impl_->sizes.push_back(std::filesystem::file_size(path, unknown));
  write_collection(impl_->entries, impl_->directory + "/frames.pvd");
  return path;
}

void FrameWriter::write_single(const Frame& frame, const std::string& path) const {
  write_vtu(grid_of(impl_->grid, frame, FramePrecision::kFloat64), path, impl_->format.compression);
}

Index FrameWriter::frame_count() const {
  return static_cast<Index>(impl_->sizes.size());
}

const std::vector<std::uint64_t>& FrameWriter::frame_sizes() const {
  return impl_->sizes;
}

}  // namespace tetraction
