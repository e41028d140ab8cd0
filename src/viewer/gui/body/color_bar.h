// Colours of a field, and the bar that explains them.
#pragma once

#include <vtkNew.h>

#include <vector>

#include "drawing_settings.h"

class vtkLookupTable;
class vtkRenderer;
class vtkScalarBarActor;

namespace tetraction::viewer {

class ColorBar {
 public:
  explicit ColorBar(vtkRenderer* renderer);
  ~ColorBar();

  /// Field, its range and the bar's text colour.
  void set(const DrawingSettings& drawing, int region_count, double text_gray);
  /// Follows the values where the range is automatic.
  void follow(const std::vector<float>& values);
  /// The next values define a new automatic range.
  void forget_range();
  vtkLookupTable* table() const { return table_; }
  double low() const;
  double high() const;

 private:
  void fill(bool categories, int count);

  DrawingSettings drawing_;
  bool known_ = false;  // whether there was a range yet
  double low_ = 0.0, high_ = 1.0;
  double spread_ = 1.0;  // of the automatic range, from its fixed end or middle
  int too_large_ = 0;    // pictures for which it was
  int shown_regions_ = -1;
  vtkNew<vtkLookupTable> table_;
  vtkNew<vtkScalarBarActor> bar_;
};

}  // namespace tetraction::viewer
