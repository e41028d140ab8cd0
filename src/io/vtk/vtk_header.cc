#include "vtk_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "core/quoting.h"
#include "io/text/file_kind.h"
#include "tetraction/core/error.h"
#include "vtk_legacy_sections.h"
#include "vtk_numbers.h"
#include "xml_binary.h"
#include "xml_tags.h"

namespace tetraction {
namespace {

// zlib, lz4 and lzma of XML files: 3 coordinates of 4 bytes, packed 1,032 to 1 at best by zlib.
constexpr std::int64_t kMostPointsPerByte = 100;
constexpr std::int64_t kMostValuesPerByte = 1032;

bool equal_ignoring_case(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

// A count, or an error that says what is there instead.
std::int64_t count_of(const std::string& path, const char* name, std::string_view value,
                      std::int64_t most) {
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), count);
  if (error != std::errc() || end != value.data() + value.size() || count < 0 || count > most) {
    throw FileError(
        fmt::format("{}: {} is {}: the file is too small for so many, so that it must be damaged. "
                    "Write the file anew.",
                    path, name, in_quotes(value)));
  }
  return count;
}

// The word after a keyword of a legacy file; empty if either is missing.
std::string_view word_after(std::string_view text, std::string_view keyword) {
  for (auto from = text.begin();;) {
    const auto found =
        std::search(from, text.end(), keyword.begin(), keyword.end(), equal_ignoring_case);
    if (found == text.end()) return {};
    const auto at = static_cast<std::size_t>(found - text.begin());
    const std::size_t after = at + keyword.size();
    const bool alone = (at == 0 || kVtkSpace.find(text[at - 1]) != kVtkSpace.npos) &&
                       after < text.size() && kVtkSpace.find(text[after]) != kVtkSpace.npos;
    if (alone) {
      const std::size_t begin = text.find_first_not_of(kVtkSpace, after);
      if (begin == text.npos) return {};
      return text.substr(begin, text.find_first_of(kVtkSpace, begin) - begin);
    }
    from = found + 1;
  }
}

// A view of the text from behind its first `lines` lines on.
std::string_view after_lines(std::string_view text, int lines) {
  for (int line = 0; line < lines; ++line) {
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + (text.empty() ? 0 : 1));
    if (text.empty()) break;
  }
  return text;
}

// Calls use(tag, tags) for the tags up to <AppendedData>. What follows may look like anything.
template <class Use>
void for_each_tag(std::string_view text, const Use& use) {
  XmlTags tags(text);
  while (const auto tag = tags.next()) {
    use(*tag, tags);
    if (tag->name == "AppendedData") return;
  }
}

// Checks the arrays of a file. Of those in text VTK takes as many numbers as there should be and leaves
// what follows them, it reads words that are no number as far as it can, and it cuts off the higher bits
// of numbers that a type does not hold.
class XmlArrays {
 public:
  XmlArrays(const std::string& path, std::string_view text, const XmlTag& file)
      : path_(path), binary_(path, text, file) {}

  void visit(const XmlTag& tag, const XmlTags& tags) {
    refuse_time_steps(tag);
    if (!tag.closes && (tag.name == "DataArray" || tag.name == "Array")) {
      refuse_references(tag);
      if (tag.attribute("offset")) {
        binary_.add_appended(tag);
      } else if (tag.attribute("format") == "binary") {
        binary_.check_inline(tag, tags.content());
      }
    }
    if (tag.name == "AppendedData" && !tag.closes) {
      binary_.check_appended(tag);
      appended_ = true;
    }
    if (tag.name == "Piece" && !tag.closes) {
      points_ = number(tag.attribute("NumberOfPoints"));
      cells_ = number(tag.attribute("NumberOfCells"));
    } else if (tag.name == "PointData" || tag.name == "CellData" || tag.name == "Points" ||
               tag.name == "Cells") {
      if (tag.closes && tag.name == "Cells") check_connectivity();
      section_ = tag.closes || tag.body.ends_with('/') ? std::string_view() : tag.name;
      connectivity_ = last_offset_ = -1;
    } else if (tag.name == "DataArray" && !tag.closes && !section_.empty() && is_text(tag)) {
      check(tag, tags.content());
    }
  }
  void finish() const {
    if (!binary_.has_appended() || appended_) return;
    throw FileError(path_ + ": has arrays with an offset and no <AppendedData>.");
  }

