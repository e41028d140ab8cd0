#include "vtk_grid.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <string_view>

#include "io/text/output_file.h"
#include "quiet_vtk.h"
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

// An array that refers to numbers instead of owning them.
template <class Array>
vtkSmartPointer<Array> view_of(const typename Array::ValueType* numbers, std::size_t count,
                               int components = 1) {
  using Value = typename Array::ValueType;
  constexpr int kNotOwned = 1;
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(components);
  array->SetArray(const_cast<Value*>(numbers), static_cast<vtkIdType>(count), kNotOwned);
  return array;
}

vtkSmartPointer<vtkDataArray> id_view(const char* name, const std::vector<std::int64_t>& ids) {
  static_assert(sizeof(vtkTypeInt64) == sizeof(std::int64_t));
  auto array =
      view_of<vtkTypeInt64Array>(reinterpret_cast<const vtkTypeInt64*>(ids.data()), ids.size());
  array->SetName(name);
  return array;
}

// The columns of a matrix as the tuples of an array of that type.
template <class Array>
vtkSmartPointer<vtkDataArray> filled_array(const Matrix& values) {
  using Value = typename Array::ValueType;
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(static_cast<int>(values.rows()));
  array->SetNumberOfTuples(values.cols());
  std::transform(values.data(), values.data() + values.size(), array->GetPointer(0),
                 [](double value) { return static_cast<Value>(value); });
  return array;
}

// The name of the array, and those of the components of tensors.
void set_names(vtkDataArray& array, const std::string& name) {
  array.SetName(name.c_str());
  const auto name_components = [&](const auto& names) {
    for (int c = 0; c < static_cast<int>(names.size()); ++c) {
      array.SetComponentName(c, names[static_cast<std::size_t>(c)]);
    }
  };
  if (array.GetNumberOfComponents() == 6) {
    name_components(std::array{"XX", "YY", "ZZ", "XY", "YZ", "XZ"});
  }
  if (array.GetNumberOfComponents() == 9) {
    name_components(std::array{"XX", "XY", "XZ", "YX", "YY", "YZ", "ZX", "ZY", "ZZ"});
  }
}

void set_compression(vtkXMLWriter& writer, FrameCompression compression) {
  switch (compression) {
    case FrameCompression::kLz4:
      writer.SetCompressorTypeToLZ4();
      return;
    case FrameCompression::kZlib:
      writer.SetCompressorTypeToZLib();
      return;
    case FrameCompression::kNone:
      writer.SetCompressorTypeToNone();
      return;
  }
}

void set_up(vtkXMLWriter& writer, vtkUnstructuredGrid* grid, FrameCompression compression) {
  writer.SetInputData(grid);
  writer.SetDataModeToAppended();
  writer.EncodeAppendedDataOff();
  set_compression(writer, compression);
  writer.SetHeaderTypeToUInt64();
  // VTK writes and compresses so many bytes at a time. Its default, 32 KiB, leaves a page of the system's cache of
  // files half filled after every piece, which takes more time than the copy.
  constexpr std::size_t kBlock = 1 << 20;
  writer.SetBlockSize(kBlock);
}

// The system's error number in VTK's, or 0.
int system_error(unsigned long code, const std::string& path) {
  if (code == vtkErrorCode::OutOfDiskSpaceError) return reason_of_a_full_disk(path);
  return code < vtkErrorCode::FirstVTKErrorCode ? static_cast<int>(code) : 0;
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

// VTK keeps the ranges of arrays that were written before with them, and writes these, too. A file must
// not depend on what was written before it.
void forget_ranges(vtkUnstructuredGrid* grid) {
  const auto forget = [](vtkAbstractArray* array) {
    if (array->HasInformation()) array->GetInformation()->Clear();
  };
  forget(grid->GetPoints()->GetData());
  for (vtkFieldData* fields :
       {static_cast<vtkFieldData*>(grid->GetPointData()),
        static_cast<vtkFieldData*>(grid->GetCellData()), grid->GetFieldData()}) {
    for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
      forget(fields->GetAbstractArray(i));
    }
  }
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
  const Index nodes = mesh.is_quadratic() ? 10 : 4;
  cells->AllocateExact(mesh.tetrahedron_count(), nodes * mesh.tetrahedron_count());
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    std::array<vtkIdType, 10> ids{};
    const auto corners = mesh.tetrahedra[e];
    std::copy(corners.begin(), corners.end(), ids.begin());
    if (mesh.is_quadratic()) {
      std::copy(mesh.edge_vertices[e].begin(), mesh.edge_vertices[e].end(), ids.begin() + 4);
    }
    cells->InsertNextCell(nodes, ids.data());
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(mesh.is_quadratic() ? VTK_QUADRATIC_TETRA : VTK_TETRA, cells);
  grid->GetPointData()->AddArray(
      id_array("vertex_id", mesh.vertex_count(), [&](Index v) { return mesh.vertex_id(v); }));
  grid->GetCellData()->AddArray(id_array("element_id", mesh.tetrahedron_count(),
                                         [&](Index e) { return mesh.tetrahedron_id(e); }));
  return grid;
}

