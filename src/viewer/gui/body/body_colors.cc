// The colours of the body, and the values that they stand for.
#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCoordinate.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTextActor.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "body_scene.h"
#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

void set_values(vtkFloatArray* array, const std::vector<float>& values) {
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()));
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  array->Modified();
}

}  // namespace

void BodyScene::color(const Snapshot& snapshot) {
  const std::vector<float>& values = snapshot.field_values;
  const auto n = static_cast<std::size_t>(points_->GetNumberOfPoints());
  const auto m = static_cast<std::size_t>(grid_->GetNumberOfCells());
  // The body has no colours until the solver has computed the new field.
  const bool fits = snapshot.field == drawing_.field && drawing_.field != nullptr &&
                    values.size() == (snapshot.field_on_cells ? m : n);
  if (fits && snapshot.field->is_integral) {
    const int regions = 1 + static_cast<int>(*std::max_element(values.begin(), values.end()));
    if (std::exchange(regions_, regions) != regions) {
      color_bar_.set(drawing_, regions_, text_gray_);
    }
  }
  colored_ =
      fits && color_bar_.follow(values, [&] { return is_strained(*shape_, snapshot.position); });
  const bool averaged =
      drawing_.averaged && snapshot.field_on_cells && fits && !snapshot.field->is_integral;
  colored_cells_ = snapshot.field_on_cells && !averaged;
  for (vtkPolyDataMapper* mapper :
       {surface_mapper_.Get(), section_mapper_.Get(), cloud_mapper_.Get()}) {
    mapper->SetScalarVisibility(colored_);
    if (colored_cells_) {
      mapper->SetScalarModeToUseCellData();
    } else {
      mapper->SetScalarModeToUsePointData();
    }
  }
  for (vtkActor* actor : {surface_actor_.Get(), section_actor_.Get()}) {
    // A face towards the light has the colour of the bar, and others are darker.
    actor->GetProperty()->SetLighting(!colored_ || drawing_.shaded);
    actor->GetProperty()->SetAmbient(colored_ ? 0.6 : 0.45);
    actor->GetProperty()->SetDiffuse(colored_ ? 0.4 : 0.75);
  }
  if (drawing_.smooth) {
    const Vector normals = outward_normals(snapshot.position);
    normals_->SetNumberOfTuples(static_cast<vtkIdType>(n));
    for (std::size_t v = 0; v < n; ++v) {
      const Vector3 normal = vertex_block(normals, static_cast<Index>(v)).normalized();
      normals_->SetTuple(static_cast<vtkIdType>(v), normal.data());
    }
    normals_->Modified();
  }
  surface_->GetPointData()->SetNormals(drawing_.smooth ? normals_.Get() : nullptr);
  for (auto& mark : extremes_) mark->SetVisibility(colored_ && drawing_.extremes);
  if (!colored_) return;
  if (colored_cells_) {
    cloud_mapper_->ScalarVisibilityOff();  // the field has no values at vertices
    std::vector<float> of_triangles(shape_->triangle_cell.size());
    for (std::size_t t = 0; t < of_triangles.size(); ++t) {
      of_triangles[t] = values[static_cast<std::size_t>(shape_->triangle_cell[t])];
    }
    set_values(triangle_values_, of_triangles);
    set_values(cell_values_, values);
    surface_->GetCellData()->SetScalars(triangle_values_);
    grid_->GetCellData()->SetScalars(cell_values_);
    grid_->GetPointData()->SetScalars(nullptr);
  } else {
    set_values(point_values_, averaged ? averages(values) : values);
    surface_->GetPointData()->SetScalars(point_values_);
    cloud_->GetPointData()->SetScalars(point_values_);
    grid_->GetPointData()->SetScalars(point_values_);
    grid_->GetCellData()->SetScalars(nullptr);
  }
  if (drawing_.extremes && texts_due_) mark_extremes(values, snapshot.field_on_cells);
}

// The mean of the tetrahedra at each vertex.
std::vector<float> BodyScene::averages(const std::vector<float>& values) const {
  std::vector<float> sums(static_cast<std::size_t>(points_->GetNumberOfPoints()), 0.0F);
  std::vector<float> counts(sums.size(), 0.0F);
  vtkIdType count = 0;
  const vtkIdType* vertices = nullptr;
  for (std::size_t e = 0; e < values.size(); ++e) {
    shape_->tetrahedra->GetCellAtId(static_cast<vtkIdType>(e), count, vertices);
    for (vtkIdType i = 0; i < count; ++i) {
      sums[static_cast<std::size_t>(vertices[i])] += values[e];
      counts[static_cast<std::size_t>(vertices[i])] += 1.0F;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) sums[v] /= std::max(counts[v], 1.0F);
  return sums;
}

void BodyScene::mark_extremes(const std::vector<float>& values, bool on_cells) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  for (std::size_t i = 0; i < 2; ++i) {
    const auto found = i == 0 ? least : most;
    const auto place = static_cast<vtkIdType>(found - values.begin());
    Vector3 point;
    if (on_cells) {
      vtkIdType count = 0;
      const vtkIdType* vertices = nullptr;
      shape_->tetrahedra->GetCellAtId(place, count, vertices);
      point.setZero();
      for (int corner = 0; corner < 4; ++corner) {
        point += 0.25 * Vector3(points_->GetPoint(vertices[corner]));
      }
    } else {
      point = Vector3(points_->GetPoint(place));
    }
    extremes_[i]->GetPositionCoordinate()->SetValue(point.data());
    const std::string text =
        (i == 0 ? "+ min " : "+ max ") + with_prefix(*found, drawing_.field->unit);
    extremes_[i]->SetInput(text.c_str());
  }
}

double BodyScene::value_at(std::size_t triangle, const Vector3& point) const {
  if (!colored_) return std::numeric_limits<double>::quiet_NaN();
  if (colored_cells_) return triangle_values_->GetValue(static_cast<vtkIdType>(triangle));
  // Weighted by the areas of the parts into which the point divides the triangle.
  const auto& corners = shape_->triangles[triangle];
  std::array<Vector3, 3> x;
  for (std::size_t i = 0; i < 3; ++i) x[i] = Vector3(points_->GetPoint(corners[i]));
  double sum = 0.0;
  double areas = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double area = (x[(i + 1) % 3] - point).cross(x[(i + 2) % 3] - point).norm();
    sum += area * point_values_->GetValue(corners[i]);
    areas += area;
  }
  return areas > 0.0 ? sum / areas : sum;
}

void BodyScene::keep_ghost() {
  vtkNew<vtkPoints> kept;
  kept->DeepCopy(points_);
  ghost_->SetPoints(kept);
}

}  // namespace tetraction::viewer
