#include "tetraction/io/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "gmsh_reader.h"
#include "plain_readers.h"
#include "tetraction/core/error.h"
#include "vtk_reader.h"

namespace tetraction {

RawMesh read_raw_mesh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool known = extension == ".vtu" || extension == ".vtk" || extension == ".msh" ||
                     extension == ".node" || extension == ".ele" || extension == ".veg";
  if (!known) {
    throw FileError(
        fmt::format("{}: the ending \"{}\" is not that of a mesh; .vtu .vtk .msh .node "
                    ".ele .veg are read.",
                    path, extension));
  }
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw FileError(path +
                    ": no such file. Check mesh.file; it is relative to the scene's folder.");
  }
  if (extension == ".msh") return read_gmsh(path);
  if (extension == ".veg") return read_vega(path);
  if (extension == ".node" || extension == ".ele") return read_tetgen(path);
  return read_vtk_mesh(path);
}

TetMesh read_mesh(const std::string& path, double scale) {
  return build_mesh(read_raw_mesh(path), scale);
}

}  // namespace tetraction
