// Checks the binary arrays of a VTU file before VTK reads them: VTK takes what is there for the rest of an
// array that is cut, or leaves the rest of its memory as it is.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "xml_tags.h"

namespace tetraction {

class XmlBinaryArrays {
 public:
  /// `file` is the tag <VTKFile>.
  XmlBinaryArrays(const std::string& path, std::string_view text, const XmlTag& file);

  /// Checks an array between its tags: its bytes are as many as it announces, in base64 without gaps.
  void check_inline(const XmlTag& array, std::string_view content) const;
  /// Keeps an array of which <AppendedData> holds the bytes.
  void add_appended(const XmlTag& array);
  /// Checks the arrays that were kept: each is there with all bytes that it announces, none overlaps
  /// another one, and after them the file ends. `section` is the tag <AppendedData>.
  void check_appended(const XmlTag& section) const;
  /// Whether arrays have been kept.
  bool has_appended() const { return !appended_.empty(); }

 private:
  struct Appended {
    std::string_view name;
    std::size_t offset;
    std::size_t word_size;
  };

  std::size_t block_length(std::string_view name, std::string_view data, bool in_base64,
                           std::size_t word_size) const;
  std::vector<std::size_t> header(std::string_view name, std::string_view data, bool in_base64,
                                  std::size_t numbers) const;
  [[noreturn]] void refuse(std::string_view name, const char* what) const;

  const std::string& path_;
  std::string_view text_;
  bool big_endian_;
  bool compressed_;
  std::size_t header_size_;  // bytes of each number of a header
  std::vector<Appended> appended_;
};

}  // namespace tetraction
