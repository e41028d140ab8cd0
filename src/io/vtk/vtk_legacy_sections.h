// Checks the order of sections of a legacy VTK file, which VTK's reader does not.
#pragma once

#include <string>
#include <string_view>

namespace tetraction {

/// Goes through the sections of a legacy file, in text or in binary. `body` begins with the third line,
/// which is ASCII or BINARY. Throws FileError if the points, the cells, their types or an array of the same
/// name are given twice, of which VTK takes the last ones, and for a type of a cell beyond 255, of
/// which VTK takes the lowest 8 bits. Stops without an error at anything that it does not know.
void check_legacy_sections(const std::string& path, std::string_view text, std::string_view body);

}  // namespace tetraction
