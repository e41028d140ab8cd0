#include "xml_binary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

#include "core/quoting.h"
#include "tetraction/core/error.h"
#include "vtk_numbers.h"

namespace tetraction {
namespace {

// The value of a character of base64, or 64.
constexpr std::array<unsigned char, 256> base64_values() {
  std::array<unsigned char, 256> values{};
  values.fill(64);
  const std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < digits.size(); ++i) {
    values[static_cast<unsigned char>(digits[i])] = static_cast<unsigned char>(i);
  }
  return values;
}
constexpr auto kBase64 = base64_values();

unsigned value_of(char c) {
  return kBase64[static_cast<unsigned char>(c)];
}

std::size_t characters(std::size_t bytes) {
  return (bytes + 2) / 3 * 4;
}

// Whether the text begins with that many bytes in base64, padded at their end.
bool holds_base64(std::string_view text, std::size_t bytes) {
  if (characters(bytes) > text.size()) return false;
  const std::size_t padding = (3 - bytes % 3) % 3;
  const std::size_t end = characters(bytes);
  const auto is_digit = [](char c) { return value_of(c) < 64; };
  return std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end - padding),
                     is_digit) &&
         text.substr(end - padding, padding).find_first_not_of('=') == text.npos;
}

// The first bytes of a text in base64, of which no padding belongs to them.
std::string decode(std::string_view text, std::size_t bytes) {
  std::string decoded;
  for (std::size_t i = 0; i + 3 < text.size() && decoded.size() < bytes; i += 4) {
    const unsigned word = value_of(text[i]) << 18U | value_of(text[i + 1]) << 12U |
                          (value_of(text[i + 2]) & 63U) << 6U | (value_of(text[i + 3]) & 63U);
    for (const unsigned shift : {16U, 8U, 0U}) decoded += static_cast<char>(word >> shift & 255U);
  }
  decoded.resize(std::min(decoded.size(), bytes));
  return decoded;
}

std::string_view without_space(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kVtkSpace), text.size()));
  return text;
}

// Takes a word and the space before it from the front of the text.
bool take(std::string_view& text, std::string_view word) {
  text = without_space(text);
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

std::size_t word_size(const XmlTag& array) {
  const auto type = xml_number_type(array.attribute("type").value_or(""));
  return type ? static_cast<std::size_t>(type->bytes) : 1;
}

}  // namespace

XmlBinaryArrays::XmlBinaryArrays(const std::string& path, std::string_view text, const XmlTag& file)
    : path_(path),
      text_(text),
      big_endian_(file.attribute("byte_order") == "BigEndian"),
      compressed_(!file.attribute("compressor").value_or("").empty()),
      header_size_(file.attribute("header_type") == "UInt64" ? 8 : 4) {}

void XmlBinaryArrays::refuse(std::string_view name, const char* what) const {
  throw FileError(fmt::format("{}: its array {} {}. The file is damaged; write it anew.", path_,
                              in_quotes(name), what));
}

// The numbers at the head of an array.
std::vector<std::size_t> XmlBinaryArrays::header(std::string_view name, std::string_view data,
                                                 bool in_base64, std::size_t numbers) const {
  const std::size_t bytes = numbers * header_size_;
  if ((in_base64 ? characters(bytes) : bytes) > data.size()) refuse(name, "is cut in its header");
  const std::string decoded = in_base64 ? decode(data, bytes) : std::string(data.substr(0, bytes));
  std::vector<std::size_t> values(numbers, 0);
  for (std::size_t i = 0; i < numbers; ++i) {
    for (std::size_t b = 0; b < header_size_; ++b) {
      const std::size_t at = big_endian_ ? b : header_size_ - 1 - b;
      values[i] = values[i] << 8U | static_cast<unsigned char>(decoded[i * header_size_ + at]);
    }
    // No array of a file has more, and sums of a few do not overflow.
    if (values[i] > std::size_t{1} << 48U) refuse(name, "announces more bytes than there can be");
  }
  return values;
}

