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

std::vector<std::string> files_of_mesh(const std::string& path) {
  std::vector<std::string> files{path};
  const std::filesystem::path name(path);
  const std::string ending = name.extension().string();
  const auto add = [&](const char* other) {
    files.push_back(std::filesystem::path(name).replace_extension(other).string());
  };
  if (ending == ".node" || ending == ".ele") {
    for (const char* other : {".node", ".ele", ".face"}) add(other);
  }
  if (ending == ".NODE" || ending == ".ELE") {
    for (const char* other : {".NODE", ".ELE", ".FACE"}) add(other);
  }
  return files;
}

}  // namespace tetraction
