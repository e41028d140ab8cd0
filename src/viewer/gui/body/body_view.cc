#include "body_view.h"

#include <QVTKInteractor.h>
#include <vtkAxesActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCaptionActor2D.h>
#include <vtkCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImageData.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkOrientationMarkerWidget.h>
#include <vtkRenderer.h>
#include <vtkTextProperty.h>
#include <vtkWindowToImageFilter.h>

#include <Eigen/Geometry>
#include <QMouseEvent>
#include <QOpenGLContext>
#include <QOpenGLFunctions>
#include <QRubberBand>
#include <QToolButton>
#include <QVBoxLayout>
#include <QWheelEvent>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {
namespace {

constexpr double kClickDistance = 4.0;    // pixels; a shorter movement of the mouse is a click
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

BodyView::BodyView(QWidget* parent) : QWidget(parent), widget_(new VtkWidget(window_, this)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(widget_);
  setMinimumSize(320, 240);
  widget_->setFocusPolicy(Qt::StrongFocus);
  widget_->setAccessibleName(tr("The body in space"));
  band_ = new QRubberBand(QRubberBand::Rectangle, widget_);
  edge_mark_ = new QToolButton(widget_);
  edge_mark_->setObjectName(QStringLiteral("edge_mark"));
  edge_mark_->setFocusPolicy(Qt::NoFocus);
  edge_mark_->setToolTip(tr("The body is outside the picture: a click shows all of it (Home)"));
  edge_mark_->hide();
  connect(edge_mark_, &QToolButton::clicked, this, &BodyView::fit);

  window_->SetMultiSamples(0);
  window_->AddRenderer(renderer_);
  window_->AddRenderer(gutter_);
  gutter_->InteractiveOff();
  gutter_->DrawOff();
  scene_ = std::make_unique<BodyScene>(renderer_, gutter_);
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  widget_->interactor()->SetInteractorStyle(style);
  for (vtkCaptionActor2D* caption :
       {marker_axes_->GetXAxisCaptionActor2D(), marker_axes_->GetYAxisCaptionActor2D(),
        marker_axes_->GetZAxisCaptionActor2D()}) {
    caption->GetCaptionTextProperty()->ShadowOff();
    caption->GetCaptionTextProperty()->ItalicOff();
    caption->GetCaptionTextProperty()->SetColor(0.5, 0.5, 0.5);
  }
  marker_->SetOrientationMarker(marker_axes_);
  marker_->SetInteractor(widget_->interactor());
  marker_->SetViewport(0.0, 0.80, 0.15, 1.0);
  marker_->EnabledOn();
  marker_->InteractiveOff();

  vtkNew<vtkCallbackCommand> count;
  count->SetClientData(this);
  count->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    ++static_cast<BodyView*>(self)->pictures_;
  });
  window_->AddObserver(vtkCommand::EndEvent, count);
  widget_->installEventFilter(this);
}

BodyView::~BodyView() {
  widget_->removeEventFilter(this);
  marker_->SetInteractor(nullptr);
}

void BodyView::set_body(std::shared_ptr<const BodyShape> shape) {
  snapshot_.reset();
  scene_->set_body(std::move(shape));
}

void BodyView::show_state(std::shared_ptr<const Snapshot> snapshot) {
  const bool moves =
      follow_ && snapshot_ && snapshot_->position.size() == snapshot->position.size();
  if (moves) scene_->move_camera(snapshot_->position, snapshot->position);
  if (snapshot_ && snapshot_->body != snapshot->body) scene_->color_bar().forget_range();
  snapshot_ = std::move(snapshot);
  scene_->set_state(snapshot_);
  draw_drag();
}

// The line from the dragged vertex to the mouse.
void BodyView::draw_drag() {
  const bool drags = gesture_ == Gesture::kDrag && !drag_is_exact_ && snapshot_;
  const Vector3 from =
      drags ? Vector3(vertex_block(snapshot_->position, pressed_vertex_)) : anchor_;
  scene_->set_drag_line(from, drags ? drag_goal_ : from);
}

void BodyView::set_drawing(const DrawingSettings& drawing) {
  drawing_ = drawing;
  scene_->set_drawing(drawing);
  render();
}

void BodyView::set_selection(const std::vector<Index>& vertices) {
  scene_->set_selection(vertices);
  render();
}

void BodyView::set_attraction(bool present) {
  scene_->set_attraction(present);
}

