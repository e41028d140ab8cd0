#include "polygon_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "core/quoting.h"
#include "io/text/file_kind.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr std::string_view kStlKind = "an STL file";
constexpr std::string_view kObjKind = "a Wavefront file (.obj)";
constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

std::string in_lower_case(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::uint32_t little_endian(const char* bytes) {
  std::uint32_t value = 0;
  for (int k = 3; k >= 0; --k) value = value << 8U | static_cast<unsigned char>(bytes[k]);
  return value;
}

float little_endian_float(const char* bytes) {
  const std::uint32_t bits = little_endian(bytes);
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

TriangleFile read_binary_stl(std::string_view text) {
  TriangleFile file;
  const std::size_t count = (text.size() - kStlHeader) / kStlTriangle;
  for (std::size_t t = 0; t < count; ++t) {
    // The normal, three points, and two bytes without a meaning.
    const char* at = text.data() + kStlHeader + t * kStlTriangle + 12;
    for (std::size_t k = 0; k < 3; ++k, at += 12) {
      file.points.emplace_back(little_endian_float(at), little_endian_float(at + 4),
                               little_endian_float(at + 8));
    }
    const auto first = static_cast<Index>(3 * t);
    file.triangles.push_back({first, first + 1, first + 2});
  }
  return file;
}

TriangleFile read_ascii_stl(const std::string& path, std::string_view text) {
  TextScanner in(path, text);
  TriangleFile file;
  const auto expect = [&](const char* wanted) {
    const std::string found = in_lower_case(in.token(wanted));
    if (found != wanted) {
      in.fail(fmt::format("expected \"{}\" instead of {}", wanted, in_quotes(excerpt(found, 40))));
    }
  };
  while (!in.at_end()) {
    expect("solid");
    in.skip_line();
    for (;;) {
      const std::string word = in_lower_case(in.token("facet or endsolid"));
      if (word == "endsolid") {
        in.skip_line();
        break;
      }
      if (word != "facet") {
        in.fail(fmt::format("expected \"facet\" or \"endsolid\" instead of {}",
                            in_quotes(excerpt(word, 40))));
      }
      expect("normal");
      // Programs write what they like where a triangle has no normal.
      for (int k = 0; k < 3; ++k) in.token("a component of a normal");
      expect("outer");
      expect("loop");
      const auto first = static_cast<Index>(file.points.size());
      for (int k = 0; k < 3; ++k) {
        expect("vertex");
        Vector3 point;
        for (double& x : point) x = in.real("a coordinate");
        file.points.push_back(point);
      }
      expect("endloop");
      expect("endfacet");
      file.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return file;
}

class ObjReader {
 public:
  ObjReader(const std::string& path, std::string_view text) : in_(path, text) {}

  TriangleFile read() {
    while (!in_.at_end()) {
      if (in_.next_is('#')) {
        in_.skip_line();
        continue;
      }
      const std::string word(in_.token("a keyword"));
      if (word == "v") {
        Vector3 point;
        for (double& x : point) x = in_.real("a coordinate");
        file_.points.push_back(point);
        // A weight or colours may follow.
        in_.skip_line();
      } else if (word == "f") {
        read_face(in_.line());
      } else if (known(word)) {
        in_.skip_line();
      } else {
        in_.fail(fmt::format("{} is not a keyword of Wavefront files that is known here.",
                             in_quotes(excerpt(word, 40))));
      }
    }
    return std::move(file_);
  }

 private:
  static bool known(std::string_view word) {
    constexpr std::array kKnown{"vn", "vt", "vp",     "g",      "o",  "s",
                                "l",  "p",  "usemtl", "mtllib", "mg", "lod"};
    return std::find(kKnown.begin(), kKnown.end(), word) != kKnown.end();
  }

  // Numbers of points, each with those of texture and normal behind strokes; negative ones count back.
  void read_face(std::string_view line) {
    std::vector<Index> corners;
    line = line.substr(0, line.find('#'));
    while (true) {
      const auto begin = line.find_first_not_of(" \t\r");
      if (begin == line.npos) break;
      line.remove_prefix(begin);
      const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
      line.remove_prefix(word.size());
      const std::string_view digits = word.substr(0, word.find('/'));
      Index number = 0;
      const auto [end, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), number);
      if (error != std::errc() || end != digits.data() + digits.size()) {
        in_.fail(fmt::format("{} is not the number of a point of a face",
                             in_quotes(excerpt(std::string(word), 40))));
      }
      const auto count = static_cast<Index>(file_.points.size());
      const Index corner = number < 0 ? count + number : number - 1;
      if (corner < 0 || corner >= count) {
        in_.fail(
            fmt::format("a face has the point {}, but there are {} points so far", number, count));
      }
      corners.push_back(corner);
    }
    if (corners.size() < 3) in_.fail("a face has fewer than three points");
    for (std::size_t k = 2; k < corners.size(); ++k) {
      file_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }

  TextScanner in_;
  TriangleFile file_;
};

}  // namespace

TriangleFile read_stl(const std::string& path) {
  const std::string text = read_file(path);
  const bool has_head = text.size() >= kStlHeader;
  const std::uint64_t count = has_head ? little_endian(text.data() + 80) : 0;
  // Binary files may begin with "solid", too; their size tells.
  if (has_head && text.size() == kStlHeader + kStlTriangle * count) return read_binary_stl(text);
  refuse_other_kinds(path, text, kStlKind);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != text.npos && in_lower_case(text.substr(first, 5)) == "solid" &&
      text.find('\0') == text.npos) {
    return read_ascii_stl(path, text);
  }
  throw FileError(
      has_head ? fmt::format(
                     "{}: is neither STL as text, which begins with \"solid\", nor binary "
                     "STL: that announces {} triangles, which take {} bytes, but the file has {}.",
                     path, count, kStlHeader + kStlTriangle * count, text.size())
               : fmt::format("{}: is not an STL file: it has {} bytes only.", path, text.size()));
}

TriangleFile read_obj(const std::string& path) {
  const std::string text = read_file(path);
  refuse_other_kinds(path, text, kObjKind);
  return ObjReader(path, text).read();
}

}  // namespace tetraction
