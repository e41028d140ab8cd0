#include "vtk_numbers.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <system_error>

namespace tetraction {
namespace {

using Kind = VtkNumberType::Kind;
using Types = std::map<std::string, VtkNumberType, std::less<>>;

std::optional<VtkNumberType> find(const Types& types, std::string_view name) {
  const auto found = types.find(name);
  if (found == types.end()) return std::nullopt;
  return found->second;
}

template <class Number>
bool parse_word(std::string_view word, Number& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

// A number that is too small for a double is zero, as VTK reads it. It also reads nan and inf.
bool is_real(std::string_view word, int bytes) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return false;
  if (error == std::errc::result_out_of_range) {
    value = std::strtod(std::string(word).c_str(), nullptr);
  } else if (error != std::errc()) {
    return false;
  } else if (!std::isfinite(value)) {
    return !word.ends_with(')');
  }
  if (bytes == 4) value = static_cast<double>(static_cast<float>(value));
  return std::isfinite(value);
}

std::int64_t least(const VtkNumberType& type) {
  if (type.kind == Kind::kUnsigned) return 0;
  return std::numeric_limits<std::int64_t>::min() >> (64 - 8 * type.bytes);
}

std::uint64_t most(const VtkNumberType& type) {
  const int bits = 8 * type.bytes - (type.kind == Kind::kSigned ? 1 : 0);
  return std::numeric_limits<std::uint64_t>::max() >> (64 - bits);
}

}  // namespace

std::optional<VtkNumberType> xml_number_type(std::string_view name) {
  static const Types types{{"Int8", {Kind::kSigned, 1}},  {"UInt8", {Kind::kUnsigned, 1}},
                           {"Int16", {Kind::kSigned, 2}}, {"UInt16", {Kind::kUnsigned, 2}},
                           {"Int32", {Kind::kSigned, 4}}, {"UInt32", {Kind::kUnsigned, 4}},
                           {"Int64", {Kind::kSigned, 8}}, {"UInt64", {Kind::kUnsigned, 8}},
                           {"Float32", {Kind::kReal, 4}}, {"Float64", {Kind::kReal, 8}}};
  return find(types, name);
}

std::optional<VtkNumberType> legacy_number_type(std::string_view name) {
  static const Types types{{"char", {Kind::kSigned, 1}},
                           {"signed_char", {Kind::kSigned, 1}},
                           {"unsigned_char", {Kind::kUnsigned, 1}},
                           {"short", {Kind::kSigned, 2}},
                           {"unsigned_short", {Kind::kUnsigned, 2}},
                           {"int", {Kind::kSigned, 4}},
                           {"unsigned_int", {Kind::kUnsigned, 4}},
                           {"long", {Kind::kSigned, 8}},
                           {"unsigned_long", {Kind::kUnsigned, 8}},
                           {"vtktypeint64", {Kind::kSigned, 8}},
                           {"vtktypeuint64", {Kind::kUnsigned, 8}},
                           // VTK has them as 32-bit integers in these files.
                           {"vtkidtype", {Kind::kSigned, 4}},
                           {"float", {Kind::kReal, 4}},
                           {"double", {Kind::kReal, 8}}};
  return find(types, name);
}

bool is_number(std::string_view word, const VtkNumberType& type) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return false;
  }
  if (type.kind == Kind::kReal) return is_real(word, type.bytes);
  if (word.starts_with('-')) {
    std::int64_t value = 0;
    return parse_word(word, value) && value >= least(type);
  }
  std::uint64_t value = 0;
  return parse_word(word, value) && value <= most(type);
}

std::string describe(const VtkNumberType& type) {
  if (type.kind == Kind::kReal) return fmt::format("a number that {} bytes hold", type.bytes);
  return fmt::format("a number from {} to {}", least(type), most(type));
}

}  // namespace tetraction
