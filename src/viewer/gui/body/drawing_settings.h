// The settings of the drawing of the body.
#pragma once

#include "viewer/snapshot.h"

namespace tetraction::viewer {

enum class Background { kAsWindow, kLight, kWhite, kDark };
enum class ColorMap { kViridis, kCividis, kCoolToWarm, kGray };
enum class Antialiasing { kWithGraphicsCard, kOff, kOn };

struct DrawingSettings {
  bool surface = true, edges = true, points = false;
  bool smooth = false;   ///< whether the surface is shaded as a curved one
  double opacity = 1.0;  ///< of the surface
  ColorField field = find_quantity("von_mises");
  ColorMap map = ColorMap::kViridis;
  bool averaged = false;         ///< whether values of tetrahedra are averaged at the vertices
  bool shaded = true;            ///< whether the light changes the brightness of the colours
  bool extremes = false;         ///< whether the least and the largest value are marked
  bool automatic_range = true;   ///< whether the colour range follows the data
  double range[2] = {0.0, 1.0};  ///< colour range if it is not automatic, in the field's unit
  double displacement_scale = 1.0;
  bool forces = true, momenta = false, reactions = false, contacts = false;
  double arrow_scale = 1.0;  ///< factor of the usual length of arrows
  bool fixed = true, rest = false, ghost = false, axes = false, center = true, cube = true,
       obstacles = true;
  bool clip = false;
  int clip_axis = 0;  ///< 0, 1, 2: x, y, z
  bool clip_flipped = false;
  double clip_at = 0.5;  ///< position of the clip plane in the bounding box at rest, 0 … 1
  double light_azimuth = -30.0;   ///< degrees to the right of the camera
  double light_elevation = 35.0;  ///< degrees above the camera
  Background background = Background::kAsWindow;
  Antialiasing antialiasing = Antialiasing::kWithGraphicsCard;
  double face_angle = 20.0;  ///< degrees between neighbouring triangles that are selected together
};

}  // namespace tetraction::viewer
