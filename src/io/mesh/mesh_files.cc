#include "mesh_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {

std::string mesh_ending(const std::string& path, const char* done) {
  constexpr std::array kEndings{".vtu", ".vtk", ".msh", ".node", ".ele", ".veg"};
  const std::string found = std::filesystem::path(path).extension().string();
  std::string ending = found;
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end()) {
    throw InputError(fmt::format(
        "{}: {} Meshes in .vtu .vtk .msh .node .ele .veg are {}.", in_quotes(path),
        found.empty()       ? "a mesh file needs an ending that tells its format."
        : ending == ".pvtu" ? "it names the pieces of a run in several processes, which "
                              "ParaView opens and this program cannot join yet."
                            : "the ending " + in_quotes(found) + " is not that of a mesh.",
        done));
  }
  return ending;
}

}  // namespace tetraction
