// Reads the text of a mesh file step by step, with line numbers for messages, and never past its
// end.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace tetraction {

/// The largest size of a file, unless the memory of the machine is less than twice as much.
inline constexpr std::size_t kLargestFile = std::size_t{8} << 30U;

/// The whole file in memory, without the mark of UTF-8 (U+FEFF) that some programs write first. Throws FileError if it is missing or cannot be read, if it is no regular
/// file (a pipe would be waited for), or if it has more than `most` bytes or more than half of the
/// machine's memory. Allocates nothing before it knows the size of the file.
std::string read_file(const std::string& path, std::size_t most = kLargestFile);

/// Reads tokens that are separated by white space.
class TextScanner {
 public:
  TextScanner(std::string path, std::string_view text) : path_(std::move(path)), text_(text) {}

  /// Throws FileError "path:line: what", with "in SECTION: " before `what` if a section is set.
  [[noreturn]] void fail(const std::string& what) const;

  /// The part of the file that messages name from now on; none if empty.
  void set_section(std::string section) { section_ = std::move(section); }
  /// From now on messages give the byte instead of the line, which has no meaning in binary data.
  void count_bytes() { bytes_ = true; }

  bool at_end();
  /// Whether the next token begins with this character.
  bool next_is(char c) { return !at_end() && text_[position_] == c; }
  /// The next token. At the end of the file an error names the expected item.
  std::string_view token(const char* wanted);
  std::int64_t integer(const char* wanted);
  double real(const char* wanted);
  /// A count of items, each of which takes at least `least_bytes` of the rest of the file. A count
  /// that is too large for the file is refused before anything is allocated.
  std::int64_t count(const char* wanted, std::int64_t least_bytes);
  /// Checks a count in the same way that was read by other means.
  std::int64_t checked_count(std::int64_t count, const char* wanted,
                             std::int64_t least_bytes) const;
  /// The rest of the line, without its end.
  std::string_view line();
  /// Moves to the next line.
  void skip_line() { line(); }
  std::size_t position() const { return position_; }
  void set_position(std::size_t position) { position_ = position; }
  std::size_t remaining() const { return text_.size() - position_; }
  std::string_view text() const { return text_; }
  const std::string& path() const { return path_; }

 private:
  void skip_space();

  std::string path_;
  std::string section_;
  bool bytes_ = false;
  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace tetraction
