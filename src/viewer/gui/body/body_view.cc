#include "body_view.h"

#include <QVTKInteractor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImageData.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <QLabel>
#include <QMouseEvent>
#include <QOpenGLContext>
#include <QOpenGLFunctions>
#include <QRubberBand>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <QWheelEvent>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "viewer/gui/widgets/theme.h"
#include "viewer/gui/widgets/vtk_widget.h"
#include "viewer/picked_geometry.h"

namespace tetraction::viewer {
namespace {

constexpr double kClickDistance = 4.0;  // pixels; a shorter movement of the mouse is a click

}  // namespace

BodyView::BodyView(QWidget* parent)
    : QWidget(parent), widget_(new VtkWidget(window_, this)), cube_(window_) {
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

  value_ = new QLabel(widget_);
  value_->setObjectName(QStringLiteral("value_text"));
  value_->setAttribute(Qt::WA_TransparentForMouseEvents);
  value_->setAutoFillBackground(true);
  value_->setMargin(kGrid / 4);
  value_->hide();
  widget_->setMouseTracking(true);

  window_->SetMultiSamples(0);
  window_->AddRenderer(renderer_);
  window_->AddRenderer(gutter_);
  gutter_->InteractiveOff();
  gutter_->DrawOff();
  scene_ = std::make_unique<BodyScene>(renderer_, gutter_);
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  widget_->interactor()->SetInteractorStyle(style);
  vtkNew<vtkCallbackCommand> count;
  count->SetClientData(this);
  count->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    auto* view = static_cast<BodyView*>(self);
    ++view->pictures_;
    const Camera camera = view->camera();
    if (std::exchange(view->drawn_camera_, camera) != camera) emit view->camera_moved();
  });
  window_->AddObserver(vtkCommand::EndEvent, count);
  // Also before the pictures that VTK draws while the mouse turns the camera.
  vtkNew<vtkCallbackCommand> place;
  place->SetClientData(this);
  place->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    static_cast<BodyView*>(self)->place_cube();
  });
  window_->AddObserver(vtkCommand::StartEvent, place);
  widget_->installEventFilter(this);
}

BodyView::~BodyView() {
  widget_->removeEventFilter(this);
}

void BodyView::set_body(std::shared_ptr<const BodyShape> shape) {
  snapshot_.reset();
  drawn_.reset();
  shape_ = std::move(shape);
  scene_->set_body(shape_);
}

void BodyView::show_state(std::shared_ptr<const Snapshot> snapshot) {
  const auto before = std::exchange(drawn_, scaled(snapshot));
  const bool moves = follow_ && before && before->position.size() == drawn_->position.size();
  if (moves) scene_->move_camera(before->position, drawn_->position);
  if (snapshot_ && snapshot_->body != snapshot->body) scene_->color_bar().forget_range();
  snapshot_ = std::move(snapshot);
  scene_->set_state(drawn_);
  draw_drag();
  show_value();
}

// The same state with larger displacements, if they are drawn so.
std::shared_ptr<const Snapshot> BodyView::scaled(const std::shared_ptr<const Snapshot>& snapshot) {
  const Index n = snapshot->position.size() / 3;
  if (drawing_.displacement_scale == 1.0 || n != shape_->rest->GetNumberOfPoints()) return snapshot;
  auto larger = std::make_shared<Snapshot>(*snapshot);
  for (Index v = 0; v < n; ++v) {
    const Vector3 rest(shape_->rest->GetPoint(v));
    vertex_block(larger->position, v) =
        rest + drawing_.displacement_scale * (vertex_block(snapshot->position, v) - rest);
  }
  return larger;
}

// The position of a vertex that is drawn there.
Vector3 BodyView::true_position(Index vertex, const Vector3& drawn) const {
  if (drawing_.displacement_scale == 1.0) return drawn;
  const Vector3 rest(shape_->rest->GetPoint(vertex));
  return rest + (drawn - rest) / drawing_.displacement_scale;
}

// The line from the dragged vertex to the mouse.
void BodyView::draw_drag() {
  const bool drags = gesture_ == Gesture::kDrag && !drag_is_exact_ && snapshot_;
  const Vector3 from = drags ? Vector3(vertex_block(drawn_->position, pressed_vertex_)) : anchor_;
  scene_->set_drag_line(from, drags ? drag_goal_ : from);
}

void BodyView::set_drawing(const DrawingSettings& drawing) {
  const bool moves = drawing.displacement_scale != drawing_.displacement_scale;
  drawing_ = drawing;
  scene_->set_drawing(drawing);
  cube_.set_dark(is_dark());
  if (moves && snapshot_) {
    drawn_ = scaled(snapshot_);
    scene_->set_state(drawn_);
  }
  show_value();
  render();
}

void BodyView::set_recording(bool on) {
  recording_ = on;
  render();
}

