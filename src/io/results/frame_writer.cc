#include "tetraction/io/frame_writer.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "io/text/output_file.h"
#include "io/vtk/obstacle_grid.h"
#include "io/vtk/vtk_grid.h"
#include "run_files.h"
#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"
#include "write_failures.h"

namespace tetraction {
namespace {

// Arrays of double precision refer to the fields, which must live as long as the data.
void add_fields(const std::vector<FrameField>& fields, vtkIdType tuples, FramePrecision precision,
                vtkFieldData& data) {
  for (const FrameField& field : fields) {
    if (field.values.cols() != tuples || field.values.rows() < 1) {
      throw InputError(fmt::format("frame array \"{}\" has {} x {} values for {} places.",
                                   field.name, field.values.rows(), field.values.cols(), tuples));
    }
    const bool is_double = !field.integral && precision == FramePrecision::kFloat64;
    data.AddArray(is_double ? array_of(field.name, field.values)
                            : make_array(field.name, field.values, field.integral, precision));
  }
}

// The points and cells of `mesh` with the time and the fields of the frame, which must live as long as the grid.
vtkSmartPointer<vtkUnstructuredGrid> grid_of(vtkUnstructuredGrid* mesh, const Frame& frame,
                                             FramePrecision precision) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->ShallowCopy(mesh);
  add_fields(frame.point_fields, mesh->GetNumberOfPoints(), precision, *grid->GetPointData());
  add_fields(frame.cell_fields, mesh->GetNumberOfCells(), precision, *grid->GetCellData());
  auto time = vtkSmartPointer<vtkDoubleArray>::New();
  time->SetName("TimeValue");
  time->InsertNextValue(frame.time);
  grid->GetFieldData()->AddArray(time);
  return grid;
}

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

// The file that names the pieces of a frame; `pieces` are their paths from its folder.
std::string pieces_text(vtkUnstructuredGrid* filled, const std::vector<std::string>& pieces) {
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
  for (const std::string& piece : pieces) {
    text += fmt::format("    <Piece Source=\"{}\"/>\n", piece);
  }
  return text + "  </PUnstructuredGrid>\n</VTKFile>\n";
}

std::uint64_t size_of(const std::string& path) {
  std::error_code unknown;
  return std::filesystem::file_size(path, unknown);
}

}  // namespace

struct FrameWriter::Impl {
  SharedMeshPart part;  // null for a whole mesh
  std::string directory;
  FrameFormat format;
  vtkSmartPointer<vtkUnstructuredGrid> grid;  // points and cells, made once
  std::string entries;                        // of the collection
  std::vector<std::uint64_t> sizes;           // of the frames
  std::string obstacle_name{};                // the last file of obstacles, and its contents
  std::string obstacle_text{};

  // Writes a file, or of a body in parts the pieces frames/STEM_PPPP.vtu and then the file, which names them from its
  // folder. Returns its size in bytes on process 0, with those of the pieces.
  std::uint64_t write(const Frame& frame, FramePrecision precision, const std::string& path,
                      const std::string& stem, const std::string& folder) const {
    const auto filled = grid_of(grid, frame, precision);
    if (!part) {
      write_vtu(filled, path, format.compression);
      return size_of(path);
    }
    std::vector<std::string> pieces;
    for (int rank = 0; rank < part->count(); ++rank) {
      pieces.push_back(fmt::format("{}_{:04}.vtu", stem, rank));
    }
    const std::string own = directory + "/frames/" + pieces[static_cast<std::size_t>(part->rank())];
    write_together(part.get(), [&] { write_vtu(filled, own, format.compression); });
    for (std::string& piece : pieces) piece = folder + piece;
    write_once(part.get(), [&] { write_text_file(path, pieces_text(filled, pieces)); });
    const double all = sum_over_parts(part.get(), static_cast<double>(size_of(own)));
    return static_cast<std::uint64_t>(all) + size_of(path);
  }

  // Writes the obstacles of a frame, if they are not those of the file before, and adds them to the collection.
  void add_obstacles(const Frame& frame) {
    std::string name = obstacle_frame_name(frame.step);
    std::string text = obstacle_file(*frame.obstacles, directory + "/" + name, format.compression);
    if (text != obstacle_text) {
      write_text_file(directory + "/" + name, text);
      obstacle_name = std::move(name);
      obstacle_text = std::move(text);
    }
    constexpr int kPart = 1;  // the body is part 0
    entries += collection_entry(frame.time, obstacle_name, kPart);
  }

  void make_folder() const {
    write_once(part.get(), [&] { make_own_directory(directory + "/frames"); });
  }
};

FrameWriter::FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format)
    : FrameWriter(mesh, directory, format, {}, {}, {}) {}

FrameWriter::FrameWriter(const TetMesh& mesh, const std::string& directory, FrameFormat format,
                         std::string kept_entries, const std::vector<std::string>& kept_names,
                         std::vector<std::uint64_t> kept_sizes)
    : impl_(std::make_unique<Impl>(Impl{mesh.part, directory, format,
                                        mesh.part ? grid_of_part(mesh) : make_grid(mesh),
                                        std::move(kept_entries), std::move(kept_sizes)})) {
  write_once(mesh.part.get(), [&] {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) {
      throw OutputError(fmt::format("{}: cannot be made ({}). Choose another directory.", directory,
                                    error.message()));
    }
    // The collection goes first, because it must not name frames that are not there.
    if (!kept_names.empty()) write_collection(impl_->entries, directory + "/frames.pvd");
    // Frames of an earlier run would look like frames of this one.
    remove_frames(directory, kept_names);
    // A run that goes on writes the same files as one that was not interrupted.
    for (const std::string& name : kept_names) {
      if (!is_obstacle_frame_name(name)) continue;
      impl_->obstacle_name = "frames/" + name;
      impl_->obstacle_text = read_output(directory + "/" + impl_->obstacle_name);
    }
  });
}

FrameWriter::~FrameWriter() = default;

std::string FrameWriter::write(const Frame& frame) {
  Impl& s = *impl_;
  s.make_folder();
  const std::string stem = fmt::format("frame_{:06}", frame.step);
  const std::string name = "frames/" + stem + (s.part ? ".pvtu" : ".vtu");
  std::string path = s.directory + "/" + name;
  s.sizes.push_back(s.write(frame, s.format.precision, path, stem, ""));
  s.entries += collection_entry(frame.time, name);
  if (frame.obstacles != nullptr && !s.part) s.add_obstacles(frame);
  write_once(s.part.get(), [&] { write_collection(s.entries, s.directory + "/frames.pvd"); });
  return path;
}

void FrameWriter::write_single(const Frame& frame, const std::string& path) const {
  if (impl_->part) impl_->make_folder();
  impl_->write(frame, FramePrecision::kFloat64, path, "frame_final", "frames/");
}

Index FrameWriter::frame_count() const {
  return static_cast<Index>(impl_->sizes.size());
}

const std::vector<std::uint64_t>& FrameWriter::frame_sizes() const {
  return impl_->sizes;
}

}  // namespace tetraction
