#include "text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

template <class Number>
bool parse(std::string_view token, Number& value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc() && end == token.data() + token.size();
}

}  // namespace

std::string read_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    throw FileError(path + ": is not a regular file (a directory, perhaps).");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError(path + ": no such file, or no permission to read it.");
  std::stringstream text;
  text << file.rdbuf();
  if (file.bad()) throw FileError(path + ": cannot be read to its end.");
  return std::move(text).str();
}

void TextScanner::fail(const std::string& what) const {
  const std::string in = section_.empty() ? "" : "in " + section_.substr(0, 40) + ": ";
  if (bytes_) throw FileError(fmt::format("{}: byte {}: {}{}", path_, position_, in, what));
  const auto line =
      1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(position_), '\n');
  throw FileError(fmt::format("{}:{}: {}{}", path_, line, in, what));
}

void TextScanner::skip_space() {
  while (position_ < text_.size() && is_space(text_[position_])) ++position_;
}

bool TextScanner::at_end() {
  skip_space();
  return position_ == text_.size();
}

std::string_view TextScanner::token(const char* wanted) {
  if (at_end()) fail(fmt::format("the file ends where {} is expected: it is truncated.", wanted));
  const std::size_t begin = position_;
  while (position_ < text_.size() && !is_space(text_[position_])) ++position_;
  return text_.substr(begin, position_ - begin);
}

std::int64_t TextScanner::integer(const char* wanted) {
  const std::string_view text = token(wanted);
  std::int64_t value = 0;
  if (!parse(text, value)) fail(fmt::format("\"{}\" is not {} (an integer).", text, wanted));
  return value;
}

double TextScanner::real(const char* wanted) {
  const std::string_view text = token(wanted);
  double value = 0.0;
  if (!parse(text, value)) fail(fmt::format("\"{}\" is not {} (a number).", text, wanted));
  return value;
}

std::int64_t TextScanner::checked_count(std::int64_t count, const char* wanted,
                                        std::int64_t least_bytes) const {
  if (count < 0 || count > static_cast<std::int64_t>(remaining()) / least_bytes + 1) {
    fail(fmt::format("{} is {}, which the rest of the file cannot hold: it is truncated or broken.",
                     wanted, count));
  }
  return count;
}

std::int64_t TextScanner::count(const char* wanted, std::int64_t least_bytes) {
  return checked_count(integer(wanted), wanted, least_bytes);
}

std::string_view TextScanner::line() {
  const std::size_t begin = position_;
  while (position_ < text_.size() && text_[position_] != '\n') ++position_;
  std::string_view result = text_.substr(begin, position_ - begin);
  if (position_ < text_.size()) ++position_;
  if (!result.empty() && result.back() == '\r') result.remove_suffix(1);
  return result;
}

}  // namespace tetraction
