// Obstacles in the picture of a body.
#pragma once

#include <vtkNew.h>

#include <memory>

#include "tetraction/io/obstacle_surface.h"

class vtkActor;
class vtkPolyData;
class vtkRenderer;

namespace tetraction::viewer {

/// Draws the surfaces of obstacles translucent, with a grid on them. What is seen from its other side, such as the
/// walls of a room between the camera and the body, is drawn as a grid only.
///
/// The camera does not count obstacles as something to show: they may be much larger than the body. The clipping range of
/// the camera is widened for those that are not too far away.
class DrawnObstacles {
 public:
  explicit DrawnObstacles(vtkRenderer* renderer);
  ~DrawnObstacles();

  /// Null: there are none.
  void set(std::shared_ptr<const ObstacleSurface> surface);
  void set_visible(bool visible);
  /// The colours for a dark or a light background.
  void set_dark(bool dark);
  void set_pixel_ratio(double ratio);

 private:
  void update_visibility();
  void widen_clipping_range();

  vtkRenderer* renderer_;
  unsigned long observer_ = 0;
  std::shared_ptr<const ObstacleSurface> surface_;
  bool visible_ = true;
  vtkNew<vtkPolyData> polygons_, lines_;
  vtkNew<vtkActor> faces_, grid_;
};

}  // namespace tetraction::viewer
