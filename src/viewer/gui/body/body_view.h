// The 3-D view: the body, and the mouse on it.
#pragma once

#include <vtkNew.h>

#include <QImage>
#include <QWidget>
#include <memory>
#include <optional>
#include <vector>

#include "body_scene.h"
#include "drawing_settings.h"

class QRubberBand;
class QVTKOpenGLNativeWidget;
class vtkAxesActor;
class vtkGenericOpenGLRenderWindow;
class vtkOrientationMarkerWidget;
class vtkRenderer;

namespace tetraction::viewer {

/// What the left mouse button does where it is dragged; a click always picks.
enum class Tool { kLook, kSelect, kMove, kForce, kMomentum };

class BodyView : public QWidget {
  Q_OBJECT

 public:
  explicit BodyView(QWidget* parent = nullptr);
  ~BodyView() override;

  void set_body(std::shared_ptr<const BodyShape> shape);
  void show_state(std::shared_ptr<const Snapshot> snapshot);
  void set_drawing(const DrawingSettings& drawing);
  /// The state that is shown; null before the first.
  const std::shared_ptr<const Snapshot>& state() const { return snapshot_; }
  const DrawingSettings& drawing() const { return drawing_; }
  void set_selection(const std::vector<Index>& vertices);
  void set_attraction(bool present);
  void set_tool(Tool tool);
  Tool tool() const { return tool_; }
  void reset_camera(int axis);
  /// Fits automatic colours to the state that is shown.
  void refit_colors();
  double color_low() { return scene_->color_bar().low(); }
  double color_high() { return scene_->color_bar().high(); }

  void render();
  /// Pictures drawn so far.
  std::uint64_t picture_count() const { return pictures_; }
  /// What is seen now.
  QImage picture() const;
  /// Where the mouse events go.
  QWidget* canvas() const;
  /// Place of a point in the canvas, in its (logical) pixels.
  QPointF to_canvas(const Vector3& point) const;
  /// The vertex that a click there picks, or −1.
  Index vertex_at(const QPointF& place) const;

 signals:
  void picked(tetraction::Index vertex, bool add);
  void banded(std::vector<tetraction::Index> vertices, bool add);
  /// The light is pulled, degrees to the right and up.
  void light_pulled(double azimuth, double elevation);
  /// A vertex is taken hold of, led to a place (m), let go.
  void grabbed(tetraction::Index vertex);
  void dragged(tetraction::Vector3 place);
  void released();
  /// An arrow that is being pulled, and one that was let go, with the tools for force and momentum; m.
  void arrow_moved(tetraction::viewer::Tool tool, tetraction::Vector3 arrow);
  void arrow_pulled(tetraction::viewer::Tool tool, tetraction::Index vertex,
                    tetraction::Vector3 arrow);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  struct Ray {
    Vector3 origin, direction;
  };
  Ray ray_at(const QPointF& place) const;
  /// Where the ray meets the plane through `anchor` that faces the camera.
  Vector3 in_view_plane(const QPointF& place, const Vector3& anchor) const;
  void look_for_graphics_card();
  bool press(const QPointF& place, Qt::KeyboardModifiers modifiers);
  bool move(const QPointF& place);
  bool release(const QPointF& place, Qt::KeyboardModifiers modifiers);
  std::vector<Index> vertices_in(const QRect& band) const;

  enum class Gesture { kNone, kCamera, kBand, kDrag, kArrow, kLight };

  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  QVTKOpenGLNativeWidget* widget_;  // draws what is in window_
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkAxesActor> marker_axes_;
  vtkNew<vtkOrientationMarkerWidget> marker_;
  std::unique_ptr<BodyScene> scene_;
  DrawingSettings drawing_;
  std::shared_ptr<const Snapshot> snapshot_;
  std::uint64_t pictures_ = 0;
  bool started_ = false;
  Tool tool_ = Tool::kLook;
  Gesture gesture_ = Gesture::kNone;
  QPointF pressed_;
  Index held_ = -1;
  Vector3 anchor_ = Vector3::Zero();  // of the gesture, on the body
  QRubberBand* band_;
};

}  // namespace tetraction::viewer
