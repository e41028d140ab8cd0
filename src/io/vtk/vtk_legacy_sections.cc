#include "vtk_legacy_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/quoting.h"
#include "tetraction/core/error.h"
#include "vtk_numbers.h"

namespace tetraction {
namespace {

std::string lower(std::string_view word) {
  std::string text(word);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// A name in which VTK has written characters as %20.
std::string decoded(const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    unsigned value = 0;
    const char* digits = name.data() + i + 1;
    const bool is_code = name[i] == '%' && i + 2 < name.size() &&
                         std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2;
    text += is_code ? static_cast<char>(value) : name[i];
    if (is_code) i += 2;
  }
  return text;
}

// Goes through the sections as VTK's reader does. Its functions return false where it cannot go on. VTK
// knows keywords and types by their first letters only; here they must be whole, or the file is refused.
class LegacySections {
 public:
  LegacySections(const std::string& path, std::string_view body, bool version5)
      : path_(path), text_(body), version5_(version5) {
    binary_ = word().starts_with("binary");
  }

  void walk() {
    for (std::string keyword = word(); !keyword.empty(); keyword = word()) {
      const std::size_t begin = at_;
      // VTK says what it misses at the end of a file that is cut.
      if (section(keyword) || at_ >= text_.size()) continue;
      throw FileError(
          fmt::format("{}: the file cannot be read as a VTK unstructured grid: its section {} is "
                      "not known or not complete, {} bytes before the end of the file.",
                      path_, in_quotes(keyword), text_.size() - begin));
    }
  }

 private:
  std::string_view raw_word() {
    const std::size_t begin = std::min(text_.find_first_not_of(kVtkSpace, at_), text_.size());
    at_ = std::min(text_.find_first_of(kVtkSpace, begin), text_.size());
    return text_.substr(begin, at_ - begin);
  }
  std::string word() {
    constexpr std::size_t kLongest = 256;
    return lower(raw_word().substr(0, kLongest));
  }
  // VTK does not tell large and small letters apart in keywords only.
  std::string name() {
    const std::size_t end_before = at_;
    word();
    const std::size_t begin = text_.find_first_not_of(kVtkSpace, end_before);
    return begin >= at_ ? std::string() : std::string(text_.substr(begin, at_ - begin));
  }
  bool number(std::int64_t& value) {
    const std::string text = word();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && value >= 0;
  }
  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  bool skip(std::int64_t count, std::int64_t factor, const std::string& type) {
    const auto left = static_cast<std::int64_t>(text_.size() - at_);
    if (factor > 0 && count > left / factor) return false;  // each value takes a byte at least
    count *= factor;
    if (type == "string" || type == "utf8_string") return skip_texts(count);
    if (type == "bit") return binary_ ? skip_bytes((count + 7) / 8) : skip_words(count, {});
    const auto number_type = legacy_number_type(type);
    if (!number_type) return false;
    return binary_ ? skip_bytes(count * number_type->bytes) : skip_words(count, number_type);
  }
  bool skip_bytes(std::int64_t bytes) {
    skip_line();
    if (bytes >= static_cast<std::int64_t>(text_.size() - at_)) return false;
    at_ += 1 + static_cast<std::size_t>(bytes);
    return true;
  }
  bool skip_words(std::int64_t count, const std::optional<VtkNumberType>& type) {
    for (std::int64_t i = 0; i < count; ++i) {
      const std::string_view number = raw_word();
      if (number.empty()) return false;
      if (!type || is_number(number, *type)) continue;
      throw FileError(fmt::format("{}: {} in its {} is not {}.", path_, in_quotes(number),
                                  values_of_, describe(*type)));
    }
    return true;
  }
  // A text is a line; in binary its length is in front of it, in 1, 2, 4 or 8 bytes.
  bool skip_texts(std::int64_t count) {
    skip_line();
    for (std::int64_t i = 0; i < count; ++i) {
      if (at_ >= text_.size()) return false;
      ++at_;
      if (!binary_) {
        skip_line();
        continue;
      }
      if (at_ >= text_.size()) return false;
      const unsigned kind = static_cast<unsigned char>(text_[at_]) >> 6U;
      const std::size_t bytes = std::size_t{1} << (3U - kind);
      if (bytes > text_.size() - at_) return false;
      std::size_t length = static_cast<unsigned char>(text_[at_]) & 63U;
      for (std::size_t b = 1; b < bytes; ++b) {
        length = length << 8U | static_cast<unsigned char>(text_[at_ + b]);
      }
      if (length >= text_.size() - at_ - bytes) return false;
      at_ += bytes + length - 1;
    }
    if (binary_) ++at_;
    return true;
  }

  void once(const char* what) {
    values_of_ = what;
    if (!sections_.insert(what).second) {
      throw FileError(
          fmt::format("{}: {} is given twice, and which of both holds is ambiguous.", path_, what));
    }
  }
  void note(const std::string& name) {
    const std::string array = decoded(name);
    values_of_ = "array " + in_quotes(array);
    if (data_.empty() || arrays_.insert(data_ + " " + array).second) return;
    throw FileError(fmt::format(
        "{}: the array {} of its {} is given twice, and which of both holds is ambiguous.", path_,
        in_quotes(array), data_));
  }

