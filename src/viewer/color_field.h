// What colours the body, and how its numbers are written.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tetraction/simulation/quantities.h"

namespace tetraction::viewer {

/// A quantity out of color_quantities(), and the component that is drawn; −1 for a scalar or for the length of
/// a vector. Without a quantity the body has one colour.
struct ColorField {
  const Quantity* quantity = nullptr;
  int component = -1;

  ColorField() = default;
  ColorField(const Quantity* of, int which = -1)  // NOLINT(google-explicit-constructor)
      : quantity(of), component(which) {}
  friend bool operator==(const ColorField&, const ColorField&) = default;
  const Quantity* operator->() const { return quantity; }
  const Quantity& operator*() const { return *quantity; }

  /// Such as "Speed" and "Velocity x". Empty for one colour.
  std::string title() const;
  /// Such as "velocity_x", for settings that are stored.
  std::string key() const;
  /// The middle of the range of colours. Without it the range begins at zero.
  std::optional<double> middle() const;
};

/// All of them in the order of the lists: one colour, then each quantity with its components.
const std::vector<ColorField>& color_fields();

/// The values that are drawn, out of components × places.
std::vector<float> color_values(const Matrix& values, int component);

/// A power of a thousand, with which numbers are written with few digits: 1e6 and "MPa".
struct PrefixedUnit {
  double factor = 1.0;
  std::string unit;
};

/// For numbers up to `size`. Units that begin with "kg", and pure numbers, have no prefix.
PrefixedUnit prefixed_unit(double size, const std::string& unit);
/// Such as "1.2 MPa".
std::string with_prefix(double value, const std::string& unit);

}  // namespace tetraction::viewer
