#include "tetraction/io/io_library_versions.h"

#include <fmt/format.h>
#include <muParser.h>
#include <toml++/toml.h>
#include <vtkVersion.h>
#include <zlib.h>
#include <nlohmann/json.hpp>
#include <string>

namespace tetraction {

std::vector<LibraryVersion> io_library_versions() {
  const std::string mu_parser = mu::Parser().GetVersion(mu::pviBRIEF);  // "2.3.3 (Release)"
  return {
      {"VTK", vtkVersion::GetVTKVersion()},
      {"toml++", fmt::format("{}.{}.{}", TOML_LIB_MAJOR, TOML_LIB_MINOR, TOML_LIB_PATCH)},
      {"nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                    NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
      {"muParser", mu_parser.substr(0, mu_parser.find(' '))},
      {"zlib", zlibVersion()},
  };
}

}  // namespace tetraction
