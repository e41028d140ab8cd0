// Arrows at vertices for one kind of vector: forces, momenta, reactions.
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

/// Draws the vectors of some vertices. All are of one scale, so that lengths can be compared.
class BodyArrows {
 public:
  BodyArrows(vtkRenderer* renderer, std::string name, std::string unit, const double* color);
  ~BodyArrows();

  void set_visible(bool visible);
  bool visible() const { return visible_; }
  /// `field`: 3 per vertex; the longest arrow gets `longest` (m). With more than some hundred vectors
  /// only those of the surface are drawn, and of these every k-th; none where `is_drawn` says no.
  void update(const Vector& position, const Vector& field, const std::vector<Index>& surface,
              double longest, const std::function<bool(const Vector3&)>& is_drawn);
  /// "force: longest arrow 3.2 N", or empty when there is nothing to see.
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
