// The camera of the body's picture.
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "body_scene.h"

namespace tetraction::viewer {
namespace {

Vector3 middle_of(const Vector& position) {
  return position.reshaped(3, position.size() / 3).rowwise().mean();
}

// Of the visible part of the plane through the focus, in a picture with perspective.
double half_height(vtkCamera* camera) {
  return camera->GetDistance() * std::tan(0.5 * camera->GetViewAngle() * std::numbers::pi / 180.0);
}

}  // namespace

std::pair<Vector3, Vector3> BodyScene::bounds() const {
  if (!last_ || last_->position.size() == 0 || !last_->position.allFinite()) {
    return {shape_->low, shape_->high};
  }
  const auto places = last_->position.reshaped(3, last_->position.size() / 3);
  return {places.rowwise().minCoeff(), places.rowwise().maxCoeff()};
}

void BodyScene::show_box(const Vector3& low, const Vector3& high) {
  // A margin for motion and for the colour bar.
  const Vector3 room = 0.12 * (high - low).norm() * Vector3::Ones();
  const double box[6] = {low.x() - room.x(),  high.x() + room.x(), low.y() - room.y(),
                         high.y() + room.y(), low.z() - room.z(),  high.z() + room.z()};
  renderer_->ResetCamera(box);
}

void BodyScene::set_parallel(bool parallel) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  if (parallel) {
    camera->SetParallelScale(half_height(camera));
  } else {  // the body keeps its size
    const double distance =
        camera->GetDistance() * camera->GetParallelScale() / half_height(camera);
    const Vector3 eye =
        Vector3(camera->GetFocalPoint()) - distance * Vector3(camera->GetDirectionOfProjection());
    camera->SetPosition(eye.x(), eye.y(), eye.z());
  }
  camera->SetParallelProjection(parallel);
}

void BodyScene::reset_camera(const Vector3& from) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const auto [low, high] = bounds();  // the body may be far from its rest position
  const Vector3 middle = 0.5 * (low + high);
  const bool along_y = from.x() == 0.0 && from.z() == 0.0;
  const Vector3 up = along_y ? Vector3(0.0, 0.0, from.y() > 0.0 ? -1.0 : 1.0) : Vector3::UnitY();
  camera->SetFocalPoint(middle.x(), middle.y(), middle.z());
  const Vector3 eye = middle + from;
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetViewUp(up.x(), up.y(), up.z());
  show_box(low, high);
}

void BodyScene::fit() {
  const auto [low, high] = bounds();
  show_box(low, high);
}

void BodyScene::fit(const std::vector<Index>& vertices) {
  if (!last_ || vertices.empty()) return;
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 high = -low;
  for (const Index v : vertices) {
    low = low.cwiseMin(Vector3(vertex_block(last_->position, v)));
    high = high.cwiseMax(Vector3(vertex_block(last_->position, v)));
  }
  const Vector3 around = (high - low).norm() * Vector3::Ones();
  show_box(low - around, high + around);
}

void BodyScene::move_camera(const Vector& from, const Vector& to) {
  const Vector3 way = middle_of(to) - middle_of(from);
  if (!way.allFinite()) return;
  vtkCamera* camera = renderer_->GetActiveCamera();
  const Vector3 eye = Vector3(camera->GetPosition()) + way;
  const Vector3 focus = Vector3(camera->GetFocalPoint()) + way;
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
}

QPointF BodyScene::direction_to_body() const {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const auto [low, high] = bounds();
  const Vector3 way = 0.5 * (low + high) - Vector3(camera->GetFocalPoint());
  const Vector3 forward(camera->GetDirectionOfProjection());
  const Vector3 right = forward.cross(Vector3(camera->GetViewUp())).normalized();
  return {way.dot(right), -way.dot(right.cross(forward))};
}

void BodyScene::fade_edges(double height) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const double visible = camera->GetParallelProjection() != 0 ? 2.0 * camera->GetParallelScale()
                                                              : 2.0 * half_height(camera);
  const double pixels = shape_->edge_length / visible * height;
  constexpr double kNone = 5.0;    // pixels from edge to edge at which none are drawn
  constexpr double kAll = 12.0;    // and from which they have their full contrast
  constexpr double kFaint = 0.55;  // grey near the brightness of the colours
  const double fade = std::clamp((kAll - pixels) / (kAll - kNone), 0.0, 1.0);
  const double gray = edge_gray_ + fade * (kFaint - edge_gray_);
  const bool drawn = drawing_.edges && (fade < 1.0 || shape_->edge_length == 0.0);
  for (vtkActor* actor : {surface_actor_.Get(), section_actor_.Get()}) {
    actor->GetProperty()->SetEdgeVisibility(drawn);
    actor->GetProperty()->SetEdgeColor(gray, gray, gray);
  }
}

}  // namespace tetraction::viewer
