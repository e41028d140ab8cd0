#include "xml_tags.h"

#include <algorithm>

#include "vtk_numbers.h"

namespace tetraction {
namespace {

// Where the tag that begins at `begin` ends: at the next > outside quotation marks.
std::size_t end_of_tag(std::string_view text, std::size_t begin) {
  for (std::size_t at = begin; at < text.size(); ++at) {
    at = text.find_first_of("\"'>", at);
    if (at == text.npos || text[at] == '>') return at;
    at = text.find(text[at], at + 1);
    if (at == text.npos) return at;
  }
  return text.npos;
}

}  // namespace

std::optional<std::string_view> XmlTag::attribute(std::string_view wanted) const {
  std::size_t at = name.size() + (closes ? 1 : 0);
  for (;;) {
    at = body.find_first_not_of(kVtkSpace, at);
    const std::size_t equals = at == body.npos ? at : body.find('=', at);
    if (equals == body.npos) return std::nullopt;
    std::string_view key = body.substr(at, equals - at);
    key = key.substr(0, key.find_last_not_of(kVtkSpace) + 1);
    const std::size_t open = body.find_first_not_of(kVtkSpace, equals + 1);
    if (open == body.npos || (body[open] != '"' && body[open] != '\'')) return std::nullopt;
    const std::size_t close = body.find(body[open], open + 1);
    if (close == body.npos) return std::nullopt;
    if (key == wanted) return body.substr(open + 1, close - open - 1);
    at = close + 1;
  }
}

bool XmlTags::skip_past(std::string_view mark) {
  const std::size_t found = text_.find(mark, position_);
  position_ = found == text_.npos ? text_.size() : found + mark.size();
  return found != text_.npos;
}

std::optional<XmlTag> XmlTags::next() {
  for (;;) {
    position_ = std::min(text_.find('<', position_), text_.size());
    const std::string_view rest = text_.substr(position_);
    if (rest.empty()) return std::nullopt;
    if (rest.starts_with("<!--")) {
      position_ += 4;
      if (!skip_past("-->")) return std::nullopt;
    } else if (rest.starts_with("<![CDATA[")) {
      if (!skip_past("]]>")) return std::nullopt;
    } else if (rest.starts_with("<?")) {
      if (!skip_past("?>")) return std::nullopt;
    } else if (rest.starts_with("<!")) {
      if (!skip_past(">")) return std::nullopt;
    } else {
      break;
    }
  }
  const std::size_t begin = position_ + 1;
  const std::size_t end = end_of_tag(text_, begin);
  if (end == text_.npos) {
    position_ = text_.size();
    return std::nullopt;
  }
  position_ = end + 1;
  XmlTag tag;
  tag.body = text_.substr(begin, end - begin);
  tag.closes = tag.body.starts_with('/');
  const std::size_t from = tag.closes ? 1 : 0;
  tag.name = tag.body.substr(from, tag.body.find_first_of(" \t\r\n/", from) - from);
  return tag;
}

std::string_view XmlTags::content() const {
  return text_.substr(position_, text_.find('<', position_) - position_);
}

}  // namespace tetraction
