// The cube in the corner of the picture that shows the axes. A click on a face looks at the body from there.
#pragma once

#include <vtkNew.h>

#include <QPointF>
#include <QSizeF>

#include "tetraction/core/types.h"

class vtkAnnotatedCubeActor;
class vtkCamera;
class vtkRenderer;
class vtkRenderWindow;

namespace tetraction::viewer {

class ViewCube {
 public:
  /// Draws above the other renderers of the window.
  explicit ViewCube(vtkRenderWindow* window);
  ~ViewCube();

  void set_visible(bool visible);
  void set_dark(bool dark);
  /// Turns the cube as the camera sees the body. It lies left of `right` (logical pixels) at the bottom of a
  /// picture of this size.
  void place(vtkCamera* camera, double right, const QSizeF& picture);
  /// The outward normal of the face at a place of the picture. Zero if there is none.
  Vector3 face_at(const QPointF& place) const;

 private:
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkAnnotatedCubeActor> cube_;
  double left_ = 0.0, top_ = 0.0, size_ = 1.0;  // of its square, logical pixels
};

}  // namespace tetraction::viewer