 private:
  // VTK leaves the memory of an array as it is that does not belong to the time that it reads.
  void refuse_time_steps(const XmlTag& tag) const {
    for (const char* name : {"TimeStep", "TimeValues"}) {
      if (!tag.attribute(name)) continue;
      throw FileError(
          fmt::format("{}: <{}> has the attribute {}: the file holds a series in time, and which "
                      "of its states is the mesh is ambiguous. Write one state without it.",
                      path_, tag.name, name));
    }
  }
  // Attributes that decide on the meaning of an array must be written without references.
  void refuse_references(const XmlTag& array) const {
    // VTK looks for numbers that are no appended ones behind the first > of the tag.
    bool is_good = array.attribute("offset") || array.body.find('>') == array.body.npos;
    for (const char* name : {"type", "format", "offset", "NumberOfComponents", "NumberOfTuples"}) {
      is_good = is_good && array.attribute(name).value_or("").find('&') == array.body.npos;
    }
    if (section_ == "Cells") is_good = is_good && array.body.find('&') == array.body.npos;
    if (is_good) return;
    throw FileError(
        fmt::format("{}: the attributes of an array, <{}>, have an & or a > where VTK and this "
                    "check could read them in two ways. Write plain words.",
                    path_, excerpt(array.body, 80)));
  }

  static std::int64_t number(std::optional<std::string_view> text) {
    std::int64_t value = -1;
    if (text) std::from_chars(text->data(), text->data() + text->size(), value);
    return value;
  }
  // As VTK decides it.
  static bool is_text(const XmlTag& array) {
    return !array.attribute("offset") && array.attribute("format") != "binary" &&
           array.attribute("type") != "String";
  }

  void check(const XmlTag& array, std::string_view content) {
    const std::string_view name = array.attribute("Name").value_or(section_);
    const std::int64_t count = check_words(array, name, content);
    if (section_ == "Cells" && name == "connectivity") connectivity_ = count;
    if (section_ == "Cells" && name != "offsets" && name != "types") return;
    const bool of_points = section_ == "PointData" || section_ == "Points";
    const std::int64_t items = of_points ? points_ : cells_;
    std::int64_t components = section_ == "Points" ? 3 : 1;
    if (const auto given = array.attribute("NumberOfComponents")) components = number(given);
    components = std::max(components, std::int64_t{1});  // as VTK takes it
    if (count == components * items) return;
    throw FileError(fmt::format("{}: its array {} has {} numbers, but there are {} {}{}{}.", path_,
                                in_quotes(name), count, items, of_points ? "points" : "cells",
                                components == 1 ? "" : fmt::format(" of {} numbers", components),
                                count > components * items ? ", which is ambiguous" : ""));
  }

  // The type of its words. That of cells is an integer, whatever the file says, since VTK makes it one.
  std::optional<VtkNumberType> type_of(const XmlTag& array, std::string_view name) const {
    if (section_ == "Cells" && name == "types") return xml_number_type("UInt8");
    auto type = xml_number_type(array.attribute("type").value_or(""));
    const bool is_whole = section_ == "Cells";
    if (type && is_whole && type->kind == VtkNumberType::Kind::kReal)
      return xml_number_type("Int64");
    return type;
  }

  // The number of words. Refuses those that VTK would read as something else.
  std::int64_t check_words(const XmlTag& array, std::string_view name, std::string_view content) {
    const auto type = type_of(array, name);
    std::int64_t count = 0;
    std::string_view word;
    for (std::size_t at = 0; (at = content.find_first_not_of(kVtkSpace, at)) != content.npos;) {
      const std::size_t end = std::min(content.find_first_of(kVtkSpace, at), content.size());
      word = content.substr(at, end - at);
      if (type && !is_number(word, *type)) {
        throw FileError(fmt::format("{}: {} in its array {} is not {}.", path_, in_quotes(word),
                                    in_quotes(name), describe(*type)));
      }
      ++count;
      at = end;
    }
    if (section_ == "Cells" && name == "offsets") last_offset_ = number(word);
    return count;
  }

  void check_connectivity() const {
    if (connectivity_ < 0 || last_offset_ < 0 || connectivity_ == last_offset_) return;
    throw FileError(
        fmt::format("{}: its array \"connectivity\" has {} numbers, but its offsets end with {}.",
                    path_, connectivity_, last_offset_));
  }