void BodyView::keep_ghost() {
  scene_->keep_ghost();
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

void BodyView::look_from(const Vector3& direction) {
  scene_->reset_camera(direction);
  render();
}

void BodyView::set_parallel(bool on) {
  scene_->set_parallel(on);
  render();
}

bool BodyView::follow_colors(const std::vector<float>& values,
                             const std::function<bool()>& is_strained) {
  const double low = color_low();
  const double high = color_high();
  const bool has_range = scene_->color_bar().follow(values, is_strained);
  if (drawn_ && (color_low() != low || color_high() != high)) scene_->set_state(drawn_);
  return has_range;
}

void BodyView::refit_colors() {
  scene_->color_bar().forget_range();
  if (drawn_) scene_->set_state(drawn_);
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
  const bool has_bar = has_color_bar_ && drawing_.field != nullptr;
  const double share = has_bar ? std::min(0.4, kGutter / widget_->width()) : 0.0;
  renderer_->SetViewport(0.0, 0.0, 1.0 - share, 1.0);
  gutter_->SetViewport(1.0 - share, 0.0, 1.0, 1.0);
  gutter_->SetDraw(share > 0.0);
  cube_.set_visible(drawing_.cube && !recording_);
  renderer_->ResetCameraClippingRange();
  window_->Render();
  show_edge_mark();
}

void BodyView::place_cube() {
  cube_.place(renderer_->GetActiveCamera(), widget_->width() * renderer_->GetViewport()[2] - kGrid,
              widget_->size());
}

void BodyView::set_color_bar(bool on) {
  has_color_bar_ = on;
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

bool BodyView::press(const QPointF& place, Qt::KeyboardModifiers modifiers) {
  pressed_ = place;
  value_->hide();
  if (const Vector3 face = cube_.face_at(place); !face.isZero()) {
    look_from(face);
    return true;
  }
  gesture_ = Gesture::kCamera;
  if (tool_ == Tool::kSelect || (modifiers & Qt::ShiftModifier) != 0) {
    gesture_ = Gesture::kBand;
    return true;
  }
  if (tool_ == Tool::kLook) return false;
  if (tool_ == Tool::kMove && (modifiers & Qt::ControlModifier) != 0 && grab_obstacle(place)) {
    return true;
  }
  pressed_vertex_ = vertex_at(place);
  if (pressed_vertex_ < 0)
    return false;  // the drag does not begin on the body: it turns the camera
  anchor_ = vertex_block(drawn_->position, pressed_vertex_);
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
      emit dragged(true_position(pressed_vertex_, drag_goal_));
      draw_drag();
      render();
      return true;
    case Gesture::kObstacle:
      emit dragged(anchor_ + in_view_plane(place, anchor_) - in_view_plane(pressed_, anchor_));
      return true;
    case Gesture::kArrow:
      // The body may move while the user pulls the arrow. The arrow starts at the present position.
      if (drawn_) anchor_ = vertex_block(drawn_->position, pressed_vertex_);
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
      hovered_ = place;
      if (gesture_ == Gesture::kNone) show_value();
      return false;
  }
}

// Whether the mouse is where its button was pressed.
bool BodyView::is_click(const QPointF& place) const {
  const QPointF d = place - pressed_;
  return std::hypot(d.x(), d.y()) < kClickDistance;
}

bool BodyView::release(const QPointF& place, Qt::KeyboardModifiers modifiers) {
  const bool add = (modifiers & (Qt::ControlModifier | Qt::ShiftModifier)) != 0;
  const bool clicked = is_click(place);
  const Gesture gesture = std::exchange(gesture_, Gesture::kNone);
  band_->hide();
  if (gesture == Gesture::kDrag) {
    emit released();
    draw_drag();
    render();
  }
  if (gesture == Gesture::kObstacle) emit released();
  if (gesture == Gesture::kArrow) {
    scene_->set_pulled_arrow(anchor_, anchor_);
    render();
  }
  const auto both = Qt::ControlModifier | Qt::ShiftModifier;
  if (clicked && gesture == Gesture::kBand && (modifiers & both) == both) {
    const auto hit = hit_at(place);
    if (hit) {
      emit band_selected(
          face_vertices(scene_->triangles(), drawn_->position, hit->triangle, drawing_.face_angle),
          add);
    }
    return true;
  }
  if (clicked && gesture != Gesture::kNone) {
    emit picked(vertex_at(place), add);
    return gesture != Gesture::kCamera;  // VTK's camera style needs the release event
  }
  if (gesture == Gesture::kArrow) {
    emit arrow_pulled(tool_, pressed_vertex_, in_view_plane(place, anchor_) - anchor_);
  }
  if (gesture == Gesture::kBand) {
    const bool through = (modifiers & Qt::AltModifier) != 0;
    emit band_selected(
        vertices_in(QRect(pressed_.toPoint(), place.toPoint()).normalized(), through), add);
  }
  return gesture != Gesture::kCamera && gesture != Gesture::kNone;
}

void BodyView::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) set_drawing(DrawingSettings(drawing_));
  QWidget::changeEvent(event);
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
      if (mouse->button() == Qt::RightButton) pressed_ = mouse->localPos();
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
      if (mouse->button() == Qt::RightButton && is_click(mouse->localPos())) {
        emit menu_wanted(vertex_at(mouse->localPos()), mouse->globalPos());
      }
      if (mouse->button() != Qt::LeftButton) return false;
      return release(mouse->localPos(), mouse->modifiers());
    }
    case QEvent::MouseButtonDblClick:
      return true;
    case QEvent::Resize:
      // The gutter and the cube have sizes in pixels.
      QTimer::singleShot(0, this, &BodyView::render);
      return false;
    case QEvent::Leave:
      hovered_ = {-1.0, -1.0};
      value_->hide();
      return false;
    case QEvent::Wheel:
      if (gesture_ != Gesture::kDrag) return false;
      emit area_scaled(static_cast<QWheelEvent*>(event)->angleDelta().y() > 0 ? 1.25 : 0.8);
      return true;
    default:
      return false;
  }
}

}  // namespace tetraction::viewer
