// Keeps two programs from writing their results into one directory.
#pragma once

#include <string>

namespace tetraction {

/// A lock on a directory of results, which is held as long as the object lives. It consists of a
/// lock of the system on the file `.lock` in the directory. The system ends it with the program,
/// however that ends, so a `.lock` that a killed program has left means nothing. A file system that
/// has no locks gives none, and then there is no protection.
class DirectoryLock {
 public:
  /// Throws OutputError if another run, study or computation of modes holds the lock, or if the
  /// directory cannot be written to.
  explicit DirectoryLock(const std::string& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tetraction
