#include "drawn_obstacles.h"

#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace tetraction::viewer {

DrawnObstacles::DrawnObstacles(vtkRenderer* renderer) : renderer_(renderer) {
  for (const auto& [data, actor] :
       {std::pair(polygons_.Get(), faces_.Get()), std::pair(lines_.Get(), grid_.Get())}) {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    mapper->ScalarVisibilityOff();
    // The body lies on obstacles: what of it touches them is drawn before them.
    mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 12.0);
    actor->SetMapper(mapper);
    actor->UseBoundsOff();
    actor->PickableOff();
    actor->ForceTranslucentOn();  // also the lines: they must not hide vertices from the mouse
    renderer->AddActor(actor);
  }
  faces_->GetProperty()->SetInterpolationToFlat();
  faces_->GetProperty()->SetOpacity(0.55);
  faces_->GetProperty()->BackfaceCullingOn();
  grid_->GetProperty()->LightingOff();
  grid_->GetProperty()->SetOpacity(0.35);
  vtkNew<vtkCallbackCommand> widen;
  widen->SetClientData(this);
  widen->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    static_cast<DrawnObstacles*>(self)->widen_clipping_range();
  });
  observer_ = renderer->AddObserver(vtkCommand::ResetCameraClippingRangeEvent, widen);
  set_dark(false);
  update_visibility();
}

DrawnObstacles::~DrawnObstacles() {
  renderer_->RemoveObserver(observer_);
}

void DrawnObstacles::set(std::shared_ptr<const ObstacleSurface> surface) {
  const bool is_same = surface == surface_ || (surface && surface_ && *surface == *surface_);
  surface_ = std::move(surface);
  if (is_same) return;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> polygons;
  vtkNew<vtkCellArray> lines;
  if (surface_) {
    for (const Vector3& x : surface_->points) points->InsertNextPoint(x.data());
    for (const auto& cell : surface_->cells) {
      const vtkIdType ids[4] = {cell[0], cell[1], cell[2], cell[3]};
      if (ObstacleSurface::is_line(cell)) {
        lines->InsertNextCell(2, ids);
      } else {
        polygons->InsertNextCell(cell[3] < 0 ? 3 : 4, ids);
      }
    }
  }
  polygons_->SetPoints(points);
  polygons_->SetPolys(polygons);
  lines_->SetPoints(points);
  lines_->SetLines(lines);
  update_visibility();
}

void DrawnObstacles::set_visible(bool visible) {
  visible_ = visible;
  update_visibility();
}

void DrawnObstacles::update_visibility() {
  for (vtkActor* actor : {faces_.Get(), grid_.Get()}) {
    actor->SetVisibility(visible_ && surface_ && !surface_->cells.empty());
  }
}

void DrawnObstacles::set_dark(bool dark) {
  // Sand, which no map of colours has.
  faces_->GetProperty()->SetColor(0.74, 0.69, 0.58);
  if (dark) {
    grid_->GetProperty()->SetColor(0.90, 0.87, 0.80);
  } else {
    grid_->GetProperty()->SetColor(0.30, 0.27, 0.22);
  }
}

void DrawnObstacles::set_pixel_ratio(double ratio) {
  grid_->GetProperty()->SetLineWidth(static_cast<float>(ratio));
}

// The range is that of the body when it is called.
void DrawnObstacles::widen_clipping_range() {
  if (grid_->GetVisibility() == 0) return;
  vtkCamera* camera = renderer_->GetActiveCamera();
  const Vector3 eye(camera->GetPosition());
  const Vector3 forward(camera->GetDirectionOfProjection());
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  const double* box = polygons_->GetBounds();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 x(box[corner & 1], box[2 + (corner >> 1 & 1)], box[4 + (corner >> 2)]);
    const double depth = forward.dot(x - eye);
    least = std::min(least, depth);
    most = std::max(most, depth);
  }
  double range[2];
  camera->GetClippingRange(range);
  // The depth buffer tells the faces of the body apart as long as the range is not many times as wide.
  constexpr double kNearer = 0.1;
  constexpr double kFarther = 20.0;
  const double nearest = camera->GetParallelProjection() != 0
                             ? range[0] - kFarther * (range[1] - range[0])
                             : kNearer * range[0];
  camera->SetClippingRange(std::clamp(least, nearest, range[0]),
                           std::clamp(most, range[1], kFarther * range[1]));
}

}  // namespace tetraction::viewer
