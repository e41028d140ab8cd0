#include "frame_grid.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <vector>

#include "io/vtk/vtk_grid.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

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

}  // namespace

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

}  // namespace tetraction
