// Common code of the fuzz targets: an input becomes a file, and a reader either accepts it or refuses it
// with a good message. Everything else ends the program.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/tet_mesh.h"

/// The function that libFuzzer calls.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tetraction::fuzzing {

[[noreturn]] inline void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

/// The path of a file of this process.
inline std::string scratch(const std::string& name) {
  static const testing_support::TemporaryFolder folder;
  return (folder.path() / name).string();
}

/// Writes a file of this process and returns its path.
inline std::string written(const std::string& name, std::string_view text) {
  const std::string path = scratch(name);
  // A new file. Some file systems write a file that is overwritten to the disk at once, which takes
  // milliseconds.
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// A message is short and has no control characters but line breaks.
inline void check_message(const std::string& message) {
  if (message.empty() || message.size() > 8000) {
    fail("a message of " + std::to_string(message.size()) + " bytes");
  }
  for (const char c : message) {
    if (c != '\n' && (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)) {
      fail("a control character in the message " + message);
    }
  }
}

/// Calls read(), which may throw the errors of a wrong file. True if it threw none.
template <class Read>
bool accepted(const Read& read) {
  try {
    read();
    return true;
  } catch (const FileError& error) {
    check_message(error.what());
  } catch (const InputError& error) {
    check_message(error.what());
  }
  return false;
}

/// The guarantees of build_mesh().
inline void check_mesh(const TetMesh& mesh) {
  if (mesh.tetrahedron_count() == 0) fail("a mesh without tetrahedra");
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      if (v < 0 || v >= mesh.vertex_count()) fail("a vertex that does not exist");
    }
    if (!(mesh.volume(e) > 0.0)) fail("a volume that is not positive");
  }
  for (const Group& group : mesh.groups) {
    for (const Index v : group.vertices) {
      if (v < 0 || v >= mesh.vertex_count()) fail("a group of vertices that do not exist");
    }
  }
}

}  // namespace tetraction::fuzzing
