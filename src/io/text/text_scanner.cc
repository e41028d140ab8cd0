#include "text_scanner.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/quoting.h"
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

std::string read_file(const std::string& path, std::size_t most) {
  // Opening a pipe would wait for somebody who writes to it.
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  const auto refuse = [&](const std::string& what) {
    if (file >= 0) close(file);
    throw FileError(path + ": " + what);
  };
  if (file < 0) {
    refuse(errno == ENOENT ? "no such file."
                           : fmt::format("cannot be read ({}).", std::strerror(errno)));
  }
  struct stat status {};
  if (fstat(file, &status) != 0) {
    refuse(fmt::format("cannot be read ({}).", std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    refuse(S_ISDIR(status.st_mode) ? "is a directory, not a regular file."
                                   : "is not a regular file (a pipe or a device, perhaps).");
  }
  const auto memory = static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) *
                      static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t bound = std::min(most, memory / 2);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > bound) {
    constexpr double kMegabyte = 1e6;
    refuse(fmt::format("has {:.4g} MB, and at most {:.4g} MB of such a file can be read here.",
                       static_cast<double>(size) / kMegabyte,
                       static_cast<double>(bound) / kMegabyte));
  }
  std::string text(size, '\0');
  std::size_t have = 0;
  while (have < size) {
    const ssize_t count = read(file, text.data() + have, size - have);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(fmt::format("cannot be read to its end ({}).", std::strerror(errno)));
    if (count == 0) break;  // it has become shorter
    have += static_cast<std::size_t>(count);
  }
  close(file);
  text.resize(have);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

void TextScanner::fail(const std::string& what) const {
  const std::string in = section_.empty() ? "" : "in " + excerpt(section_, 40) + ": ";
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
  if (!parse(text, value)) fail(fmt::format("{} is not {} (an integer).", in_quotes(text), wanted));
  return value;
}

double TextScanner::real(const char* wanted) {
  const std::string_view text = token(wanted);
  double value = 0.0;
  if (!parse(text, value)) fail(fmt::format("{} is not {} (a number).", in_quotes(text), wanted));
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
