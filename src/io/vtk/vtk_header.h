// Checks the plain text at the head of a VTK file before VTK's readers read the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tetraction {

/// The counts that the file's text states, and whether it announces this program's own arrays.
struct VtkHeader {
  std::int64_t points = 0;
  std::int64_t cells = 0;
  bool own_arrays = false;
};

/// Title of the legacy files written here. It names the arrays that must follow, so that a file cut
/// between two of its sections is told from a whole one without them.
inline constexpr const char* kOwnLegacyTitle = "Tetraction mesh: vertex_id, element_id, region";

/// Counts of a VTU file, summed over its pieces. Throws FileError for another data set, a missing
/// end, and counts that are negative or larger than the file could hold.
VtkHeader check_xml_header(const std::string& path, std::string_view text);

/// The same for a legacy .vtk file.
VtkHeader check_legacy_header(const std::string& path, std::string_view text);

}  // namespace tetraction
