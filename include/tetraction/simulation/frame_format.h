// How the numbers of frames are stored in files.
#pragma once

#include <string>

namespace tetraction {

/// Type of the floating-point numbers of a frame.
enum class FramePrecision { kFloat32, kFloat64 };
/// Method that compresses the arrays of a frame.
enum class FrameCompression { kLz4, kZlib, kNone };

/// "float32", "float64".
std::string to_string(FramePrecision precision);
/// "lz4", "zlib", "none".
std::string to_string(FrameCompression compression);

}  // namespace tetraction
