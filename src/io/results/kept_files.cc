#include "kept_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "io/text/check_sum.h"
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
                      std::uint32_t kept_sum) {
  std::ifstream file = open_table(path);
  check_header(file, path, header);
  file.seekg(0);
  std::string part(std::size_t{1} << 20, '\0');
  std::uint32_t sum = 0;
  for (std::int64_t left = kept_size; left > 0; left -= file.gcount()) {
    file.read(part.data(), std::min(left, static_cast<std::int64_t>(part.size())));
    if (file.gcount() == 0) fail(path, "it has fewer rows than at the checkpoint");
    sum = check_sum(std::string_view(part).substr(0, static_cast<std::size_t>(file.gcount())), sum);
  }
  if (sum != kept_sum) fail(path, "its rows have changed since the checkpoint");
}

KeptFrames read_kept_frames(const std::string& directory, const std::vector<std::uint64_t>& sizes,
                            Index last_frame) {
  KeptFrames kept;
  if (sizes.empty()) return kept;
  const std::string path = directory + "/frames.pvd";
  std::ifstream file = open_table(path);
  constexpr std::string_view kFile = "file=\"frames/";
  for (std::string line; kept.names.size() < sizes.size() && std::getline(file, line);) {
    const std::size_t at = line.find(kFile);
    const std::size_t begin = at + kFile.size();
    const std::size_t end = at == std::string::npos ? at : line.find('"', begin);
    if (end == std::string::npos) continue;
    kept.entries += line + '\n';
    kept.names.push_back(line.substr(begin, end - begin));
    std::error_code error;
    const std::string frame = directory + "/frames/" + kept.names.back();
    if (!fs::is_regular_file(fs::symlink_status(frame, error))) fail(frame, "it is missing");
    if (fs::file_size(frame, error) != sizes[kept.names.size() - 1]) {
      fail(frame, "it has another size than at the checkpoint");
    }
  }
  if (kept.names.size() < sizes.size() ||
      kept.names.back() != fmt::format("frame_{:06}.vtu", last_frame)) {
    fail(path, "it has other frames than at the checkpoint");
  }
  return kept;
}

}  // namespace tetraction
