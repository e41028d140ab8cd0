#include "output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "check_sum.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Writes all of the text, or returns the system's reason. `text` is then what was not written.
int write_all(int descriptor, std::string_view& text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

// Deletes a file or a link. What is not there is deleted already, whatever a file system that cannot be
// written says of it.
void remove_entry(const std::string& path) {
  if (::unlink(path.c_str()) == 0 || errno == ENOENT || errno == ENOTDIR) return;
  const int reason = errno;
  if (!is_entry(path)) return;
  throw OutputError(
      fmt::format("{}: cannot be deleted ({}). Delete it, or choose another directory (on the "
                  "command line: --out).",
                  path, std::strerror(reason)));
}

// Replaces a file that has other names by one of its own with the same first bytes, so that what has the
// other names stays as it is.
void separate_from_hard_links(const std::string& path, std::int64_t size) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_nlink < 2)
    return;
  std::ifstream source(path, std::ios::binary);
  ReplacementFile copy(path);
  std::string part(std::size_t{1} << 20U, '\0');
  while (size > 0 && source.good()) {
    source.read(part.data(), std::min<std::streamsize>(size, std::ssize(part)));
    copy.write(std::string_view(part).substr(0, static_cast<std::size_t>(source.gcount())));
    size -= source.gcount();
  }
  if (size > 0) fail_to_write(path, EINVAL);
  copy.finish();
}

}  // namespace

void fail_to_write(const std::string& path, int error_number) {
  if (error_number == EFBIG) {
    throw OutputError(fmt::format(
        "{}: cannot be written ({}). The limit of the size of a file is reached: raise it "
        "(ulimit -f), or write to a file system that takes larger files.",
        path, std::strerror(error_number)));
  }
  throw OutputError(fmt::format(
      "{}: cannot be written{}. Check the directory's permissions and the free space.", path,
      error_number == 0 ? "" : fmt::format(" ({})", std::strerror(error_number))));
}

int reason_of_a_full_disk(const std::string& path) {
  struct rlimit limit {};
  struct statvfs disk {};
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return ENOSPC;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::statvfs(folder.empty() ? "." : folder.c_str(), &disk) != 0) return ENOSPC;
  // A file cannot have filled more than the limit allows.
  const double room = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
  return room > static_cast<double>(limit.rlim_cur) ? EFBIG : ENOSPC;
}

std::string temporary_name(const std::string& path) {
  return path + ".part";
}

void remove_output(const std::string& path) {
  remove_entry(path);
  remove_entry(temporary_name(path));
}

bool is_entry(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

void make_own_directory(const std::string& path) {
  if (::mkdir(path.c_str(), 0777) == 0) return;
  if (errno != EEXIST) {
    throw OutputError(fmt::format(
        "{}: cannot be made ({}). Choose another directory (on the command line: --out).", path,
        std::strerror(errno)));
  }
  check_own_directory(path);
}

void check_own_directory(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || S_ISDIR(status.st_mode)) return;
  throw OutputError(fmt::format(
      "{}: {}. Delete it, or choose another directory (on the command line: --out).", path,
      S_ISLNK(status.st_mode) ? "this is a link, and results are written into no linked folder"
                              : "there is a file of that name, where a folder is needed"));
}

ReplacementFile::ReplacementFile(std::string path)
    : path_(std::move(path)), temporary_(temporary_name(path_)) {
  // A link or a FIFO of this name must not be opened, so the file is always a new one.
  remove_entry(temporary_);
  descriptor_ =
      ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail_to_write(path_, errno);
}

std::string read_output(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(path, error))) return {};
  // Larger ones are no results that are read as a whole.
  constexpr std::uintmax_t kMost = std::uintmax_t{1} << 28;
  if (std::filesystem::file_size(path, error) > kMost || error) return {};
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

ReplacementFile::~ReplacementFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
}

void ReplacementFile::write(std::string_view text) {
  if (const int reason = write_all(descriptor_, text); reason != 0) fail_to_write(path_, reason);
}

void ReplacementFile::finish() {
  int reason = 0;
  // Some file systems report only here that there was no space.
  if (::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) reason = errno;
  if (reason == 0 && std::rename(temporary_.c_str(), path_.c_str()) != 0) reason = errno;
  if (reason == 0) return;
  ::unlink(temporary_.c_str());
  fail_to_write(path_, reason);
}

