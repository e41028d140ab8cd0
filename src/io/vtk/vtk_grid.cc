#include "vtk_grid.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "quiet_vtk.h"
#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

// id(i): the number of item i.
template <class Id>
vtkSmartPointer<vtkDataArray> id_array(const char* name, Index count, const Id& id) {
  auto array = vtkSmartPointer<vtkTypeInt64Array>::New();
  array->SetName(name);
  array->SetNumberOfTuples(count);
  for (Index i = 0; i < count; ++i) array->SetValue(i, id(i));
  return array;
}

// VTK reports no error if the disk becomes full while it writes the last bytes of its buffer.
bool ends_as_vtu(const std::string& path) {
  constexpr std::string_view kEnd = "</VTKFile>\n";
  std::ifstream file(path, std::ios::binary);
  std::string tail(kEnd.size(), ' ');
  file.seekg(-static_cast<std::streamoff>(kEnd.size()), std::ios::end);
  file.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  return file && tail == kEnd;
}

}  // namespace

vtkSmartPointer<vtkUnstructuredGrid> make_grid(const TetMesh& mesh) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    points->SetPoint(v, mesh.vertices[static_cast<std::size_t>(v)].data());
  }
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->AllocateExact(mesh.tetrahedron_count(), 4 * mesh.tetrahedron_count());
  for (const auto t : mesh.tetrahedra) {
    const std::array<vtkIdType, 4> ids{t[0], t[1], t[2], t[3]};
    cells->InsertNextCell(4, ids.data());
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->AddArray(
      id_array("vertex_id", mesh.vertex_count(), [&](Index v) { return mesh.vertex_id(v); }));
  grid->GetCellData()->AddArray(id_array("element_id", mesh.tetrahedron_count(),
                                         [&](Index e) { return mesh.tetrahedron_id(e); }));
  return grid;
}

vtkSmartPointer<vtkDataArray> make_array(const std::string& name, const Matrix& values,
                                         bool integral) {
  vtkSmartPointer<vtkDataArray> array;
  if (integral) {
    array = vtkSmartPointer<vtkIntArray>::New();
  } else {
    array = vtkSmartPointer<vtkDoubleArray>::New();
  }
  array->SetName(name.c_str());
  array->SetNumberOfComponents(static_cast<int>(values.rows()));
  array->SetNumberOfTuples(values.cols());
  for (Index i = 0; i < values.cols(); ++i) array->SetTuple(i, values.col(i).data());
  if (values.rows() == 6) {
    constexpr const char* kComponents[] = {"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
    for (int c = 0; c < 6; ++c) array->SetComponentName(c, kComponents[c]);
  }
  return array;
}

void write_vtu(vtkUnstructuredGrid* grid, const std::string& path) {
  const std::string temporary = path + ".part";
  VtkMessages messages;
  auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
  messages.watch(writer);
  writer->SetFileName(temporary.c_str());
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->SetHeaderTypeToUInt64();
  const bool written = writer->Write() == 1 && writer->GetErrorCode() == 0 && messages.empty() &&
                       ends_as_vtu(temporary);
  std::error_code error;
  if (written) std::filesystem::rename(temporary, path, error);
  if (!written || error) {
    std::remove(temporary.c_str());
    throw OutputError(fmt::format(
        "{}: cannot be written{}. Check the directory's permissions and the free space.", path,
        error ? " (" + error.message() + ")" : ""));
  }
}

std::string collection_entry(double time, const std::string& file) {
  return fmt::format("    <DataSet timestep=\"{:.17g}\" group=\"\" part=\"0\" file=\"{}\"/>\n",
                     time, file);
}

void write_collection(const std::string& entries, const std::string& path) {
  write_text_file(path,
                  "<?xml version=\"1.0\"?>\n"
                  "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                  "  <Collection>\n" +
                      entries + "  </Collection>\n</VTKFile>\n");
}

}  // namespace tetraction
