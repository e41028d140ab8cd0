// Goes through the tags of an XML text, without reading what is between them. The time grows with the
// length of the text.
#pragma once

#include <optional>
#include <string_view>

namespace tetraction {

struct XmlTag {
  std::string_view name;  ///< without the slash of a closing tag
  std::string_view body;  ///< between the angle brackets
  bool closes = false;    ///< </name>

  /// The value of an attribute as the file has it.
  std::optional<std::string_view> attribute(std::string_view wanted) const;
};

class XmlTags {
 public:
  explicit XmlTags(std::string_view text) : text_(text) {}

  /// The next tag. Comments, CDATA sections, declarations and processing instructions are left out. None
  /// at the end, and if something is not closed.
  std::optional<XmlTag> next();
  /// The text between the last tag and the one that follows.
  std::string_view content() const;

 private:
  bool skip_past(std::string_view mark);

  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace tetraction
