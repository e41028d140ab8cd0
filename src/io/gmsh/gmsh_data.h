// Arrays of a Gmsh file: $ElementData and $NodeData.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gmsh_numbers.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/types.h"

namespace tetraction {

struct GmshData {
  std::string name;
  std::vector<std::int64_t> tags;  ///< of elements or nodes, each once
  Matrix values;                   ///< components × tags
};

/// Reads the body of $ElementData or $NodeData. `item` is "element" or "node", for messages. Throws
/// FileError, also if an item has two rows.
GmshData read_gmsh_data(TextScanner& in, GmshNumbers& numbers, const char* item);

/// The text between the first and the last quotation mark of a line. Throws FileError with `missing` if it
/// has no two.
std::string quoted_text(const TextScanner& in, std::string_view line, const char* missing);

}  // namespace tetraction
