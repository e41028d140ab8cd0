// What the user wants to see of the body.
#pragma once

#include "viewer/snapshot.h"

namespace tetraction::viewer {

enum class Background { kLight, kWhite, kDark };

struct DrawingSettings {
  bool surface = true, edges = true, points = false;
  ColorField field = ColorField::kVonMises;
  bool automatic_range = true;   ///< of the colours: follows the data
  double range[2] = {0.0, 1.0};  ///< otherwise this, in the field's unit
  bool forces = true, momenta = false, reactions = false;
  double arrow_scale = 1.0;  ///< of the arrows' usual length
  bool fixed = true, rest = false, axes = false, center = true;
  bool clip = false;
  int clip_axis = 0;  ///< 0, 1, 2: x, y, z
  bool clip_flipped = false;
  double clip_at = 0.5;           ///< 0 … 1 through the rest shape's box
  double light_azimuth = -30.0;   ///< degrees to the right of the camera
  double light_elevation = 35.0;  ///< degrees above it
  Background background = Background::kLight;
};

/// "von Mises stress".
const char* field_name(ColorField field);
/// "Pa"; empty for pure numbers.
const char* field_unit(ColorField field);

}  // namespace tetraction::viewer
