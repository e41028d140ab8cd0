// Input of the user in messages: short, on one line, and harmless to a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tetraction {

/// Most characters of one piece of input that a message quotes.
inline constexpr std::size_t kMostQuoted = 80;

/// The text with control characters, marks that reverse the direction of writing, and bytes that
/// are not UTF-8 as \xNN, NUL included. Line breaks and tabs stay.
std::string printable(std::string_view text);

/// printable(), in which words of more than 1,000 bytes are cut to their excerpts: for whole messages,
/// which may name a path or an argument.
std::string printable_message(std::string_view text);

/// The first `most` characters of the text on one line: printable(), with \n, \r and \t for line
/// breaks and tabs, and "…" if more follow.
std::string excerpt(std::string_view text, std::size_t most = kMostQuoted);

/// The excerpt in quotation marks.
std::string in_quotes(std::string_view text);

/// The first names in quotation marks, separated by commas, and how many there are besides.
std::string quoted_list(const std::vector<std::string_view>& names);

}  // namespace tetraction
