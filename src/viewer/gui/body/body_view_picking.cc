// What the mouse points at in the view.
#include <vtkCamera.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include <Eigen/Geometry>
#include <QLabel>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "body_view.h"
#include "viewer/display_units.h"
#include "viewer/gui/widgets/theme.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {
namespace {

constexpr double kNearSilhouette = 10.0;  // pixels; a click this near to the body picks a vertex

// The nearest triangle that a ray intersects in front of its origin.
struct RayHit {
  std::size_t triangle = 0;
  double distance = 0.0;  // from the origin, in lengths of the direction
};

// `position`: 3 per vertex. Intersections for which `is_drawn` returns false are ignored.
template <class IsDrawn>
std::optional<RayHit> first_hit(const std::vector<std::array<Index, 3>>& triangles,
                                const Vector& position, const Vector3& origin,
                                const Vector3& direction, const IsDrawn& is_drawn) {
  // The method of Möller and Trumbore (1997), for both sides of a triangle.
  std::optional<RayHit> nearest;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3 a = vertex_block(position, triangles[t][0]);
    const Vector3 ab = vertex_block(position, triangles[t][1]) - a;
    const Vector3 ac = vertex_block(position, triangles[t][2]) - a;
    const Vector3 p = direction.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0.0) continue;
    const Vector3 s = origin - a;
    const double u = s.dot(p) / determinant;
    if (!(u >= 0.0 && u <= 1.0)) continue;
    const Vector3 q = s.cross(ab);
    const double v = direction.dot(q) / determinant;
    if (!(v >= 0.0 && u + v <= 1.0)) continue;
    const double distance = ac.dot(q) / determinant;
    if (!(distance > 0.0) || (nearest && distance >= nearest->distance)) continue;
    if (!is_drawn(origin + distance * direction)) continue;
    nearest = RayHit{t, distance};
  }
  return nearest;
}

}  // namespace

QPointF BodyView::to_canvas(const Vector3& point) const {
  renderer_->SetWorldPoint(point.x(), point.y(), point.z(), 1.0);
  renderer_->WorldToDisplay();
  const double* display = renderer_->GetDisplayPoint();
  const double ratio = widget_->effectiveDevicePixelRatio();
  return {display[0] / ratio, widget_->height() - 1 - display[1] / ratio};
}

BodyView::Ray BodyView::ray_at(const QPointF& place) const {
  const double ratio = widget_->effectiveDevicePixelRatio();
  Vector3 ends[2];
  for (int i = 0; i < 2; ++i) {
    renderer_->SetDisplayPoint(place.x() * ratio, (widget_->height() - 1 - place.y()) * ratio, i);
    renderer_->DisplayToWorld();
    const double* world = renderer_->GetWorldPoint();
    ends[i] = Vector3(world[0], world[1], world[2]) / world[3];
  }
  return {ends[0], ends[1] - ends[0]};
}

Vector3 BodyView::in_view_plane(const QPointF& place, const Vector3& anchor) const {
  const Ray ray = ray_at(place);
  const Vector3 normal(renderer_->GetActiveCamera()->GetDirectionOfProjection());
  return ray.origin + ray.direction * (normal.dot(anchor - ray.origin) / normal.dot(ray.direction));
}

std::optional<BodyView::Hit> BodyView::hit_at(const QPointF& place) const {
  if (!drawn_) return {};
  const Ray ray = ray_at(place);
  const auto hit = first_hit(scene_->triangles(), drawn_->position, ray.origin, ray.direction,
                             [this](const Vector3& x) { return scene_->is_drawn(x); });
  if (!hit) return {};
  return Hit{hit->triangle, ray.origin + hit->distance * ray.direction};
}

// Begins to drag the obstacle that is seen at this place. Returns whether there is one.
bool BodyView::grab_obstacle(const QPointF& place) {
  if (!snapshot_ || !snapshot_->obstacles || !drawing_.obstacles) return false;
  const ObstacleSurface& surface = *snapshot_->obstacles;
  std::vector<std::array<Index, 3>> triangles;
  std::vector<int> obstacles;
  for (std::size_t i = 0; i < surface.cells.size(); ++i) {
    const auto& [a, b, c, d] = surface.cells[i];
    if (ObstacleSurface::is_line(surface.cells[i])) continue;
    triangles.push_back({a, b, c});
    obstacles.push_back(surface.obstacle[i]);
    if (d < 0) continue;
    triangles.push_back({a, c, d});
    obstacles.push_back(surface.obstacle[i]);
  }
  Vector points(3 * static_cast<Index>(surface.points.size()));
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    vertex_block(points, static_cast<Index>(i)) = surface.points[i];
  }
  const Ray ray = ray_at(place);
  const auto hit =
      first_hit(triangles, points, ray.origin, ray.direction, [](const Vector3&) { return true; });
  if (!hit) return false;
  anchor_ = ray.origin + hit->distance * ray.direction;
  gesture_ = Gesture::kObstacle;
  emit obstacle_grabbed(static_cast<std::size_t>(obstacles[hit->triangle]), anchor_);
  return true;
}

