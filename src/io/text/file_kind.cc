#include "file_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

bool begins_with(std::string_view text, std::string_view mark) {
  return text.size() >= mark.size() &&
         std::equal(mark.begin(), mark.end(), text.begin(), [](unsigned char a, unsigned char b) {
           return std::tolower(a) == std::tolower(b);
         });
}

}  // namespace

std::string_view kind_of_file(std::string_view text) {
  using namespace std::string_view_literals;
  constexpr std::size_t kHead = 4096;
  text = text.substr(0, kHead);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  static constexpr std::array kMarks{
      std::pair{
          "version https://git-lfs.github.com/spec/"sv,
          "a Git LFS pointer, which stands for the file itself: fetch that with git lfs pull"sv},
      std::pair{"$MeshFormat"sv, kGmshKind},
      std::pair{"$NOD\n"sv, kGmshKind},
      std::pair{"$NOD\r"sv, kGmshKind},
      std::pair{"# vtk DataFile"sv, kLegacyVtkKind},
      std::pair{"<VTKFile"sv, kXmlVtkKind},
      std::pair{"*VERTICES"sv, kVegaKind},
      std::pair{"# Vega"sv, kVegaKind},
      std::pair{"MeshVersionFormatted"sv, "a Medit mesh (.mesh)"sv},
      std::pair{"*HEADING"sv, "an input file of Abaqus or CalculiX (.inp)"sv},
      std::pair{"*NODE"sv, "an input file of Abaqus or CalculiX (.inp)"sv},
      std::pair{"<!DOCTYPE html"sv, "a web page (HTML)"sv},
      std::pair{"<html"sv, "a web page (HTML)"sv},
      std::pair{"\x1f\x8b"sv, "a file packed with gzip: unpack it first"sv},
      std::pair{"PK\x03\x04"sv, "a ZIP archive: unpack it first"sv},
      std::pair{"\x89HDF"sv, "an HDF5 file"sv},
      std::pair{"\xff\xfe"sv, "a text in UTF-16: save it as UTF-8"sv},
      std::pair{"\xfe\xff"sv, "a text in UTF-16: save it as UTF-8"sv}};
  for (const auto& [mark, kind] : kMarks) {
    if (begins_with(text, mark)) return kind;
  }
  if (!begins_with(text, "<?xml")) return {};
  return text.find("<VTKFile") != text.npos ? kXmlVtkKind : "an XML file"sv;
}

void refuse_other_kinds(const std::string& path, std::string_view text, std::string_view wanted) {
  const std::string_view kind = kind_of_file(text);
  if (kind.empty() || kind == wanted) return;
  throw FileError(fmt::format("{}: is not {}. It is {}.", path, wanted, kind));
}

}  // namespace tetraction
