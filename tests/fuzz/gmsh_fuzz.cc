// Gmsh files of all versions.
#include "fuzz_target.h"
#include "tetraction/io/mesh_reader.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetraction;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzzing::written("mesh.msh", text);
  fuzzing::accepted([&] { fuzzing::check_mesh(read_mesh(path)); });
  return 0;
}
