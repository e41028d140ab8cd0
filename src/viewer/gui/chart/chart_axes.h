// What the sources of the chart share.
#pragma once

#include <vtkDoubleArray.h>
#include <vtkTable.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetraction::viewer {

inline constexpr double kLargest = 1e30;  // VTK plots in single precision
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

inline vtkDoubleArray* column(vtkTable* table, int i) {
  return vtkDoubleArray::SafeDownCast(table->GetColumn(i));
}

// Whether an axis from `low` to `high` can have ticks. If neighbouring ticks would be the same
// number, VTK would search for them forever.
inline bool is_drawable(double low, double high) {
  const double range = high - low;
  return range > std::max(1e-30, 1e-6 * std::max(std::abs(low), std::abs(high))) &&
         range < kLargest;
}

}  // namespace tetraction::viewer
