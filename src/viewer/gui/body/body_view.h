// The 3-D view of the body with its mouse actions.
#pragma once

#include <vtkNew.h>

#include <QImage>
#include <QWidget>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "body_scene.h"
#include "drawing_settings.h"
#include "view_cube.h"

class QLabel;
class QRubberBand;
class QToolButton;
class vtkGenericOpenGLRenderWindow;
class vtkRenderer;

namespace tetraction::viewer {

class VtkWidget;

/// The effect of dragging with the left mouse button. A click always picks a vertex.
enum class Tool { kLook, kSelect, kMove, kForce, kMomentum };

class BodyView : public QWidget {
  Q_OBJECT

 public:
  explicit BodyView(QWidget* parent = nullptr);
  ~BodyView() override;

  void set_body(std::shared_ptr<const BodyShape> shape);
  void show_state(std::shared_ptr<const Snapshot> snapshot);
  void set_drawing(const DrawingSettings& drawing);
  /// The state that is shown. Null before the first show_state().
  const std::shared_ptr<const Snapshot>& state() const { return snapshot_; }
  const DrawingSettings& drawing() const { return drawing_; }
  void set_selection(const std::vector<Index>& vertices);
  void set_attraction(bool present);
  void set_tool(Tool tool);
  Tool tool() const { return tool_; }
  /// Shows the whole body, as seen from this direction.
  void look_from(const Vector3& direction);
  /// Whether the picture is without perspective.
  void set_parallel(bool on);
  /// Keeps the shape of this moment as the ghost (DrawingSettings::ghost).
  void keep_ghost();
  /// Whether pictures are recorded. They are without the cube.
  void set_recording(bool on);
  /// Shows the whole body from the present direction.
  void fit();
  /// The same if no part of the body is in the picture.
  void fit_if_outside();
  /// Whether the camera moves with the middle of the body.
  void set_follow(bool on);
  /// Shows a tetrahedron from near, from the present direction, and selects its vertices.
  void show_element(const TetMesh& mesh, Index element);
  /// Where the camera is and looks.
  using Camera = std::array<double, 11>;
  Camera camera() const;
  void set_camera(const Camera& camera);
  /// Whether the next pictures have the colour bar.
  void set_color_bar(bool on);
  /// Widens an automatic range of the colours for these values, too. False if there is no range yet.
  bool follow_colors(const std::vector<float>& values, const std::function<bool()>& is_strained);
  /// The arrow at the edge of the picture that points to a body outside it.
  QToolButton* edge_mark() const { return edge_mark_; }
  /// Fits the automatic colour range to the state that is shown.
  void refit_colors();
  double color_low() { return scene_->color_bar().low(); }
  double color_high() { return scene_->color_bar().high(); }

  void render();
  /// Number of pictures that have been drawn.
  std::uint64_t picture_count() const { return pictures_; }
  /// The present picture.
  QImage picture() const;
  /// The same in so many pixels that it can fill this size.
  QImage picture(const QSize& size);
  /// The widget that receives the mouse events.
  QWidget* canvas() const;
  /// Coordinates of a point in the canvas, in logical pixels.
  QPointF to_canvas(const Vector3& point) const;
  /// The vertex that a click at these coordinates picks, or −1.
  Index vertex_at(const QPointF& place) const;

 signals:
  void picked(tetraction::Index vertex, bool add);
  /// The right button was clicked: on this vertex, or on none (−1), at this point of the screen.
  void menu_wanted(tetraction::Index vertex, const QPoint& place);
  void band_selected(std::vector<tetraction::Index> vertices, bool add);
  /// The user turns the light by these angles, degrees to the right and up.
  void light_turned(double azimuth, double elevation);
  /// The user or a command has moved the camera, and the picture is drawn.
  void camera_moved();
  /// The user begins to drag a vertex, drags it to a position (m), and releases it.
  /// `exact`: the vertices shall be where the mouse is, whatever the body does.
  void grabbed(tetraction::Index vertex, bool exact);
  /// The user turns the wheel during a drag: the area of influence grows by this factor.
  void area_scaled(double factor);
  /// The same for a point (m) of an obstacle.
  void obstacle_grabbed(std::size_t number, tetraction::Vector3 point);
  void dragged(tetraction::Vector3 position);
  void released();
  /// The user pulls an arrow (m) with the tool for force or momentum, and releases it.
  void arrow_moved(tetraction::viewer::Tool tool, tetraction::Vector3 arrow);
  void arrow_pulled(tetraction::viewer::Tool tool, tetraction::Index vertex,
                    tetraction::Vector3 arrow);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  struct Ray {
    Vector3 origin, direction;
  };
  struct Hit {
    std::size_t triangle;
    Vector3 point;
  };
  Ray ray_at(const QPointF& place) const;
  /// The intersection of the ray with the plane through `anchor` that faces the camera.
  Vector3 in_view_plane(const QPointF& place, const Vector3& anchor) const;
  void detect_graphics_card();
  bool press(const QPointF& place, Qt::KeyboardModifiers modifiers);
  bool move(const QPointF& place);
  bool is_click(const QPointF& place) const;
  bool release(const QPointF& place, Qt::KeyboardModifiers modifiers);
  std::optional<Hit> hit_at(const QPointF& place) const;
  bool grab_obstacle(const QPointF& place);
  std::vector<Index> vertices_in(const QRect& band, bool through);
  std::shared_ptr<const Snapshot> scaled(const std::shared_ptr<const Snapshot>& snapshot);
  Vector3 true_position(Index vertex, const Vector3& drawn) const;
  void place_cube();
  void show_value();
  void draw_drag();
  bool is_outside() const;
  void show_edge_mark();

  enum class Gesture { kNone, kCamera, kBand, kDrag, kObstacle, kArrow, kLight };

  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  VtkWidget* widget_;  // shows window_
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderer> gutter_;  // of the colour bar, right of the body
  ViewCube cube_;
  std::unique_ptr<BodyScene> scene_;
  DrawingSettings drawing_;
  std::shared_ptr<const BodyShape> shape_;
  std::shared_ptr<const Snapshot> snapshot_, drawn_;  // drawn_ has scaled displacements
  std::uint64_t pictures_ = 0;
  bool started_ = false;
  Tool tool_ = Tool::kLook;
  Gesture gesture_ = Gesture::kNone;
  QPointF pressed_;
  Index pressed_vertex_ = -1;
  Vector3 anchor_ = Vector3::Zero();  // position of pressed_vertex_
  Vector3 drag_goal_ = Vector3::Zero();
  bool drag_is_exact_ = false;
  bool follow_ = false;
  bool recording_ = false;
  bool has_color_bar_ = true;
  Camera drawn_camera_{};
  QPointF hovered_{-1.0, -1.0};  // where the mouse is, without a pressed button
  QRubberBand* band_;
  QLabel* value_;
  QToolButton* edge_mark_;
};

}  // namespace tetraction::viewer
