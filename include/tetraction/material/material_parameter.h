// The description of a material's parameters, which scenes, messages, documents and the window use.
#pragma once

#include "tetraction/core/number_range.h"

namespace tetraction {

/// Linear tetrahedra lock from this Poisson's ratio on: the body is too stiff.
inline constexpr double kLockingRatio = 0.45;

/// A parameter of a material, under its name in scenes.
struct MaterialParameter {
  const char* name;
  const char* unit;   ///< empty: none
  NumberRange range;  ///< of the parameter alone; the material checks what several must satisfy
  const char* help;
};

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
     .advice = "; take 0.44 for rubber-like materials, since linear tetrahedra are too stiff from "
               "0.45 on"},
    "Poisson's ratio ν"};

}  // namespace tetraction
