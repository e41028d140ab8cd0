// Files of results, written such that a program that ends at any moment leaves only complete ones.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace tetraction {

/// Throws OutputError: `path` cannot be written, with the system's reason for `error_number` (0: no
/// reason is known) and what to do.
[[noreturn]] void fail_to_write(const std::string& path, int error_number);

/// Why a library that knows only of a full disk could not write `path`: EFBIG if the limit of the size of
/// files is smaller than the free space, otherwise ENOSPC.
int reason_of_a_full_disk(const std::string& path);

/// The temporary file beside `path` in which it is written before it gets its name.
std::string temporary_name(const std::string& path);

/// Deletes the file and what a program that was killed has left of it under its temporary name.
/// A link is deleted itself, not its target. Throws OutputError.
void remove_output(const std::string& path);

/// The text of a result file. Empty if there is none, if it cannot be read, or if it is a link, a pipe
/// or a directory, for which nothing must wait.
std::string read_output(const std::string& path);

/// Whether there is a file, folder or link of that name. A link is not followed.
bool is_entry(const std::string& path);

/// Throws OutputError if `path` is a link, or there is something that is no directory.
void check_own_directory(const std::string& path);

/// Makes the directory if it is not there. Throws OutputError if `path` is a link or no directory:
/// results never go through a link out of their directory.
void make_own_directory(const std::string& path);

/// A file that gets its name only when it is complete: it is written in a temporary file beside it,
/// which is then renamed. What had the name before is replaced: a link by the file, not its target.
/// All functions throw OutputError.
class ReplacementFile {
 public:
  /// Makes the temporary file, empty.
  explicit ReplacementFile(std::string path);
  /// Deletes the temporary file unless it has been renamed.
  ~ReplacementFile();
  ReplacementFile(const ReplacementFile&) = delete;
  ReplacementFile& operator=(const ReplacementFile&) = delete;

  /// The temporary file, for writers that open it by its name.
  const std::string& temporary() const { return temporary_; }
  void write(std::string_view text);
  /// Gives the file its name.
  void finish();

 private:
  std::string path_;
  std::string temporary_;
  int descriptor_;
};

/// A directory that gets its name only when it is complete. It must not be there before, or be empty. All
/// functions throw OutputError; the constructor throws InputError for a directory with something in it.
class ReplacementDirectory {
 public:
  explicit ReplacementDirectory(std::string path);
  /// Deletes the temporary directory unless it has been renamed.
  ~ReplacementDirectory();
  ReplacementDirectory(const ReplacementDirectory&) = delete;
  ReplacementDirectory& operator=(const ReplacementDirectory&) = delete;

  const std::string& temporary() const { return temporary_; }
  /// Gives the directory its name.
  void finish();

 private:
  std::string path_;
  std::string temporary_;
};

/// A table that grows by whole rows. Rows are collected for a tenth of a second at most while others
/// follow, and are then given to the system in one piece. All functions throw OutputError, after
/// which the file ends with a whole row and takes no more.
class RowFile {
 public:
  /// Begins a file that has `begin`, the header with the first rows, as soon as it has its name.
  RowFile(std::string path, std::string_view begin);
  /// Goes on with a file that is there, after its first `kept_size` bytes, which have this check sum.
  /// Bytes after them are cut off. The file must have that size or more, and must not be a link.
  /// A hard link is replaced by a copy: what has its other names stays as it is.
  RowFile(std::string path, std::int64_t kept_size, std::uint32_t kept_sum);
  /// Writes the rows that were collected, if they can be written.
  ~RowFile();
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  /// Adds a row, or several, with their line breaks.
  void add(std::string_view row);
  /// Gives all rows to the system and returns the size of the file in bytes. The file then has them,
  /// whatever happens to the program.
  std::int64_t flush();
  /// The CRC-32 of these bytes of the file.
  std::uint32_t sum() const { return sum_; }
  /// Writes the rest and closes the file. It is an error if the file was deleted in the meantime.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  std::string path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;  // of the whole rows in the file
  std::uint32_t sum_ = 0;  // of these rows
  std::string rows_;       // not written yet
  bool is_broken_ = false;
  Clock::time_point flushed_ = Clock::now();
};

}  // namespace tetraction
