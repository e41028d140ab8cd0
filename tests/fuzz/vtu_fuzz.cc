// VTU files as meshes and as frames of a run.
#include "fuzz_target.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/mesh_reader.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetraction;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzzing::written("mesh.vtu", text);
  const bool is_mesh = fuzzing::accepted([&] { fuzzing::check_mesh(read_mesh(path)); });
  if (!is_mesh) return 0;
  fuzzing::accepted([&] { read_frame(path, {"displacement", "velocity"}, {"von_mises"}); });
  return 0;
}
