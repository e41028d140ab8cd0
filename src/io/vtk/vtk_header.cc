#include "vtk_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
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
    throw FileError(fmt::format(
        "{}: {} is {}: the file is too small for so many, so that it must be damaged. Write "
        "the file anew.",
        path, name, in_quotes(value)));
  }
  return count;
}

// The value of an attribute of an XML tag.
std::optional<std::string_view> attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != tag.npos; at = tag.find(name, at + 1)) {
    if (at == 0 || kSpace.find(tag[at - 1]) == kSpace.npos) continue;
    std::size_t begin = tag.find_first_not_of(kSpace, at + name.size());
    if (begin == tag.npos || tag[begin] != '=') continue;
    begin = tag.find_first_not_of(kSpace, begin + 1);
    if (begin == tag.npos || (tag[begin] != '"' && tag[begin] != '\'')) return std::nullopt;
    const std::size_t end = tag.find(tag[begin], begin + 1);
    if (end == tag.npos) return std::nullopt;
    return tag.substr(begin + 1, end - begin - 1);
  }
  return std::nullopt;
}

// The next tag that begins with `name`, comments left out; moves `position` past it.
std::optional<std::string_view> next_tag(std::string_view text, std::string_view name,
                                         std::size_t& position) {
  for (;;) {
    const std::size_t begin = text.find(name, position);
    if (begin == text.npos) return std::nullopt;
    if (const std::size_t comment = text.find("<!--", position); comment < begin) {
      position = text.find("-->", comment);
      if (position == text.npos) return std::nullopt;
      continue;
    }
    const std::size_t end = std::min(text.find('>', begin), text.size());
    position = end;
    return text.substr(begin, end - begin);
  }
}

// The word after a keyword of a legacy file; empty if either is missing.
std::string_view word_after(std::string_view text, std::string_view keyword) {
  for (auto from = text.begin();;) {
    const auto found =
        std::search(from, text.end(), keyword.begin(), keyword.end(), equal_ignoring_case);
    if (found == text.end()) return {};
    const auto at = static_cast<std::size_t>(found - text.begin());
    const std::size_t after = at + keyword.size();
    const bool alone = (at == 0 || kSpace.find(text[at - 1]) != kSpace.npos) &&
                       after < text.size() && kSpace.find(text[after]) != kSpace.npos;
    if (alone) {
      const std::size_t begin = text.find_first_not_of(kSpace, after);
      if (begin == text.npos) return {};
      return text.substr(begin, text.find_first_of(kSpace, begin) - begin);
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

std::int64_t word_count(std::string_view text) {
  std::int64_t count = 0;
  for (std::size_t at = 0; (at = text.find_first_not_of(kSpace, at)) != text.npos; ++count) {
    at = std::min(text.find_first_of(kSpace, at), text.size());
  }
  return count;
}

// VTK reads as many offsets and types as there are cells and leaves what follows them. Only text is
// checked.
void check_cell_arrays(const std::string& path, std::string_view piece, std::int64_t cells) {
  std::size_t position = 0;
  if (!next_tag(piece, "<Cells", position)) return;
  const std::string_view part = piece.substr(0, piece.find("</Cells>", position));
  while (const auto array = next_tag(part, "<DataArray", position)) {
    const auto name = attribute(*array, "Name");
    if ((name != "offsets" && name != "types") || attribute(*array, "format") != "ascii") continue;
    const std::size_t begin = std::min(position + 1, part.size());
    const std::int64_t count = word_count(part.substr(begin, part.find('<', begin) - begin));
    if (count == cells) continue;
    throw FileError(fmt::format("{}: its array {} has {} numbers, but there are {} cells.", path,
                                in_quotes(*name), count, cells));
  }
}

}  // namespace

VtkHeader check_xml_header(const std::string& path, std::string_view text) {
  // Binary data after this mark may look like anything.
  const std::string_view head = text.substr(0, text.find("<AppendedData"));
  std::size_t position = 0;
  const auto file = next_tag(head, "<VTKFile", position);
  if (!file) throw FileError(path + ": is not a VTU file: it has no <VTKFile>.");
  const auto type = attribute(*file, "type");
  if (type != "UnstructuredGrid") {
    throw FileError(
        fmt::format("{}: holds a data set of type {}; tetrahedra come in an "
                    "UnstructuredGrid. Convert it first.",
                    path, in_quotes(type.value_or(""))));
  }
  if (text.rfind("</VTKFile>") == text.npos) {
    throw FileError(path + ": the file is truncated: it has no </VTKFile>. Write it anew.");
  }
  const auto most = kMostPointsPerByte * static_cast<std::int64_t>(text.size());
  VtkHeader header;
  bool pieces = false;
  while (const auto piece = next_tag(head, "<Piece", position)) {
    pieces = true;
    const std::int64_t cells_before = header.cells;
    for (auto [name, sum] :
         {std::pair{"NumberOfPoints", &header.points}, std::pair{"NumberOfCells", &header.cells}}) {
      const auto value = attribute(*piece, name);
      if (!value) throw FileError(fmt::format("{}: a <Piece> has no {}.", path, name));
      *sum += count_of(path, name, *value, most);
    }
    const std::string_view rest = head.substr(position);
    check_cell_arrays(path, rest.substr(0, rest.find("</Piece>")), header.cells - cells_before);
  }
  if (!pieces) throw FileError(path + ": has no <Piece>, so it holds no mesh.");
  // VTK allocates whole arrays before it looks for their values.
  const auto most_values = kMostValuesPerByte * static_cast<std::int64_t>(text.size());
  const auto most_components =
      most_values / std::max({header.points, header.cells, std::int64_t{1}}) + 1;
  for (position = 0; const auto array = next_tag(head, "<DataArray", position);) {
    if (const auto value = attribute(*array, "NumberOfComponents")) {
      count_of(path, "NumberOfComponents", *value, most_components);
    }
    if (const auto value = attribute(*array, "NumberOfTuples")) {
      count_of(path, "NumberOfTuples", *value, most_values);
    }
  }
  return header;
}

VtkHeader check_legacy_header(const std::string& path, std::string_view text) {
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
        fmt::format("{}: holds a data set of type {}; tetrahedra come in an "
                    "UNSTRUCTURED_GRID. Convert it first.",
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
  header.own_arrays = title.substr(0, std::string_view(kOwnLegacyTitle).size()) == kOwnLegacyTitle;
  return header;
}

}  // namespace tetraction