ReplacementDirectory::ReplacementDirectory(std::string path)
    : path_(std::move(path)), temporary_() {
  // A slash at the end would make the temporary name one inside the directory.
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  temporary_ = temporary_name(path_);
  std::error_code problem;
  const bool is_free =
      !is_entry(path_) ||
      (std::filesystem::is_directory(std::filesystem::symlink_status(path_, problem)) &&
       std::filesystem::is_empty(path_, problem));
  if (!is_free) {
    throw InputError(
        fmt::format("{}: this is not an empty directory. Choose another one with --out.", path_));
  }
  const std::filesystem::path above = std::filesystem::path(path_).parent_path();
  if (!above.empty()) std::filesystem::create_directories(above, problem);
  if (problem) fail_to_write(path_, problem.value());
  std::filesystem::remove_all(temporary_, problem);  // of a program that was killed
  if (!std::filesystem::create_directory(temporary_, problem))
    fail_to_write(temporary_, problem.value());
}

ReplacementDirectory::~ReplacementDirectory() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
}

void ReplacementDirectory::finish() {
  std::error_code problem;
  std::filesystem::rename(temporary_, path_, problem);
  if (problem) fail_to_write(path_, problem.value());
  temporary_.clear();
}

RowFile::RowFile(std::string path, std::string_view begin) : path_(std::move(path)) {
  ReplacementFile file(path_);
  file.write(begin);
  // The same file under another descriptor, which stays open when it gets its name.
  descriptor_ = ::open(file.temporary().c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor_ < 0) fail_to_write(path_, errno);
  size_ = static_cast<std::int64_t>(begin.size());
  sum_ = check_sum(begin);
  try {
    file.finish();
  } catch (const OutputError&) {
    ::close(descriptor_);
    throw;
  }
}

RowFile::RowFile(std::string path, std::int64_t kept_size, std::uint32_t kept_sum)
    : path_(std::move(path)), size_(kept_size), sum_(kept_sum) {
  separate_from_hard_links(path_, kept_size);
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  struct stat status {};
  if (descriptor_ < 0) fail_to_write(path_, errno);
  int reason = ::fstat(descriptor_, &status) != 0 ? errno : 0;
  if (reason == 0 && (!S_ISREG(status.st_mode) || status.st_size < kept_size)) reason = EINVAL;
  if (reason == 0 && ::ftruncate(descriptor_, kept_size) != 0) reason = errno;
  if (reason == 0) return;
  ::close(descriptor_);
  fail_to_write(path_, reason);
}

RowFile::~RowFile() {
  if (descriptor_ < 0) return;
  try {
    flush();
  } catch (const OutputError&) {  // nobody is left who could be told
  }
  ::close(descriptor_);
}

void RowFile::add(std::string_view row) {
  constexpr auto kLongest = std::chrono::milliseconds(100);
  constexpr std::size_t kMost = std::size_t{1} << 16;
  if (is_broken_) return;
  rows_ += row;
  if (rows_.size() >= kMost || Clock::now() - flushed_ >= kLongest) flush();
}

std::int64_t RowFile::flush() {
  flushed_ = Clock::now();
  if (rows_.empty()) return size_;
  std::string_view rest = rows_;
  const int reason = write_all(descriptor_, rest);
  std::string_view written = std::string_view(rows_).substr(0, rows_.size() - rest.size());
  // The last one of the rows that fit may be incomplete.
  written = written.substr(0, written.rfind('\n') + 1);
  size_ += static_cast<std::int64_t>(written.size());
  sum_ = check_sum(written, sum_);
  rows_.clear();
  if (reason == 0) return size_;
  is_broken_ = true;  // a row after a gap would look like the next one
  const bool is_cut = ::ftruncate(descriptor_, size_) == 0;
  static_cast<void>(is_cut);
  fail_to_write(path_, reason);
}

void RowFile::close() {
  flush();
  struct stat mine {};
  struct stat named {};
  const bool is_there = ::fstat(descriptor_, &mine) == 0 && ::lstat(path_.c_str(), &named) == 0 &&
                        mine.st_ino == named.st_ino && mine.st_dev == named.st_dev;
  const int reason = ::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR ? errno : 0;
  if (reason != 0) fail_to_write(path_, reason);
  if (!is_there) {
    throw OutputError(path_ + ": it was deleted or replaced while it was being written.");
  }
}

}  // namespace tetraction
