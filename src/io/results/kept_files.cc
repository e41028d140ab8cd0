#include "kept_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw FileError(fmt::format(
      "{}: {}, so that the run cannot go on from the checkpoint. Start it anew without --resume.",
      path, what));
}

std::ifstream open_table(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error))) fail(path, "it is missing or no file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "it cannot be read");
  return file;
}

void check_header(std::ifstream& file, const std::string& path, const std::string& header) {
  std::string line;
  std::getline(file, line);
  if (line + '\n' != header) fail(path, "it has other columns than this run");
}

template <class Number>
Number parse(const std::string& path, const std::string& cell) {
  Number value{};
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || rest != cell.data() + cell.size()) {
    fail(path, fmt::format("it has a cell that is no number (\"{:.40}\")", cell));
  }
  return value;
}

}  // namespace

double number_of(const std::string& path, const std::string& cell) {
  return parse<double>(path, cell);
}

Index step_of(const std::string& path, const std::string& cell) {
  return parse<Index>(path, cell);
}

void for_each_kept_row(const std::string& path, const std::string& header, std::int64_t kept_size,
                       const std::function<void(const std::vector<std::string>& cells)>& visit) {
  std::ifstream file = open_table(path);
  check_header(file, path, header);
  const auto columns = static_cast<std::size_t>(std::ranges::count(header, ',')) + 1;
  auto read = static_cast<std::int64_t>(header.size());
  std::vector<std::string> cells;
  for (std::string line; read < kept_size && std::getline(file, line);) {
    read += static_cast<std::int64_t>(line.size()) + 1;
    if (file.eof()) break;  // a row without its line break
    cells.assign(1, {});
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    if (cells.size() != columns) fail(path, "it has a row of another length than the header");
    visit(cells);
  }
  if (read != kept_size || file.eof()) fail(path, "it has fewer rows than at the checkpoint");
}

void check_kept_table(const std::string& path, const std::string& header, std::int64_t kept_size,
                      Index last_row) {
  constexpr std::int64_t kLongestRow = 1 << 20;
  std::ifstream file = open_table(path);
  check_header(file, path, header);
  const std::int64_t begin =
      std::max(static_cast<std::int64_t>(header.size()) - 1, kept_size - kLongestRow);
  std::string end(static_cast<std::size_t>(std::max<std::int64_t>(0, kept_size - begin)), '\0');
  file.seekg(begin);
  file.read(end.data(), static_cast<std::streamsize>(end.size()));
  if (!file || end.empty()) fail(path, "it has fewer rows than at the checkpoint");
  // "\n", the last row, "\n"
  const std::size_t before = end.size() < 2 ? std::string::npos : end.rfind('\n', end.size() - 2);
  if (end.back() != '\n' || before == std::string::npos) fail(path, "its rows have changed");
  const std::string row = end.substr(before + 1);
  if (step_of(path, row.substr(0, row.find(','))) != last_row) fail(path, "its rows have changed");
}

KeptFrames read_kept_frames(const std::string& directory, Index count, Index last_frame) {
  KeptFrames kept;
  if (count == 0) return kept;
  const std::string path = directory + "/frames.pvd";
  std::ifstream file = open_table(path);
  constexpr std::string_view kFile = "file=\"frames/";
  for (std::string line;
       static_cast<Index>(kept.names.size()) < count && std::getline(file, line);) {
    const std::size_t at = line.find(kFile);
    const std::size_t begin = at + kFile.size();
    const std::size_t end = at == std::string::npos ? at : line.find('"', begin);
    if (end == std::string::npos) continue;
    kept.entries += line + '\n';
    kept.names.push_back(line.substr(begin, end - begin));
    std::error_code error;
    const std::string frame = directory + "/frames/" + kept.names.back();
    if (!fs::is_regular_file(fs::symlink_status(frame, error))) fail(frame, "it is missing");
  }
  if (static_cast<Index>(kept.names.size()) < count ||
      kept.names.back() != fmt::format("frame_{:06}.vtu", last_frame)) {
    fail(path, "it has other frames than at the checkpoint");
  }
  return kept;
}

}  // namespace tetraction
