// What counts as a touch between bodies.
#pragma once

namespace tetraction {

/// Gaps between bodies, and depths, below this share of the thickness of the layer are a touch, which no state may begin
/// with.
inline constexpr double kTouchShare = 1e-4;

}  // namespace tetraction
