#include "tetraction/io/frame_reader.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "io/text/text_scanner.h"
#include "io/vtk/quiet_vtk.h"
#include "io/vtk/vtk_header.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::vector<Matrix> read_arrays(vtkDataSetAttributes* data, const std::vector<std::string>& names) {
  std::vector<Matrix> arrays;
  for (const std::string& name : names) {
    Matrix& values = arrays.emplace_back();
    vtkDataArray* array = data->GetArray(name.c_str());
    if (array == nullptr) continue;
    values.resize(array->GetNumberOfComponents(), array->GetNumberOfTuples());
    for (Index i = 0; i < values.cols(); ++i) array->GetTuple(i, values.col(i).data());
  }
  return arrays;
}

}  // namespace

StoredFrame read_frame(const std::string& path, const std::vector<std::string>& point_names,
                       const std::vector<std::string>& cell_names) {
  // Files on which VTK's reader would crash are refused before it reads them.
  check_xml_header(path, read_file(path));
  VtkMessages messages;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  messages.watch(reader);
  reader->SetFileName(path.c_str());
  reader->Update();
  if (!messages.empty()) throw FileError(fmt::format("{}: {}", path, messages.first()));
  vtkUnstructuredGrid* grid = reader->GetOutput();
  return {grid->GetNumberOfPoints(), grid->GetNumberOfCells(),
          read_arrays(grid->GetPointData(), point_names),
          read_arrays(grid->GetCellData(), cell_names)};
}

}  // namespace tetraction
