#include "view_cube.h"

#include <vtkAnnotatedCubeActor.h>
#include <vtkCamera.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tetraction::viewer {
namespace {

constexpr double kSize = 88.0;  // of the square with the cube, logical pixels
constexpr double kBelow = 8.0;  // it
constexpr double kHalfHeight =
    0.95;  // of the square, in edges of the cube, which fits in every direction

}  // namespace

ViewCube::ViewCube(vtkRenderWindow* window) {
  constexpr int kAbove = 1;
  window->SetNumberOfLayers(kAbove + 1);
  renderer_->SetLayer(kAbove);
  renderer_->InteractiveOff();
  window->AddRenderer(renderer_);
  cube_->SetXPlusFaceText("+x");
  cube_->SetXMinusFaceText("-x");
  cube_->SetYPlusFaceText("+y");
  cube_->SetYMinusFaceText("-y");
  cube_->SetZPlusFaceText("+z");
  cube_->SetZMinusFaceText("-z");
  cube_->SetZFaceTextRotation(90.0);
  cube_->SetFaceTextScale(0.45);
  cube_->SetTextEdgesVisibility(0);
  cube_->GetCubeProperty()->EdgeVisibilityOn();
  for (vtkProperty* property :
       {cube_->GetCubeProperty(), cube_->GetXPlusFaceProperty(), cube_->GetXMinusFaceProperty(),
        cube_->GetYPlusFaceProperty(), cube_->GetYMinusFaceProperty(),
        cube_->GetZPlusFaceProperty(), cube_->GetZMinusFaceProperty()}) {
    property->LightingOff();
  }
  renderer_->AddViewProp(cube_);
  renderer_->GetActiveCamera()->ParallelProjectionOn();
  set_dark(false);
}

ViewCube::~ViewCube() = default;

void ViewCube::set_visible(bool visible) {
  renderer_->SetDraw(visible);
}

void ViewCube::set_dark(bool dark) {
  const double face = dark ? 0.30 : 0.93;
  const double text = dark ? 0.92 : 0.15;
  const double edge = dark ? 0.60 : 0.50;
  cube_->GetCubeProperty()->SetColor(face, face, face);
  cube_->GetCubeProperty()->SetEdgeColor(edge, edge, edge);
  for (vtkProperty* property : {cube_->GetXPlusFaceProperty(), cube_->GetXMinusFaceProperty(),
                                cube_->GetYPlusFaceProperty(), cube_->GetYMinusFaceProperty(),
                                cube_->GetZPlusFaceProperty(), cube_->GetZMinusFaceProperty()}) {
    property->SetColor(text, text, text);
  }
}

void ViewCube::place(vtkCamera* camera, double right, const QSizeF& picture) {
  size_ = std::min({kSize, 0.5 * picture.width(), 0.5 * picture.height()});
  left_ = right - size_;
  top_ = picture.height() - kBelow - size_;
  renderer_->SetViewport(std::max(left_ / picture.width(), 0.0), kBelow / picture.height(),
                         right / picture.width(), (kBelow + size_) / picture.height());
  const Vector3 direction(camera->GetDirectionOfProjection());
  const Vector3 eye = -4.0 * direction;
  const Vector3 up(camera->GetViewUp());
  vtkCamera* own = renderer_->GetActiveCamera();
  own->SetFocalPoint(0.0, 0.0, 0.0);
  own->SetPosition(eye.x(), eye.y(), eye.z());
  own->SetViewUp(up.x(), up.y(), up.z());
  own->SetParallelScale(kHalfHeight);
  own->SetClippingRange(1.0, 8.0);
}

Vector3 ViewCube::face_at(const QPointF& place) const {
  if (renderer_->GetDraw() == 0) return Vector3::Zero();
  vtkCamera* camera = renderer_->GetActiveCamera();
  const Vector3 direction(camera->GetDirectionOfProjection());
  const Vector3 right = direction.cross(Vector3(camera->GetViewUp())).normalized();
  const double scale = 2.0 * kHalfHeight / size_;
  const double x = (place.x() - left_ - 0.5 * size_) * scale;
  const double y = (top_ + 0.5 * size_ - place.y()) * scale;
  const Vector3 origin = x * right + y * right.cross(direction);
  // The ray enters the cube through the last of the planes of the three faces that it can see.
  double entry = -1e30;
  double exit = 1e30;
  Vector3 face = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (std::abs(direction[i]) < 1e-9) {
      if (std::abs(origin[i]) > 0.5) return Vector3::Zero();
      continue;
    }
    const double side = direction[i] > 0.0 ? -0.5 : 0.5;
    const double near = (side - origin[i]) / direction[i];
    exit = std::min(exit, (-side - origin[i]) / direction[i]);
    if (near > entry) {
      entry = near;
      face = 2.0 * side * Vector3::Unit(i);
    }
  }
  return entry < exit ? face : Vector3::Zero();
}

}  // namespace tetraction::viewer
