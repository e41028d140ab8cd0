#include "directory_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// "process 1234": who holds the lock, as far as the file says so.
std::string holder(int descriptor) {
  std::array<char, 24> text{};
  const ssize_t size = ::pread(descriptor, text.data(), text.size() - 1, 0);
  const std::string number(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return "";
  return fmt::format(" (process {})", number);
}

// Whether the file of the descriptor still has this name: its last holder may have deleted it.
bool has_name(int descriptor, const std::string& path) {
  struct stat mine {};
  struct stat named {};
  return ::fstat(descriptor, &mine) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         mine.st_ino == named.st_ino && mine.st_dev == named.st_dev;
}

}  // namespace

DirectoryLock::DirectoryLock(const std::string& directory) : path_(directory + "/.lock") {
  for (;;) {
    // O_NONBLOCK: a FIFO of this name must not be waited for.
    descriptor_ =
        ::open(path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    struct stat status {};
    // A file that has another name, too, belongs to somebody else.
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode) ||
        status.st_nlink > 1) {
      const int reason = descriptor_ < 0 ? errno : EINVAL;
      if (descriptor_ >= 0) ::close(descriptor_);
      throw OutputError(fmt::format(
          "{}: the file that locks the directory cannot be opened ({}). Delete it if it is a link, "
          "has another name as well, or is no ordinary file, or choose another directory (on the "
          "command line: --out).",
          path_, std::strerror(reason)));
    }
    int result = 0;
    do {
      result = ::flock(descriptor_, LOCK_EX | LOCK_NB);
    } while (result != 0 && errno == EINTR);
    if (result != 0 && errno == EWOULDBLOCK) {
      const std::string who = holder(descriptor_);
      ::close(descriptor_);
      throw OutputError(fmt::format(
          "{}: another run is writing here{}. Wait until it has ended, or choose another directory "
          "(on the command line: --out).",
          directory, who));
    }
    if (has_name(descriptor_, path_)) break;
    ::close(descriptor_);
  }
  const std::string number = std::to_string(::getpid());
  // It only makes the message of another program more exact.
  if (::ftruncate(descriptor_, 0) == 0) {
    const ssize_t ignored = ::pwrite(descriptor_, number.data(), number.size(), 0);
    static_cast<void>(ignored);
  }
}

DirectoryLock::~DirectoryLock() {
  // Deleted while the lock is held, so that nobody else can have it by then.
  if (has_name(descriptor_, path_)) ::unlink(path_.c_str());
  ::close(descriptor_);
}

}  // namespace tetraction
