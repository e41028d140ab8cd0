// How the numbers of frames are stored in files.
#pragma once

#include <array>

#include "tetraction/core/enum_names.h"

namespace tetraction {

/// Type of the floating-point numbers of a frame.
enum class FramePrecision { kFloat32, kFloat64 };
/// Method that compresses the arrays of a frame.
enum class FrameCompression { kLz4, kZlib, kNone };

template <>
struct EnumNames<FramePrecision> {
  static constexpr std::array names{"float32", "float64"};
};
template <>
struct EnumNames<FrameCompression> {
  static constexpr std::array names{"lz4", "zlib", "none"};
};

}  // namespace tetraction
