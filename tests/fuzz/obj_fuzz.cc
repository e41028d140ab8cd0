// Wavefront files.
#include "surface_fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  tetraction::fuzzing::check_surface("surface.obj", text);
  return 0;
}
