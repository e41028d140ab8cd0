// Words of VTK files: the characters between them, the types of numbers, and whether a word is a number.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tetraction {

/// The characters between words of VTK files.
inline constexpr std::string_view kVtkSpace = " \t\r\n";

struct VtkNumberType {
  enum class Kind { kReal, kSigned, kUnsigned };
  Kind kind = Kind::kReal;
  int bytes = 8;
};

/// Types of VTU files, such as Int32. None for texts, bits and types that are not known.
std::optional<VtkNumberType> xml_number_type(std::string_view name);
/// Types of legacy files, such as unsigned_char, in small letters. None as above.
std::optional<VtkNumberType> legacy_number_type(std::string_view name);

/// Whether the whole word is exactly one number in the range of its type; reals may be nan or inf. VTK itself stops inside
/// a word or reads it as two, and keeps the lowest bits of integers that a type does not hold.
bool is_number(std::string_view word, const VtkNumberType& type);

/// "a number from 0 to 255", for messages.
std::string describe(const VtkNumberType& type);

}  // namespace tetraction