Index BodyView::vertex_at(const QPointF& place) const {
  if (!drawn_) return -1;
  const auto hit = hit_at(place);
  Index best = -1;
  double nearest = std::numeric_limits<double>::infinity();
  const auto consider = [&](Index v, double limit) {
    const Vector3 x = vertex_block(drawn_->position, v);
    if (!scene_->is_drawn(x)) return;
    const QPointF d = to_canvas(x) - place;
    const double distance = std::hypot(d.x(), d.y());
    if (distance <= limit && distance < nearest) {
      nearest = distance;
      best = v;
    }
  };
  if (hit) {
    for (const Index v : scene_->triangles()[hit->triangle]) {
      consider(v, std::numeric_limits<double>::infinity());
    }
  } else {
    for (const auto& triangle : scene_->triangles()) {
      for (const Index v : triangle) consider(v, kNearSilhouette);
    }
  }
  return best;
}

// What VTK has drawn hides vertices behind it, unless the band selects through.
std::vector<Index> BodyView::vertices_in(const QRect& band, bool through) {
  std::vector<Index> inside;
  if (!drawn_) return inside;
  for (Index v = 0; v < drawn_->position.size() / 3; ++v) {
    const Vector3 x = vertex_block(drawn_->position, v);
    if (scene_->is_drawn(x) && QRectF(band).contains(to_canvas(x))) inside.push_back(v);
  }
  if (through || inside.empty() || !widget_->isValid()) return inside;
  // The surface at a vertex may be some pixels away and a little nearer: the vertex must not be behind all of
  // the pixels around it.
  const int* size = window_->GetSize();
  vtkNew<vtkFloatArray> depths;
  window_->GetZbufferData(0, 0, size[0] - 1, size[1] - 1, depths);
  const auto place_of = [&](Index v) {
    const Vector3 x = vertex_block(drawn_->position, v);
    renderer_->SetWorldPoint(x.x(), x.y(), x.z(), 1.0);
    renderer_->WorldToDisplay();
    return Vector3(renderer_->GetDisplayPoint());
  };
  // The range of the depths is that of the body: obstacles may be much nearer and farther.
  double least = 1.0;
  double most = 0.0;
  for (Index v = 0; v < drawn_->position.size() / 3; ++v) {
    const double depth = place_of(v)[2];
    least = std::min(least, depth);
    most = std::max(most, depth);
  }
  constexpr double kSlackOfRange = 5e-3;
  const double slack = kSlackOfRange * std::max(0.0, most - least);
  std::erase_if(inside, [&](Index v) {
    const Vector3 place = place_of(v);
    constexpr int kAround = 1;  // pixels
    double farthest = 0.0;
    for (int i = -kAround; i <= kAround; ++i) {
      for (int j = -kAround; j <= kAround; ++j) {
        const int column = std::clamp(static_cast<int>(place[0]) + i, 0, size[0] - 1);
        const int row = std::clamp(static_cast<int>(place[1]) + j, 0, size[1] - 1);
        farthest = std::max<double>(farthest, depths->GetValue(row * size[0] + column));
      }
    }
    return place[2] > farthest + slack;
  });
  return inside;
}

// Writes the value of the colour beside the mouse.
void BodyView::show_value() {
  const bool wanted = QRectF(widget_->rect()).contains(hovered_) && gesture_ == Gesture::kNone;
  const auto hit = wanted && drawing_.surface ? hit_at(hovered_) : std::nullopt;
  double value = std::numeric_limits<double>::quiet_NaN();
  if (hit) {
    const auto& [a, b, c] = scene_->triangles()[hit->triangle];
    const Vector3 origin = vertex_block(drawn_->position, a);
    const Vector3 normal = (vertex_block(drawn_->position, b) - origin)
                               .cross(vertex_block(drawn_->position, c) - origin);
    // The inner side of a face is seen through the section, whose value is another.
    if (normal.dot(ray_at(hovered_).direction) < 0.0) {
      value = scene_->value_at(hit->triangle, hit->point);
    }
  }
  value_->setVisible(std::isfinite(value));
  if (!std::isfinite(value)) return;
  value_->setText(QString::fromStdString(drawing_.field.title() + " " +
                                         with_prefix(value, drawing_.field->unit)));
  value_->adjustSize();
  const QPoint beside = hovered_.toPoint() + QPoint(2 * kGrid, 2 * kGrid);
  value_->move(std::min(beside.x(), widget_->width() - value_->width()),
               std::min(beside.y(), widget_->height() - value_->height()));
}

}  // namespace tetraction::viewer
