// Reads the numbers of a Gmsh file, which are text or bytes in either byte order.
#pragma once

#include <cstdint>

#include "io/text/text_scanner.h"

namespace tetraction {

class GmshNumbers {
 public:
  /// Text, until begin_binary_file(). Keeps a reference to the scanner.
  explicit GmshNumbers(TextScanner& in) : in_(in) {}

  /// Reads the byte-order mark that follows the line of the format; numbers are bytes from here on.
  void begin_binary_file();
  bool binary() const { return binary_; }
  /// Binary data begin on the line after the section's name or its count in text.
  void begin_section() {
    if (binary_) in_.skip_line();
  }

  /// Read the types that the format calls int, size_t and double. Each throws FileError, which
  /// names the expected item, at the end of the file and if there is no such number.
  std::int64_t int32(const char* wanted);
  std::int64_t size(const char* wanted);
  double real(const char* wanted);

 private:
  template <class Number>
  Number bytes(const char* wanted);

  TextScanner& in_;
  bool binary_ = false;
  bool swap_ = false;
};

}  // namespace tetraction
