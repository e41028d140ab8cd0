#include "part_frames.h"

#include <optional>

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "frame_grid.h"
#include "io/text/output_file.h"
#include "io/vtk/vtk_grid.h"
#include "run_files.h"
#include "tetraction/io/text_file.h"
#include "write_failures.h"

namespace tetraction {
namespace {

const char* type_name(int type) {
  switch (type) {
    case VTK_DOUBLE:
      return "Float64";
    case VTK_FLOAT:
      return "Float32";
    case VTK_INT:
      return "Int32";
    default:
      return "Int64";  // numbers of vertices and elements
  }
}

std::string declarations(vtkFieldData* fields) {
  std::string text;
  for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* array = fields->GetAbstractArray(i);
    text += fmt::format("      <PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
                        type_name(array->GetDataType()), array->GetName(),
                        array->GetNumberOfComponents());
    for (int c = 0; array->HasAComponentName() && c < array->GetNumberOfComponents(); ++c) {
      text += fmt::format(" ComponentName{}=\"{}\"", c, array->GetComponentName(c));
    }
    text += "/>\n";
  }
  return text;
}

}  // namespace

struct PartFrames::Impl {
  SharedMeshPart part;
  std::string directory;
  FrameFormat format;
  vtkSmartPointer<vtkUnstructuredGrid> grid;  // points and cells, made once; refers to the mesh
  std::string entries;                        // of the collection
  std::vector<std::uint64_t> sizes;           // of the frames

  static std::string piece_name(const std::string& stem, int rank) {
    return fmt::format("{}_{:04}.vtu", stem, rank);
  }

  // Writes the pieces frames/STEM_PPPP.vtu, and then `collection`, which names them from its folder.
  void write(const Frame& frame, FramePrecision precision, const std::string& stem,
             const std::string& collection, const std::string& folder) const {
    std::optional<OutputError> failure;
    if (part->rank() == 0) attempt(failure, [&] { make_own_directory(directory + "/frames"); });
    throw_together(*part, failure);
    const auto filled = grid_of(grid, frame, precision);
    attempt(failure, [&] {
      write_vtu(filled, directory + "/frames/" + piece_name(stem, part->rank()),
                format.compression);
    });
    throw_together(*part, failure);
    if (part->rank() == 0) {
      attempt(failure, [&] { write_pieces(filled, stem, collection, folder); });
    }
    throw_together(*part, failure);
  }

  void write_pieces(vtkUnstructuredGrid* filled, const std::string& stem,
                    const std::string& collection, const std::string& folder) const {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n"
        "  <PUnstructuredGrid GhostLevel=\"0\">\n    <PPointData>\n" +
        declarations(filled->GetPointData()) + "    </PPointData>\n    <PCellData>\n" +
        declarations(filled->GetCellData()) +
        "    </PCellData>\n    <PPoints>\n"
        "      <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n"
        "    </PPoints>\n";
    for (int rank = 0; rank < part->count(); ++rank) {
      text += fmt::format("    <Piece Source=\"{}{}\"/>\n", folder, piece_name(stem, rank));
    }
    write_text_file(directory + "/" + collection, text + "  </PUnstructuredGrid>\n</VTKFile>\n");
  }
};

PartFrames::PartFrames(const TetMesh& mesh, std::string directory, FrameFormat format)
    : impl_(std::make_unique<Impl>(
          Impl{mesh.part, std::move(directory), format, grid_of_part(mesh), {}, {}})) {}

PartFrames::PartFrames(const TetMesh& mesh, std::string directory, FrameFormat format,
                       const KeptFrames& kept, std::vector<std::uint64_t> kept_sizes)
    : PartFrames(mesh, std::move(directory), format) {
  Impl& s = *impl_;
  std::optional<OutputError> failure;
  if (s.part->rank() == 0) {
    s.entries = kept.entries;
    s.sizes = std::move(kept_sizes);
    attempt(failure, [&] {
      // The collection goes first, because it must not name frames that are not there.
      if (!s.sizes.empty()) write_collection(s.entries, s.directory + "/frames.pvd");
      remove_frames(s.directory, kept.names);
    });
  }
  throw_together(*s.part, failure);
}

PartFrames::~PartFrames() = default;

void PartFrames::write(const Frame& frame) {
  Impl& s = *impl_;
  const std::string stem = fmt::format("frame_{:06}", frame.step);
  const std::string collection = "frames/" + stem + ".pvtu";
  s.write(frame, s.format.precision, stem, collection, "");
  s.entries += collection_entry(frame.time, collection);
  std::error_code unknown;
  const std::string piece = s.directory + "/frames/" + Impl::piece_name(stem, s.part->rank());
  const double pieces =
      sum_over_parts(s.part.get(), static_cast<double>(std::filesystem::file_size(piece, unknown)));
  std::optional<OutputError> failure;
  if (s.part->rank() == 0) {
    s.sizes.push_back(static_cast<std::uint64_t>(pieces) +
                      std::filesystem::file_size(s.directory + "/" + collection, unknown));
    attempt(failure, [&] { write_collection(s.entries, s.directory + "/frames.pvd"); });
  }
  throw_together(*s.part, failure);
}

const std::vector<std::uint64_t>& PartFrames::frame_sizes() const {
  return impl_->sizes;
}

void PartFrames::write_final(const Frame& frame) const {
  impl_->write(frame, FramePrecision::kFloat64, "frame_final", "final.pvtu", "frames/");
}

}  // namespace tetraction
