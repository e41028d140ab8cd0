// Writes text files either completely or not at all.
#pragma once

#include <string>

namespace tetraction {

/// Writes `text` to a temporary file beside `path` and renames it into place.
/// Throws OutputError, naming the path and the system's reason.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace tetraction