void BodyView::set_tool(Tool tool) {
  tool_ = tool;
  widget_->setCursor(tool == Tool::kLook     ? Qt::OpenHandCursor
                     : tool == Tool::kSelect ? Qt::CrossCursor
                                             : Qt::PointingHandCursor);
}

void BodyView::reset_camera(int axis) {
  scene_->reset_camera(axis);
  render();
}

void BodyView::refit_colors() {
  scene_->color_bar().forget_range();
  if (snapshot_) scene_->set_state(snapshot_);
  render();
}

void BodyView::render() {
  if (!widget_->isValid()) return;  // not on the screen yet
  if (!started_) {
    started_ = true;
    detect_graphics_card();
  }
  scene_->set_pixel_ratio(widget_->effectiveDevicePixelRatio());
  scene_->fade_edges(widget_->height());
  // The colour bar has a place of its own, so that it never lies over the body.
  constexpr double kGutter = 120.0;  // pixels
  const double share = drawing_.field != nullptr ? std::min(0.4, kGutter / widget_->width()) : 0.0;
  renderer_->SetViewport(0.0, 0.0, 1.0 - share, 1.0);
  gutter_->SetViewport(1.0 - share, 0.0, 1.0, 1.0);
  gutter_->SetDraw(share > 0.0);
  renderer_->ResetCameraClippingRange();
  window_->Render();
  show_edge_mark();
}

void BodyView::detect_graphics_card() {
  widget_->makeCurrent();
  const auto* name =
      reinterpret_cast<const char*>(widget_->context()->functions()->glGetString(GL_RENDERER));
  const QByteArray renderer(name);
  widget_->doneCurrent();
  scene_->set_graphics_card(!renderer.contains("llvmpipe") && !renderer.contains("softpipe") &&
                            !renderer.contains("swrast"));
}

QImage BodyView::picture() const {
  return widget_->grabFramebuffer();
}

QImage BodyView::picture(const QSize& size) {
  const QImage own = picture();
  const double needed = std::max(static_cast<double>(size.width()) / own.width(),
                                 static_cast<double>(size.height()) / own.height());
  if (needed <= 1.0) return own;
  // VTK draws the parts of a larger picture one after another.
  vtkNew<vtkWindowToImageFilter> parts;
  parts->SetInput(window_);
  parts->SetScale(static_cast<int>(std::ceil(needed)));
  parts->ReadFrontBufferOff();
  parts->Update();
  vtkImageData* pixels = parts->GetOutput();
  const int* points = pixels->GetDimensions();
  const QImage whole(static_cast<const uchar*>(pixels->GetScalarPointer()), points[0], points[1],
                     3 * points[0], QImage::Format_RGB888);
  const QImage picture = whole.mirrored();
  render();
  return picture;
}

QWidget* BodyView::canvas() const {
  return widget_;
}

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

