// The body as VTK objects. All objects share one set of points, which follow the state.
#pragma once

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <QPointF>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "body_arrows.h"
#include "body_shape.h"
#include "color_bar.h"
#include "drawing_settings.h"
#include "drawn_obstacles.h"
#include "viewer/snapshot.h"

class vtkActor;
class vtkAxesActor;
class vtkCutter;
class vtkFloatArray;
class vtkLight;
class vtkLineSource;
class vtkPlane;
class vtkPoints;
class vtkPolyData;
class vtkPolyDataMapper;
class vtkRenderer;
class vtkSphereSource;
class vtkTextActor;
class vtkUnstructuredGrid;

namespace tetraction::viewer {

/// The usual direction from which the body is seen.
inline const Vector3 kOblique{0.45, 0.4, 1.0};

/// Draws a body and its state in a VTK renderer. It is independent of Qt. Not thread-safe.
class BodyScene {
 public:
  /// The colour bar is drawn by a renderer of its own.
  BodyScene(vtkRenderer* renderer, vtkRenderer* gutter);
  ~BodyScene();

  /// Sets another body: all objects are made anew, and the camera shows the whole body.
  void set_body(std::shared_ptr<const BodyShape> shape);
  /// Moves the points to the state and colours them.
  void set_state(std::shared_ptr<const Snapshot> snapshot);
  void set_drawing(const DrawingSettings& drawing);
  /// Sets the screen pixels per logical pixel, so that points and lines keep their visible size.
  void set_pixel_ratio(double ratio);
  /// Lets the edges fade, and leaves them out at last, where they are so near to each other that they
  /// would hide the colours. `height` of the picture in logical pixels.
  void fade_edges(double height);
  /// Whether the machine has a graphics card. Without one the background has one colour and edges are
  /// not smoothed, which doubles the pictures per second.
  void set_graphics_card(bool present);
  /// Keeps the shape of this moment as the ghost.
  void keep_ghost();
  void set_selection(const std::vector<Index>& vertices);
  /// Draws the arrow that the user is pulling. An arrow of length zero is not drawn.
  void set_pulled_arrow(const Vector3& from, const Vector3& to);
  /// Draws a line from a vertex that is dragged to the mouse. A line of length zero is not drawn.
  void set_drag_line(const Vector3& from, const Vector3& to);
  /// Whether there is an attraction to the origin, so that its centre is drawn.
  void set_attraction(bool present);
  /// Shows the whole body at its present position, as seen from this direction.
  void reset_camera(const Vector3& from);
  /// Whether the picture is without perspective. The body keeps its size.
  void set_parallel(bool parallel);
  /// Shows the whole body, or some of its vertices, from the present direction.
  void fit();
  void fit(const std::vector<Index>& vertices);
  /// Moves the camera as the middle of the body moves between two positions.
  void move_camera(const Vector& from, const Vector& to);
  /// The box around the body at its present position, m.
  std::pair<Vector3, Vector3> bounds() const;
  /// The direction to the body in the picture: to the right and down.
  QPointF direction_to_body() const;

  /// The vertices of the surface triangles.
  const std::vector<std::array<Index, 3>>& triangles() const { return shape_->triangles; }
  /// The value of the colour at a point of a triangle. NaN if the body has one colour.
  double value_at(std::size_t triangle, const Vector3& point) const;
  /// Whether a point is on the side of the clip plane that is drawn.
  bool is_drawn(const Vector3& point) const;
  ColorBar& color_bar() { return color_bar_; }

 private:
  double size() const { return (shape_->high - shape_->low).norm(); }  // diagonal at rest, m
  void update_clip();
  Vector outward_normals(const Vector& x) const;
  void update_arrows();
  void color(const Snapshot& snapshot);
  std::vector<float> averages(const std::vector<float>& values) const;
  void mark_extremes(const std::vector<float>& values, bool on_cells);

  vtkRenderer* renderer_;
  vtkRenderer* gutter_;
  DrawingSettings drawing_;
  std::shared_ptr<const BodyShape> shape_ = std::make_shared<BodyShape>();
  std::shared_ptr<const Snapshot> last_;
  bool attraction_ = false;
  bool gradient_ = true;                          // a graphics card is there
  bool colored_ = false, colored_cells_ = false;  // what the mappers draw
  double pixel_ratio_ = 0.0;
  int regions_ = 1;
  double text_gray_ = 0.0;
  double edge_gray_ = 0.25;
  std::vector<Index> selection_;

  vtkNew<vtkPoints> points_;
  void show_box(const Vector3& low, const Vector3& high);

  vtkNew<vtkPolyData> surface_, edges_, cloud_, fixed_, selected_, area_, rest_, ghost_;
  vtkNew<vtkUnstructuredGrid> grid_;
  vtkNew<vtkFloatArray> point_values_, triangle_values_, cell_values_, normals_;
  vtkNew<vtkPolyDataMapper> surface_mapper_, edge_mapper_, cloud_mapper_, fixed_mapper_,
      selected_mapper_, area_mapper_, section_mapper_;
  vtkNew<vtkActor> surface_actor_, edge_actor_, cloud_actor_, fixed_actor_, selected_actor_,
      area_actor_, rest_actor_, ghost_actor_, section_actor_, center_actor_, pulled_actor_,
      drag_actor_;
  vtkNew<vtkLineSource> drag_line_;
  vtkNew<vtkPlane> clip_plane_;
  vtkNew<vtkCutter> section_;
  vtkNew<vtkAxesActor> axes_;
  vtkNew<vtkSphereSource> center_;
  vtkNew<vtkLight> light_;
  vtkNew<vtkTextActor> arrow_legend_;
  std::array<vtkNew<vtkTextActor>, 2> extremes_;  // the marks of the least and the largest value
  std::chrono::steady_clock::time_point texts_changed_;
  bool texts_due_ = true;
  BodyArrows forces_, momenta_, reactions_, contacts_;
  DrawnObstacles obstacles_;
  ColorBar color_bar_;
};

}  // namespace tetraction::viewer