vtkSmartPointer<vtkUnstructuredGrid> grid_of_part(const TetMesh& mesh) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetData(
      view_of<vtkDoubleArray>(mesh.vertices.view().data(), 3 * mesh.vertices.size(), 3));
  constexpr std::size_t kNodes = 4;
  const std::size_t count = mesh.tetrahedra.size();
  auto offsets = vtkSmartPointer<vtkTypeInt64Array>::New();
  offsets->SetNumberOfTuples(static_cast<vtkIdType>(count + 1));
  for (std::size_t e = 0; e <= count; ++e) {
    offsets->SetValue(static_cast<vtkIdType>(e), static_cast<vtkTypeInt64>(kNodes * e));
  }
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(offsets, view_of<vtkTypeInt64Array>(
                              static_cast<const vtkTypeInt64*>(mesh.tetrahedra.view().data()),
                              kNodes * count));
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->AddArray(id_view("vertex_id", mesh.vertex_ids));
  grid->GetCellData()->AddArray(id_view("element_id", mesh.tetrahedron_ids));
  return grid;
}

vtkSmartPointer<vtkDataArray> make_array(const std::string& name, const Matrix& values,
                                         bool integral, FramePrecision precision) {
  vtkSmartPointer<vtkDataArray> array;
  if (integral) {
    array = filled_array<vtkIntArray>(values);
  } else if (precision == FramePrecision::kFloat32) {
    array = filled_array<vtkFloatArray>(values);
  } else {
    array = filled_array<vtkDoubleArray>(values);
  }
  set_names(*array, name);
  return array;
}

vtkSmartPointer<vtkDataArray> array_of(const std::string& name, const Matrix& values) {
  auto array = view_of<vtkDoubleArray>(values.data(), static_cast<std::size_t>(values.size()),
                                       static_cast<int>(values.rows()));
  set_names(*array, name);
  return array;
}

void write_vtu(vtkUnstructuredGrid* grid, const std::string& path, FrameCompression compression) {
  forget_ranges(grid);
  ReplacementFile file(path);
  VtkMessages messages;
  auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
  messages.watch(writer);
  writer->SetFileName(file.temporary().c_str());
  set_up(*writer, grid, compression);
  const bool is_written = writer->Write() == 1 && writer->GetErrorCode() == 0 && messages.empty() &&
                          ends_as_vtu(file.temporary());
  if (!is_written) fail_to_write(path, system_error(writer->GetErrorCode(), path));
  file.finish();
}

std::string vtu_text(vtkUnstructuredGrid* grid, const std::string& path,
                     FrameCompression compression) {
  forget_ranges(grid);
  VtkMessages messages;
  auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
  messages.watch(writer);
  writer->WriteToOutputStringOn();
  set_up(*writer, grid, compression);
  if (writer->Write() != 1 || !messages.empty()) fail_to_write(path, 0);
  return writer->GetOutputString();
}

std::string collection_entry(double time, const std::string& file, int part) {
  return fmt::format("    <DataSet timestep=\"{:.17g}\" group=\"\" part=\"{}\" file=\"{}\"/>\n",
                     time, part, file);
}

void write_collection(const std::string& entries, const std::string& path) {
  write_text_file(path,
                  "<?xml version=\"1.0\"?>\n"
                  "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                  "  <Collection>\n" +
                      entries + "  </Collection>\n</VTKFile>\n");
}

}  // namespace tetraction
