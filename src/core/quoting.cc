#include "quoting.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "printable_json.h"

namespace tetraction {
namespace {

struct Character {
  std::size_t bytes = 1;
  bool harmless = false;
  unsigned code = 0;  // 0 also of bytes that are not UTF-8
};

// The UTF-8 character at the beginning of a text that is not empty. Wrong bytes count one by one.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return {1, first >= 0x20 && first != 0x7F, first};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return {};
  unsigned code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return {};
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  constexpr unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool valid = code >= kLeast[bytes] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
  if (!valid) return {};
  const bool control = code < 0xA0;
  const bool line_break = code == 0x2028 || code == 0x2029;
  const bool direction = code == 0x200E || code == 0x200F || (code >= 0x202A && code <= 0x202E) ||
                         (code >= 0x2066 && code <= 0x2069);
  return {bytes, !control && !line_break && !direction, code};
}

void append_escaped(std::string& result, std::string_view bytes) {
  for (const char c : bytes) {
    fmt::format_to(std::back_inserter(result), "\\x{:02x}", static_cast<unsigned char>(c));
  }
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Character next = first_character(text);
    const std::string_view bytes = text.substr(0, next.bytes);
    if (next.harmless || bytes == "\n" || bytes == "\t") {
      result += bytes;
    } else {
      append_escaped(result, bytes);
    }
    text.remove_prefix(next.bytes);
  }
  return result;
}

std::string printable_json(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Character next = first_character(text);
    const std::string_view bytes = text.substr(0, next.bytes);
    const bool is_space = bytes == "\n" || bytes == "\t" || bytes == "\r";
    if (next.harmless || is_space || next.code == 0) {
      result += bytes;
    } else {
      fmt::format_to(std::back_inserter(result), "\\u{:04x}", next.code);
    }
    text.remove_prefix(next.bytes);
  }
  return result;
}

std::string excerpt(std::string_view text, std::size_t most) {
  std::string result;
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == most) return result + "…";
    const Character next = first_character(text);
    const std::string_view bytes = text.substr(0, next.bytes);
    if (next.harmless) {
      result += bytes;
    } else if (bytes == "\n") {
      result += "\\n";
    } else if (bytes == "\r") {
      result += "\\r";
    } else if (bytes == "\t") {
      result += "\\t";
    } else {
      append_escaped(result, bytes);
    }
    text.remove_prefix(next.bytes);
  }
  return result;
}

std::string printable_message(std::string_view text) {
  constexpr std::size_t kLongestWord = 1000;
  std::string result;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find_first_of(" \n"));
    result += word.size() > kLongestWord ? excerpt(word) : printable(word);
    text.remove_prefix(word.size());
    const std::size_t space = std::min(text.find_first_not_of(" \n"), text.size());
    result += text.substr(0, space);
    text.remove_prefix(space);
  }
  return result;
}

std::string in_quotes(std::string_view text) {
  return '"' + excerpt(text) + '"';
}

std::string quoted_list(const std::vector<std::string_view>& names) {
  constexpr std::size_t kMostNames = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
    text += (i == 0 ? "" : ", ") + in_quotes(names[i]);
  }
  if (names.size() > kMostNames) text += fmt::format(" and {} more", names.size() - kMostNames);
  return text;
}

}  // namespace tetraction
