#include "body_shape.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tetraction/fem/rest_state.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction::viewer {
namespace {

// The edges of the triangles, each of them once. The four triangles of a quadratic face have inner edges
// between the middles of its edges, which are left out.
vtkSmartPointer<vtkCellArray> edge_cells(const TetMesh& mesh,
                                         const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<bool> is_corner(mesh.vertices.size(), !mesh.is_quadratic());
  if (mesh.is_quadratic()) {
    for (const auto& tetrahedron : mesh.tetrahedra) {
      for (const Index v : tetrahedron) is_corner[static_cast<std::size_t>(v)] = true;
    }
  }
  std::vector<std::array<Index, 2>> edges;
  for (const auto& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax({triangle[i], triangle[(i + 1) % 3]});
      const bool is_drawn =
          is_corner[static_cast<std::size_t>(a)] || is_corner[static_cast<std::size_t>(b)];
      if (is_drawn) edges.push_back({a, b});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& edge : edges) {
    const vtkIdType ids[2] = {edge[0], edge[1]};
    cells->InsertNextCell(2, ids);
  }
  return cells;
}

// Finds the surface triangles and their tetrahedra.
void find_surface(vtkUnstructuredGrid* grid, BodyShape& shape) {
  vtkNew<vtkDataSetSurfaceFilter> filter;
  filter->SetInputData(grid);
  filter->PassThroughPointIdsOn();
  filter->PassThroughCellIdsOn();
  filter->Update();
  vtkPolyData* found = filter->GetOutput();
  const auto* vertex =
      vtkIdTypeArray::SafeDownCast(found->GetPointData()->GetArray("vtkOriginalPointIds"));
  const auto* cell =
      vtkIdTypeArray::SafeDownCast(found->GetCellData()->GetArray("vtkOriginalCellIds"));
  for (vtkIdType t = 0; t < found->GetNumberOfCells(); ++t) {
    vtkIdType count = 0;
    const vtkIdType* corners = nullptr;
    found->GetCellPoints(t, count, corners);
    if (count != 3) continue;
    const vtkIdType ids[3] = {vertex->GetValue(corners[0]), vertex->GetValue(corners[1]),
                              vertex->GetValue(corners[2])};
    shape.triangles.push_back({ids[0], ids[1], ids[2]});
    shape.triangle_cell.push_back(cell->GetValue(t));
  }
}

// Draws every face of a quadratic element as four triangles between its vertices.
void divide_surface(const TetMesh& mesh, BodyShape& shape) {
  shape.triangles = EdgeVertices(mesh).divide(shape.triangles);
  std::vector<Index> cells;
  for (const auto cell : shape.triangle_cell) cells.insert(cells.end(), 4, cell);
  shape.triangle_cell.assign(cells.begin(), cells.end());
}

}  // namespace

bool is_strained(const BodyShape& shape, const Vector& position) {
  constexpr double kRoundOff = 1e-9;
  const auto squared_length = [](const Vector& at, Index v, Index w) {
    return (vertex_block(at, v) - vertex_block(at, w)).squaredNorm();
  };
  vtkIdType count = 0;
  const vtkIdType* vertices = nullptr;
  for (vtkIdType e = 0; e < shape.tetrahedra->GetNumberOfCells(); ++e) {
    shape.tetrahedra->GetCellAtId(e, count, vertices);
    for (vtkIdType i = 0; i < count; ++i) {
      for (vtkIdType j = 0; j < i; ++j) {
        const double before = squared_length(shape.rest_position, vertices[i], vertices[j]);
        const double after = squared_length(position, vertices[i], vertices[j]);
        if (std::abs(after - before) > 2.0 * kRoundOff * before) return true;
      }
    }
  }
  return false;
}

vtkSmartPointer<vtkCellArray> point_cells(const std::vector<Index>& vertices) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->AllocateExact(static_cast<vtkIdType>(vertices.size()),
                       static_cast<vtkIdType>(vertices.size()));
  for (const Index v : vertices) {
    const vtkIdType id = v;
    cells->InsertNextCell(1, &id);
  }
  return cells;
}

std::shared_ptr<const BodyShape> make_body_shape(const TetMesh& mesh) {
  auto shape = std::make_shared<BodyShape>();
  const Index n = mesh.vertex_count();
  shape->rest = vtkSmartPointer<vtkPoints>::New();
  shape->rest->SetDataTypeToFloat();
  shape->rest->SetNumberOfPoints(n);
  shape->low = shape->high = mesh.vertices.front();
  for (Index v = 0; v < n; ++v) {
    const Vector3& x = mesh.vertices[static_cast<std::size_t>(v)];
    shape->rest->SetPoint(v, x.data());
    shape->low = shape->low.cwiseMin(x);
    shape->high = shape->high.cwiseMax(x);
  }
  shape->tetrahedra = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& tetrahedron : mesh.tetrahedra) {
    const vtkIdType ids[4] = {tetrahedron[0], tetrahedron[1], tetrahedron[2], tetrahedron[3]};
    shape->tetrahedra->InsertNextCell(4, ids);
  }
  shape->rest_position = mesh.rest_positions();
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(shape->rest);
  grid->SetCells(VTK_TETRA, shape->tetrahedra);
  find_surface(grid, *shape);
  if (mesh.is_quadratic()) {
    divide_surface(mesh, *shape);
    shape->cell_type = VTK_QUADRATIC_TETRA;
    shape->tetrahedra = vtkSmartPointer<vtkCellArray>::New();
    const RestState rest(mesh);
    for (Index e = 0; e < rest.element_count(); ++e) {
      const ElementNodes nodes = rest.nodes(e);
      const std::vector<vtkIdType> ids(nodes.begin(), nodes.end());
      shape->tetrahedra->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
    }
  }
  shape->faces = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& triangle : shape->triangles) {
    const vtkIdType ids[3] = {triangle[0], triangle[1], triangle[2]};
    shape->faces->InsertNextCell(3, ids);
  }
  shape->edges = edge_cells(mesh, shape->triangles);
  double perimeters = 0.0;
  for (const auto& triangle : shape->triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      perimeters += (mesh.vertices[static_cast<std::size_t>(triangle[i])] -
                     mesh.vertices[static_cast<std::size_t>(triangle[(i + 1) % 3])])
                        .norm();
    }
  }
  if (!shape->triangles.empty()) {
    shape->edge_length = perimeters / (3.0 * static_cast<double>(shape->triangles.size()));
  }

  for (const auto& triangle : shape->triangles) {
    shape->surface_vertices.insert(shape->surface_vertices.end(), triangle.begin(), triangle.end());
  }
  auto& surface = shape->surface_vertices;
  std::sort(surface.begin(), surface.end());
  surface.erase(std::unique(surface.begin(), surface.end()), surface.end());
  std::vector<Index> all(static_cast<std::size_t>(n));
  std::iota(all.begin(), all.end(), Index{0});
  shape->points = point_cells(all);
  return shape;
}

}  // namespace tetraction::viewer
