// Check sums of what is written to files.
#pragma once

#include <cstdint>
#include <string_view>

namespace tetraction {

/// The CRC-32 of `bytes` (IEEE 802.3, as of zlib and PNG). For bytes that come in parts, `before` is that of the
/// parts before these.
std::uint32_t check_sum(std::string_view bytes, std::uint32_t before = 0);

}  // namespace tetraction
