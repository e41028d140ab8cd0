#include "tetraction/io/mesh_reader.h"

#include <filesystem>

#include "io/gmsh/gmsh_reader.h"
#include "io/vtk/vtk_reader.h"
#include "mesh_files.h"
#include "plain_readers.h"
#include "tetraction/core/error.h"

namespace tetraction {

RawMesh read_raw_mesh(const std::string& path) {
  const std::string extension = mesh_ending(path, "read");
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw FileError(error ? path + ": cannot be read (" + error.message() + ")."
                          : path + ": no such file.");
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