// How much of `data` the array takes. In base64 its header and its bytes are one text, or two if they
// are compressed.
std::size_t XmlBinaryArrays::block_length(std::string_view name, std::string_view data,
                                          bool in_base64, std::size_t word_size) const {
  constexpr const char* kCut = "has fewer bytes than it announces, or some that are not base64";
  std::vector<std::size_t> head = header(name, data, in_base64, compressed_ ? 3 : 1);
  std::size_t stored = head[0];
  std::size_t head_bytes = header_size_;
  std::size_t head_length = 0;
  std::size_t whole = head[0];
  if (compressed_) {
    const std::size_t blocks = head[0];
    if (blocks > data.size()) refuse(name, kCut);
    head = header(name, data, in_base64, 3 + blocks);
    head_bytes *= 3 + blocks;
    head_length = in_base64 ? characters(head_bytes) : head_bytes;
    if (in_base64 && !holds_base64(data, head_bytes)) refuse(name, kCut);
    stored = 0;
    for (std::size_t b = 0; b < blocks && stored <= data.size(); ++b) stored += head[3 + b];
    whole = blocks == 0 ? 0
                        : (head[2] != 0 ? head[2] : head[1]) % word_size +
                              (blocks > 1 ? head[1] % word_size : 0);
    head_bytes = 0;
  }
  if (whole % word_size != 0) refuse(name, "announces bytes that are no whole numbers");
  const std::size_t bytes = head_bytes + stored;
  data.remove_prefix(head_length);
  const bool complete = in_base64 ? holds_base64(data, bytes) : bytes <= data.size();
  if (!complete) refuse(name, kCut);
  return head_length + (in_base64 ? characters(bytes) : bytes);
}

void XmlBinaryArrays::check_inline(const XmlTag& array, std::string_view content) const {
  const std::string_view name = array.attribute("Name").value_or("");
  content = without_space(content);
  const std::size_t length = block_length(name, content, true, word_size(array));
  if (!without_space(content.substr(length)).empty()) {
    refuse(name, "has more behind the bytes that it announces");
  }
}

void XmlBinaryArrays::add_appended(const XmlTag& array) {
  const std::string_view name = array.attribute("Name").value_or("");
  std::string_view offset = without_space(array.attribute("offset").value_or(""));
  offset = offset.substr(0, offset.find_last_not_of(kVtkSpace) + 1);
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(offset.data(), offset.data() + offset.size(), value);
  if (error != std::errc() || end != offset.data() + offset.size() || value > text_.size()) {
    refuse(name, "has an offset that is not a position in the file");
  }
  appended_.push_back({name, value, word_size(array)});
}

void XmlBinaryArrays::check_appended(const XmlTag& section) const {
  std::string_view data =
      text_.substr(static_cast<std::size_t>(section.body.end() - text_.begin()) + 1);
  const bool in_base64 = section.attribute("encoding") != "raw";
  if (section.body.ends_with('/') || !take(data, "_")) {
    throw FileError(path_ + ": its <AppendedData> does not begin with an underscore.");
  }
  auto arrays = appended_;
  std::sort(arrays.begin(), arrays.end(),
            [](const Appended& a, const Appended& b) { return a.offset < b.offset; });
  std::size_t end = 0;
  for (const Appended& array : arrays) {
    if (array.offset < end) refuse(array.name, "begins within another array");
    if (array.offset > data.size()) refuse(array.name, "begins after the end of the file");
    end = array.offset +
          block_length(array.name, data.substr(array.offset), in_base64, array.word_size);
  }
  std::string_view rest = data.substr(end);
  if (take(rest, "</AppendedData") && take(rest, ">") && take(rest, "</VTKFile") &&
      take(rest, ">") && without_space(rest).empty()) {
    return;
  }
  throw FileError(path_ +
                  ": its <AppendedData> does not end after the last of its arrays, or something "
                  "follows it, so that the file is damaged or ambiguous. Write it anew.");
}

}  // namespace tetraction