  bool section(const std::string& keyword) {
    if (keyword == "dataset") return once("DATASET"), !word().empty();
    if (keyword == "points") return once("POINTS"), typed_values(3);
    if (keyword == "cells") return once("CELLS"), cells();
    if (keyword == "cell_types") return once("CELL_TYPES"), cell_types();
    if (keyword == "field") return field();
    if (keyword == "cell_data" || keyword == "point_data") {
      data_ = keyword == "cell_data" ? "CELL_DATA" : "POINT_DATA";
      return number(items_);
    }
    if (keyword == "metadata") return metadata();
    return !data_.empty() && attribute(keyword);
  }

  // The number of values and their type come first.
  bool typed_values(std::int64_t factor) {
    std::int64_t count = 0;
    return number(count) && skip(count, factor, word());
  }

  bool cells() {
    std::int64_t first = 0;
    std::int64_t second = 0;
    if (!number(first) || !number(second)) return false;
    if (!version5_) return skip(second, 1, "int");
    return word() == "offsets" && skip(first, 1, word()) && word() == "connectivity" &&
           skip(second, 1, word());
  }

  bool cell_types() {
    std::int64_t count = 0;
    if (!number(count)) return false;
    const std::size_t begin = at_;
    if (binary_ && !skip(count, 1, "int")) return false;
    for (std::int64_t i = 0; i < count && (binary_ || at_ < text_.size()); ++i) {
      const std::int64_t type = binary_ ? big_endian(begin, i) : integer(word());
      if (type >= 0 && type <= 255) continue;
      throw FileError(
          fmt::format("{}: the type {} of cell {} is not a number from 0 to 255.", path_, type, i));
    }
    return true;
  }
  // Number i of the 32-bit integers on the line after `begin`.
  std::int64_t big_endian(std::size_t begin, std::int64_t i) const {
    const std::size_t at = text_.find('\n', begin) + 1 + 4 * static_cast<std::size_t>(i);
    std::uint32_t value = 0;
    for (std::size_t b = 0; b < 4; ++b) {
      value = value << 8U | static_cast<unsigned char>(text_[at + b]);
    }
    return static_cast<std::int32_t>(value);
  }
  // 0 if it is none, which VTK refuses.
  static std::int64_t integer(const std::string& text) {
    std::int64_t value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }

  bool field() {
    name();
    std::int64_t arrays = 0;
    if (!number(arrays)) return false;
    for (std::int64_t a = 0; a < arrays; ++a) {
      const std::string array = name();
      if (lower(array) == "metadata" && metadata()) {
        --a;
        continue;
      }
      if (array == "NULL_ARRAY") continue;
      std::int64_t components = 0;
      std::int64_t tuples = 0;
      if (!number(components) || !number(tuples)) return false;
      note(array);
      if (!skip(tuples, components, word())) return false;
    }
    return true;
  }

  // Ends with an empty line.
  bool metadata() {
    skip_line();
    while (at_ < text_.size()) {
      const std::size_t begin = ++at_;
      skip_line();
      if (text_.substr(begin, at_ - begin).find_first_not_of(kVtkSpace) == text_.npos) return true;
    }
    return false;
  }

  bool attribute(const std::string& keyword) {
    static const std::map<std::string, std::int64_t> components{
        {"vectors", 3},    {"normals", 3},          {"tensors", 9},
        {"tensors6", 6},   {"global_ids", 1},       {"pedigree_ids", 1},
        {"edge_flags", 1}, {"rational_weights", 1}, {"higher_order_degrees", 3}};
    const std::string colour = binary_ ? "unsigned_char" : "float";  // from 0 to 1 in text
    const std::string array = name();
    if (keyword == "lookup_table") {
      std::int64_t colours = 0;
      return number(colours) && skip(colours, 4, colour);
    }
    if (keyword == "scalars") return note(array), scalars();
    std::int64_t count = 0;
    if (keyword == "color_scalars") {
      return note(array), number(count) && skip(items_, count, colour);
    }
    if (keyword == "texture_coordinates") {
      return note(array), number(count) && skip(items_, count, word());
    }
    const auto found = components.find(keyword);
    return found != components.end() && (note(array), skip(items_, found->second, word()));
  }

  // The number of components may be missing.
  bool scalars() {
    const std::string type = word();
    std::int64_t components = 1;
    const std::size_t before = at_;
    if (!number(components)) {
      at_ = before;
      components = 1;
    }
    if (word() != "lookup_table") return false;
    name();
    return skip(items_, components, type);
  }

  const std::string& path_;
  std::string_view text_;
  bool version5_;
  bool binary_ = false;
  std::size_t at_ = 0;
  std::int64_t items_ = 0;
  std::string data_;       // CELL_DATA or POINT_DATA, which the arrays belong to
  std::string values_of_;  // what the numbers belong to, for messages
  std::set<std::string> sections_;
  std::set<std::string> arrays_;
};

}  // namespace

void check_legacy_sections(const std::string& path, std::string_view text, std::string_view body) {
  const std::string title = lower(text.substr(0, text.find('\n')));
  const std::size_t version = title.find("version ");
  LegacySections(path, body, version != title.npos && title.compare(version + 8, 1, "5") >= 0)
      .walk();
}

}  // namespace tetraction
