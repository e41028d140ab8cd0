// The colours of a field and their legend.
#pragma once

#include <vtkNew.h>

#include <functional>
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

  /// Sets the field, its range and the colour of the text.
  void set(const DrawingSettings& drawing, int region_count, double text_gray);
  /// Adapts an automatic range to the values. False while they are no more than round-off, so that there is no
  /// range: the body has one colour then, and there is no bar. Those of a body without strains are that, if they follow
  /// from strains.
  bool follow(const std::vector<float>& values, const std::function<bool()>& is_strained);
  /// The next call of follow() defines a new automatic range.
  void forget_range();
  vtkLookupTable* table() const { return table_; }
  double low() const;
  double high() const;

 private:
  void fill(bool categories, int count);
  void show_range();
  bool has_fixed_range() const;

  DrawingSettings drawing_;
  bool known_ = false;  // whether the automatic range is defined
  double low_ = 0.0, high_ = 1.0;
  double spread_ = 1.0;  // width of the automatic range from its fixed end or middle
  int too_large_ = 0;    // number of pictures for which the range was too large
  vtkNew<vtkLookupTable> table_, bar_table_;
  vtkNew<vtkScalarBarActor> bar_;
};

}  // namespace tetraction::viewer
