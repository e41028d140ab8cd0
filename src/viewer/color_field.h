// What colours the body.
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

}  // namespace tetraction::viewer
