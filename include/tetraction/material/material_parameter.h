// What a material says of its parameters: scenes, messages, documents and the window take it from here.
#pragma once

namespace tetraction {

/// A parameter of a material, under its name in scenes.
struct MaterialParameter {
  enum class Range { kAnyValue, kAboveZero, kZeroOrMore, kPoisson };

  const char* name;
  const char* unit;  ///< empty: none
  Range range;       ///< of the parameter alone; the material checks what several must satisfy
  const char* help;
};

/// What every material can be given by, beside parameters of its own.
inline constexpr MaterialParameter kYoungsModulus{
    "youngs_modulus", "Pa", MaterialParameter::Range::kAboveZero, "Young's modulus E"};
inline constexpr MaterialParameter kPoissonsRatio{
    "poissons_ratio", "", MaterialParameter::Range::kPoisson, "Poisson's ratio ν"};

}  // namespace tetraction
