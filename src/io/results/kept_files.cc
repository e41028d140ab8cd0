#include "kept_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "history_rows.h"
#include "io/text/check_sum.h"
#include "probe_file.h"
#include "run_files.h"
#include "tetraction/core/error.h"
#include "tetraction/io/checkpoint_file.h"

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

// The text between `begin`, whose last character is a quotation mark, and the next such mark. Empty if the line
// does not have it.
std::string quoted_after(const std::string& line, std::string_view begin) {
  const std::size_t at = line.find(begin);
  if (at == std::string::npos) return {};
  const std::size_t first = at + begin.size();
  const std::size_t end = line.find('"', first);
  return end == std::string::npos ? std::string() : line.substr(first, end - first);
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

namespace {

// Throws FileError unless a table has this header and `kept_size` bytes or more, the first ones with this check sum.
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

// The names of the pieces of a frame (part_frames.h).
std::vector<std::string> pieces_of(const std::string& path) {
  std::vector<std::string> names;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    const std::string name = quoted_after(line, "<Piece Source=\"");
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

void check_is_there(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error))) fail(path, "it is missing");
}

// Throws FileError unless frames.pvd has so many entries, the last of them of this step, and their files are there and
// have these sizes, a frame in pieces with its pieces. The obstacles of a frame follow it.
KeptFrames read_kept_frames(const std::string& directory, const std::vector<std::uint64_t>& sizes,
                            Index last_frame) {
  KeptFrames kept;
  if (sizes.empty()) return kept;
  const std::string path = directory + "/frames.pvd";
  std::ifstream file = open_table(path);
  const std::string frames = directory + "/frames/";
  std::string last;
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) {
    const std::string name = quoted_after(line, "file=\"frames/");
    if (name.empty()) continue;
    const bool has_obstacles = is_obstacle_frame_name(name);
    if (count == sizes.size() && !has_obstacles) break;
    kept.entries += line + '\n';
    if (has_obstacles) {
      check_is_there(frames + name);
      kept.names.push_back(name);
      continue;
    }
    last = name;
    std::vector<std::string> files{name};
    if (name.ends_with(".pvtu")) {
      for (std::string& piece : pieces_of(frames + name)) files.push_back(std::move(piece));
    }
    std::uint64_t size = 0;
    for (std::string& own : files) {
      check_is_there(frames + own);
      std::error_code error;
      size += fs::file_size(frames + own, error);
      kept.names.push_back(std::move(own));
    }
    if (size != sizes[count++]) {
      fail(frames + name, "it has another size than at the checkpoint");
    }
  }
  const std::string stem = fmt::format("frame_{:06}", last_frame);
  if (count < sizes.size() || (last != stem + ".vtu" && last != stem + ".pvtu")) {
    fail(path, "it has other frames than at the checkpoint");
  }
  kept.last = frames + last;
  return kept;
}

}  // namespace

KeptFrames check_kept_files(const std::string& directory, const HistoryColumns& columns,
                            const Session& session, const RecordedFiles& files) {
  check_kept_table(directory + "/history.csv", header_text(columns),
                   static_cast<std::int64_t>(files.history_size), files.history_sum);
  if (!session.scene().probe.empty()) {
    check_kept_table(directory + "/probes.csv", ProbeFile::header(session.probes()),
                     static_cast<std::int64_t>(files.probes_size), files.probes_sum);
  }
  return read_kept_frames(directory, files.frame_sizes, files.last_frame);
}

}  // namespace tetraction
