// The description of a material parameter, which the scene reader, messages, documents and the window
// use.
#pragma once

#include "tetraction/core/number_range.h"

namespace tetraction {

/// Linear tetrahedra lock from this Poisson's ratio on: the body is too stiff.
inline constexpr double kLockingRatio = 0.45;

/// A parameter of a material.
struct MaterialParameter {
  const char* name;  ///< its name in scenes
  const char* unit;  ///< empty if it has none
  NumberRange
      range;  ///< range of this parameter; the material itself checks relations between several
  const char* help;
  int most_entries = 0;  ///< of a list of numbers; 0: the parameter is one number
};

/// The density of the undeformed body, which a scene gives beside the parameters.
inline constexpr MaterialParameter kDensity{"density", "kg/m³", kModeratePositive,
                                            "of the undeformed body"};

/// The two parameters that every material accepts in place of parameters of its own.
inline constexpr MaterialParameter kYoungsModulus{"youngs_modulus", "Pa", kModeratePositive,
                                                  "Young's modulus E"};
inline constexpr MaterialParameter kPoissonsRatio{
    "poissons_ratio",
    "",
    {.least = -1.0,
     .most = 0.5,
     .least_itself = false,
     .most_itself = false,
     .advice =
         "; take 0.49 to 0.4999 with mesh.element = \"quadratic\" or mesh.volume = \"nodal\" for "
         "rubber-like materials"},
    "Poisson's ratio ν"};

}  // namespace tetraction