Index BodyView::vertex_at(const QPointF& place) const {
  if (!snapshot_) return -1;
  const Ray ray = ray_at(place);
  const auto drawn = [this](const Vector3& x) { return scene_->is_drawn(x); };
  const auto hit =
      first_hit(scene_->triangles(), snapshot_->position, ray.origin, ray.direction, drawn);
  Index best = -1;
  double nearest = std::numeric_limits<double>::infinity();
  const auto consider = [&](Index v, double limit) {
    const Vector3 x = vertex_block(snapshot_->position, v);
    if (!drawn(x)) return;
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

std::vector<Index> BodyView::vertices_in(const QRect& band) const {
  std::vector<Index> inside;
  if (!snapshot_) return inside;
  for (Index v = 0; v < snapshot_->position.size() / 3; ++v) {
    const Vector3 x = vertex_block(snapshot_->position, v);
    if (scene_->is_drawn(x) && QRectF(band).contains(to_canvas(x))) inside.push_back(v);
  }
  return inside;
}

bool BodyView::press(const QPointF& place, Qt::KeyboardModifiers modifiers) {
  pressed_ = place;
  gesture_ = Gesture::kCamera;
  if (tool_ == Tool::kSelect || (modifiers & Qt::ShiftModifier) != 0) {
    gesture_ = Gesture::kBand;
    return true;
  }
  if (tool_ == Tool::kLook) return false;
  pressed_vertex_ = vertex_at(place);
  if (pressed_vertex_ < 0)
    return false;  // the drag does not begin on the body: it turns the camera
  anchor_ = vertex_block(snapshot_->position, pressed_vertex_);
  gesture_ = tool_ == Tool::kMove ? Gesture::kDrag : Gesture::kArrow;
  if (gesture_ == Gesture::kDrag) {
    drag_is_exact_ = (modifiers & Qt::AltModifier) != 0;
    drag_goal_ = anchor_;
    emit grabbed(pressed_vertex_, drag_is_exact_);
  }
  return true;
}

bool BodyView::move(const QPointF& place) {
  switch (gesture_) {
    case Gesture::kBand:
      band_->setGeometry(QRect(pressed_.toPoint(), place.toPoint()).normalized());
      band_->show();
      return true;
    case Gesture::kDrag:
      drag_goal_ = anchor_ + in_view_plane(place, anchor_) - in_view_plane(pressed_, anchor_);
      emit dragged(drag_goal_);
      draw_drag();
      render();
      return true;
    case Gesture::kArrow:
      // The body may move while the user pulls the arrow. The arrow starts at the present position.
      if (snapshot_) anchor_ = vertex_block(snapshot_->position, pressed_vertex_);
      scene_->set_pulled_arrow(anchor_, in_view_plane(place, anchor_));
      emit arrow_moved(tool_, in_view_plane(place, anchor_) - anchor_);
      render();
      return true;
    case Gesture::kLight: {
      constexpr double kDegreesPerPixel = 0.4;
      const QPointF movement = place - std::exchange(pressed_, place);
      emit light_turned(kDegreesPerPixel * movement.x(), -kDegreesPerPixel * movement.y());
      return true;
    }
    default:
      return false;
  }
}

bool BodyView::release(const QPointF& place, Qt::KeyboardModifiers modifiers) {
  const bool add = (modifiers & (Qt::ControlModifier | Qt::ShiftModifier)) != 0;
  const QPointF d = place - pressed_;
  const bool clicked = std::hypot(d.x(), d.y()) < kClickDistance;
  const Gesture gesture = std::exchange(gesture_, Gesture::kNone);
  band_->hide();
  if (gesture == Gesture::kDrag) {
    emit released();
    draw_drag();
    render();
  }
  if (gesture == Gesture::kArrow) {
    scene_->set_pulled_arrow(anchor_, anchor_);
    render();
  }
  if (clicked && gesture != Gesture::kNone) {
    emit picked(vertex_at(place), add);
    return gesture != Gesture::kCamera;  // VTK's camera style needs the release event
  }
  if (gesture == Gesture::kArrow) {
    emit arrow_pulled(tool_, pressed_vertex_, in_view_plane(place, anchor_) - anchor_);
  }
  if (gesture == Gesture::kBand) {
    emit band_selected(vertices_in(QRect(pressed_.toPoint(), place.toPoint()).normalized()), add);
  }
  return gesture != Gesture::kCamera && gesture != Gesture::kNone;
}

bool BodyView::eventFilter(QObject* watched, QEvent* event) {
  if (watched != widget_) return QWidget::eventFilter(watched, event);
  switch (event->type()) {
    case QEvent::KeyPress:
    case QEvent::KeyRelease:
      // Keys are not passed to VTK, because it has actions of its own for letters ("e" ends the program).
      event->ignore();
      return true;
    case QEvent::MouseButtonPress: {
      const auto* mouse = static_cast<QMouseEvent*>(event);
      if (mouse->button() == Qt::RightButton && (mouse->modifiers() & Qt::ControlModifier) != 0) {
        pressed_ = mouse->localPos();
        gesture_ = Gesture::kLight;
        return true;
      }
      if (mouse->button() != Qt::LeftButton) return false;
      widget_->setFocus(Qt::MouseFocusReason);
      return press(mouse->localPos(), mouse->modifiers());
    }
    case QEvent::MouseMove:
      return move(static_cast<QMouseEvent*>(event)->localPos());
    case QEvent::MouseButtonRelease: {
      const auto* mouse = static_cast<QMouseEvent*>(event);
      if (mouse->button() == Qt::RightButton && gesture_ == Gesture::kLight) {
        gesture_ = Gesture::kNone;
        return true;
      }
      if (mouse->button() != Qt::LeftButton) return false;
      return release(mouse->localPos(), mouse->modifiers());
    }
    case QEvent::MouseButtonDblClick:
      return true;
    case QEvent::Wheel:
      if (gesture_ != Gesture::kDrag) return false;
      emit area_scaled(static_cast<QWheelEvent*>(event)->angleDelta().y() > 0 ? 1.25 : 0.8);
      return true;
    default:
      return false;
  }
}

}  // namespace tetraction::viewer
