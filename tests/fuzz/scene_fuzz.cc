// Scenes. What is accepted can be written and read again.
#include "fuzz_target.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetraction;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzzing::written("scene.toml", text);
  const std::string folder = std::filesystem::path(path).parent_path().string();
  std::string again;
  const bool is_scene = fuzzing::accepted([&] { again = scene_text(read_scene(path), folder); });
  if (!is_scene || again.empty()) return 0;
  const std::string copy = fuzzing::written("again.toml", again);
  if (!fuzzing::accepted([&] { read_scene(copy); })) {
    fuzzing::fail("the scene cannot be read again:\n" + again);
  }
  return 0;
}
