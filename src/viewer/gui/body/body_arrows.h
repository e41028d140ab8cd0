// Arrows at vertices that show a vector field, such as forces.
#pragma once

#include <vtkNew.h>

#include <functional>
#include <string>
#include <vector>

#include "tetraction/core/types.h"

class vtkActor;
class vtkFloatArray;
class vtkGlyph3DMapper;
class vtkPoints;
class vtkPolyData;
class vtkRenderer;

namespace tetraction::viewer {

/// Draws the vectors of a field at some vertices. All arrows have the same scale.
class BodyArrows {
 public:
  BodyArrows(vtkRenderer* renderer, std::string name, std::string unit, const double* color);
  ~BodyArrows();

  void set_visible(bool visible);
  bool visible() const { return visible_; }
  /// Draws `field` (3 per vertex) at `position`. The longest arrow gets the length `longest` (m). If
  /// there are more than some hundred vectors, only every k-th vertex of the surface gets an arrow.
  /// Points for which `is_drawn` returns false get none. If there are `normals` (3 per vertex, zero
  /// inside the body), an arrow that points into the body ends at its vertex, so that it is outside.
  void update(const Vector& position, const Vector& field, const std::vector<Index>& surface,
              double longest, const std::function<bool(const Vector3&)>& is_drawn,
              const Vector& normals = {});
  /// A text such as "force: longest arrow 3.2 N". Empty if no arrow is drawn.
  std::string legend() const;
  const double* color() const { return color_; }

 private:
  std::string name_, unit_;
  double color_[3];
  bool visible_ = false;
  double largest_ = 0.0;
  vtkNew<vtkPoints> points_;
  vtkNew<vtkFloatArray> vectors_;
  vtkNew<vtkPolyData> data_;
  vtkNew<vtkGlyph3DMapper> mapper_;
  vtkNew<vtkActor> actor_;
};

}  // namespace tetraction::viewer
