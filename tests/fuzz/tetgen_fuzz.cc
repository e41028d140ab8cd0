// The three files of TetGen, with lines of one % between them.
#include <algorithm>

#include "fuzz_target.h"
#include "tetraction/io/mesh_reader.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetraction;
  std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto next_file = [&text] {
    constexpr std::string_view kBetween = "\n%\n";
    const std::string_view file = text.substr(0, text.find(kBetween));
    text.remove_prefix(std::min(text.size(), file.size() + kBetween.size()));
    return file;
  };
  const std::string path = fuzzing::written("mesh.node", next_file());
  fuzzing::written("mesh.ele", next_file());
  std::filesystem::remove(fuzzing::scratch("mesh.face"));
  if (!text.empty()) fuzzing::written("mesh.face", next_file());
  fuzzing::accepted([&] { fuzzing::check_mesh(read_mesh(path)); });
  return 0;
}
