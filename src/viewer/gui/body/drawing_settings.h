// The settings of the drawing of the body.
#pragma once

#include "viewer/snapshot.h"

namespace tetraction::viewer {

enum class Background { kLight, kWhite, kDark };

struct DrawingSettings {
  bool surface = true, edges = true, points = false;
  ColorField field = find_quantity("von_mises");
  bool automatic_range = true;   ///< whether the colour range follows the data
  double range[2] = {0.0, 1.0};  ///< colour range if it is not automatic, in the field's unit
  bool forces = true, momenta = false, reactions = false;
  double arrow_scale = 1.0;  ///< factor of the usual length of arrows
  bool fixed = true, rest = false, axes = false, center = true;
  bool clip = false;
  int clip_axis = 0;  ///< 0, 1, 2: x, y, z
  bool clip_flipped = false;
  double clip_at = 0.5;  ///< position of the clip plane in the bounding box at rest, 0 … 1
  double light_azimuth = -30.0;   ///< degrees to the right of the camera
  double light_elevation = 35.0;  ///< degrees above the camera
  Background background = Background::kLight;
};

}  // namespace tetraction::viewer