  const std::string& path_;
  XmlBinaryArrays binary_;
  bool appended_ = false;
  std::string_view section_;
  std::int64_t points_ = 0;
  std::int64_t cells_ = 0;
  std::int64_t connectivity_ =
      -1;  // numbers of this array and the last one of `offsets`, if they are text
  std::int64_t last_offset_ = -1;
};

}  // namespace

VtkHeader check_xml_header(const std::string& path, std::string_view text) {
  refuse_other_kinds(path, text, kXmlVtkKind);
  if (text.substr(0, text.find("<VTKFile")).find("<!DOCTYPE") != text.npos) {
    throw FileError(path + ": has a <!DOCTYPE>, whose definitions are not read. Write it without.");
  }
  const auto file = XmlTags(text).next();
  if (!file || file->name != "VTKFile") {
    throw FileError(path + ": is not a VTU file: it has no <VTKFile>.");
  }
  const auto type = file->attribute("type");
  if (type != "UnstructuredGrid") {
    throw FileError(
        fmt::format("{}: holds a data set of type {}; tetrahedra come in an UnstructuredGrid. "
                    "Convert it first.",
                    path, in_quotes(type.value_or(""))));
  }
  if (text.rfind("</VTKFile>") == text.npos) {
    throw FileError(path + ": the file is truncated: it has no </VTKFile>. Write it anew.");
  }
  const auto most = kMostPointsPerByte * static_cast<std::int64_t>(text.size());
  VtkHeader header;
  bool pieces = false;
  for_each_tag(text, [&](const XmlTag& tag, const XmlTags&) {
    if (tag.name != "Piece" || tag.closes) return;
    pieces = true;
    for (auto [name, sum] :
         {std::pair{"NumberOfPoints", &header.points}, std::pair{"NumberOfCells", &header.cells}}) {
      const auto value = tag.attribute(name);
      if (!value) throw FileError(fmt::format("{}: a <Piece> has no {}.", path, name));
      *sum += count_of(path, name, *value, most);
    }
  });
  if (!pieces) throw FileError(path + ": has no <Piece>, so it holds no mesh.");
  // VTK allocates whole arrays before it looks for their values.
  const auto most_values = kMostValuesPerByte * static_cast<std::int64_t>(text.size());
  const auto most_components =
      most_values / std::max({header.points, header.cells, std::int64_t{1}}) + 1;
  XmlArrays arrays(path, text, *file);
  for_each_tag(text, [&](const XmlTag& tag, const XmlTags& tags) {
    if (tag.name == "DataArray" && !tag.closes) {
      if (const auto value = tag.attribute("NumberOfComponents")) {
        count_of(path, "NumberOfComponents", *value, most_components);
      }
      if (const auto value = tag.attribute("NumberOfTuples")) {
        count_of(path, "NumberOfTuples", *value, most_values);
      }
    }
    arrays.visit(tag, tags);
  });
  arrays.finish();
  return header;
}

VtkHeader check_legacy_header(const std::string& path, std::string_view text) {
  refuse_other_kinds(path, text, kLegacyVtkKind);
  constexpr std::string_view kMark = "# vtk datafile";
  if (text.size() < kMark.size() ||
      !std::equal(kMark.begin(), kMark.end(), text.begin(), equal_ignoring_case)) {
    throw FileError(path + ": is not a legacy VTK file: no \"# vtk DataFile\" in its first line.");
  }
  const std::string_view title = after_lines(text, 1);
  const std::string_view body = after_lines(text, 3);
  const std::string_view type = word_after(body, "dataset");
  constexpr std::string_view kType = "unstructured_grid";
  if (!std::equal(kType.begin(), kType.end(), type.begin(), type.end(), equal_ignoring_case)) {
    throw FileError(
        fmt::format("{}: holds a data set of type {}; tetrahedra come in an UNSTRUCTURED_GRID. "
                    "Convert it first.",
                    path, in_quotes(type)));
  }
  const auto most = static_cast<std::int64_t>(text.size());
  VtkHeader header;
  for (auto [name, count] :
       {std::pair{"POINTS", &header.points}, std::pair{"CELL_TYPES", &header.cells}}) {
    const std::string_view value = word_after(body, name);
    if (value.empty()) {
      throw FileError(
          fmt::format("{}: has no {}: the file is truncated or holds no mesh.", path, name));
    }
    *count = count_of(path, name, value, most);
  }
  check_legacy_sections(path, text, after_lines(text, 2));
  header.own_arrays = title.substr(0, std::string_view(kOwnLegacyTitle).size()) == kOwnLegacyTitle;
  return header;
}

}  // namespace tetraction
