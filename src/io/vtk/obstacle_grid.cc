#include "obstacle_grid.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <cstdint>
#include <vector>

#include "guarded_grid.h"
#include "io/text/byte_stream.h"
#include "tetraction/core/error.h"
#include "vtk_grid.h"

namespace tetraction {
namespace {

constexpr std::size_t kCorners = 4;

// Three coordinates of each point, four corners of each cell, and its obstacle. Throws FileError.
std::string encode_surface(vtkUnstructuredGrid* grid) {
  ByteWriter out;
  std::vector<double> points;
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    const double* x = grid->GetPoint(i);
    points.insert(points.end(), x, x + 3);
  }
  std::vector<std::int64_t> cells;
  std::vector<std::int64_t> numbers;
  vtkDataArray* obstacle = grid->GetCellData()->GetArray("obstacle");
  vtkNew<vtkIdList> corners;
  for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i) {
    const int type = grid->GetCellType(i);
    if (type != VTK_LINE && type != VTK_TRIANGLE && type != VTK_QUAD) {
      throw FileError("it has a cell that is no line, triangle or quadrangle");
    }
    grid->GetCellPoints(i, corners);
    for (vtkIdType k = 0; k < static_cast<vtkIdType>(kCorners); ++k) {
      cells.push_back(k < corners->GetNumberOfIds() ? corners->GetId(k) : -1);
    }
    numbers.push_back(
        obstacle == nullptr ? 0 : static_cast<std::int64_t>(obstacle->GetComponent(i, 0)));
  }
  out.put_all(points.data(), points.size());
  out.put_all(cells.data(), cells.size());
  out.put_all(numbers.data(), numbers.size());
  return out.take_bytes();
}

}  // namespace

std::string obstacle_file(const ObstacleSurface& surface, const std::string& path,
                          FrameCompression compression) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vector3& x : surface.points) points->InsertNextPoint(x.data());
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(points);
  grid->AllocateExact(static_cast<vtkIdType>(surface.cells.size()),
                      static_cast<vtkIdType>(kCorners * surface.cells.size()));
  for (const auto& cell : surface.cells) {
    const vtkIdType ids[kCorners] = {cell[0], cell[1], cell[2], cell[3]};
    if (ObstacleSurface::is_line(cell)) {
      grid->InsertNextCell(VTK_LINE, 2, ids);
    } else {
      const bool is_triangle = cell[3] < 0;
      grid->InsertNextCell(is_triangle ? VTK_TRIANGLE : VTK_QUAD, is_triangle ? 3 : 4, ids);
    }
  }
  const Matrix at_rest = Matrix::Zero(3, static_cast<Index>(surface.points.size()));
  grid->GetPointData()->AddArray(make_array("displacement", at_rest, false));
  Matrix numbers(1, static_cast<Index>(surface.obstacle.size()));
  for (std::size_t i = 0; i < surface.obstacle.size(); ++i) {
    numbers(0, static_cast<Index>(i)) = surface.obstacle[i];
  }
  grid->GetCellData()->AddArray(make_array("obstacle", numbers, true));
  return vtu_text(grid, path, compression);
}

std::shared_ptr<const ObstacleSurface> read_obstacle_file(const std::string& path) {
  const GridFile file = read_guarded(path, encode_surface);
  ByteReader in(file.bytes);
  const auto points = in.get_all<double>();
  const auto cells = in.get_all<std::int64_t>();
  const auto numbers = in.get_all<std::int64_t>();
  const std::size_t count = points.size() / 3;
  if (!in.good() || cells.size() != kCorners * numbers.size()) {
    refuse_grid(path, "its parts do not fit together");
  }
  check_counts(path, file.header, count, numbers.size());
  auto surface = std::make_shared<ObstacleSurface>();
  for (std::size_t i = 0; i < count; ++i) {
    surface->points.emplace_back(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    if (!surface->points.back().allFinite()) refuse_grid(path, "a point is not finite");
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::array<Index, kCorners> cell{};
    for (std::size_t k = 0; k < kCorners; ++k) {
      cell[k] = cells[kCorners * i + k];
      const bool is_absent = k >= 2 && cell[k] == -1;
      if (!is_absent && (cell[k] < 0 || cell[k] >= static_cast<Index>(count))) {
        refuse_grid(path, "a cell has a point that is not there");
      }
    }
    surface->cells.push_back(cell);
    surface->obstacle.push_back(static_cast<int>(numbers[i]));
  }
  return surface;
}

}  // namespace tetraction
