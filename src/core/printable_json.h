// JSON for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace tetraction {

/// JSON text with the characters that printable() (quoting.h) replaces as \uNNNN, so that it stays the same JSON.
std::string printable_json(std::string_view text);

}  // namespace tetraction
