#include "check_sum.h"

#include <zlib.h>

namespace tetraction {

std::uint32_t check_sum(std::string_view bytes, std::uint32_t before) {
  // Without any bytes zlib would begin anew.
  if (bytes.empty()) return before;
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace tetraction
