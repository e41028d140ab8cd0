#include "tetraction/io/mesh_reader.h"

#include <filesystem>

#include "io/gmsh/gmsh_reader.h"
#include "io/vtk/vtk_reader.h"
#include "mesh_files.h"
#include "plain_readers.h"
#include "tetraction/core/error.h"

namespace tetraction {

RawMesh read_raw_mesh(const std::string& path) {
  std::vector<std::string> unused;
  return read_raw_mesh(path, unused);
}

RawMesh read_raw_mesh(const std::string& path, std::vector<std::string>& unused) {
  const std::string extension = mesh_ending(path, "read");
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw FileError(error ? path + ": cannot be read (" + error.message() + ")."
                          : path + ": no such file.");
  }
  if (extension == ".msh") return read_gmsh(path, unused);
  if (extension == ".veg") return read_vega(path, unused);
  if (extension == ".node" || extension == ".ele") return read_tetgen(path, unused);
  return read_vtk_mesh(path, unused);
}

TetMesh read_mesh(const std::string& path, double scale) {
  return build_mesh(read_raw_mesh(path), scale);
}

TetMesh read_mesh(const std::string& path, double scale, std::vector<std::string>& unused) {
  return build_mesh(read_raw_mesh(path, unused), scale);
}

}  // namespace tetraction
