// Pieces of the text formats of meshes.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "tetraction/core/types.h"

namespace tetraction {

/// The name of the material of Vega files that the writer makes; the reader does not look at it.
inline constexpr const char* kPlaceholderMaterial = "placeholder";

/// "x y z" with all digits.
inline std::string coordinates(const Vector3& x) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", x.x(), x.y(), x.z());
}

template <class... Args>
void append(std::string& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

}  // namespace tetraction
